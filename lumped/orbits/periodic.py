"""Periodic motions: driven, turning and self-excited."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError
from lumped.language.expression import Expr
from lumped.orbits.guesses import (
    advances,
    after_cycles,
    after_response,
    after_time,
    drifting,
    needs_time,
)
from lumped.orbits.orbit import PeriodicOrbit
from lumped.orbits.shooting import Guess, Orbit, OrbitProblem, refuse_rest, shoot
from lumped.orbits.smooth_curves import values_along
from lumped.points.start import search_start
from lumped.simulation.simulate import simulate_led
from lumped.support.arguments import checked
from lumped.support.units import read_time
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Trajectory
from lumped.vibration.ordered.order_response import OrderResponse

GRID = 200
"""Output intervals of motions of which there are many."""


@checked
def periodic(
    system: System,
    *,
    period: float | Name | None = None,
    near: float | None = None,
    turn: Mapping[Name, float] | None = None,
    warm_up: float | None = None,
    free: Iterable[Name] = (),
    speed: float | None = None,
    parameters: Changes | None = None,
    start: Changes | OperatingPoint | OrderResponse | None = None,
    grid: int = 1000,
    rtol: float = 1e-10,
    iterations: int = 20,
) -> PeriodicOrbit:
    """Find a motion that repeats, and how small disturbances of it grow or fade.

    Three cases: driven at a known `period`; turning, where an angle gains its `turn` in a period
    that is unknown (or known, if it is driven too); self-excited, of an unknown period `near` some
    value. The motion is first simulated for some time, then found by shooting: Newton's method on
    the states after a period, across friction, contact and impacts. With a parameter in `free`, a
    motion of unknown period gets the one that is given: a motor finds the torque with which its
    shaft turns at a given mean speed. An order response as the `start` says what turns, how far,
    and what is free, and spares the simulation.

    Parameters
    ----------
    system : System
        From `assemble`.
    period : float or name, optional
        The period, s, if functions of time prescribe it. Each period begins at the time zero. The
        name of a parameter if it is one; then derivatives by it are those with the period.
    near : float, optional
        About the period, s, if nothing prescribes it.
    turn : mapping of name to float, optional
        States that go on turning, and by how much in a period, rad or m (with sign).
    warm_up : float, optional
        Time to simulate first, s; default ten periods. Must be given with `turn` alone.
    free : iterable of one name, optional
        Parameter that the motion determines, so that `period` is its period though no function of
        time prescribes it; the search begins at its value.
    speed : float, optional
        Mean speed of the motion, rad/s, one of those of an order response that is `start`.
    parameters, start
        As for `simulate`; a point gives its states, as those at the time zero. `start` may be the
        response of `order_response` with `shaft` and `free`, in place of the options above and of
        `parameters`.
    grid : int
        Output intervals of the run over one period.
    rtol : float
        Tolerance of runs, and of what may be missing after a period, over the size of each state.
        Tighter than elsewhere: what is missing adds up over all the periods that follow.
    iterations : int
        Newton steps after which to give up.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    OptionError
        If neither `period`, `near` nor `turn` is given, values make no sense, or functions of time
        act without a `period`.
    SolverError
        If no periodic motion is found, or more than one nearby; its `partial` is the last run.
    """
    if not isinstance(grid, int) or grid < 10:
        raise OptionError(f"periodic: grid = {grid!r}: at least 10 output intervals are needed.")
    if not 1e-13 <= rtol <= 1e-4:
        raise OptionError(f"periodic: rtol = {rtol}: choose it between 1e-13 and 1e-4.")
    if isinstance(start, OrderResponse):
        given = (period, near, turn, warm_up, parameters)
        if speed is None or any(v is not None for v in given) or tuple(free):
            raise OptionError(
                "periodic: an order response to start from goes with one of its speeds: start= and "
                "speed=, without period, near, turn, warm_up, free and parameters, which it has."
            )
        problem, balancing = turning_problem(system, start, rtol, iterations)
        first = after_response(problem, start, start.number_of(float(speed), "periodic"))
        return find_orbit(problem, first, grid, balancing)
    if speed is not None:
        raise OptionError("periodic: speed= is one of those of an order response, start=.")
    near = None if near is None else read_time(near, "near")
    warm_up = None if warm_up is None else read_time(warm_up, "warm_up")
    point = search_start(system, parameters, start)
    system = point.system
    clock = None
    if isinstance(period, str) and not period[:1].isalpha():
        period = read_time(period, "period")
    if isinstance(period, str | Expr):
        (clock,) = system.places([system.key(period)])
        period = float(point.theta[clock])
    if period is None and near is None and not turn:
        raise OptionError(
            "periodic: give period= (prescribed by functions of time), turn= (an angle that goes "
            "on turning) or near= (about the period of a self-excited oscillation)."
        )
    if period is not None and near is not None:
        raise OptionError("periodic: give period= or near=, not both.")
    if period is None and near is None and warm_up is None:
        raise OptionError("periodic: the period is unknown; give warm_up=, a time to simulate, s.")
    for name, value in (("period", period), ("near", near), ("warm_up", warm_up)):
        least = 0 if name == "warm_up" and period is not None else 1e-300
        if value is not None and not (np.isfinite(value) and value >= least):
            raise OptionError(f"periodic: {name} = {value!r} s: a positive, finite time is needed.")
    names = [system.key(name) for name in free]
    if names:
        if len(names) > 1 or period is None or clock is not None:
            raise OptionError(
                f"periodic: free = {names}: one parameter is determined by one period; give one, "
                "and the period as a number."
            )
        system.places(names)
        wanted = near = period
        period = None
    advance = advances(point, turn or {}, period)
    driven = needs_time(system, point.theta)
    if driven and names:
        raise OptionError(
            f"periodic: functions of time act on {system.name}, so {names[0]} is not determined by "
            "the period. Leave out free=."
        )
    if driven and period is None:
        raise OptionError(
            f"periodic: functions of time act on {system.name}; give the period that they "
            "prescribe, period=."
        )
    if not driven and period is not None:
        raise OptionError(
            f"periodic: no function of time acts on {system.name}, so that no period is "
            "prescribed; give turn= or near= instead, or a parameter in free= for which this is "
            "the period."
        )
    if not len(system.state_names):
        raise OptionError(f"periodic: {system.name} has no states; simulate one period of it.")
    active = np.flatnonzero(~drifting(system, advance))
    if not len(active):
        raise OptionError(f"periodic: no state of {system.name} has an effect; nothing repeats.")
    problem = OrbitProblem(system, advance, active, period is None, rtol, iterations, clock)
    if period is not None:
        first = after_cycles(problem, point, period, warm_up)
    else:
        first = after_time(problem, point, near, warm_up)
    if names:
        return find_orbit(problem, replace(first, period=wanted), grid, names[0])
    return find_orbit(problem, first, grid)


def find_orbit(
    problem: OrbitProblem, guess: Guess, grid: int, free: str | None = None
) -> PeriodicOrbit:
    """The motion near a guess, or that of its period for which a parameter is free."""
    if free is None:
        return result_of(problem, shoot(problem, guess), grid)
    (place,) = problem.system.places([free])
    found = result_of(problem, shoot(replace(problem, parameter=place), guess), grid)
    return replace(found, free={free: float(found.run.theta[place])})


def turning_problem(
    system: System, response: OrderResponse, rtol: float, iterations: int
) -> tuple[OrbitProblem, str]:
    """What must repeat in the motion that an order response describes, and what is free.

    Raises
    ------
    OptionError
        If it is the response of another system, or tells too little of the motion.
    """
    steady, free = response.rotation, response.rotation.balancing
    if response.system is not system:
        raise OptionError(
            f"{system.name}: the order response is that of another system; give one of this."
        )
    if free is None:
        raise OptionError(
            f"{system.name}: an order response in which nothing is free does not balance the mean "
            "torques, as a periodic motion does; name the torque that does, "
            "order_response(shaft=..., free=...)."
        )
    if response.excitations:
        raise OptionError(
            f"{system.name}: a run has no excitations= ({', '.join(response.excitations)}); make "
            "them part of the model, as torques over the angle of the shaft."
        )
    if needs_time(system, steady.theta[0]):
        raise OptionError(
            f"periodic: functions of time act on {system.name}, so {free} is not determined by "
            "the period. Give period= in place of an order response."
        )
    if not steady.turns_matter:
        raise OptionError(
            f"periodic: nothing in {system.name} depends on the angle {steady.shaft}, so that "
            "nothing vibrates by itself."
        )
    advance = 2 * np.pi * steady.turns * steady.turning
    active = np.flatnonzero(~drifting(system, advance))
    return OrbitProblem(system, advance, active, True, rtol, iterations), free


def result_of(problem: OrbitProblem, orbit: Orbit, grid: int) -> PeriodicOrbit:
    """What was found, with a run over its period, as a result."""
    system, active, names = problem.system, problem.active, problem.system.state_names
    T, point = orbit.guess.period, orbit.guess.point
    run = simulate_led(system, until=T, start=point, grid=grid, rtol=problem.rtol)
    if problem.free:
        refuse_rest(problem, run)
    values = np.linalg.eigvals(orbit.monodromy)
    values = values[np.argsort(-np.abs(values))]
    shift = None
    if problem.free:
        nearest = int(np.argmin(np.abs(values - 1)))
        shift, values = complex(values[nearest]), np.delete(values, nearest)
    idle = np.setdiff1d(np.arange(len(names)), active)
    gained = run.pieces[-1].x[-1] - point.x
    worst = int(np.argmax(np.abs(orbit.residuals)))
    return PeriodicOrbit(
        system,
        run,
        T,
        {names[i]: float(problem.advance[i]) for i in np.flatnonzero(problem.advance)},
        {names[i]: float(gained[i]) for i in idle},
        values,
        shift,
        float(np.abs(orbit.residuals).max()),
        names[active[worst]],
        orbit.condition,
        _seam(run, active),
        orbit.iterations,
        orbit.evaluations,
        problem,
        orbit,
    )


def _seam(run: Trajectory, active: np.ndarray) -> tuple[str, ...]:
    """States whose rates at the end are not those at the start."""
    system = run.system
    rates = np.hstack(values_along(system.rhs, run))
    jumps = np.abs(rates[:, -1] - rates[:, 0]) > 1e-6 * np.abs(rates).max(axis=1)
    return tuple(system.state_names[i] for i in active if jumps[i])
