"""Single shooting: whole runs, across events, with gradients by the adjoint."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from lumped.compiler.system import Changes, System
from lumped.errors import LumpedError
from lumped.functionals import Functional
from lumped.gradients.gradient import Gradient, gradient
from lumped.optimisation.design import Optimum, Task
from lumped.optimisation.first_designs import first_designs
from lumped.optimisation.search import DesignSearch
from lumped.points.start import start_point
from lumped.simulation.simulate import simulate
from lumped.timeloop.result import Trajectory

__all__ = ["RunSearch", "best_runs"]


class RunSearch(DesignSearch):
    """One run and one sweep back for each design.

    Parameters
    ----------
    until, parameters, start, rtol
        As for `optimise`.
    """

    def __init__(
        self,
        system: System,
        task: Task,
        *,
        until: float,
        parameters: Changes | None = None,
        start: Changes | None = None,
        rtol: float = 1e-8,
    ) -> None:
        base = start_point(system, parameters=parameters, start=start)
        self.options: dict[str, Any] = {"until": until, "start": start, "rtol": rtol}
        scene = {**self.options, "parameters": parameters}
        super().__init__(system, base.theta, base.parameters, task, **scene)
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

    def run(self, w: np.ndarray) -> Trajectory:
        """The run of a design."""
        if self.of:
            return self.at(w).run
        options = {**self.options, "parameters": self.changed | self.design(w)}
        return simulate(self.system, **options)

    def functional(self, key: Functional, w: np.ndarray) -> tuple[float, np.ndarray]:
        """A number of the run and its gradient."""
        row, found = self.of.index(key), self.at(w)
        slope = np.zeros(len(w))
        slope[: len(self.names)] = found.derivatives[row] * self.scale
        return float(found.values[row]), slope


def best_runs(system: System, task: Task, *, starts: int = 1, **options: Any) -> Optimum:
    """The part of `optimise` for whole runs."""
    search = RunSearch(system, task, **options)
    begins = [search.box[:, 0].copy()]
    if starts > 1:
        scene = {**options, "rtol": max(options["rtol"], 1e-6)}
        box = search.box * search.scale[:, None]
        wanted = task.weights, task.subject_to
        more = first_designs(system, search.names, box, *wanted, starts - 1, scene)
        begins += [*(more / search.scale)]
    found = []
    for begin in begins:
        search.box[:, 0] = begin
        try:
            found.append(search.confirmed())
        except LumpedError:
            if begin is begins[-1] and not found:
                raise
    found.sort(key=lambda each: each[0].objective)
    best = search.optimum(search.run(found[0][0].w), *found[0])
    others = tuple((other.objective, search.design(other.w)) for other, *_ in found[1:])
    return replace(best, others=others)
