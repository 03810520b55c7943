"""Results of many runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lumped.errors import OptionError
from lumped.support.optional_packages import extra
from lumped.support.text_table import number, table

__all__ = ["Ensemble"]

_TOLD = 3
"""Reasons of failures in a printed ensemble."""


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Results of many runs; ``found[label]`` gives one of them for all runs.

    Attributes
    ----------
    names : tuple of str
        What was varied.
    points : ndarray, shape (n, len(names))
        Its values in each run.
    labels : tuple of str
        What was taken from each run.
    values : ndarray, shape (n, len(labels))
        Results; nan where a run failed.
    failures : dict of int to str
        Why runs failed, or which results are not numbers, by the number of the run.
    shape : tuple of int
        That of the grid over which was swept, such as ``found["peak"].reshape(found.shape)``.
    workers : int
        Threads or processes that worked.
    seconds, busy : float
        Wall time, and the time that all of them spent in runs.
    """

    names: tuple[str, ...]
    points: NDArray[np.float64]
    labels: tuple[str, ...]
    values: NDArray[np.float64]
    failures: dict[int, str]
    shape: tuple[int, ...]
    workers: int
    seconds: float
    busy: float

    def __getitem__(self, label: str) -> NDArray[np.float64]:
        if label in self.labels:
            return self.values[:, self.labels.index(label)]
        if label in self.names:
            return self.points[:, self.names.index(label)]
        known = ", ".join((*self.names, *self.labels))
        raise OptionError(f"ensemble: there is no '{label}', only {known}.")

    def __len__(self) -> int:
        return len(self.points)

    def quantile(self, label: str, q: float | Sequence[float] | NDArray[np.float64]) -> Any:
        """Quantiles of a result over all runs that have one, linear between two of them.

        Parameters
        ----------
        label : str
            Of the result.
        q : float or sequence of float
            Between 0 and 1.

        Returns
        -------
        float or ndarray

        Raises
        ------
        OptionError
            If no run has this result.
        """
        values = self[label]
        there = values[np.isfinite(values)]
        if not len(there):
            raise OptionError(f"ensemble: no run has '{label}'. {self._reason()}")
        return np.quantile(there, q)

    def to_pandas(self) -> Any:
        """A DataFrame, one row for each run, with an empty ``failure`` where there is none.

        Raises
        ------
        OptionError
            If pandas is not installed.
        """
        pandas = extra("pandas", "data", "to_pandas")
        columns = {name: self[name] for name in (*self.names, *self.labels)}
        reasons = [self.failures.get(i, "") for i in range(len(self.points))]
        return pandas.DataFrame(columns | {"failure": reasons})

    def _reason(self) -> str:
        return next(iter(self.failures.values()), "")

    def __repr__(self) -> str:
        head = (
            f"{len(self.points)} runs, {len(self.failures)} failed; {self.seconds:.3g} s with "
            f"{self.workers} workers, {self.busy:.3g} s of work"
        )
        rows = []
        for label in self.labels:
            good = self[label][np.isfinite(self[label])]
            spread = good if len(good) else np.array([np.nan])
            deviation = spread.std(ddof=1) if len(spread) > 1 else np.nan
            told = (spread.min(), np.median(spread), spread.max(), spread.mean(), deviation)
            rows.append((label, *map(number, told)))
        columns = ("result", "least", "median", "greatest", "mean", "deviation")
        counts: dict[str, list[int]] = {}
        for i, reason in self.failures.items():
            counts.setdefault(reason, []).append(i)
        reasons = [
            f"run {runs[0]}{f' and {len(runs) - 1} more' * (len(runs) > 1)}: {reason}"
            for reason, runs in list(counts.items())[:_TOLD]
        ]
        return "\n".join([head, table(columns, rows), *reasons])
