"""States at which nothing changes: steady state, steady rotation and rest."""

from __future__ import annotations

from collections.abc import Iterable

import casadi as ca
import numpy as np
import scipy

from lumped.analysis.changeover import Settler
from lumped.analysis.holds import Holds
from lumped.analysis.initial import initial_residuals
from lumped.analysis.linearise import growth
from lumped.analysis.result import Convergence, OperatingPoint
from lumped.analysis.settings import settings_at
from lumped.analysis.settle import settled
from lumped.analysis.start import start_point
from lumped.analysis.steady import unsteady_part
from lumped.arguments import checked
from lumped.errors import SolverError, StartError
from lumped.prune import uses
from lumped.system import Changes, Name, System

__all__ = ["equilibrium"]

_MOST_CLOSING = 20
"""Times that a linkage is closed anew at what looked like an equilibrium."""
_MOST_MODES = 10
"""Times that what sticks, slides or switches is chosen anew."""
_SINGULAR = 1e-14
_FARTHEST = 1e9
"""A free parameter so many times larger than it was runs away."""
_REST = (
    "Nothing may move at rest: stop sources of motion, and let springs or supports take the "
    "torques that do not balance."
)


@checked
def equilibrium(
    system: System,
    *,
    parameters: Changes | None = None,
    start: Changes | None = None,
    free: Iterable[Name] = (),
    rest: bool = False,
    time: float = 0.0,
    tolerance: float = 1e-10,
) -> OperatingPoint:
    """Find states whose derivatives all vanish, nearest to the start values.

    Given start values are kept and initial equations go on to hold if an equilibrium allows it, so
    a free drive turns at the speed that was given. Absolute angles or positions may go on at a
    constant rate if nothing depends on how far they turned together (steady rotation).

    The search starts from `start_point`. It is a Newton iteration with minimum-norm steps
    (Deuflhard, Newton Methods for Nonlinear Problems, ch. 4). Where that fails, the way on which
    the system settles is followed in pseudo-time.

    Parameters
    ----------
    system : System
        From `assemble`.
    parameters, start : mapping of name to float, optional
        Parameters to change, start values to set.
    free : iterable of names
        Parameters that the equilibrium determines, for example the torque of a motor that turns
        its load at the given speed. Given start values must then hold.
    rest : bool
        Nothing moves: all speeds are zero, whatever start values instances give them.
    time : float
        Instant at which functions of time are taken, s.
    tolerance : float
        Largest remaining derivative, relative to the derivatives' own scale.

    Raises
    ------
    SolverError
        If there is no equilibrium near the start; the text names the worst equation.
    StartError
        If free parameters are not determined, or speeds are given to a system at rest.
    """
    places = system.places(free)
    begin = start_point(system, parameters, start)
    if rest:
        _refuse_speeds(system, start)
    unknowns = {*system._flat.given, *(system._tree.unknown(name) for name in start or {})}
    nodes = (system._reduced.node(unknown) for unknown in unknowns)
    given = {node for node in nodes if node is not None} - {*system._values.implicit}
    for _ in range(_MOST_MODES):
        found = _with_modes(begin, given, places, rest, time, tolerance)
        begin = _settled(found)
        if begin is found:
            system.check_parameters(found.theta)
            return found
    raise SolverError(
        f"{system.name}: no equilibrium near the start values: what sticks or slides changes "
        "again and again. Give start values nearer to it."
    )


def _with_modes(
    begin: OperatingPoint,
    given: set[int],
    places: list[int],
    rest: bool,
    time: float,
    tolerance: float,
) -> OperatingPoint:
    """Equilibrium in which everything sticks, slides and is switched as at the begin."""
    system = begin.system
    stuck = _stuck(begin)
    held, others = _kept(system, given | stuck, initial_residuals(system)[0])
    still, resting = _kept(system, stuck, ca.SX(0, 1))
    if rest:
        still |= np.array([_order(system, n) > 0 for n in system.states], dtype=bool)
    every = scipy.sparse.eye_array(len(still), format="csc")
    change = every if rest else unsteady_part(begin)
    x = np.where(still, 0.0, begin.x)
    implicit = begin.modes[len(begin.modes) - len(system._values.implicit) :]
    settings = settings_at(system, x, begin.theta, time + 1e-300, implicit, begin.modes)
    attempts = [(held | still, others)] + [(still, resting)] * (not places)
    for fixed, kept in attempts:
        search = _Search(begin, places, time, tolerance, change, kept)
        found = search.near(x, settings, ~fixed, still)
        if found is not None:
            if rest:
                search.check_rest(found)
            return found
    raise SolverError(search.fault("rest" if rest else "equilibrium"))


