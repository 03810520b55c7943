"""Designs from which searches begin: the best of many, far from each other."""

from __future__ import annotations

import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.ensembles.distributions import paired
from lumped.ensembles.ensemble import RunsAt
from lumped.ensembles.variants import variants_of
from lumped.errors import OptionError, SolverError
from lumped.functionals import Functional
from lumped.optimisation.design import bounds_of
from lumped.optimisation.search import DesignSearch
from lumped.timeloop.run_options import RunPlan

_TRIED = 128
"""Designs that are run for each search."""
_APART = 0.15
"""Least distance of designs from which searches begin, over the diagonal of the bounds."""


def first_designs(search: DesignSearch, count: int, plan: RunPlan | None) -> np.ndarray:
    """Scaled designs between bounds, of a system those whose runs are best.

    If no run keeps all constraints, those that miss them least.

    Parameters
    ----------
    search : DesignSearch
        What varies, what is made small and what holds.
    count : int
        How many designs.
    plan : RunPlan, optional
        Options of the runs of a system.

    Returns
    -------
    ndarray, shape (at most count, k)

    Raises
    ------
    OptionError
        If a bound is missing.
    ParameterError
        If a design between the bounds is out of range.
    SolverError
        If the run of every design fails.
    """
    system, names, weights = search.system, search.names, search.weights
    _, low, high = (search.box[: len(names)] * search.scale[:, None]).T
    points = draw_designs("optimise", names, low, high, count)[: _TRIED * count]
    if plan is None:
        spread: np.ndarray = apart(points, low, high, count) / search.scale
        return spread
    of = list(dict.fromkeys(k for k in (*weights, *search.bounds) if not isinstance(k, str)))
    values, failures = run_designs(
        "optimise", system, names, points, of, plan.at(max(plan.rtol, 1e-6))
    )
    if len(failures) == len(points) and np.isnan(values).all():
        raise SolverError(f"optimise: all {len(points)} runs fail. Run 0: {failures[0]}", None)
    results = dict(zip(of, values.T, strict=True))
    worth = np.zeros(len(points))
    for key, weight in weights.items():
        if not isinstance(key, str):
            worth += weight * results[key]
        elif system.key(key) in names:  # another parameter is the same in all runs
            worth += weight * points[:, names.index(system.key(key))]
    missed = np.zeros(len(points))
    for key, given in search.bounds.items():
        least, most = bounds_of(str(key), given)
        value = results[key]
        size = max([abs(b) for b in (least, most) if np.isfinite(b)], default=0.0) or 1.0
        missed += np.maximum(np.maximum(least - value, value - most), 0.0) / size
    order = np.lexsort((worth, missed))
    order = order[np.isfinite(worth[order]) & np.isfinite(missed[order])]
    found: np.ndarray = apart(points[order], low, high, count) / search.scale
    return found


def draw_designs(
    analysis: str, names: list[str], low: np.ndarray, high: np.ndarray, count: int
) -> np.ndarray:
    """Designs evenly spread between bounds, 128 or more for each of some searches.

    Raises
    ------
    OptionError
        If a bound is missing.
    """
    for name, *ends in zip(names, low, high, strict=True):
        if not np.isfinite(ends).all():
            raise OptionError(
                f"{analysis}: searches= needs both bounds of {name}; designs are tried between "
                "them."
            )
    sampler = scipy.stats.qmc.Sobol(len(names), rng=0)
    unit = sampler.random_base2(int(np.ceil(np.log2(_TRIED * count))))
    points: np.ndarray = low + (high - low) * unit
    return points


def run_designs(
    analysis: str,
    system: System,
    names: list[str],
    points: np.ndarray,
    of: list[Functional],
    plan: RunPlan,
) -> tuple[np.ndarray, dict[int, str]]:
    """Functionals of the runs of designs, shape (designs, len(of)), and why some failed."""
    over = paired(dict(zip(names, points.T, strict=True)))
    changes = plan.changes(system)
    varied = variants_of(system, over, parameters=changes, analysis=analysis)
    labels = {f"{number}": functional for number, functional in enumerate(of)}
    return RunsAt(system, varied.names, labels, plan, None)(varied.values)


def apart(points: np.ndarray, low: np.ndarray, high: np.ndarray, count: int) -> np.ndarray:
    """The first designs of a list that are not near to others, shape (at most count, k)."""
    chosen: list[np.ndarray] = []
    for point in points:
        place = (point - low) / (high - low)
        far = [np.linalg.norm(place - other) / np.sqrt(len(low)) for other in chosen]
        if len(chosen) < count and min(far, default=1.0) > _APART:
            chosen.append(place)
    begins: np.ndarray = low + (high - low) * np.array(chosen).reshape(-1, len(low))
    return begins
