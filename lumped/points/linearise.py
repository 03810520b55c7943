"""Linearisation at an operating point."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError, SolverError
from lumped.points.control_systems import control_names
from lumped.points.situation import one_sided, situation
from lumped.points.start import point_or_start
from lumped.support.arguments import checked
from lumped.support.arrays import Boolean
from lumped.support.by_name import find_place
from lumped.support.made_once import made_once
from lumped.support.optional_packages import extra
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.validity import refuse_point_outside

_MOST = 500
_GROWS = 1e-7


@dataclass(frozen=True, eq=False)
class Linearisation(RichHtml):
    """``der(x) = A x + B u``, ``y = C x + D u`` for small deviations.

    Attributes
    ----------
    A, B, C, D : ndarray
        Shapes (n, n), (n, inputs), (outputs, n), (outputs, inputs).
    states, inputs, outputs : tuple of str
        Names.
    point : OperatingPoint
        Where it holds.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    point: OperatingPoint

    def to_control(self) -> Any:
        """The same system for python-control, with names.

        Control refuses dots in names, so each is a slash there: ``shaft.tau`` is ``shaft/tau``,
        and ``name.replace("/", ".")`` gives the name here.

        Returns
        -------
        control.StateSpace

        Raises
        ------
        OptionError
            If there is no input or no output, a name has a slash, or the package is missing.
        """
        control = extra("control", "control", "to_control")
        states, inputs, outputs = map(control_names, (self.states, self.inputs, self.outputs))
        return control.StateSpace(
            *self._matrices("to_control"),
            name=self.point.system.name,
            states=states,
            inputs=inputs,
            outputs=outputs,
        )

    def to_scipy(self) -> Any:
        """The same system for SciPy, which knows no names.

        Returns
        -------
        scipy.signal.StateSpace

        Raises
        ------
        OptionError
            If there is no input or no output.
        """
        return scipy.signal.StateSpace(*self._matrices("to_scipy"))

    def _matrices(self, what: str) -> tuple[np.ndarray, ...]:
        if not self.D.size:
            raise OptionError(
                f"{self.point.system.name}: {what} needs at least one input and one output; name "
                "them in linearise(inputs=, outputs=)."
            )
        return self.A, self.B, self.C, self.D

    def __repr__(self) -> str:
        rows = [
            (name, *(number(v, 4) for v in row))
            for name, row in zip(self.states, self.A[:10, :8], strict=False)
        ]
        point = self.point
        rates = np.abs(point.system.rhs(*point.inputs).toarray().ravel())
        text = f"{point.system.name}: exact at t = {point.time:g} s"
        if len(rates):
            fastest = int(rates.argmax())
            text += (
                f", where der({self.states[fastest]}) = {rates[fastest]:.3g} is the fastest change"
            )
        text += f"{situation(point)}\n"
        if side := one_sided(point):
            text += f"{side}\n"
        head = (f"der of, A {self.A.shape[0]}x{self.A.shape[1]}", *self.states[:8])
        return text + table(head, rows)


@checked
def linearise(
    system: System,
    *,
    at: OperatingPoint | None = None,
    inputs: Iterable[Name] = (),
    outputs: Iterable[Name] = (),
    parameters: Changes | None = None,
) -> Linearisation:
    """Linearise a system; all derivatives are exact.

    Parameters
    ----------
    system : System
        From `assemble`.
    at : OperatingPoint, optional
        Where; default is the start point.
    inputs : iterable of names
        Parameters (or inputs given as numbers) that vary.
    outputs : iterable of names
        Quantities to observe.
    parameters : mapping of name to float, optional
        Parameters to change, if `at` is not given.

    Returns
    -------
    Linearisation

    Raises
    ------
    UnknownNameError
        If an input or output does not exist.
    SolverError
        If a derivative is not finite at the point.
    """
    point = finite(point_or_start("linearise", system, at, parameters))
    system = point.system
    matrices, given, observed = linear_matrices(system, point, inputs, outputs)
    A, B, C, D = (m.toarray() for m in matrices.at())
    return Linearisation(A, B, C, D, tuple(system.state_names), given, observed, point)


