"""Single shooting: whole runs, across events, with gradients by the adjoint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import numpy as np

from lumped.compiler.system import Changes, Name, System
from lumped.errors import LumpedError
from lumped.gradients.gradient import Gradient, gradient
from lumped.numerics.nlp import Solution
from lumped.optimisation.design import Bounds, Optimum
from lumped.optimisation.first_designs import first_designs
from lumped.optimisation.search import DesignSearch
from lumped.points.start import start_point
from lumped.simulation.functionals import Functional

__all__ = ["RunKey", "RunSearch", "best_runs"]

RunKey = Functional | str


class RunSearch(DesignSearch[Functional]):
    """One run and one sweep back for each design.

    Parameters
    ----------
    until, parameters, start, rtol
        As for `optimise`.
    """

    def __init__(
        self,
        system: System,
        vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
        weights: Mapping[RunKey, float],
        subject_to: Mapping[RunKey, Bounds],
        *,
        until: float,
        parameters: Changes | None = None,
        start: Changes | None = None,
        rtol: float = 1e-8,
    ) -> None:
        base = start_point(system, parameters=parameters, start=start)
        super().__init__(system, base.theta, base.parameters, vary, weights, subject_to)
        self.options: dict[str, Any] = {"until": until, "start": start, "rtol": rtol}
        self.changed = {system.key(name): value for name, value in (parameters or {}).items()}
        self.tolerance = max(1e-12, rtol)
        self.of = [key for key in self.keys if isinstance(key, Functional)]
        self.last: tuple[bytes, Gradient] | None = None

    def at(self, w: np.ndarray) -> Gradient:
        """Functionals of a design and their derivatives by what varies."""
        u = w[: len(self.names)]
        if self.last is None or self.last[0] != u.tobytes():
            values = self.changed | self.design(u)
            found = gradient(
                self.system, of=self.of, to=self.names, parameters=values, **self.options
            )
            self.last, self.count = (u.tobytes(), found), self.count + 1
        return self.last[1]

    def functional(self, key: Functional, w: np.ndarray) -> tuple[float, np.ndarray]:
        """A number of the run and its gradient."""
        row, found = self.of.index(key), self.at(w)
        slope = np.zeros(len(w))
        slope[: len(self.names)] = found.derivatives[row] * self.scale
        return float(found.values[row]), slope


def best_runs(
    system: System,
    vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
    weights: Mapping[RunKey, float],
    subject_to: Mapping[RunKey, Bounds],
    *,
    starts: int = 1,
    **options: Any,
) -> Optimum:
    """The part of `optimise` for whole runs."""
    search = RunSearch(system, vary, weights, subject_to, **options)
    begins = [search.start]
    if starts > 1:
        scene = {**options, "rtol": max(options["rtol"], 1e-6)}
        limits = cast(dict[Functional, Bounds], dict(subject_to))
        box = search.box * search.scale[:, None]
        begins += [*first_designs(system, search.names, box, weights, limits, starts - 1, scene)]
    found: list[tuple[Solution, tuple[str, ...]]] = []
    for begin in begins:
        search.box[:, 0] = begin / search.scale
        try:
            found.append(search.solved())
        except LumpedError:
            if begin is begins[-1] and not found:
                raise
    found.sort(key=lambda pair: pair[0].objective)
    solution, active = found[0]
    best, first, numbers = search.found(solution.w)
    return Optimum(
        search.at(solution.w).run,
        best,
        first,
        solution.objective,
        numbers,
        active,
        0.0,
        solution,
        tuple((other.objective, search.design(other.w)) for other, _ in found[1:]),
    )
