"""Newton's method for equilibria, in given positions of conditions and holds."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.errors import SolverError, StartError
from lumped.numerics.damping import damp_step
from lumped.points.linearise import growth
from lumped.timeloop.plants.executable import evaluate_at
from lumped.timeloop.results.operating_point import Convergence, OperatingPoint
from lumped.timeloop.settings import follow_settings, just_after, settings_at

_MOST_CLOSING = 20
"""Times that a linkage is closed anew at what looked like an equilibrium."""
_SHORTEST = 2.0**-11
"""Part of a Newton step at which the search ends."""
_SINGULAR = 1e-14
_FARTHEST = 1e9
"""A free parameter so many times larger than it was runs away."""
_MOST_STEPS = 500
"""Steps of pseudo-time."""
_FIRST_MOVE = 0.1
"""What the first of them may move a state, relative to its size."""
_RUNS_AWAY = 1e12
"""A state so many times larger than it was runs away."""
_REST = (
    "Nothing may move at rest: stop sources of motion, and let springs or supports take the "
    "torques that do not balance."
)


class EquilibriumSearch:
    """Newton's method on the states and free parameters of a system.

    Parameters
    ----------
    begin : OperatingPoint
        Whose time and parameters hold.
    places : list of int
        Places of the free parameters.
    change : csc_array, shape (states, states)
        What of the derivatives must vanish: a projection on what is no steady motion.
    kept : SX
        Expressions that must have certain values.
    wanted : ndarray
        These values.
    wishes : sequence of (SX, ndarray)
        Expressions that shall have certain values as far as that is possible, the first before
        all others.

    Attributes
    ----------
    on_the_way : bool
        Whether the last point found is where positions change on the way to an equilibrium.
    """

    def __init__(
        self,
        begin: OperatingPoint,
        places: list[int],
        tolerance: float,
        change: scipy.sparse.csc_array,
        kept: ca.SX,
        wanted: np.ndarray,
        wishes: Sequence[tuple[ca.SX, np.ndarray]] = (),
    ) -> None:
        self.system, self.theta, self.places = begin.system, begin.theta, places
        self.time, self.tolerance, self.change = begin.time, tolerance, change
        x, theta = self.system.inputs[:2]
        free = theta[places] if places else ca.SX(0, 1)
        by_parameters = ca.jacobian(self.system.rates, free)
        parts = [by_parameters, kept, ca.jacobian(kept, ca.vertcat(x, free))]
        self.effects = ca.Function("effects", self.system.inputs, parts)
        self.wanted, self.on_the_way = wanted, False
        self.wishes = []
        for expression, value in wishes:
            parts = [expression, ca.jacobian(expression, ca.vertcat(x, free))]
            self.wishes.append((ca.Function("wish", self.system.inputs, parts), value))
        self.residual = np.zeros(len(begin.x) + len(self.wanted))
        self.iterations = self.evaluations = 0

    def near(
        self, begin: np.ndarray, settings: np.ndarray, movable: np.ndarray, still: np.ndarray
    ) -> OperatingPoint | None:
        """An equilibrium near a point, if one is found; only movable states change.

        On its way to rest also what shall stand still in the end may move. Where positions of
        conditions or holds change on the way on which the system settles, the search ends there.
        """
        self.on_the_way = False
        found = self.newton(begin, settings, movable)
        if found is None and (self.system.switching or not self.places):
            point = OperatingPoint(self.system, self.time, begin, self.theta, settings)
            end = settle_states(point, movable | still, self.change)
            if end is not None and end[1]:
                self.on_the_way = True
                return end[0]
            if end is not None and not self.places:
                found = self.newton(np.where(still, 0.0, end[0].x), end[0].settings, movable)
        return found

    def newton(
        self, begin: np.ndarray, settings: np.ndarray, movable: np.ndarray
    ) -> OperatingPoint | None:
        """Newton's method, repeated until linkages are closed where it ends."""
        z = np.concatenate([begin, self.theta[self.places]])
        for _ in range(_MOST_CLOSING):
            z, found = self._newton(z, settings, movable)
            if not found:
                return None
            before, (x, theta) = settings, self._split(z)
            guesses = before[len(before) - len(self.system.structure.implicit) :]
            settings = settings_at(self.system, x, theta, just_after(self.time), guesses, settings)
            count = len(before) - len(guesses)
            if np.allclose(settings[count:], before[count:], rtol=1e-9, atol=1e-12):
                search = self._convergence(z, settings, movable)
                return OperatingPoint(self.system, self.time, x, theta, settings, search=search)
        return None

    def _convergence(self, z: np.ndarray, settings: np.ndarray, movable: np.ndarray) -> Convergence:
        """What the search cost, and how well its result is founded.

        Raises
        ------
        StartError
            If free parameters could be others.
        """
        matrix, scale = self._jacobian(z, settings)
        left = np.abs(self._evaluate(z, settings)) / scale
        columns = np.append(movable, np.ones(len(self.places), dtype=bool))
        scaled = (matrix * (np.abs(z) + 1e-3) / scale[:, None])[:, columns]
        self._check_determined(scaled)
        sizes = np.linalg.svd(scaled, compute_uv=False)
        least = sizes[len(sizes) - 1] if scaled.shape[1] <= scaled.shape[0] and len(sizes) else 0.0
        condition = sizes[0] / least if least > _SINGULAR * sizes.max(initial=0.0) else np.inf
        point = OperatingPoint(self.system, self.time, *self._split(z), settings)
        cost, residual = (self.iterations, self.evaluations), float(left.max(initial=0.0))
        return Convergence(*cost, residual, float(condition), growth(self.system, point)[0])

    def _split(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States and parameters."""
        theta = self.theta.copy()
        count = len(self.system.structure.states)
        theta[self.places] = z[count:]
        return z[:count], theta

    def _evaluate(self, z: np.ndarray, settings: np.ndarray) -> np.ndarray:
        """Derivatives that must vanish, then changes of what is kept."""
        self.evaluations += 1
        point = (*self._split(z), self.time, settings)
        rates = self.change @ np.asarray(self.system.rhs(*point)).ravel()
        return np.append(rates, np.asarray(self.effects(*point)[1]).ravel() - self.wanted)

    def _jacobian(self, z: np.ndarray, settings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of these by states and free parameters, and their own scale."""
        point = (*self._split(z), self.time, settings)
        by_parameters, _, kept = (part.full() for part in self.effects(*point))
        rates = np.hstack([self.system.jacobian(*point)[0].full(), by_parameters])
        matrix = np.vstack([self.change @ rates, kept])
        return matrix, np.abs(matrix) @ (np.abs(z) + 1e-3) + 1e-9

    def _newton(
        self, z: np.ndarray, settings: np.ndarray, movable: np.ndarray
    ) -> tuple[np.ndarray, bool]:
        """Where the iteration ends, and whether the derivatives vanish there."""
        columns = np.append(movable, np.ones(len(self.places), dtype=bool))
        first = self.residual = self._evaluate(z, settings)
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
            least = scipy.linalg.lstsq(scaled, -self.residual / scale, lapack_driver="gelsy")[0]
            step[columns] = least
            if self.wishes:
                step[columns] = self._follow_wishes(z, settings, step, scaled, columns)
            moved = self._damp(z, step, scale, settings)
            if moved is None:
                break
            z, self.residual = moved
            if (np.abs(z[len(movable) :]) > far).any():  # as if a body were infinitely heavy
                self.residual = first
                break
        return z, False

    def _follow_wishes(
        self,
        z: np.ndarray,
        settings: np.ndarray,
        step: np.ndarray,
        scaled: np.ndarray,
        columns: np.ndarray,
    ) -> np.ndarray:
        """The step with what it leaves open used for the wishes, one after the other."""
        space = scipy.linalg.null_space(scaled, rcond=1e-10)
        point = (*self._split(z), self.time, settings)
        for function, value in self.wishes:
            now, slopes = (part.full() for part in function(*point))
            effect = slopes[:, columns] @ space
            if not effect.size:
                continue
            short = value - now.ravel() - slopes @ step
            step = step.copy()
            step[columns] += space @ scipy.linalg.lstsq(effect, short)[0]
            space = space @ scipy.linalg.null_space(effect, rcond=1e-10)
        found: np.ndarray = step[columns]
        return found

    def _damp(
        self, z: np.ndarray, step: np.ndarray, scale: np.ndarray, settings: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """Where a part of the step leads, and what is missed there."""

        def trial(part: float) -> tuple[tuple[np.ndarray, np.ndarray], float]:
            tried = z + part * step
            found = self._evaluate(tried, settings)
            far = float(np.linalg.norm(found / scale)) if np.isfinite(found).all() else np.inf
            return (tried, found), far

        before = float(np.linalg.norm(self.residual / scale))
        return damp_step(trial, before * (1 - 1e-4), _SHORTEST)

    def _check_determined(self, scaled: np.ndarray) -> None:
        """Refuse free parameters, which are the last columns, that could be others."""
        if not self.places:
            return
        open_ = np.abs(scipy.linalg.null_space(scaled)).max(axis=1, initial=0.0)
        free = self.system.structure.parameters.free_names
        lost = np.array(self.places)[open_[-len(self.places) :] > 1e-6]
        if len(lost):
            names = ", ".join(free[place] for place in lost)
            raise StartError(
                f"{self.system.name}: the equilibrium does not determine the free parameters "
                f"{names}. Give more start values, for example a speed, or free fewer."
            )

    def check_rest(self, point: OperatingPoint) -> None:
        """Refuse an equilibrium in which something moves."""
        system = self.system
        nodes = [system.structure.reduced.states[i] + 1 for i in sorted(system.structure.positions)]
        lost = np.setdiff1d(
            np.arange(len(system.structure.reduced.states)), system.structure.in_use
        )
        speeds = ca.Function(
            "speeds",
            system.inputs,
            [system.structure.without(system.structure.values.of(nodes), lost)],
        )
        found = np.asarray(speeds(*point.inputs)).ravel()
        for node, speed in zip(nodes, found, strict=True):
            if not abs(speed) <= 1e-9:
                name = system.structure.node_name(node)
                unit = "" if "(" in name else f" {system.quantity(name).unit}"
                raise SolverError(f"{system.name}: no rest: {name} = {speed:.4g}{unit}. {_REST}")

    def fault(self, what: str) -> str:
        """Why the last search found nothing."""
        system, residual = self.system, self.residual[: len(self.system.structure.states)]
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
        elif system.structure.in_use[worst] in system.structure.positions:
            hint = "It moves while something depends on where it is, which is no equilibrium."
        return (
            f"{system.name}: no {what} near the start values: der({system.state_names[worst]}) "
            f"stays at {residual[worst]:.4g} "
            f"after {self.iterations} iterations of Newton's method. {hint}"
        )


def settle_states(
    point: OperatingPoint, movable: np.ndarray, change: scipy.sparse.csc_array
) -> tuple[OperatingPoint, bool] | None:
    """A point near that which the system approaches; None if it settles nowhere.

    And whether positions of conditions or holds change there, on the way.

    Pseudo-transient continuation (Kelley and Keyes, SIAM J. Numer. Anal. 35 (1998) 508): one
    linearised step of the implicit Euler method after the other. A step is taken if the equations
    are nearly met at its end; the next is then longer. Short steps follow the motion that the
    system would make, long ones are steps of Newton's method. States not movable are held; only
    what the matrix `change` makes of the derivatives counts. Where positions of conditions or holds
    change, the way ends.
    """
    system, begin = point.system, point.x
    nominal = np.array([_nominal(system, node) for node in system.structure.states])
    free = np.flatnonzero(movable)
    if not len(free):
        return None
    rates = change @ _rates(point)
    size = np.abs(begin) + nominal
    fastest = np.abs(rates[free] / size[free]).max()
    if not (np.isfinite(fastest) and fastest > 0):
        return None
    length = shortest = _FIRST_MOVE / fastest
    for _ in range(_MOST_STEPS):
        x = point.x
        size = np.abs(x) + nominal
        jacobian = system.jacobian(x, point.theta, point.time, point.settings)[0]
        rows = scipy.sparse.csc_array(change @ scipy.sparse.csc_array(jacobian.sparse()))[free]
        matrix = rows[:, free]
        step = np.zeros(len(x))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", scipy.sparse.linalg.MatrixRankWarning)
            euler = scipy.sparse.csc_array(scipy.sparse.eye_array(len(free)) / length - matrix)
            step[free] = np.atleast_1d(scipy.sparse.linalg.spsolve(euler, rates[free]))
        closed = follow_settings(system, x + step, point.theta, point.time, point.settings)
        share = np.inf
        if closed is not None:
            trial = replace(point, x=x + step, settings=closed)
            found = change @ _rates(trial)
            miss = (step / length - found)[free] / size[free]
            share = float(np.linalg.norm(miss) / np.linalg.norm(rates[free] / size[free]))
        if closed is None or not share <= 0.5:  # not finite counts as too far
            length /= 4
            if length < 1e-12 * shortest:
                break
            continue
        point, rates = trial, found
        if _changes(point):
            return point, True
        length *= 10 if share < 0.1 else 2
        if np.abs(step / size).max() <= 1e-8 or not rates[free].any():
            return point, False
        if (np.abs(point.x) > _RUNS_AWAY * (np.abs(begin) + nominal)).any():
            break
    return None


def _rates(point: OperatingPoint) -> np.ndarray:
    return np.asarray(point.system.rhs(*point.inputs)).ravel()


def _nominal(system: System, node: int) -> float:
    unknown = system.structure.members.get(node)
    return 1.0 if unknown is None else system.structure.tree.quantity(unknown).nominal


def _changes(point: OperatingPoint) -> bool:
    """Whether conditions or holds do not have their positions any more."""
    if not (point.system.switching and point.system.margins.size1_out(0)):
        return False
    left, tolerance = np.split(evaluate_at(point.system, "margin", *point.inputs), 2)
    return bool((left < -tolerance).any())
