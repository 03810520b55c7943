"""Results of many runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np

from lumped.errors import OptionError, nearest
from lumped.plots.draw import Canvas, draw
from lumped.plots.numbers import histograms
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.by_name import ByName
from lumped.support.display_units import Shown, Units, choose_units, display
from lumped.support.optional_packages import extra
from lumped.support.ranking import quantiles, ranks
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, table

_SHOWN = 3
"""Reasons of failures in a printed result."""


@dataclass(frozen=True, eq=False)
class Ensemble(ByName, RichHtml):
    """Results of many runs; ``found[label]`` gives one of them for all runs.

    ``found[[label, label]]`` gives several as columns, ``list(found)`` all labels;
    ``len(found)`` is the number of runs.

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
    title : str
        Name of the system.
    units : tuple of str
        Units of the results, where they are known.
    """

    names: tuple[str, ...]
    points: Real
    labels: tuple[str, ...]
    values: Real
    failures: dict[int, str]
    shape: tuple[int, ...]
    workers: int
    seconds: float
    busy: float
    title: str = ""
    units: tuple[str, ...] = ()

    def __getitem__(self, label: str | list[str]) -> Real:
        if isinstance(label, list):
            return np.column_stack([self[one] for one in label])
        if label in self.labels:
            return self.values[:, self.labels.index(label)]
        if label in self.names:
            return self.points[:, self.names.index(label)]
        raise OptionError(f"ensemble: there is no '{label}'. {nearest(label, self._names())}")

    def _names(self) -> tuple[str, ...]:
        return (*self.names, *self.labels)

    def __len__(self) -> int:
        return len(self.points)

    def quantile(self, label: str, q: float | Sequence[float] | Real) -> Any:
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
        there = values[~np.isnan(values)]
        if not len(there):
            raise OptionError(f"ensemble: no run has '{label}'. {self._reason()}")
        return quantiles(there, q)

    def rank_correlations(self, label: str) -> dict[str, float]:
        """How strongly a result goes with what was varied: 1 or -1 if it follows one alone.

        Spearman's correlation of ranks over all runs that have the result, the strongest first.

        Parameters
        ----------
        label : str
            Of the result.

        Returns
        -------
        dict of str to float
            By the names of what was varied.

        Raises
        ------
        OptionError
            If fewer than three runs have this result.
        """
        values = self[label]
        there = ~np.isnan(values)
        if there.sum() < 3:
            raise OptionError(
                f"ensemble: {there.sum()} runs have '{label}'; for correlations three are needed. "
                f"{self._reason()}"
            )
        own = ranks(values[there])
        found = {n: _correlation(ranks(self[n][there]), own) for n in self.names}
        return dict(sorted(found.items(), key=lambda item: -abs(item[1])))

    @checked
    def plot(
        self,
        labels: Sequence[str] | None = None,
        *,
        units: Units = None,
        **canvas: Unpack[Canvas],
    ) -> Any:
        """Histograms of results, those named or all, with medians and quantiles.

        Parameters
        ----------
        labels : sequence of str, optional
            Of the results.
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        found = {label: self[label] for label in (self.labels if labels is None else labels)}
        shown = self._choose_units(units)
        results = {k: (shown[k].unit, shown[k].value(y)) for k, y in found.items()}
        return draw(histograms(self.title, results), **canvas)

    def to_pandas(self, *, units: Units = None) -> Any:
        """A DataFrame, one row for each run, with an empty ``failure`` where there is none.

        Units of the results are in ``frame.attrs``; what was varied is in SI units.

        Parameters
        ----------
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.

        Raises
        ------
        OptionError
            If pandas is not installed.
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        pandas = extra("pandas", "data", "to_pandas")
        shown = self._choose_units(units)
        columns = {name: self[name] for name in self.names}
        columns |= {label: shown[label].value(self[label]) for label in self.labels}
        reasons = [self.failures.get(i, "") for i in range(len(self.points))]
        frame = pandas.DataFrame(columns | {"failure": reasons})
        frame.attrs = {"units": {label: shown[label].unit for label in self.labels}}
        return frame

    def _units(self) -> dict[str, str]:
        """SI units of the results; empty where they are not known."""
        return dict.fromkeys(self.labels, "") | dict(zip(self.labels, self.units, strict=False))

    def _choose_units(self, units: Units) -> dict[str, Shown]:
        choice = choose_units(units, self.labels)
        varied = dict.fromkeys(self.names, Shown(""))
        return varied | {k: display(k, unit, choice) for k, unit in self._units().items()}

    def _reason(self) -> str:
        return next(iter(self.failures.values()), "")

    def __repr__(self) -> str:
        head = (
            f"{len(self.points)} runs, {len(self.failures)} failed; {self.seconds:.3g} s with "
            f"{self.workers} workers, {self.busy:.3g} s of work"
        )
        rows = []
        units = self._units()
        for label in self.labels:
            good = self[label][~np.isnan(self[label])]
            spread = good if len(good) else np.array([np.nan])
            known = len(spread) > 1 and np.isfinite(spread).all()
            deviation = spread.std(ddof=1) if known else np.nan
            middle = float(quantiles(spread, 0.5))
            summary = (spread.min(), middle, spread.max(), spread.mean())
            *texts, unit = amounts(label, units[label], *summary)
            off, _ = amounts(label, units[label], deviation, is_change=True)
            rows.append((label, *texts, off, unit))
        columns = ("result", "least", "median", "greatest", "mean", "deviation", "unit")
        return "\n".join([head, table(columns, rows), *list_reasons(self.failures)])


def list_reasons(failures: Mapping[int, str]) -> list[str]:
    """The first reasons of failures, and how many runs have each."""
    counts: dict[str, list[int]] = {}
    for i, reason in failures.items():
        counts.setdefault(reason, []).append(i)
    return [
        f"run {runs[0]}{f' and {len(runs) - 1} more' * (len(runs) > 1)}: {reason}"
        for reason, runs in list(counts.items())[:_SHOWN]
    ]


def _correlation(a: Real, b: Real) -> float:
    """Of two series; zero if one of them is constant."""
    a, b = a - a.mean(), b - b.mean()
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 0 else 0.0
