"""Single shooting: whole runs, across events, with gradients by the adjoint."""

from __future__ import annotations

import numpy as np

from lumped.compiler.system import System
from lumped.functionals import Functional
from lumped.gradients.gradient import Gradient, gradient_of
from lumped.optimisation.design import Task
from lumped.optimisation.search import DesignSearch
from lumped.points.start import run_start
from lumped.simulation.simulate import recorder, run_on
from lumped.timeloop.results.trajectory import Trajectory
from lumped.timeloop.run_options import RunPlan


class RunSearch(DesignSearch):
    """One run and one sweep back for each design.

    Parameters
    ----------
    system, task
        What is optimised, and what is wanted.
    plan : RunPlan
        Options of each run.
    """

    def __init__(self, system: System, task: Task, plan: RunPlan) -> None:
        self.plan, self.changed = plan, plan.changes(system)
        super().__init__(system, run_start(system, plan), task, plan)
        self.tolerance = max(1e-12, plan.rtol)
        self.of = [key for key in self.keys if isinstance(key, Functional)]
        self.last: tuple[bytes, Gradient] | None = None

    def at(self, w: np.ndarray) -> Gradient:
        """Functionals of a design and their derivatives by what varies."""
        u = w[: len(self.names)]
        if self.last is None or self.last[0] != u.tobytes():
            found = gradient_of(self.system, self.of, self.names, self._plan(u))
            self.last, self.count = (u.tobytes(), found), self.count + 1
        return self.last[1]

    def result(self, w: np.ndarray) -> Trajectory:
        """The run of a design."""
        if self.of:
            return self.at(w).run
        plan = self._plan(w)
        point = run_start(self.system, plan)
        return run_on(point, plan, recorder(point, plan, 500))

    def _plan(self, w: np.ndarray) -> RunPlan:
        """Options of the run of a design."""
        return self.plan._replace(parameters=self.changed | self.design(w))

    def functional(self, key: Functional, w: np.ndarray) -> tuple[float, np.ndarray]:
        """A number of the run and its gradient."""
        row, found = self.of.index(key), self.at(w)
        slope = np.zeros(len(w))
        slope[: len(self.names)] = found.derivatives[row] * self.scale
        return float(found.values[row]), slope
