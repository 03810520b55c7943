"""The search for a steady rotation at each of many speeds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError, SolverError
from lumped.numerics.interpolated_rows import interpolate_rows
from lumped.points.start import point_at, start_point
from lumped.support.arrays import Real
from lumped.support.made_once import made_once
from lumped.timeloop.plants.many_points import ManyPoints
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.vibration.rotating.rotation import Rotation, find_settings, speed_of
from lumped.vibration.rotating.small_vibrations import Parts, small_vibrations
from lumped.vibration.rotating.turns import everything_along, turns_of

_REPEATS = 1e-9
"""Difference of rates, relative to the largest, below which a drive is the same after a cycle."""
_NO_EFFECT = 1e-9
"""Effect of a parameter, relative to the largest at an angle, that is rounding in its mean."""
_LOOKS = 7
"""Angles at which a drive is compared with itself a cycle later."""
_STRAIGHT = 1e-9
"""Difference from a straight line over the speed, relative to the states, that is rounding."""
_NEAR_ZERO = 1e-12
"""The same, of states that are zero but for rounding."""
_CLOSED = 1e-11
"""What may be missing of a balance, relative to the parts that make it up."""
_SINGULAR = 1e-13
"""Singular value of the balance, relative to the largest, that is rounding."""
_STEPS = 50
"""Steps of Newton's method in which it must converge."""


def find_rotation(
    analysis: str,
    system: System,
    shaft: Name | None,
    speeds: Real,
    turns: int,
    at: OperatingPoint | Callable[[float], OperatingPoint] | None,
    parameters: Changes | None,
    free: Name | None,
) -> Rotation:
    """Steady rotation at speeds, for an analysis that is named in errors.

    Without a point, all parts move together. Functions of time are taken at that of the first
    point.

    Raises
    ------
    OptionError
        If options contradict each other, or the drive is another after its turns.
    SolverError
        If there is no such rotation.
    """
    if at is not None and parameters:
        raise OptionError(f"{system.name}: give parameters when making the operating point `at`.")
    if turns < 1:
        raise OptionError(f"{system.name}: turns = {turns}: a whole number of turns is needed.")
    key, count = None if shaft is None else system.key(shaft), len(speeds)
    if key is not None and system.quantity(key).unit != "rad":
        raise OptionError(
            f"{system.name}: shaft={key!r} is no angle. Name the angle of an inertia, such as "
            "'crank.phi'."
        )
    if callable(at):
        points = tuple(point_at(analysis, system, at, float(w)) for w in speeds)
        x, theta, settings = (
            np.array([getattr(p, of) for p in points]) for of in ("x", "theta", "settings")
        )
    else:
        if at is None and key is not None:
            point, x = _turn_together(system, key, speeds, parameters)
            settings = find_settings(point.system, x, point.theta, point.settings, point.time)
        else:
            point = at or start_point(system, parameters=parameters)
            x, settings = (np.tile(each, (count, 1)) for each in (point.x, point.settings))
        points, theta = (point,), np.tile(point.theta, (count, 1))
    first = points[0]
    system = first.system
    turning = np.zeros(x.shape[1]) if key is None else _turning(first, x[0], key, turns)
    if turning.any() and system.structure.implicit:
        raise OptionError(
            f"{system.name}: linkages that close on themselves turn with {key}; compute a periodic "
            "motion (lumped.periodic) instead."
        )
    found = Rotation(
        system, key, speeds, x, theta, settings, turning, turns, points, at is not None
    )
    return found if free is None else _balance_torques(found, free)


def _turn_together(
    system: System, shaft: str, speeds: Real, parameters: Changes | None
) -> tuple[OperatingPoint, Real]:
    """Point at the first speed at which all parts move together, and such states at all speeds.

    These lie on straight lines, which points at the ends and in the middle of the speeds tell.

    Raises
    ------
    OptionError
        If the states do not lie on straight lines over the speed.
    """
    name = speed_of(system, shaft)
    first, *others = (
        start_point(system, parameters=parameters, start={name: float(w)}, together=True)
        for w in np.unique([speeds[0], 0.5 * (speeds[0] + speeds[-1]), speeds[-1]])
    )
    if not others:
        return first, np.tile(first.x, (len(speeds), 1))
    begin, middle, end = (p.x for p in (first, *others))
    bent = np.abs(begin + end - 2 * middle)
    size = np.abs(begin) + np.abs(end)
    if (bent > _STRAIGHT * size + _NEAR_ZERO).any():
        worst = system.state_names[int(np.argmax(bent - _STRAIGHT * size))]
        raise OptionError(
            f"{system.name}: {worst} is no linear function of the speed where all parts move "
            "together; give the operating point at each speed, at=lambda w: ..."
        )
    share = ((speeds - speeds[0]) / (speeds[-1] - speeds[0]))[:, None]
    return first, (1 - share) * begin + share * end


