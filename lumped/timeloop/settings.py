"""Modes and implicit quantities at an instant: what sticks from then on, what collides."""

from __future__ import annotations

import math

import numpy as np

from lumped.compiler.open_conditions import open_conditions
from lumped.compiler.system import System
from lumped.errors import LumpedError, SolverError, StartError
from lumped.kernel import engine
from lumped.kernel.run import GOES_ON, INSIDE, NOT_CLOSED, SET_TWICE, Run
from lumped.timeloop.clocks import clocks, modes_at
from lumped.timeloop.guards import set_twice_fault
from lumped.timeloop.holds import Holds
from lumped.timeloop.plants.executable import executable
from lumped.timeloop.results.event import Change


def just_after(time: float) -> float:
    """The next number: what begins at a time holds there, what ends there does not."""
    return math.nextafter(time, math.inf)


def settings_at(
    system: System,
    x: np.ndarray,
    theta: np.ndarray,
    time: float,
    guesses: np.ndarray,
    modes: np.ndarray | None = None,
) -> np.ndarray:
    """Modes at a time, and implicit quantities there, found from guesses.

    Modes that depend on more than the time are those given, or zero.

    Raises
    ------
    StartError
        If a closed linkage cannot be closed from these guesses.
    """
    now = modes_at(system, theta, time)
    if modes is not None and len(now):
        timed = [m for clock in clocks(system) for m in clock.condition.modes]
        kept = modes[: len(now)].copy()
        kept[timed] = now[timed]
        now = kept
    return close_settings(system, x, theta, time, now, guesses)


