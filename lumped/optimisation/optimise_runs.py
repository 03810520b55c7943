"""Single shooting: whole runs, across events, with gradients by the adjoint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import numpy as np

from lumped.compiler.system import Changes, Name, System
from lumped.errors import LumpedError, OptionError
from lumped.gradients.gradient import Gradient, gradient
from lumped.numerics.nlp import Solution
from lumped.numerics.sqp import bounded, sqp
from lumped.optimisation.design import Bounds, Key, Optimum, bounds_of, varied
from lumped.optimisation.first_designs import first_designs
from lumped.points.start import start_point
from lumped.simulation.functionals import Functional

__all__ = ["RunKey", "best_runs"]

RunKey = Functional | str


def best_runs(
    system: System,
    vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
    weights: Mapping[RunKey, float],
    subject_to: Mapping[RunKey, Bounds],
    *,
    until: float,
    parameters: Changes | None = None,
    start: Changes | None = None,
    rtol: float = 1e-8,
    starts: int = 1,
) -> Optimum:
    """The part of `optimise` for whole runs: one run and one sweep back for each design."""
    options: dict[str, Any] = {"until": until, "start": start, "rtol": rtol}
    base = start_point(system, parameters=parameters, start=start)
    names, box, scale = varied(system, vary, base.theta)
    changed = {system.key(name): value for name, value in (parameters or {}).items()}
    known = base.parameters
    for key in [*weights, *subject_to]:
        if isinstance(key, str):
            system.places([key])
    for key in subject_to:
        if isinstance(key, str):
            raise OptionError(f"optimise: {key} is a parameter; its bounds belong to `vary`.")
    of = list(dict.fromkeys(k for k in [*weights, *subject_to] if not isinstance(k, str)))
    last: dict[bytes, Gradient] = {}
    count = 0

    def at(w: np.ndarray) -> Gradient:
        nonlocal count
        if w.tobytes() not in last:
            values = changed | dict(zip(names, (w * scale).tolist(), strict=True))
            last.clear()
            last[w.tobytes()] = gradient(system, of=of, to=names, parameters=values, **options)
            count += 1
        return last[w.tobytes()]

    def number(key: RunKey, w: np.ndarray) -> tuple[float, np.ndarray]:
        if isinstance(key, str):
            own = system.key(key)
            here = np.array([name == own for name in names])
            return float((w * scale)[here][0]) if here.any() else known[own], here * scale
        row, found = of.index(key), at(w)
        return float(found.values[row]), found.derivatives[row] * scale

    def objective(w: np.ndarray) -> tuple[float, np.ndarray]:
        total, slope = 0.0, np.zeros(len(w))
        for key, weight in weights.items():
            value, by = number(key, w)
            total, slope = total + weight * value, slope + weight * by
        return total, slope

    def rows(w: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[str]]:
        found = []
        for key, given in subject_to.items():
            found += bounded(str(key), *number(key, w), *bounds_of(str(key), given))
        values, slopes, labels = zip(*found, strict=True) if found else ((), (), ())
        return np.array(values), np.array(slopes).reshape(-1, len(w)), list(labels)

    begins = [box[:, 0]]
    if starts > 1:
        scene = {**options, "parameters": parameters, "rtol": max(rtol, 1e-6)}
        limits = cast(dict[Functional, Bounds], dict(subject_to))
        begins += [*first_designs(system, names, box, weights, limits, starts - 1, scene)]
    found: list[tuple[Solution, tuple[str, ...]]] = []
    for begin in begins:
        scaled = np.column_stack([begin, box[:, 1:]]) / scale[:, None]
        try:
            search = objective, rows, lambda: count
            found.append(sqp(system.name, names, scaled, *search, max(1e-12, rtol)))
        except LumpedError:
            if begin is begins[-1] and not found:
                raise
    found.sort(key=lambda pair: pair[0].objective)
    solution, active = found[0]
    best = at(solution.w)
    values: dict[Key, float] = {k: float(v) for k, v in zip(of, best.values, strict=True)}
    return Optimum(
        best.run,
        dict(zip(names, (solution.w * scale).tolist(), strict=True)),
        dict(zip(names, box[:, 0].tolist(), strict=True)),
        solution.objective,
        values,
        active,
        0.0,
        solution,
        tuple(
            (other.objective, dict(zip(names, (other.w * scale).tolist(), strict=True)))
            for other, _ in found[1:]
        ),
    )