def _turning(point: OperatingPoint, x: Real, shaft: str, turns: int) -> Real:
    """By what each state grows with the angle of the shaft; zero if no rate depends on it.

    One state alone leads the angle: that with which the drive is the same after the turns.

    Raises
    ------
    OptionError
        If the drive is another after the turns.
    """
    system = point.system
    none = np.zeros(len(x))
    node = system.structure.reduced.node(system.structure.tree.unknown(shaft))
    if node is None or not system.structure.available([node], cyclic=True)[0]:
        return none
    symbols = system.inputs[0]
    slopes = ca.jacobian(system.expressions([shaft]), symbols)
    ratios = np.asarray(
        ca.Function("ratios", system.inputs, [ca.densify(slopes)])(
            x, point.theta, point.time, point.settings
        )
    ).ravel()
    used = np.array(ca.which_depends(system.rates, symbols, 1, False), dtype=bool)
    missed = np.inf
    for i in np.flatnonzero(ratios):
        cycle = none.copy()
        cycle[i] = 2 * np.pi * turns / ratios[i]
        # at a single angle, such as a dead centre, it may be the same by chance
        angles = x + np.arange(_LOOKS)[:, None] / _LOOKS * cycle
        before, after = (_rates_at(point, states) for states in (angles, angles + cycle))
        largest = np.abs(before).max(initial=1e-300)
        change = float(np.abs(after - before).max()) / largest
        missed = min(missed, change)
        if change <= _REPEATS:
            return np.where(np.arange(len(x)) == i, 1 / ratios[i], 0.0) if used[i] else none
    if not ratios.any():
        return none
    raise OptionError(
        f"{system.name}: the drive is another after {turns} turn{'s' * (turns > 1)} of {shaft}: "
        f"rates differ by {missed:.3g} of the largest. Give turns=, the turns after which "
        "everything repeats (2 for a four-stroke engine); with shafts whose ratio is no simple "
        "fraction, give excitations= instead."
    )


def _rates_at(point: OperatingPoint, x: Real) -> Real:
    """Rates at states, shapes (points, n), with the parameters and the time of a point."""
    m = find_settings(point.system, x, point.theta, point.settings, point.time)
    return _rates(point.system)(x, point.theta, np.full(len(x), point.time), m)


@made_once
def _rates(system: System) -> ManyPoints:
    return ManyPoints(ca.Function("rates", system.inputs, [ca.densify(system.rates)]))


def _balance_torques(steady: Rotation, free: Name) -> Rotation:
    """The rotation in which mean torques balance, with a parameter that they determine.

    Between few of many speeds states and parameter are interpolated (`interpolate_rows`).

    Raises
    ------
    OptionError
        If the parameter has no effect.
    SolverError
        If there is no balance at a speed.
    """
    system, shaft = steady.system, steady.shaft
    if shaft is None:
        raise OptionError(
            f"{system.name}: free={system.key(free)!r} is determined by the speed of a shaft; name "
            "its angle, shaft=."
        )
    balance, count = _Balance(steady, shaft, system.key(free)), len(steady.speeds)
    if len(steady.points) > 1:
        rows = np.array([balance.solve(k)[0] for k in range(count)])
    else:
        rows = interpolate_rows(balance.solve, steady.speeds)
    x, theta, settings = rows[:, :-1].copy(), steady.theta.copy(), steady.settings.copy()
    theta[:, balance.place] = rows[:, -1]
    for k in range(count):
        settings[k] = find_settings(system, x[k : k + 1], theta[k], settings[k], steady.time)[0]
    return replace(steady, x=x, theta=theta, settings=settings, balancing=balance.name)