def _order(system: System, node: int) -> int:
    return system._reduced.class_and_order(node)[1]


def _settled(point: OperatingPoint) -> OperatingPoint:
    """The point, with what sticks, slides and is switched there; itself if nothing changes.

    What would have to slide backwards on the way there is tried at standstill first.
    """
    system, switching = point.system, point.system.switching
    if not switching:
        return point
    modes, guesses = np.split(point.modes, [len(point.modes) - len(system._values.implicit)])
    holds, time, x = Holds(system, point.theta), point.time + 1e-300, point.x.copy()
    speed = holds.look(time, x, modes, guesses).v
    _, forward, backward = holds.parts(modes)
    turned = (forward & (speed < 0) | backward & (speed > 0)) & ~switching.has_gap
    holds.stop(x, turned)
    settler = Settler(system, point.theta, 1.0)
    _, now, changes = settler.settle(time, x, modes, guesses, modes)
    if not changes:
        return point
    return OperatingPoint(system, 0.0, x, point.theta, np.append(now, guesses))


def _stuck(point: OperatingPoint) -> set[int]:
    """Speeds that are held at zero."""
    switching = point.system.switching
    if not switching:
        return set()
    stuck = point.modes[switching.first_modes] > 0.5
    return {node for node, on in zip(switching.speeds, stuck, strict=True) if on and node >= 0}


def _kept(system: System, nodes: set[int], equations: ca.SX) -> tuple[np.ndarray, ca.SX]:
    """States among the nodes; the other nodes and equations that must keep their values."""
    held = np.array([node in nodes for node in system.states], dtype=bool)
    others = sorted(nodes.difference(system._reduced.states))
    expression = ca.vertcat(system._values.of(others), equations)
    used = uses(expression, system._values).tocoo()
    lost = used.row[~np.isin(used.col, system._in_use)]
    kept = np.setdiff1d(np.arange(expression.numel()), lost).tolist()
    return held, expression[kept] if kept else ca.SX(0, 1)


def _refuse_speeds(system: System, start: Changes | None) -> None:
    for name, value in (start or {}).items():
        node = system._reduced.node(system._tree.unknown(name))
        if node is not None and _order(system, node) > 0 and value:
            raise StartError(
                f"{system.key(name)} = {value:g} {system.quantity(name).unit}: nothing moves at "
                "rest. Leave out this start value, or rest=True."
            )


