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
from lumped.vibration.rotating.rotation import Rotation, find_settings, samples_of, speed_of
from lumped.vibration.rotating.small_vibrations import small_vibrations

_REPEATS = 1e-9
"""Difference of rates, relative to the largest, below which a drive is the same after a cycle."""
_LOOKS = 7
"""Angles at which a drive is compared with itself a cycle later."""
_STRAIGHT = 1e-9
"""Difference from a straight line over the speed that is rounding."""
_CLOSED = 1e-11
"""What may be missing of a balance, relative to the parts that make it up."""
_SINGULAR = 1e-13
"""Singular value of the balance, relative to the largest, that is rounding."""
_STEPS = 50


def rotation(
    system: System,
    shaft: Name | None,
    speeds: Real,
    turns: int,
    at: OperatingPoint | Callable[[float], OperatingPoint] | None,
    parameters: Changes | None,
    free: Name | None,
) -> Rotation:
    """Steady rotation at speeds.

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
    if callable(at):
        points = tuple(point_at("order_response", system, at, float(w)) for w in speeds)
        x = np.array([p.x for p in points])
    elif at is None and key is not None:
        points, x = _turn_together(system, key, speeds, parameters)
    else:
        points = (at or start_point(system, parameters=parameters),)
        x = np.tile(points[0].x, (count, 1))
    first = points[0]
    system = first.system
    each = points if len(points) == count else (first,) * count
    theta, settings = (np.array([getattr(p, of) for p in each]) for of in ("theta", "settings"))
    turning = np.zeros(x.shape[1]) if key is None else _turning(first, x[0], key, turns)
    if turning.any() and system.structure.implicit:
        raise OptionError(
            f"{system.name}: linkages that close on themselves turn with {key}; compute a periodic "
            "motion (lumped.periodic) instead."
        )
    found = Rotation(
        system, key, speeds, x, theta, settings, turning, turns, points, at is not None
    )
    return found if free is None else balance_torques(found, free)


def _turn_together(
    system: System, shaft: str, speeds: Real, parameters: Changes | None
) -> tuple[tuple[OperatingPoint, ...], Real]:
    """Points at up to three speeds at which all parts move together, and states at all speeds.

    Raises
    ------
    OptionError
        If the states do not lie on straight lines over the speed.
    """
    name = speed_of(system, shaft)
    wanted = np.unique([speeds[0], 0.5 * (speeds[0] + speeds[-1]), speeds[-1]])
    points = tuple(
        start_point(system, parameters=parameters, start={name: float(w)}, together=True)
        for w in wanted
    )
    if len(points) < 3:
        return points, np.tile(points[0].x, (len(speeds), 1))
    begin, middle, end = (p.x for p in points)
    bent = np.abs(begin + end - 2 * middle)
    size = np.abs(begin) + np.abs(end)
    if (bent > _STRAIGHT * size + 1e-12).any():
        worst = system.state_names[int(np.argmax(bent - _STRAIGHT * size))]
        raise OptionError(
            f"{system.name}: {worst} is no linear function of the speed where all parts move "
            "together; give the operating point at each speed, at=lambda w: ..."
        )
    share = ((speeds - speeds[0]) / (speeds[-1] - speeds[0]))[:, None]
    return points, (1 - share) * begin + share * end


def _turning(point: OperatingPoint, x: Real, shaft: str, turns: int) -> Real:
    """By what each state grows with the angle of the shaft.

    Raises
    ------
    OptionError
        If the drive is another after the turns.
    """
    system = point.system
    own = np.zeros(len(x))
    node = system.structure.reduced.node(system.structure.tree.unknown(shaft))
    if node is None or not system.structure.available([node], cyclic=True)[0]:
        return own
    states = system.inputs[0]
    slopes = ca.jacobian(system.expressions([shaft]), states)
    ratios = np.asarray(
        ca.Function("ratios", system.inputs, [ca.densify(slopes)])(
            x, point.theta, point.time, point.settings
        )
    ).ravel()
    rates = _rates(system)
    used = np.array(ca.which_depends(system.rates, states, 1, False), dtype=bool)
    missed = np.inf
    for i in np.flatnonzero(ratios):
        step = np.zeros(len(x))
        step[i] = 2 * np.pi * turns / ratios[i]
        # at a single angle, such as a dead centre, it may be the same by chance
        angles = x + np.arange(_LOOKS)[:, None] / _LOOKS * step
        before, after = (_at(rates, found, point) for found in (angles, angles + step))
        size = np.abs(before).max(initial=1e-300)
        missed = min(missed, float(np.abs(after - before).max()) / size)
        if np.abs(after - before).max() <= _REPEATS * size:
            own[i] = 1 / ratios[i]
            return own if used[i] else np.zeros(len(x))
    if not ratios.any():
        return own
    raise OptionError(
        f"{system.name}: the drive is another after {turns} turn{'s' * (turns > 1)} of {shaft}: "
        f"rates differ by {missed:.3g} of the largest. Give turns=, the turns after which "
        "everything repeats (2 for a four-stroke engine); with shafts whose ratio is no simple "
        "fraction, give excitations= instead."
    )


def _at(rates: ManyPoints, x: Real, point: OperatingPoint) -> Real:
    """Rates at states, shapes (points, n)."""
    m = find_settings(point.system, x, point.theta, point.settings)
    return rates(x, point.theta, np.zeros(len(x)), m)


@made_once
def _rates(system: System) -> ManyPoints:
    return ManyPoints(ca.Function("rates", system.inputs, [ca.densify(system.rates)]))


def balance_torques(rotation: Rotation, free: Name) -> Rotation:
    """The rotation in which mean torques balance, with a parameter that they determine.

    Newton's method on the mean rates over the turns, at each speed from the nearest that is solved.
    Between few of many speeds states and parameter are interpolated (`interpolate_rows`).

    Raises
    ------
    OptionError
        If the parameter has no effect.
    SolverError
        If there is no balance at a speed.
    """
    system, shaft = rotation.system, rotation.shaft
    if shaft is None:
        raise OptionError(
            f"{system.name}: free={system.key(free)!r} is determined by the speed of a shaft; name "
            "its angle, shaft=."
        )
    name = system.key(free)
    (place,) = system.places([name])
    turns_with = speed_of(system, shaft)
    parts = small_vibrations(system, (name,), (turns_with,))
    states = np.flatnonzero((rotation.turning == 0) & ~rotation.idle)
    n, samples = len(rotation.turning), samples_of(rotation)
    x, theta, settings = rotation.x.copy(), rotation.theta.copy(), rotation.settings.copy()
    time = rotation.time

    def missing(k: int, at: Real, value: float) -> tuple[Real, Real, Real, float]:
        """Mean rates and missing speed, matrix, size of their parts, largest effect at an angle.

        Rates of masses that vary are torques.
        """
        own = theta[k].copy()
        own[place] = value
        points = at + rotation.angles(samples)[:, None] * rotation.turning
        m = find_settings(system, points, own, settings[k])
        found = parts(points, own, m, time)
        matrix = parts.whole_matrix(found)
        speed = rotation.speeds[k]
        residual = np.hstack(found[:2]).mean(axis=0) - speed * np.append(rotation.turning, 1.0)
        residual[:n][rotation.idle] = 0.0
        matrix[:n][rotation.idle] = 0.0
        size = np.append(np.abs(found.rates).max(axis=0), abs(speed))
        size = np.maximum(size, np.abs(matrix) @ np.abs(np.append(at, value)))
        acting = max(float(np.abs(part).max(initial=0.0)) for part in (found.B, found.D))
        return residual, matrix, np.maximum(size, 1e-300), acting

    solved: dict[int, Real] = {}

    def newton(k: int) -> Real:
        """States and the value of the parameter at a speed, from those at the nearest solved."""
        found = np.append(x[k], theta[k, place])
        if solved:
            near = min(solved, key=lambda i: abs(i - k))
            found[:n] += solved[near][:n] - x[near]
            found[n] = solved[near][n]
        unknown = np.append(states, n)
        for _ in range(_STEPS):
            residual, matrix, size, acting = missing(k, found[:n], found[n])
            worst = int(np.argmax(np.abs(residual) / size))
            if np.abs(residual[worst]) <= _CLOSED * size[worst]:
                return found
            if (np.abs(matrix[:, n]) <= _REPEATS * acting).all():
                raise OptionError(
                    f"{system.name}: free={name!r} changes no rate where the drive turns steadily; "
                    "name the torque of the load or of the motor."
                )
            own = matrix[:, unknown]
            scale = np.maximum(np.abs(own).max(axis=1), 1e-300)  # parts may all be zero at first
            step = np.linalg.lstsq(own / scale[:, None], residual / scale, rcond=_SINGULAR)[0]
            found[unknown] -= step
        names = [*system.state_names, turns_with]
        raise SolverError(
            f"{system.name}: mean torques do not balance at {rotation.speeds[k]:g} rad/s with "
            f"{name} free: {names[worst]} keeps a mean rate of {residual[worst]:.3g}. Name "
            "another parameter, or give the operating points, at=."
        )

    def row(k: int) -> tuple[Real, Real]:
        while k not in solved:
            step = k
            while step not in solved:
                try:
                    solved[step] = newton(step)
                except SolverError:
                    near = min(solved, key=lambda i: abs(i - step), default=step)
                    if abs(near - step) <= 1:
                        raise
                    step = (near + step) // 2
        return solved[k], np.abs(solved[k])

    count = len(rotation.speeds)
    if len(rotation.points) == count:
        rows = np.array([row(k)[0] for k in range(count)])
    else:
        rows = interpolate_rows(row, rotation.speeds)
    theta[:, place] = rows[:, n]
    for k in range(count):
        settings[k] = find_settings(system, rows[k : k + 1, :n], theta[k], settings[k])[0]
    return replace(rotation, x=rows[:, :n].copy(), theta=theta, settings=settings, balancing=name)
