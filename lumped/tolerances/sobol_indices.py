"""Shares of parameters in the variance by sampling, for any functional."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
import scipy

from lumped.ensembles.variants import Over, probabilities
from lumped.errors import OptionError, SolverError, shown
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import list_names, table
from lumped.timeloop.run_options import RunOptions
from lumped.tolerances.scene import Scattered, Scene, refuse_correlated, scene_of

_LEAST = 16
"""Pairs of parameter sets."""
_RESAMPLES, _AT_ONCE = 1000, 4_000_000
"""Samples drawn again for intervals; numbers in the memory at once."""
_MOST = 12
"""Parameters of each functional in a printed result."""


@dataclass(frozen=True, eq=False)
class SobolIndices(RichHtml):
    """Shares of d parameters in the variance of k functionals, with intervals.

    Attributes
    ----------
    names, labels : tuple of str
        Parameters and functionals.
    first, total : ndarray, shape (k, d)
        Share of each parameter alone, and of all in which it has a part.
    first_interval, total_interval : ndarray, shape (k, d, 2)
        Where they lie with the confidence asked for.
    confidence : float
    runs : int
        How many were made.
    failures : dict of int to str
        Why runs failed.
    left_out : ndarray of int, shape (k,)
        Pairs of parameter sets, of ``pairs``, that did not serve, since a run of theirs failed.
    pairs : int
    """

    names: tuple[str, ...]
    labels: tuple[str, ...]
    first: Real
    total: Real
    first_interval: Real
    total_interval: Real
    confidence: float
    runs: int
    failures: dict[int, str]
    left_out: np.ndarray
    pairs: int

    def __repr__(self) -> str:
        rows = []
        for k, label in enumerate(self.labels):
            for j in np.argsort(-self.total[k], kind="stable")[:_MOST]:
                texts = []
                for found, interval in (
                    (self.first, self.first_interval),
                    (self.total, self.total_interval),
                ):
                    low, high = interval[k, j]
                    texts += [f"{found[k, j]:.3f}", f"{low:.3f} to {high:.3f}"]
                rows.append((label, self.names[j], *texts))
        span = f"{self.confidence:.0%}"
        head = ("share in the variance of", "parameter", "alone", span, "with others", span)
        text = f"{self.runs} runs over {list_names(self.names)}, {len(self.failures)} failed"
        parts = [text, table(head, rows)]
        if self.failures:
            run, reason = next(iter(self.failures.items()))
            parts.append(
                f"at most {self.left_out.max()} of {self.pairs} pairs of parameter sets were left "
                f"out, as a run of theirs failed; shares hold for the others. Run {run}: {reason}"
            )
        return "\n".join(parts)


@checked
def sobol_indices(
    what: Scattered,
    *,
    over: Over,
    of: Mapping[str, Any] | Iterable[Any],
    until: float | str | None = None,
    pairs: int = 1024,
    seed: int = 0,
    confidence: float = 0.95,
    rtol: float = 1e-6,
    workers: int | None = None,
    **options: Unpack[RunOptions],
) -> SobolIndices:
    """Which parameters the variance of results comes from, for functionals of any kind.

    Two sets of parameters make a pair; with d more, which take one parameter each from the second
    and all others from the first, a pair costs d + 2 runs. Intervals come from drawing the pairs
    again.

    Parameters
    ----------
    what, over, of, until, rtol, workers
        As for `lumped.scatter`; parameters that are independent.
    pairs : int
        At least 16, best a power of two.
    seed : int
        Of the scrambled Sobol points from which pairs are drawn, and of intervals.
    confidence : float
        Of the intervals, between 0 and 1.
    **options : RunOptions
        For a system: of each run (see `RunOptions`).

    Returns
    -------
    SobolIndices

    Raises
    ------
    OptionError
        If an option makes no sense, or parameters are correlated.
    SolverError
        If fewer than 16 pairs have results.

    Notes
    -----
    A. Saltelli, P. Annoni, I. Azzini, F. Campolongo, M. Ratto, S. Tarantola: Variance based
    sensitivity analysis of model output. Design and estimator for the total sensitivity index.
    Computer Physics Communications 181 (2010) 259-270, table 2, rows b and f.
    """
    scene = scene_of(
        what,
        over=over,
        of=of,
        until=until,
        rtol=rtol,
        workers=workers,
        analysis="sobol_indices",
        **options,
    )
    return indices_of(scene, pairs, seed, confidence)


def indices_of(scene: Scene, pairs: int, seed: int, confidence: float) -> SobolIndices:
    """The same for a scene (see `sobol_indices`)."""
    if not pairs >= _LEAST:
        raise OptionError(
            f"{scene.analysis}: pairs = {shown(pairs)}: at least {_LEAST} are needed."
        )
    if not 0 < confidence < 1:
        raise OptionError(
            f"{scene.analysis}: confidence = {shown(confidence)}: a number between 0 and 1 is "
            "needed, such as 0.95."
        )
    refuse_correlated(scene)
    d = len(scene.names)
    both = scipy.special.ndtri(probabilities(pairs, 2 * d, seed, "sobol", scene.analysis))
    a, b = both[:, :d], both[:, d:]
    mixed = [np.where(np.arange(d) == j, b, a) for j in range(d)]
    values = scene.values(scene.physical(np.concatenate([a, b, *mixed])))
    f = values.reshape(d + 2, pairs, -1)
    there = np.logical_and.reduce(np.isfinite(f), axis=0)
    kept = np.count_nonzero(there, axis=0)
    if kept.min() < _LEAST:
        k = int(kept.argmin())
        run, reason = next(iter(scene.failures.items()), (0, "it has no value"))
        raise SolverError(
            f"{scene.analysis}: {kept[k]} of {pairs} pairs have {scene.labels[k]}; {_LEAST} are "
            f"needed. Run {run}: {reason}"
        )
    random = np.random.default_rng(seed)
    found = [_shares(f[:, there[:, k], k], confidence, random) for k in range(f.shape[2])]
    shares = np.array([share for share, _ in found])
    intervals = np.array([interval for _, interval in found])
    return SobolIndices(
        scene.names,
        scene.labels,
        shares[:, 0],
        shares[:, 1],
        intervals[:, 0],
        intervals[:, 1],
        confidence,
        values.shape[0],
        dict(scene.failures),
        pairs - kept,
        pairs,
    )


def _shares(f: Real, confidence: float, random: np.random.Generator) -> tuple[Real, Real]:
    """Shares alone and with others, shape (2, d), and their intervals, shape (2, d, 2).

    Parameters
    ----------
    f : ndarray, shape (d + 2, n)
        Values for the first set of each pair, the second, and the mixed ones.
    """
    n = f.shape[1]
    a, b, *mixed = f - f[:2].mean()
    columns = [a, b, a**2, b**2]
    columns += [b * (m - a) for m in mixed] + [0.5 * (m - a) ** 2 for m in mixed]
    terms = np.column_stack(columns)
    own = _of_means(terms.mean(axis=0)[None])[0]
    size = max(1, _AT_ONCE // n)
    again = []
    for begin in range(0, _RESAMPLES, size):
        count = min(size, _RESAMPLES - begin)
        drawn = random.multinomial(n, np.full(n, 1 / n), size=count)
        again.append(_of_means(drawn @ terms / n))
    tail = 0.5 * (1 - confidence)
    ends = np.quantile(np.concatenate(again), [tail, 1 - tail], axis=0)
    return own, np.moveaxis(ends, 0, -1)


def _of_means(means: Real) -> Real:
    """Shares from means of the terms of each sample, shape (samples, 2, d); 0 if nothing varies."""
    middle = means[:, :2].mean(axis=1)
    variance = means[:, 2:4].mean(axis=1) - middle**2
    parts = means[:, 4:].reshape(len(means), 2, -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = parts / variance[:, None, None]
    return np.where(np.isfinite(found), found, 0.0)
