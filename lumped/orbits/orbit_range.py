"""Periodic motions over a range of speeds, each begun from the one before."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError, ParameterError, SolverError
from lumped.orbits.guesses import after_response, needs_time
from lumped.orbits.orbit import PeriodicOrbit
from lumped.orbits.order_check import angle_of, order_harmonics
from lumped.orbits.periodic import GRID, find_orbit, periodic, turning_problem
from lumped.orbits.shooting import Guess
from lumped.points.start import search_start
from lumped.support.arguments import checked
from lumped.support.arrays import Complex, Real
from lumped.support.display_units import speed_unit
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.vibration.ordered.order_amplitudes import OrderAmplitudes
from lumped.vibration.ordered.order_response import OrderResponse

_HALVINGS = 8
"""How often a step of the speed is halved before the range ends."""
_NEAR = 0.3
"""Part of a vibration by which it may change in a step; more is another motion."""
_ORDERS = 8
"""Periods up to the highest order, where none is named."""


@dataclass(frozen=True, eq=False)
class OrbitRange(OrderAmplitudes):
    """Periodic motions over the speed; ``found[name]`` has the shape (speeds, orders).

    Attributes
    ----------
    system, speeds, orders, of, values, means
        As in `OrderAmplitudes`; the speeds that were reached, in the order in which they were.
    orbits : tuple of PeriodicOrbit
        The motions.
    ended : str
        Where and why the motions end before the last speed; empty if they do not.
    """

    orbits: tuple[PeriodicOrbit, ...]
    ended: str

    @property
    def multipliers(self) -> Complex:
        """Floquet multipliers, the largest first, shape (k, m)."""
        return np.array([orbit.multipliers for orbit in self.orbits])

    @property
    def largest(self) -> Real:
        """Magnitude of the largest multiplier, shape (k,)."""
        return np.array([orbit.largest for orbit in self.orbits])

    @checked
    def greatest(self, of: Name) -> Real:
        """Greatest value of a quantity over the motion, shape (k,)."""
        return np.array([orbit.greatest(of).value for orbit in self.orbits])

    @checked
    def least(self, of: Name) -> Real:
        """Least value of a quantity over the motion, shape (k,)."""
        return np.array([orbit.least(of).value for orbit in self.orbits])

    def __repr__(self) -> str:
        speed = speed_unit()
        speeds = speed.value(self.speeds)
        head = (
            f"{self.system.name}: periodic motions at {len(speeds)} speeds from "
            f"{speeds[0]:g} to {speeds[-1]:g} {speed.unit}"
        )
        free = {name for orbit in self.orbits for name in orbit.free}
        if free:
            held = [(name, [orbit.free[name] for orbit in self.orbits]) for name in sorted(free)]
            head += "".join(f"; {n} from {v[0]:.6g} to {v[-1]:.6g}" for n, v in held)
        unstable = speeds[[not orbit.stable for orbit in self.orbits]]
        if len(unstable):
            head += (
                f"; {len(unstable)} unstable, from {unstable.min():g} to {unstable.max():g} "
                f"{speed.unit}"
            )
        return "\n".join([head, self.largest_orders(), *([self.ended] if self.ended else [])])


@checked
def periodic_range(
    system: System,
    *,
    speeds: Sequence[float] | np.ndarray | Mapping[Name, ArrayLike],
    of: Iterable[Name] | None = None,
    orders: Iterable[float] | None = None,
    turns: int = 1,
    warm_up: float | None = None,
    parameters: Changes | None = None,
    start: Changes | OperatingPoint | OrderResponse | None = None,
    rtol: float = 1e-10,
    iterations: int = 10,
) -> OrbitRange:
    """Periodic motions over a range of speeds, up or down, each begun from those before.

    Of a drive that turns, the mean speed is given and a torque is found, as an order response as
    the `start` says. Of a system that functions of time drive, a parameter is the speed of these,
    so that it repeats after ``2 pi turns / speed``.

    Where no motion is found near the last, the step is halved. Where steps become too short, as at
    a fold, the range ends with the last motion that was found; a range in the other direction finds
    the motions beyond.

    Parameters
    ----------
    system : System
        From `assemble`.
    speeds : array_like, shape (k,), or mapping of name to array_like
        Ascending or descending, rad/s; with the name of the parameter that is the speed, unless
        `start` is an order response.
    of : iterable of names, optional
        Quantities to observe; default is those of an order response.
    orders : iterable of float, optional
        Periods for each turn to tell; default is those of an order response, or the first
        eight.
    turns : int
        Turns after which everything repeats; an order response has its own.
    warm_up, parameters, start
        As for `periodic`, at the first speed; or `start` alone, an order response, which begins at
        its nearest speed.
    rtol : float
        As for `periodic`. Tighter than elsewhere: what is missing after a period adds up.
    iterations : int
        Newton steps at each speed after which to give up.

    Returns
    -------
    OrbitRange

    Raises
    ------
    OptionError
        If options contradict each other or make no sense.
    SolverError
        If no motion is found at the first speed.
    """
    if isinstance(start, OrderResponse) and not isinstance(speeds, Mapping):
        if turns != 1 or any(v is not None for v in (warm_up, parameters)):
            raise OptionError(
                "periodic_range: an order response has its turns and parameters; leave these out, "
                "and warm_up."
            )
        grid, response = _monotonic(speeds), start
        turns = response.rotation.turns
        outputs = response.of if of is None else tuple(system.key(name) for name in of)
        problem, free = turning_problem(system, response, rtol, iterations)
        k = int(np.abs(response.speeds - grid[0]).argmin())
        near, guess = float(response.speeds[k]), after_response(problem, response, k)
        first = find_orbit(problem, guess, GRID, free)
        march = _March(near, first, turns, None)
        march.reach(float(grid[0]))
        if march.ended:
            raise SolverError(f"{system.name}: {march.ended}")
        angle = angle_of(response, k)
    elif isinstance(speeds, Mapping) and not isinstance(start, OrderResponse):
        if len(speeds) != 1:
            raise OptionError(
                f"periodic_range: speeds = {dict(speeds)}: one parameter is the speed."
            )
        ((parameter, values),) = speeds.items()
        grid, response = _monotonic(values), None
        outputs = tuple(system.key(name) for name in of or ())
        name, speed = system.key(parameter), float(grid[0])
        if isinstance(turns, bool) or turns < 1:
            raise OptionError(f"periodic_range: turns = {turns!r}: a whole number is needed.")
        (place,) = system.places([name])
        given = {system.key(n): value for n, value in (parameters or {}).items()}
        point = search_start(system, {**given, name: speed}, start)
        if not needs_time(point.system, point.theta):
            raise OptionError(
                f"periodic_range: no function of time acts on {system.name}; give an order "
                "response as the start."
            )
        first = periodic(
            point.system,
            period=2 * np.pi * turns / speed,
            warm_up=warm_up,
            start=point,
            grid=GRID,
            rtol=rtol,
            iterations=iterations,
        )
        march, angle = _March(speed, first, turns, place), None
    else:
        raise OptionError(
            "periodic_range: start= an order response, or name the parameter that is the speed of "
            "functions of time: speeds={name: values}."
        )
    if not outputs:
        raise OptionError("periodic_range: name at least one quantity to observe, of=[...].")
    chosen = _orders(orders, response, turns)
    found = [march.orbit]
    for target in grid[1:]:
        march.reach(float(target))
        if march.ended:
            break
        found.append(march.orbit)
    each = [order_harmonics(orbit, outputs, chosen, turns, angle) for orbit in found]
    values, means = (np.array(part) for part in zip(*each, strict=True))
    speeds = grid[: len(found)]
    return OrbitRange(system, speeds, chosen, outputs, values, means, tuple(found), march.ended)


class _March:
    """From motion to motion over the speed.

    Parameters
    ----------
    speed : float
        Of the first motion, rad/s.
    prescribed : int or None
        Place of the parameter that is the speed.
    """

    def __init__(
        self, speed: float, first: PeriodicOrbit, turns: int, prescribed: int | None
    ) -> None:
        self.turns, self.prescribed, self.known = turns, prescribed, [(speed, first)]
        self.ended = ""

    @property
    def orbit(self) -> PeriodicOrbit:
        """The last motion."""
        return self.known[-1][1]

    def reach(self, target: float) -> None:
        """Go to a speed, in shorter steps where there is no motion near the last."""
        step = target - self.known[-1][0]
        least = abs(step) * 2.0**-_HALVINGS
        fault = ""
        while self.known[-1][0] != target:
            (now, last), free = self.known[-1], next(iter(self.orbit.free), None)
            speed = target if abs(target - now) <= abs(step) * (1 + 1e-9) else now + step
            try:
                orbit = find_orbit(last.problem, self._predict(speed), GRID, free)
                fault = "the motions found there are others" * (_apart(last, orbit) > _NEAR)
            except (SolverError, ParameterError) as error:
                fault = str(error).partition(": ")[2].partition(". ")[0]
            if not fault:
                self.known = [*self.known[-1:], (speed, orbit)]
                continue
            step = 0.5 * (speed - now)
            if abs(step) < least:
                self.ended = (
                    f"ends at {now * 30 / np.pi:.6g} 1/min, where the largest multiplier is "
                    f"{last.largest:.4g}: no motion near the last was found in steps down to "
                    f"{abs(2 * step) * 30 / np.pi:.2g} 1/min ({fault})"
                )
                return

    def _predict(self, speed: float) -> Guess:
        """On a straight line through the last two motions."""
        now, last = self.known[-1]
        point = last.found.guess.point
        x, theta = point.x.copy(), point.theta.copy()
        if len(self.known) > 1:
            before, other = self.known[0]
            part = (speed - now) / (now - before)
            x += part * (point.x - other.found.guess.point.x)
            theta += part * (theta - other.found.guess.point.theta)
        if self.prescribed is not None:
            theta[self.prescribed] = speed
        point.system.check_parameters(theta)
        moved = OperatingPoint(point.system, 0.0, x, theta, point.settings)
        return replace(last.found.guess, point=moved, period=2 * np.pi * self.turns / speed)


def _apart(one: PeriodicOrbit, other: PeriodicOrbit) -> float:
    """Difference of two vibrations, of the state where it is largest, over their size."""
    a, b = (_vibration(orbit) for orbit in (one, other))
    size = np.maximum(np.abs(a).max(axis=0), np.abs(b).max(axis=0))
    least = 1e-6 * np.maximum(np.abs(one.run.x).max(axis=0), 1e-300)[one.problem.active]
    return float((np.abs(a - b).max(axis=0) / np.maximum(size, least)).max())


def _vibration(orbit: PeriodicOrbit) -> Real:
    """States over the period, without their means and what they gain, shape (points, n)."""
    run, problem = orbit.run, orbit.problem
    share = np.linspace(0, 1, GRID, endpoint=False)
    x = np.column_stack([np.interp(share * orbit.period, run.t, column) for column in run.x.T])
    x = (x - share[:, None] * problem.advance)[:, problem.active]
    found: Real = x - x.mean(axis=0)
    return found


def _monotonic(speeds: ArrayLike) -> Real:
    grid = np.asarray(speeds, dtype=float).ravel()
    steps = np.diff(grid)
    good = np.isfinite(grid).all() and (grid > 0).all() and ((steps > 0).all() or (steps < 0).all())
    if not len(grid) or not good:
        raise OptionError(
            "periodic_range: speeds must ascend or descend, finite and above zero, rad/s."
        )
    return grid


def _orders(orders: Iterable[float] | None, response: OrderResponse | None, turns: int) -> Real:
    if orders is None and response is not None:
        return response.orders
    if orders is None:
        return np.arange(1, _ORDERS + 1) / turns
    chosen = np.array(sorted({float(order) for order in orders}))
    cycles = chosen * turns
    good = np.isfinite(chosen).all() and (chosen > 0).all()
    if not len(chosen) or not good or (np.abs(cycles - np.rint(cycles)) > 1e-9).any():
        raise OptionError(
            f"periodic_range: orders must be positive, with whole numbers of periods in {turns} "
            f"turn{'s' * (turns > 1)}."
        )
    return chosen
