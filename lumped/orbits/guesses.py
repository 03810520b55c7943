"""What must repeat in a periodic motion: which states, by which advance; where to begin."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.orbits.shooting import Guess, OrbitProblem, in_modes, refuse_rest, sizes
from lumped.simulation.simulate import simulate_led
from lumped.support.units import plain
from lumped.timeloop.clocks import clocks
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Piece, Trajectory
from lumped.vibration.ordered.order_response import OrderResponse

_CYCLES = 10
"""Periods to settle unless a time is given."""

_COARSE = 1e-8
"""Tolerance of runs that only give a first guess."""


def advances(point: OperatingPoint, turn: Mapping[Name, float], period: float | None) -> np.ndarray:
    """By what each state grows in a period, from the advances of named angles or positions.

    Of several states that an angle is the sum of, such as another angle and a twist, the one turns
    after whose turn everything repeats.

    Raises
    ------
    OptionError
        If a name is no state, nor in a constant ratio to one, or nothing repeats after the turn.
    """
    system = point.system
    found = np.zeros(len(system.state_names))
    x, p, _, _ = system.inputs
    choices: list[np.ndarray] = [found]
    for name, given in turn.items():
        key, unit = system.key(name), system.quantity(name).unit
        value = plain(given, unit, f"periodic: turn of {key} =", OptionError)
        if not np.isfinite(value) or value == 0:
            raise OptionError(f"periodic: turn of {key} = {value!r}: a number other than zero.")
        slopes = ca.jacobian(system.expressions([key]), x)
        if not slopes.nnz() or any(not ca.depends_on(p, v) for v in ca.symvar(slopes)):
            raise OptionError(
                f"periodic: {key} is neither a state nor in a constant ratio to one; give the "
                "turn of a state that goes on turning. States: "
                f"{', '.join(system.state_names[:12])}."
            )
        (ratios,) = np.asarray(ca.Function("ratios", [p], [ca.densify(slopes)])(point.theta))
        units = np.eye(len(ratios))[np.flatnonzero(ratios)]
        choices = [c + value * unit / (ratios @ unit) for c in choices for unit in units]
    faults = [_fault(point, choice, period) for choice in choices]
    for choice, fault in zip(choices, faults, strict=True):
        if not fault:
            return choice
    raise OptionError(f"periodic: {system.name} is another after its turn: {faults[0]}")


def _fault(point: OperatingPoint, advance: np.ndarray, period: float | None) -> str:
    """What is different after an advance; empty if nothing is."""
    system, theta, names = point.system, point.theta, point.system.state_names
    before = np.asarray(system.rhs(point.x, theta, 0.0, point.settings)).ravel()
    least, text = np.inf, ""
    for t in (0.0,) if period is None else (0.0, period):
        after = np.asarray(system.rhs(point.x + advance, theta, t, point.settings)).ravel()
        scale = np.maximum(np.maximum(np.abs(before), np.abs(after)), 1.0)
        missed = np.abs(after - before) / scale
        worst = int(np.argmax(missed))
        if missed[worst] <= 1e-6:
            return ""
        if missed[worst] < least:
            least = missed[worst]
            text = (
                f"the rate of {names[worst]} is {before[worst]:.6g} before it and "
                f"{after[worst]:.6g} after. Give the turn, with its sign, after which everything "
                "repeats, for all states that turn."
            )
    return text


def drifting(system: System, advance: np.ndarray) -> np.ndarray:
    """Which states have no effect on any that must repeat, such as a counter of energy."""
    x = system.inputs[0]
    n = len(system.state_names)
    place = {node: i for i, node in enumerate(system.structure.states)}
    acts = np.zeros((n + 1, n), dtype=bool)  # the last row is what switches
    _mark(acts, np.arange(n), system.rates, x)
    if system.switching:
        needed = system.structure.in_states(system.switching.collect_needed())
        _mark(acts, np.full(needed.numel(), n), needed, x)
        values = system.structure.in_states(system.switching.values)
        rows = np.full(values.numel(), n)
        for jump in system.switching.jumps:
            for i, node in enumerate(jump.nodes):
                rows[jump.first + i] = place.get(node, n)
        _mark(acts, rows, values, x)
    left = np.ones(n + 1, dtype=bool)
    while True:
        idle = left[:n] & ~acts[left].any(axis=0) & (advance == 0)
        if not idle.any():
            return ~left[:n]
        left[:n] &= ~idle


def _mark(acts: np.ndarray, owners: np.ndarray, expression: ca.SX, x: ca.SX) -> None:
    rows, columns = ca.jacobian_sparsity(expression, x).get_triplet()
    acts[owners[np.array(rows, dtype=int)], np.array(columns, dtype=int)] = True


def needs_time(system: System, theta: np.ndarray) -> bool:
    """Whether functions of time act on the states."""
    t = system.inputs[2]
    parts = [system.rates]
    if system.switching:
        parts.append(system.structure.in_states(system.switching.collect_needed()))
    return bool(
        ca.jacobian_sparsity(ca.vertcat(*parts), t).nnz()
        or any(clock.moves for clock in clocks(system))
    )


def after_cycles(
    problem: OrbitProblem, point: OperatingPoint, period: float, warm_up: float | None
) -> Guess:
    """Where a driven system is after some periods, each begun anew at the time zero."""
    for _ in range(_CYCLES if warm_up is None else round(warm_up / period)):
        run = _run(problem, point, period)
        point = _point(point, run, run.pieces[-1], -1, problem.advance)
    return Guess(point, period, np.zeros(len(problem.active)))


def after_time(
    problem: OrbitProblem, point: OperatingPoint, near: float | None, warm_up: float | None
) -> Guess:
    """Where a system of unknown period is after some time, its period, what fixes the phase.

    Of an angle that turns, the place where it started is taken again; else the middle of the
    longest smooth part of a period.
    """
    advance, near = problem.advance, float(near or 0)
    run = _run(problem, point, _CYCLES * near if warm_up is None else warm_up)
    if advance.any():
        return _at_section(problem, point, run)
    begin = _point(point, run, run.pieces[-1], -1, advance)
    later = _run(problem, begin, 2 * near, 1000)
    refuse_rest(problem, later)
    inside = [p for p in later.pieces if len(p.t) > 2 and p.t[0] < 0.5 * near]
    longest = max(inside, key=lambda p: min(p.t[-1], 0.6 * near) - p.t[0])
    middle = int(np.searchsorted(longest.t, 0.5 * (longest.t[0] + min(longest.t[-1], 0.6 * near))))
    now, x = float(longest.t[middle]), longest.x[middle]
    size = sizes(problem, later.x)
    ahead = (later.t > now + 0.6 * near) & (later.t < now + 1.4 * near)
    apart = (later.x[ahead] - x)[:, problem.active] / size
    period = float(later.t[ahead][np.argmin(np.linalg.norm(apart, axis=1))] - now)
    rate = np.asarray(problem.system.rhs(x, run.theta, now, longest.settings[middle])).ravel()
    phase = rate[problem.active] / size**2
    return Guess(_point(begin, later, longest, middle, advance), period, phase)


def after_response(problem: OrbitProblem, response: OrderResponse, k: int) -> Guess:
    """What an order response says of the motion at one of its speeds."""
    solved = response.solution_at(k)
    steady = solved.steady
    x = steady.x[0] + solved.x[0].real.sum(axis=0)
    point = OperatingPoint(problem.system, 0.0, x, steady.theta[0], steady.settings[0])
    leading = int(np.flatnonzero(problem.advance)[0])
    period = 2 * np.pi * steady.turns / float(steady.speeds[0])
    return Guess(point, period, (problem.active == leading).astype(float))


def _run(
    problem: OrbitProblem, point: OperatingPoint, until: float, grid: int | None = None
) -> Trajectory:
    """A run that only gives a first guess."""
    rtol = max(problem.rtol, _COARSE)
    run = simulate_led(problem.system, until=until, start=point, grid=grid, rtol=rtol)
    if any(piece.system is not run.system for piece in run.pieces):
        raise SolverError(
            f"{run.system.name}: states change places (see run.events); periodic motions are not "
            "followed across that.",
            run,
        )
    return run


def _at_section(problem: OrbitProblem, point: OperatingPoint, run: Trajectory) -> Guess:
    """The last time that the first turning angle passes where it started."""
    system, advance = problem.system, problem.advance
    leading = int(np.flatnonzero(advance)[0])
    turns = (run.x[:, leading] - point.x[leading]) / advance[leading]
    whole = int(np.floor(turns[-1]))
    if whole < 1:
        name = system.state_names[leading]
        raise SolverError(
            f"{system.name}: after warm_up = {run.t[-1]:g} s {name} has turned "
            f"{turns[-1]:.3g} of its turn of {advance[leading]:.6g}; at least one is needed. Let "
            "it warm up longer, or give the turn the sign in which it turns.",
            run,
        )
    first, now = (np.interp(k, turns, run.t) for k in (whole - 1, whole))
    piece = next(p for p in reversed(run.pieces) if len(p.t) and p.t[0] <= now)
    x = np.array([np.interp(now, piece.t, column) for column in piece.x.T])
    near = min(int(np.searchsorted(piece.t, now)), len(piece.t) - 1)
    found = OperatingPoint(
        system, 0.0, x - whole * advance, run.theta, in_modes(point, piece.settings[near])
    )
    found.x[leading] = point.x[leading]
    phase = (problem.active == leading).astype(float)
    return Guess(found, float(now - first), phase)


def _point(
    old: OperatingPoint, run: Trajectory, piece: Piece, row: int, advance: np.ndarray
) -> OperatingPoint:
    """A point of a run as start of the next, at the time zero."""
    modes = in_modes(old, piece.settings[row])
    return OperatingPoint(old.system, 0.0, piece.x[row] - advance, run.theta, modes)