class _Balance:
    """The balance of mean torques at each speed: states, and then a parameter, that close it.

    Newton's method on the mean rates over the turns, from the nearest speed that is solved.
    """

    def __init__(self, steady: Rotation, shaft: str, name: str) -> None:
        self._steady, self.name = steady, name
        (self.place,) = steady.system.places([name])
        self._speed = speed_of(steady.system, shaft)
        outputs = (self._speed, *steady.standing)
        self._small = small_vibrations(steady.system, (name,), outputs)
        moving = (steady.turning == 0) & ~steady.idle
        self._unknown = np.flatnonzero(np.append(moving, True))
        self._solved: dict[int, tuple[Real, Real]] = {}

    def solve(self, k: int) -> tuple[Real, Real]:
        """States and parameter at a speed, shape (n + 1,), and the sizes of what they balance.

        Where a step to the speed is too large, one between is solved first.
        """
        while k not in self._solved:
            tried = k
            while tried not in self._solved:
                try:
                    self._solved[tried] = self._search(tried)
                except SolverError:
                    near = self._nearest(tried)
                    if near is None or abs(near - tried) <= 1:
                        raise
                    tried = (near + tried) // 2
        return self._solved[k]

    def _nearest(self, k: int) -> int | None:
        """The nearest speed that is solved."""
        return min(self._solved, key=lambda i: abs(i - k), default=None)

    def _search(self, k: int) -> tuple[Real, Real]:
        """States and parameter at a speed by Newton's method, and sizes (see `solve`).

        Raises
        ------
        OptionError
            If the parameter has no effect.
        SolverError
            If there is no balance.
        """
        found = self._guess(k)
        for _ in range(_STEPS):
            parts, residual, matrix, size = self._missing(k, found)
            worst = int(np.argmax(np.abs(residual) / size))
            columns = matrix[:, self._unknown]
            # parts may all be zero at first
            scale = np.maximum(np.abs(columns).max(axis=1), 1e-300)
            scaled = columns / scale[:, None]
            if np.abs(residual[worst]) <= _CLOSED * size[worst]:
                own = np.abs(found)
                inverse = np.linalg.pinv(scaled, rcond=_SINGULAR)
                own[self._unknown] += np.abs(inverse) @ (size / scale)
                return found, own
            acting = max(float(np.abs(part).max(initial=0.0)) for part in (parts.B, parts.D))
            if (np.abs(matrix[:, -1]) <= _NO_EFFECT * acting).all():
                raise OptionError(
                    f"{self._steady.system.name}: free={self.name!r} changes no rate where the "
                    "drive turns steadily; name the torque of the load or of the motor."
                )
            found[self._unknown] -= np.linalg.lstsq(scaled, residual / scale, rcond=_SINGULAR)[0]
        system = self._steady.system
        names = [*system.state_names, *self._small.outputs]
        raise SolverError(
            f"{system.name}: mean torques do not balance at {self._steady.speeds[k]:g} rad/s with "
            f"{self.name} free: {names[worst]} keeps a mean rate of {residual[worst]:.3g}. Name "
            "another parameter, or give the operating points, at=."
        )

    def _guess(self, k: int) -> Real:
        """What was given at a speed, moved by what the balance changed at the nearest solved."""
        x, near = self._steady.x, self._nearest(k)
        found = np.append(x[k], self._steady.theta[k, self.place])
        if near is not None:
            solved, _ = self._solved[near]
            found[:-1] += solved[:-1] - x[near]
            found[-1] = solved[-1]
        return found

    def _missing(self, k: int, found: Real) -> tuple[Parts, Real, Real, Real]:
        """All over the turns; mean rates and speed that are missing, their matrix and sizes.

        Rates of masses that vary are torques.
        """
        steady, theta = self._steady, self._steady.theta[k].copy()
        theta[self.place] = found[-1]
        there = replace(steady.at(k), x=found[None, :-1], theta=theta[None])
        turns, speed = turns_of(self._small, there), steady.speeds[k]
        parts = everything_along(self._small, there, turns)
        matrix = self._small.whole_matrix(parts, turns.weights)
        means = turns.weights @ np.hstack([parts.rates, parts.outputs])
        n = len(steady.turning)
        residual = means.copy()
        residual[: n + 1] -= speed * np.append(steady.turning, 1.0)
        residual[:n][steady.idle] = 0.0
        matrix[:n][steady.idle] = 0.0
        size = np.full(len(means), abs(speed))
        size[:n] = np.abs(parts.rates).max(axis=0)
        size = np.maximum(size, np.abs(matrix) @ np.abs(found))
        return parts, residual, matrix, np.maximum(size, 1e-300)
