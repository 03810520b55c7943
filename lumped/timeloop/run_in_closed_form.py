"""Runs of linear drives without steps: each part between two jumps in closed form."""

from __future__ import annotations

import itertools
import math
import time as clock
from typing import NamedTuple

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.language.lowering import has_steps
from lumped.numerics.closed_form import ClosedForm
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import Recent, made_once
from lumped.support.text_table import list_names
from lumped.timeloop.guards import finite_fault
from lumped.timeloop.levers import may_be_unfit
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.recorder import Recorder
from lumped.timeloop.results.statistics import Used
from lumped.timeloop.run import Simulation
from lumped.timeloop.run_options import RunPlan

_HIGHEST = 6
_DENSE = 500
"""States up to which the matrix is kept as an array."""
_KEPT_PARTS = 64
"""Parts of runs whose coefficients are kept."""
_KEPT_FORMS = 16


class Part(NamedTuple):
    """Coefficients of ``der(x) = A x + g(t)`` in a part of a run.

    Attributes
    ----------
    entries : ndarray
        Nonzeros of A, in the order of the Jacobian.
    terms : ndarray, shape (degree + 1, n)
        Coefficients of the powers of the time since the begin of the part in g.
    """

    entries: np.ndarray
    terms: np.ndarray


class LinearForm:
    """A system that is linear in its states, with polynomials of time beside them.

    Parameters
    ----------
    system : System
        What has this form.
    terms : list of SX
        Derivatives of g by the time, from the zeroth on.
    """

    def __init__(self, system: System, terms: list[ca.SX]) -> None:
        x, theta, t, settings = system.inputs
        slopes = system.jacobian(ca.SX.zeros(x.numel()), theta, t, settings)[0]
        self._cancelling, self._pattern = system.cancelling, slopes.sparsity()
        self._places = tuple(np.array(v, dtype=int) for v in self._pattern.get_triplet())
        self._factorials = np.array([[math.factorial(k)] for k in range(len(terms))], dtype=float)
        columns = ca.densify(ca.horzcat(*terms))
        entries = ca.vertcat(ca.SX(0, 1), ca.SX(slopes.nz[:]))
        function = ca.Function("part", [theta, t, settings], [ca.densify(entries), columns])
        self._coefficients = ArrayFunction(function)
        self._known: Recent[Part] = Recent(_KEPT_PARTS)
        self._solved: Recent[ClosedForm] = Recent(_KEPT_FORMS)

    def at(self, theta: np.ndarray, time: float, settings: np.ndarray) -> Part:
        """The coefficients from a time on."""
        key = (theta.tobytes(), time, settings.tobytes())
        return self._known.of(key, lambda: self._at(theta, time, settings))

    def _at(self, theta: np.ndarray, time: float, settings: np.ndarray) -> Part:
        entries, terms = self._coefficients(theta, time, settings)
        entries[self._cancelling] = 0.0
        return Part(entries, terms.reshape(len(self._factorials), -1) / self._factorials)

    def solve(self, entries: np.ndarray) -> ClosedForm:
        """The closed form for a matrix, given by its nonzeros."""
        return self._solved.of(entries.tobytes(), lambda: ClosedForm(self.matrix(entries)))

    def matrix(self, entries: np.ndarray) -> np.ndarray | scipy.sparse.csc_array:
        """The matrix with these nonzeros, sparse if it is large."""
        shape = self._pattern.shape
        if shape[0] > _DENSE:
            return scipy.sparse.csc_array((entries, self._places), shape)
        found = np.zeros(shape)
        found[self._places] = entries
        return found


def linear_form(system: System) -> LinearForm:
    """The linear form of a system.

    Raises
    ------
    OptionError
        If there is none; the text names what is not linear.
    """
    found = _form_or_refusal(system)
    if isinstance(found, OptionError):
        raise OptionError(str(found))
    return found


def has_linear_form(system: System) -> bool:
    """Whether a system has a linear form."""
    return isinstance(_form_or_refusal(system), LinearForm)


@made_once
def _form_or_refusal(system: System) -> LinearForm | OptionError:
    try:
        return _make(system)
    except OptionError as refusal:
        return refusal


def _make(system: System) -> LinearForm:
    if system.switching:
        raise _refusal(system, f"its modes depend on states, in {list_names(_switching(system))}")
    if system.structure.implicit:
        names = [system.structure.node_name(node) for node in system.structure.implicit]
        raise _refusal(system, f"{list_names(names)} follow from equations that are not linear")
    if may_be_unfit(system):
        raise _refusal(system, "what its states lead is not linear in them")
    x, _, t, _ = system.inputs
    rates = system.rates
    if has_steps(rates, ca.vertcat(x, t)):
        raise _refusal(system, "kinks stand in `smooth` or in a spline of a state")
    entries = ca.SX(ca.jacobian(rates, x).nz[:])
    moving = ca.vertcat(x, t)
    if entries.numel() and any(ca.which_depends(entries, moving, 1, False)):
        rows = ca.which_depends(rates, moving, 2, True)
        names = [n for n, bent in zip(system.state_names, rows, strict=True) if bent]
        raise _refusal(
            system,
            f"the derivatives of {list_names(names)} are not linear in the states with constant "
            "coefficients",
        )
    terms = [ca.densify(ca.substitute(rates, x, ca.SX.zeros(x.numel())))]
    while terms[-1].numel() and any(ca.which_depends(terms[-1], t, 1, False)):
        if len(terms) > _HIGHEST:
            rows = ca.which_depends(terms[-1], t, 1, True)
            names = [n for n, bent in zip(system.state_names, rows, strict=True) if bent]
            raise _refusal(
                system,
                f"what drives {list_names(names)} is no polynomial of the time between jumps, or "
                f"one of a degree above {_HIGHEST}",
            )
        terms.append(ca.densify(ca.jacobian(terms[-1], t)))
    return LinearForm(system, terms)


def _switching(system: System) -> list[str]:
    found = system.switching
    conditions = [found.relation_text(k, True)[0] for k in range(len(found.relation_modes))]
    return sorted({*conditions, *found.names})


def _refusal(system: System, why: str) -> OptionError:
    return OptionError(
        f"{system.name}: method='exact' is for linear systems between jumps of functions of time, "
        f"but {why}. Use method='auto'."
    )


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
        entries, terms = self._form.at(self.point.theta, begin, modes)
        if not (np.isfinite(entries).all() and np.isfinite(terms).all()):
            rates = self._form.matrix(entries) @ x + terms[0]
            self.refuse(finite_fault(self.system, begin, x, rates))
            self.refuse(f"a coefficient is not finite at t = {begin:g} s")
        solution = self._form.solve(entries)
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
