"""Runs of linear drives without steps: each part between two jumps in closed form."""

from __future__ import annotations

import itertools
import math
import time as clock
from dataclasses import dataclass

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.language.lowering import has_steps
from lumped.numerics.closed_form import ClosedForm
from lumped.support.made_once import Recent, made_once
from lumped.support.text_table import list_names
from lumped.timeloop.guards import finite_fault
from lumped.timeloop.instants import instants
from lumped.timeloop.levers import may_be_unfit
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.recorder import Recorder
from lumped.timeloop.results.statistics import Used
from lumped.timeloop.run import Simulation
from lumped.timeloop.run_options import RunPlan

_HIGHEST = 6
_KEPT_PARTS = 64
"""Parts of runs whose coefficients are kept."""
_KEPT_FORMS = 16
_MOST_STATES = 200
"""States up to which eigenvalues and eigenvectors cost less than the steps of a short run."""
_MOST_INSTANTS = 300
"""Instants of functions of time up to which parts in closed form cost less than steps."""


@dataclass(frozen=True, eq=False)
class LinearForm:
    """A system that is linear in its states, with polynomials of time beside them.

    Attributes
    ----------
    system : System
        What has this form.
    degree : int
        Highest power of the time.
    """

    system: System
    degree: int
    _taylor: ca.Function
    _known: Recent[tuple[scipy.sparse.csc_array, np.ndarray]]

    def at(
        self, theta: np.ndarray, time: float, settings: np.ndarray
    ) -> tuple[scipy.sparse.csc_array, np.ndarray]:
        """A, shape (n, n), and the coefficients of ``(t - time)^k`` in g, shape (degree + 1, n)."""
        key = (theta.tobytes(), time, settings.tobytes())
        return self._known.of(key, lambda: self._at(theta, time, settings))

    def _at(
        self, theta: np.ndarray, time: float, settings: np.ndarray
    ) -> tuple[scipy.sparse.csc_array, np.ndarray]:
        none = np.zeros(len(self.system.structure.states))
        matrix = self.system.state_matrix((none, theta, time, settings))
        found = np.asarray(self._taylor(theta, time, settings)).T
        factorials = np.array([math.factorial(k) for k in range(self.degree + 1)])
        return matrix, found / factorials[:, None]


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
    x, theta, t, settings = system.inputs
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
    columns = ca.densify(ca.horzcat(*terms))
    taylor = ca.Function("taylor", [theta, t, settings], [columns])
    return LinearForm(system, len(terms) - 1, taylor, Recent(_KEPT_PARTS))


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
    return Recent(_KEPT_FORMS)


def closed_form_pays(point: OperatingPoint, until: float, rtol: float) -> bool:
    """Whether there is a closed form, with few states and rounding below the tolerance."""
    system, theta = point.system, point.theta
    if not 0 < len(system.state_names) <= _MOST_STATES:
        return False
    try:
        form = linear_form(system)
    except OptionError:
        return False
    found = instants(system, theta, point.time, until)
    if len(found.times) > _MOST_INSTANTS:
        return False
    edges = [point.time, *found.times.tolist(), until]
    modes = np.zeros(system.structure.mode_count)
    for (begin, end), now in zip(itertools.pairwise(edges), found.modes, strict=True):
        modes[found.places] = now
        matrix, _ = form.at(theta, begin, modes)
        if not np.isfinite(matrix.data).all():
            return False
        if find_closed_form(system, matrix).rounding(end - begin) > rtol:
            return False
    return True