class Matrices:
    """A, B, C and D of a system at a point, as sparse matrices.

    Laws that depend on the frequency of the vibration have that frequency (see `param`).

    Parameters
    ----------
    point : OperatingPoint
        Where.
    inputs, outputs : tuple of str
        Full names.
    """

    def __init__(
        self, point: OperatingPoint, inputs: tuple[str, ...], outputs: tuple[str, ...]
    ) -> None:
        system = point.system
        self._point, self._vibrating = point, system.structure.parameters.vibrating
        self._call = _slopes(system, inputs, outputs)
        self._stated: list[scipy.sparse.csc_array] | None = None

    def theta(self, w: float | None = None) -> np.ndarray:
        """Parameters for a vibration of an angular frequency, rad/s."""
        found = self._point.theta.copy()
        if w is not None:
            found[self._vibrating] = w
        return found

    def at(self, w: float | None = None) -> list[scipy.sparse.csc_array]:
        """The matrices for a vibration of an angular frequency, rad/s; as stated without one.

        Raises
        ------
        SolverError
            If a derivative is not finite.
        """
        if not self._vibrating or w is None:
            if self._stated is None:
                self._stated = self._make(None)
            return self._stated
        return self._make(w)

    def _make(self, w: float | None) -> list[scipy.sparse.csc_array]:
        point = self._point
        found = self._call(point.x, self.theta(w), point.time, point.settings)
        matrices = [scipy.sparse.csc_array(ca.DM(m).sparse()) for m in found]
        if not all(np.isfinite(m.data).all() for m in matrices):
            raise SolverError(
                f"{point.system.name}: a derivative is not finite at the operating point:\n"
                f"{point!r}"
            )
        return matrices


@made_once
def _slopes(system: System, inputs: tuple[str, ...], outputs: tuple[str, ...]) -> ca.Function:
    """A, B, C and D."""
    x, theta, _, _ = system.inputs
    u = theta[system.places(inputs)] if inputs else ca.SX(0, 1)
    parts = [
        ca.jacobian(f, by) for f in (system.rates, system.expressions(outputs)) for by in (x, u)
    ]
    return ca.Function("linear", system.inputs, parts)


def linear_matrices(
    system: System, point: OperatingPoint, inputs: Iterable[Name], outputs: Iterable[Name]
) -> tuple[Matrices, tuple[str, ...], tuple[str, ...]]:
    """A, B, C and D, and the full names of inputs and outputs."""
    free = system.structure.parameters.free_names
    given = tuple(system.key(name) for name in inputs)
    observed = tuple(system.key(name) for name in outputs)
    for name in given:
        if given.count(name) > 1:
            raise OptionError(f"{system.name}: the input {name} is named twice.")
        fault = "is not a parameter that can vary"
        is_known = name in {*system.structure.parameters.names, *system.names()}
        if is_known and system.quantity(name).kind in ("input", "parameter"):
            fault = (
                "is given by an expression or a connection: name a parameter in that, or give it a "
                "number"
            )
        find_place(name, free, fault)
    return Matrices(point, given, observed), given, observed


def growth(system: System, point: OperatingPoint) -> tuple[float, str]:
    """Fastest growth of small deviations, 1/s, and the state in which it shows most.

    Zero if none grows, beyond rounding; nan for systems of more than 500 states, whose eigenvalues
    would take too long.
    """
    own = np.flatnonzero(moving(system, point))
    if len(own) > _MOST:
        return np.nan, ""
    if not len(own):
        return 0.0, ""
    matrix = system.state_matrix(point.inputs).toarray()[own][:, own]
    balanced = scipy.linalg.matrix_balance(matrix, permute=False)[0]
    values, vectors = scipy.linalg.eig(balanced)
    first = int(values.real.argmax())
    # an angle beside its speed is a double zero, found to the root of rounding
    if values.real[first] <= _GROWS * np.abs(values).max():
        return 0.0, ""
    most = int(np.abs(vectors[:, first]).argmax())
    return float(values.real[first]), system.state_names[own[most]]


def moving(system: System, point: OperatingPoint) -> Boolean:
    """States that can vibrate: neither cyclic nor held at the operating point, shape (n,)."""
    return ~np.isin(
        system.structure.states,
        [*system.structure.cyclic, *system.switching.find_held(point.settings)],
    )


def finite(point: OperatingPoint) -> OperatingPoint:
    """The point itself.

    Raises
    ------
    SolverError
        If a state or parameter is no number there, or equations of a component do not hold.
    """
    names = [*point.system.state_names, *point.system.structure.parameters.free_names]
    values = np.append(point.x, point.theta)
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        raise SolverError(
            f"{point.system.name}: the operating point is not finite: {names[bad[0]]} = "
            f"{values[bad[0]]}. Take one from start_point, equilibrium or a run."
        )
    refuse_point_outside(point, "at the operating point")
    return point