class _Search:
    """Newton's method on the states and free parameters of a system.

    Parameters
    ----------
    begin : OperatingPoint
        Whose parameters and values of `kept` hold.
    places : list of int
        Places of the free parameters.
    change : csc_array, shape (states, states)
        What of the derivatives must vanish: a projection on what is no steady motion.
    kept : SX
        Expressions that must keep the values that they have at the begin.
    """

    def __init__(
        self,
        begin: OperatingPoint,
        places: list[int],
        time: float,
        tolerance: float,
        change: scipy.sparse.csc_array,
        kept: ca.SX,
    ) -> None:
        self.system, self.theta, self.places = begin.system, begin.theta, places
        self.time, self.tolerance, self.change = time, tolerance, change
        x, theta = self.system._inputs[:2]
        free = theta[places] if places else ca.SX(0, 1)
        by_parameters = ca.SX(len(begin.x), 0)
        if places:
            by_parameters = ca.jacobian(self.system.rates, free)
        self.effects = ca.Function(
            "effects",
            self.system._inputs,
            [
                by_parameters,
                kept,
                ca.jacobian(kept, ca.vertcat(x, free)),
            ],
        )
        self.wanted = np.asarray(
            self.effects(begin.x, begin.theta, begin.time, begin.modes)[1]
        ).ravel()
        self.residual = np.zeros(len(begin.x) + len(self.wanted))
        self.iterations = self.evaluations = 0

    def near(
        self, begin: np.ndarray, settings: np.ndarray, movable: np.ndarray, still: np.ndarray
    ) -> OperatingPoint | None:
        """An equilibrium near a point, if one is found; only movable states change.

        On its way to rest also what shall stand still in the end may move.
        """
        found = self._closed(begin, settings, movable)
        if found is None and not self.places:
            point = OperatingPoint(self.system, self.time, begin, self.theta, settings)
            end = settled(point, movable | still, self.change)
            if end is not None:
                found = self._closed(np.where(still, 0.0, end[0]), end[1], movable)
        return found

    def _closed(
        self, begin: np.ndarray, settings: np.ndarray, movable: np.ndarray
    ) -> OperatingPoint | None:
        """Newton's method, repeated until linkages are closed where it ends."""
        z = np.concatenate([begin, self.theta[self.places]])
        for _ in range(_MOST_CLOSING):
            z, found = self._newton(z, settings, movable)
            if not found:
                return None
            before, (x, theta) = settings, self._parted(z)
            guesses = before[len(before) - len(self.system._values.implicit) :]
            settings = settings_at(self.system, x, theta, self.time + 1e-300, guesses, settings)
            if np.allclose(settings, before, rtol=1e-9, atol=1e-12):
                self._check_determined(z, settings, movable)
                search = self._convergence(z, settings, movable)
                return OperatingPoint(self.system, self.time, x, theta, settings, search=search)
        return None

    def _convergence(self, z: np.ndarray, settings: np.ndarray, movable: np.ndarray) -> Convergence:
        """What the search cost, and how well its result is founded."""
        matrix, scale = self._jacobian(z, settings)
        left = np.abs(self._missed(z, settings)) / scale
        columns = np.append(movable, np.ones(len(self.places), dtype=bool))
        scaled = (matrix * (np.abs(z) + 1e-3) / scale[:, None])[:, columns]
        sizes = np.linalg.svd(scaled, compute_uv=False)
        least = sizes[len(sizes) - 1] if scaled.shape[1] <= scaled.shape[0] and len(sizes) else 0.0
        condition = sizes[0] / least if least > _SINGULAR * sizes.max(initial=0.0) else np.inf
        point = OperatingPoint(self.system, self.time, *self._parted(z), settings)
        cost, residual = (self.iterations, self.evaluations), float(left.max(initial=0.0))
        return Convergence(*cost, residual, float(condition), growth(self.system, point)[0])

    def _parted(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States and parameters."""
        theta = self.theta.copy()
        count = len(self.system.states)
        theta[self.places] = z[count:]
        return z[:count], theta

    def _missed(self, z: np.ndarray, settings: np.ndarray) -> np.ndarray:
        """Derivatives that must vanish, then changes of what is kept."""
        self.evaluations += 1
        point = (*self._parted(z), self.time, settings)
        rates = self.change @ np.asarray(self.system.rhs(*point)).ravel()
        return np.append(rates, np.asarray(self.effects(*point)[1]).ravel() - self.wanted)

    def _jacobian(self, z: np.ndarray, settings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of these by states and free parameters, and their own scale."""
        point = (*self._parted(z), self.time, settings)
        by_parameters, _, kept = (part.full() for part in self.effects(*point))
        rates = np.hstack([self.system.jacobian(*point)[0].full(), by_parameters])
        matrix = np.vstack([self.change @ rates, kept])
        return matrix, np.abs(matrix) @ (np.abs(z) + 1e-3) + 1e-9

    def _newton(
        self, z: np.ndarray, settings: np.ndarray, movable: np.ndarray
    ) -> tuple[np.ndarray, bool]:
        """Where the iteration ends, and whether the derivatives vanish there."""
        columns = np.append(movable, np.ones(len(self.places), dtype=bool))
        first = self.residual = self._missed(z, settings)
        far = _FARTHEST * (np.abs(z[len(movable) :]) + 1.0)
        for _ in range(100):
            if not np.isfinite(self.residual).all():
                break
            matrix, scale = self._jacobian(z, settings)
            if (np.abs(self.residual) <= self.tolerance * scale).all():
                return z, True
            if not (columns.any() and np.isfinite(matrix).all()):
                break
            self.iterations += 1
            step = np.zeros(len(z))
            scaled = matrix[:, columns] / scale[:, None]
            step[columns] = scipy.linalg.lstsq(
                scaled, -self.residual / scale, lapack_driver="gelsy"
            )[0]
            z, moved = self._line_search(z, step, scale, settings)
            if not moved:
                break
            if (np.abs(z[len(movable) :]) > far).any():  # as if a body were infinitely heavy
                self.residual = first
                break
        return z, False

    def _line_search(
        self, z: np.ndarray, step: np.ndarray, scale: np.ndarray, settings: np.ndarray
    ) -> tuple[np.ndarray, bool]:
        """Shorten the step until it helps."""
        before = float(np.linalg.norm(self.residual / scale))
        for power in range(12):
            trial = z + 0.5**power * step
            found = self._missed(trial, settings)
            if np.isfinite(found).all() and np.linalg.norm(found / scale) < before * (1 - 1e-4):
                self.residual = found
                return trial, True
        return z, False

    def _check_determined(self, z: np.ndarray, settings: np.ndarray, movable: np.ndarray) -> None:
        """Refuse free parameters that could be others."""
        if not self.places:
            return
        columns = np.append(movable, np.ones(len(self.places), dtype=bool))
        matrix, scale = self._jacobian(z, settings)
        scaled = matrix * (np.abs(z) + 1e-3) / scale[:, None]
        open_ = np.abs(scipy.linalg.null_space(scaled[:, columns])).max(axis=1, initial=0.0)
        p = self.system._flat.parameters
        lost = np.array(self.places)[open_[int(movable.sum()) :] > 1e-6]
        if len(lost):
            names = ", ".join(p.names[p.free[place]] for place in lost)
            raise StartError(
                f"{self.system.name}: the equilibrium does not determine the free parameters "
                f"{names}. Give more start values, for example a speed, or free fewer."
            )

    def check_rest(self, point: OperatingPoint) -> None:
        """Refuse an equilibrium in which something moves."""
        system = self.system
        nodes = [system._reduced.states[i] + 1 for i in sorted(system._positions)]
        lost = np.setdiff1d(np.arange(len(system._reduced.states)), system._in_use)
        speeds = ca.Function(
            "speeds", system._inputs, [system._without(system._values.of(nodes), lost)]
        )
        found = np.asarray(speeds(point.x, point.theta, point.time, point.modes)).ravel()
        for node, speed in zip(nodes, found, strict=True):
            if not abs(speed) <= 1e-9:
                name = system._node_name(node)
                unit = "" if "(" in name else f" {system.quantity(name).unit}"
                raise SolverError(f"{system.name}: no rest: {name} = {speed:.4g}{unit}. {_REST}")

    def fault(self, what: str) -> str:
        """Why the last search found nothing."""
        system, residual = self.system, self.residual[: len(self.system.states)]
        worst = int(np.argmax(np.where(np.isfinite(residual), np.abs(residual), np.inf)))
        hint = (
            "A free drive with a net torque accelerates for ever: add a load or damper, or set "
            "torques that balance."
        )
        if self.places:
            hint = (
                "The given start values must hold beside free parameters: give fewer of them, or "
                "free a parameter that has an effect there."
            )
        elif what == "rest":
            hint = _REST
        elif system._in_use[worst] in system._positions:
            hint = "It moves while something depends on where it is, which is no equilibrium."
        return (
            f"{system.name}: no {what} near the start values: der({system.state_names[worst]}) "
            f"stays at {residual[worst]:.4g} "
            f"after {self.iterations} iterations of Newton's method. {hint}"
        )
