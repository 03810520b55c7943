"""Modes and implicit quantities at an instant: what a right-hand side needs beside states."""

from __future__ import annotations

import math

import numpy as np

from lumped.compiler.system import System
from lumped.errors import StartError
from lumped.kernel import engine
from lumped.timeloop.clocks import clocks, modes_at
from lumped.timeloop.plants.executable import executable


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
