"""Periodic motions: driven, turning and self-excited."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from lumped.analysis.harmonic import collocate
from lumped.analysis.orbit import PeriodicOrbit
from lumped.analysis.repeating import advances, after_cycles, after_time, drifting, needs_time
from lumped.analysis.result import Trajectory
from lumped.analysis.shooting import Guess, Orbit, Problem, closed, refuse_rest, shoot
from lumped.analysis.simulate import simulate
from lumped.analysis.start import start_point
from lumped.errors import OptionError
from lumped.system import Changes, Name, System
from lumped.units import in_seconds

__all__ = ["again", "periodic"]


def periodic(
    system: System,
    *,
    period: float | None = None,
    near: float | None = None,
    turn: Mapping[Name, float] | None = None,
    settle: float | None = None,
    parameters: Changes | None = None,
    start: Changes | None = None,
    method: Literal["shooting", "harmonic"] = "shooting",
    harmonics: int | None = None,
    grid: int = 1000,
    rtol: float = 1e-10,
    iterations: int = 20,
) -> PeriodicOrbit:
    """Find a motion that repeats, and how small disturbances of it grow or fade.

    Three cases: driven at a known `period`; turning, where an angle gains its `turn` in a period
    that is unknown (or known, if it is driven too); self-excited, of an unknown period `near` some
    value. The motion is first simulated for some time, then found by Newton's method.

    Shooting takes any system, with friction, contact and impacts. Harmonic balance takes smooth
    ones: trigonometric collocation at ``2 harmonics + 1`` points (Krack and Gross, Harmonic Balance
    for Nonlinear Vibration Problems, 2019, ch. 3), also for orbits that a run leaves at once.

    Parameters
    ----------
    system : System
        From `assemble`.
    period : float, optional
        The period, s, if functions of time prescribe it. Each period begins at the time zero.
    near : float, optional
        About the period, s, if nothing prescribes it.
    turn : mapping of name to float, optional
        States that go on turning, and by how much in a period, rad or m (with sign).
    settle : float, optional
        Time to simulate first, s; default ten periods. Must be given with `turn` alone.
    parameters, start : mapping of name to float, optional
        As for `simulate`.
    method : {"shooting", "harmonic"}
        How to find it.
    harmonics : int, optional
        Harmonics of the second method; default doubles them from 8 until the last fade below
        `rtol`.
    grid : int
        Output intervals of the run over one period.
    rtol : float
        Tolerance of runs, and of what may be missing after a period, over the size of each state.
    iterations : int
        Newton steps after which to give up.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    OptionError
        If neither `period`, `near` nor `turn` is given, values make no sense, functions of time
        act without a `period`, or harmonic balance is asked of a system with events.
    SolverError
        If no periodic motion is found, or more than one nearby; its `partial` is the last run.
    """
    period = None if period is None else in_seconds(period, "period")
    near = None if near is None else in_seconds(near, "near")
    settle = None if settle is None else in_seconds(settle, "settle")
    _check(system, period, near, turn, settle, method, harmonics, grid, rtol)
    point = start_point(system, parameters, start)
    advance = advances(point, turn or {}, period)
    driven = needs_time(system, point.theta)
    if driven and period is None:
        raise OptionError(
            f"periodic: functions of time act on {system.name}; give the period that they "
            "prescribe, period=."
        )
    if not driven and period is not None:
        raise OptionError(
            f"periodic: no function of time acts on {system.name}, so that no period is "
            "prescribed; give turn= or near= instead."
        )
    if not len(system.states):
        raise OptionError(f"periodic: {system.name} has no states; simulate one period of it.")
    active = np.flatnonzero(~drifting(system, advance))
    if not len(active):
        raise OptionError(f"periodic: no state of {system.name} has an effect; nothing repeats.")
    problem = Problem(system, advance, active, period is None, rtol, iterations)
    if period is not None:
        guess = after_cycles(problem, point, period, settle)
    else:
        guess = after_time(problem, point, near, settle)
    used = None
    if method == "harmonic":
        refined, used, steps, evaluations = collocate(problem, guess, harmonics)
        orbit = closed(problem, refined)
        orbit = replace(orbit, iterations=steps, evaluations=orbit.evaluations + evaluations)
    else:
        orbit = shoot(problem, guess)
    return _result(problem, orbit, method, used, grid)


def again(orbit: PeriodicOrbit, guess: Guess) -> PeriodicOrbit:
    """The periodic motion near a guess, by shooting, as another was found."""
    grid = max(sum(len(piece.t) for piece in orbit.run.pieces), 100)
    return _result(orbit.problem, shoot(orbit.problem, guess), "shooting", None, grid)


def _result(
    problem: Problem, orbit: Orbit, method: str, used: int | None, grid: int
) -> PeriodicOrbit:
    system, active, names = problem.system, problem.active, problem.system.state_names
    T, point = orbit.guess.period, orbit.guess.point
    run = simulate(system, until=T, start=point, grid=grid, rtol=problem.rtol)
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
        method,
        used,
        orbit.iterations,
        orbit.evaluations,
        problem,
        orbit,
    )


def _seam(run: Trajectory, active: np.ndarray) -> tuple[str, ...]:
    """States whose rates at the end are not those at the start."""
    system, rows = run.system, []
    for piece in run.pieces:
        found = system.rhs(piece.x.T, run.theta, piece.t[None, :], piece.settings.T)
        rows.append(np.asarray(found).T)
    rates = np.concatenate(rows)
    jumps = np.abs(rates[-1] - rates[0]) > 1e-6 * np.abs(rates).max(axis=0)
    return tuple(system.state_names[i] for i in active if jumps[i])


def _check(
    system: System,
    period: float | None,
    near: float | None,
    turn: Mapping[Name, float] | None,
    settle: float | None,
    method: str,
    harmonics: int | None,
    grid: int,
    rtol: float,
) -> None:
    if period is None and near is None and not turn:
        raise OptionError(
            "periodic: give period= (prescribed by functions of time), turn= (an angle that goes "
            "on turning) or near= (about the period of a self-excited oscillation)."
        )
    if period is not None and near is not None:
        raise OptionError("periodic: give period= or near=, not both.")
    if period is None and near is None and settle is None:
        raise OptionError("periodic: the period is unknown; give settle=, a time to simulate, s.")
    for name, value in (("period", period), ("near", near), ("settle", settle)):
        least = 0 if name == "settle" and period is not None else 1e-300
        if value is not None and not (np.isfinite(value) and value >= least):
            raise OptionError(f"periodic: {name} = {value!r} s: a positive, finite time is needed.")
    if method not in ("shooting", "harmonic"):
        raise OptionError(f"periodic: method = {method!r}: choose 'shooting' or 'harmonic'.")
    if harmonics is not None and (method != "harmonic" or harmonics < 1):
        raise OptionError(
            f"periodic: harmonics = {harmonics!r}: a positive number, with method='harmonic'."
        )
    if not isinstance(grid, int) or grid < 10:
        raise OptionError(f"periodic: grid = {grid!r}: at least 10 output intervals are needed.")
    if not 1e-13 <= rtol <= 1e-4:
        raise OptionError(f"periodic: rtol = {rtol}: choose it between 1e-13 and 1e-4.")
    if method == "harmonic" and system.switching:
        names = ", ".join(sorted(set(system.switching.names))[:6])
        raise OptionError(
            f"periodic: harmonic balance needs a smooth system, but {system.name} changes modes "
            f"({names or 'conditions and when statements'}). Use method='shooting'."
        )
