"""Runs of linear drives without steps: each part between two jumps in closed form."""

from __future__ import annotations

import itertools
import time as clock

import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.numerics.closed_form import ClosedForm
from lumped.support.made_once import Recent, made_once
from lumped.timeloop.guards import finite_fault
from lumped.timeloop.linear_form import linear_form
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.recorder import Recorder
from lumped.timeloop.results.statistics import Used
from lumped.timeloop.run import Simulation
from lumped.timeloop.run_options import RunPlan

_KEPT = 16


class RunInClosedForm(Simulation):
    """One simulation in closed form; `rtol` limits its rounding, relative to the largest state."""

    def __init__(self, point: OperatingPoint, plan: RunPlan, output: Recorder) -> None:
        super().__init__(point, plan, output)
        self._form = linear_form(self.system)
        self.methods.append(Used(point.time, "exact"))

    def go(self) -> None:
        """Run to the end.

        Raises
        ------
        SolverError
            With what was computed so far.
        """
        edges, x, modes = self.find_instants().tolist(), self.point.x, self.point.settings
        for k, (begin, end) in enumerate(itertools.pairwise(edges)):
            before, modes = modes, modes.copy()
            modes[self.instants.places] = self.instants.modes[k]
            if k:
                self.refuse_jump(begin, x, before, modes)
            self.output.open(self.system)
            self.output.edge(begin, x, modes)
            if end > begin:
                begun = clock.perf_counter()
                x = self._through(begin, end, x, modes)
                self.seconds += clock.perf_counter() - begun
                if self.output.on_grid:
                    self.output.edge(end, x, modes)
        self.output.finish(x, modes)

    def _through(self, begin: float, end: float, x: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """States at the end of a part."""
        matrix, terms = self._form.at(self.point.theta, begin, modes)
        self.refuse(finite_fault(self.system, begin, x, matrix @ x + terms[0]))
        if not (np.isfinite(matrix.data).all() and np.isfinite(terms).all()):
            self.refuse(f"a coefficient is not finite at t = {begin:g} s")
        solution = find_closed_form(self.system, matrix)
        rounding = solution.rounding(end - begin)
        if rounding > self.rtol:
            self.refuse(
                f"rounding may reach {rounding:.1g} of the largest state by t = {end:g} s, more "
                f"than rtol = {self.rtol:g}, because the drive is so stiff, the run so long, or "
                "the model unstable. Loosen rtol, or use method='auto'."
            )
        wanted = self.output.due(end) if self.output.on_grid else np.zeros(0)
        times = np.append(wanted, end)
        found = solution.solve(x, terms, times - begin)
        if not np.isfinite(found).all():
            where = times[np.flatnonzero(~np.isfinite(found).all(axis=1))[0]]
            self.refuse(
                f"states grow beyond all numbers before t = {where:g} s; an instability of the "
                "model."
            )
        kept = slice(None, -1) if self.output.on_grid else slice(None)
        settings = np.repeat(modes[None, :], len(times), axis=0)
        self.output.add(times[kept], found[kept], settings[kept])
        self.steps += 1
        self.evaluations += 1
        last: np.ndarray = found[-1]
        return last


def find_closed_form(system: System, matrix: scipy.sparse.csc_array) -> ClosedForm:
    """Closed form for a matrix."""
    key = (matrix.indices.tobytes(), matrix.data.tobytes())
    return _closed_forms(system).of(key, lambda: ClosedForm(matrix))


@made_once
def _closed_forms(_: System) -> Recent[ClosedForm]:
    return Recent(_KEPT)
