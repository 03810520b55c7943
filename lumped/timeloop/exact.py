"""Linear drives without steps: each part of a run between two jumps in closed form."""

from __future__ import annotations

import math
import time as clock

import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.numerics.closed_form import ClosedForm
from lumped.timeloop.advance import Reached
from lumped.timeloop.guards import finite_fault
from lumped.timeloop.linear_form import linear_form
from lumped.timeloop.recorder import Recorder

__all__ = ["Exact", "closed"]

_KEPT = 16


class Exact:
    """Advances a run like `Advance`, in one step to the end of each part.

    Parameters
    ----------
    theta : ndarray
        Parameters.
    rtol : float
        Rounding must stay below this, relative to the largest state.
    output : Recorder
        Takes what is computed.

    Attributes
    ----------
    description : str
        The method.
    native : bool
        No machine code is needed.
    steps, rejected, evaluations : int
        Parts of the run, none, evaluations of the right-hand side and its matrix.
    seconds : float
        Wall time.
    atol : ndarray, shape (n,)
        No state is governed by an absolute tolerance.
    implicit_from : float
        Never, s.
    """

    def __init__(self, theta: np.ndarray, rtol: float, output: Recorder) -> None:
        self._theta, self._rtol, self._output = theta, rtol, output
        self.description, self.native, self.implicit_from = "exact", False, math.inf
        self.steps = self.rejected = self.evaluations = 0
        self.seconds = 0.0

    def take(self, system: System) -> None:
        """Integrate the states of this system from now on."""
        self._system, self._form = system, linear_form(system)
        self.atol = np.zeros(len(system.states))

    def through(
        self, begin: float, end: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray
    ) -> Reached:
        """Advance to the end.

        Raises
        ------
        SolverError
            If rounding would spoil the result, or it is beyond all numbers.
        """
        if end <= begin:
            return Reached(end, x, guess, None)
        started = clock.perf_counter()
        matrix, terms = self._form.at(self._theta, begin, modes)
        fault = finite_fault(self._system, begin, x, matrix @ x + terms[0])
        if fault or not (np.isfinite(matrix.data).all() and np.isfinite(terms).all()):
            raise SolverError(
                f"{self._system.name}: {fault or f'a coefficient is not finite at t = {begin:g} s'}"
            )
        solution = closed(self._system, matrix)
        rounding = solution.rounding(end - begin)
        if rounding > self._rtol:
            raise SolverError(
                f"{self._system.name}: rounding may reach {rounding:.1g} of the largest state by "
                f"t = {end:g} s, more than rtol = {self._rtol:g}, because the drive is so stiff, "
                "the run so long, or the model unstable. Loosen rtol, or use method='auto'."
            )
        wanted = self._output.due(end) if self._output.on_grid else np.zeros(0)
        times = np.append(wanted, end)
        found = solution.solve(x, terms, times - begin)
        if not np.isfinite(found).all():
            where = times[np.flatnonzero(~np.isfinite(found).all(axis=1))[0]]
            raise SolverError(
                f"{self._system.name}: states grow beyond all numbers before t = {where:g} s; an "
                "instability of the model."
            )
        kept = slice(None, -1) if self._output.on_grid else slice(None)
        settings = np.repeat(modes[None, :], len(times), axis=0)
        self._output.add(times[kept], found[kept], settings[kept])
        self.steps += 1
        self.evaluations += 1
        self.seconds += clock.perf_counter() - started
        return Reached(end, found[-1], guess, None)


def closed(system: System, matrix: scipy.sparse.csc_array) -> ClosedForm:
    """Closed form for a matrix, made once."""
    made = system.made.setdefault("closed forms", {})
    key = (matrix.indices.tobytes(), matrix.data.tobytes())
    if key not in made:
        if len(made) >= _KEPT:
            made.clear()
        made[key] = ClosedForm(matrix)
    found: ClosedForm = made[key]
    return found