def open_modes(
    system: System, x: np.ndarray, theta: np.ndarray, time: float, guesses: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Modes with which a start is searched for from all states, and guesses of implicit quantities.

    Where these depend on conditions, those hold there; other modes are as in `settings_at`.
    """
    modes = modes_at(system, theta, just_after(time))
    if len(guesses) and open_conditions(system) is not None:
        used = x[system.structure.in_use]
        run = executable(system).at(theta, time, used, np.concatenate([modes, guesses]))
        if engine.call("close_first", run):
            modes, guesses = np.split(run.m.copy(), [len(modes)])
    return modes, guesses


def close_settings(
    system: System,
    x: np.ndarray,
    theta: np.ndarray,
    time: float,
    modes: np.ndarray,
    guesses: np.ndarray,
) -> np.ndarray:
    """The same for given modes."""
    if not len(guesses):
        return modes
    code = executable(system)
    run = code.at(theta, time, x, np.concatenate([modes, guesses]))
    if engine.call("close_linkages", run):
        return run.m.copy()
    raise StartError(closing_fault(system, time))


def closing_fault(system: System, time: float) -> str:
    """A linkage that cannot be closed."""
    names = ", ".join(system.structure.node_name(n) for n in system.structure.implicit[:6])
    return (
        f"{system.name}: no values of {names} meet their equations at t = {round(time, 12):g} s, "
        "so a linkage cannot be closed. Check its lengths, and give start values near the "
        "position that is meant."
    )


def follow_settings(
    system: System, x: np.ndarray, theta: np.ndarray, time: float, settings: np.ndarray
) -> np.ndarray | None:
    """Settings near those of a neighbouring point with the same modes; None if there are none."""
    if not system.structure.implicit:
        return settings
    run = executable(system).at(theta, time, x, settings)
    return run.m.copy() if engine.call("converge_linkages", run) else None


def begin(
    system: System, theta: np.ndarray, time: float, x: np.ndarray, settings: np.ndarray
) -> tuple[np.ndarray, np.ndarray, tuple[Change, ...]]:
    """States and settings at the start, and what collides there at once.

    Of the modes only those of functions of time are given.

    Raises
    ------
    StartError
        If bodies start inside each other, or a linkage cannot be closed.
    SolverError
        If no modes fit.
    """
    run = executable(system).at(theta, time, x, settings)
    _check(system, run, engine.call("begin", run))
    at, collisions = run.instant, tuple[Change, ...]()
    if at.is_struck.any():
        s, holds = system.switching, Holds(system, theta)
        fast = np.abs(at.speed_at_begin) > holds.rounding(x)
        hits = np.flatnonzero((at.is_struck != 0) & fast).tolist()
        collisions = tuple(
            Change(s.names[h], "", holds.word(at.m, h), float(at.loss[h])) for h in hits
        )
    return at.x.copy(), at.m.copy(), collisions


def calm_positions(
    system: System, theta: np.ndarray, time: float, x: np.ndarray, settings: np.ndarray
) -> np.ndarray:
    """Settings at a start before anything collides there, as for `begin`.

    Raises
    ------
    StartError
        If a linkage cannot be closed.
    SolverError
        If no modes fit.
    """
    run = executable(system).at(theta, time, x, settings)
    _check(system, run, engine.call("calm_positions", run))
    return run.instant.m.copy()


def settle_positions(
    system: System, theta: np.ndarray, time: float, x: np.ndarray, settings: np.ndarray
) -> np.ndarray | None:
    """Settings in which everything fits, from those that were found before; None if these do.

    Raises
    ------
    StartError
        If a linkage cannot be closed.
    SolverError
        If no modes fit.
    """
    run = executable(system).at(theta, time, x, settings)
    run.instant.before[:] = settings
    run.instant.fired_count = 0
    run.instant.prepared_at = -np.inf
    engine.call("watch_constraints", run)
    _check(system, run, engine.call("find_positions", run))
    found, positions = run.instant.m.copy(), system.switching.positions
    same = (positions(found) == positions(settings)).all() and not run.instant.is_struck.any()
    return None if same else found


def _check(system: System, run: Run, status: int) -> None:
    """Raise an error if positions were not found."""
    if status == INSIDE:
        raise StartError(_inside(system, run))
    if status == NOT_CLOSED:
        raise StartError(closing_fault(system, run.t))
    if status == SET_TWICE:
        raise SolverError(f"{system.name}: {set_twice_fault(system, run)}")
    if status != GOES_ON:
        raise no_fit(system, run)


def _inside(system: System, run: Run) -> str:
    s, gap = system.switching, run.instant.seen.gap
    h = int(np.argmin(np.where(s.has_gap, gap, 0.0)))
    return (
        f"{system.name}: {s.names[h]} starts {-gap[h]:.6g} {s.gap_units[h]} inside the body that "
        "it must not enter. Give start values that leave a gap, or none."
    )


def no_fit(system: System, run: Run) -> LumpedError:
    """Which holds have no answer where no modes fit, and what was tried last."""
    s, at, theta = system.switching, run.instant, np.asarray(run.p)[: run.plant.parameters].copy()
    holds = Holds(system, theta)
    settings = at.m.copy()
    count = len(settings) - len(system.structure.implicit)
    look = holds.look(run.t, at.x.copy(), settings[:count], settings[count:])
    listed = [
        f"{name}: {holds.word(settings, h)}, speed {look.speed[h]:.4g}, "
        f"reaction {look.reaction[h]:.6g}"
        for h, name in enumerate(s.names)
    ]
    texts = [
        "{}: {}".format(*s.relation_text(k, settings[m])) for k, m in enumerate(s.relation_modes)
    ]
    against = list(dict.fromkeys(n for n, w in zip(s.names, at.problem.is_wrong, strict=True) if w))
    why = "changes follow each other without end"
    if against:
        why = f"no impulses or reactions of {', '.join(against)} fit"
    return SolverError(
        f"{system.name}: no set of modes fits at t = {run.t:.9g} s: {why}. Last tried:\n  "
        + "\n  ".join((listed + texts)[:12])
        + "\nCheck conditions that switch each other, limits of reactions that depend on the "
        "reaction itself, and jumps that make their own condition true again.",
        None,
    )
