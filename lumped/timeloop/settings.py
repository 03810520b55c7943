"""Modes and implicit quantities at an instant: what a right-hand side needs beside states."""

from __future__ import annotations

import numpy as np

from lumped.compiler.system import System
from lumped.errors import StartError
from lumped.timeloop.instants import clocks, modes_at

__all__ = ["closed_with", "followed", "just_after", "settings_at"]

_MOST_CLOSING = 20
_RADII = (0.0, *(r for r in (0.1, 0.3, 1.0, 3.0) for _ in range(5)))
"""Distances from the given guesses at which the search for a linkage's position begins."""


def just_after(time: float) -> float:
    """The next number: what begins at a time holds there, what ends there does not."""
    return float(np.nextafter(time, np.inf))


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
    return closed_with(system, x, theta, time, now, guesses)


def closed_with(
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
    rng = np.random.default_rng(3)
    for radius in _RADII:
        begin = guesses + radius * rng.uniform(-1, 1, len(guesses))
        found = _closed(system, (x, theta, time), modes, begin)
        if found is not None:
            return np.concatenate([modes, found])
    names = ", ".join(system._node_name(n) for n in system._values.implicit[:6])
    raise StartError(
        f"{system.name}: no values of {names} meet their equations at t = {round(time, 12):g} s, "
        "so a linkage cannot be closed. Check its lengths, and give start values near the "
        "position that is meant."
    )


def followed(
    system: System, x: np.ndarray, theta: np.ndarray, time: float, settings: np.ndarray
) -> np.ndarray | None:
    """Settings near those of a neighbouring point with the same modes; None if there are none."""
    first = len(settings) - len(system._values.implicit)
    if first == len(settings):
        return settings
    found = _closed(system, (x, theta, time), settings[:first], settings[first:])
    return None if found is None else np.concatenate([settings[:first], found])


def _closed(
    system: System,
    point: tuple[np.ndarray, np.ndarray, float],
    modes: np.ndarray,
    guesses: np.ndarray,
) -> np.ndarray | None:
    """Implicit quantities by Newton's method, or None if it does not converge."""
    for _ in range(_MOST_CLOSING):
        found, step = system.closure(*point, np.concatenate([modes, guesses]))
        guesses, last = np.asarray(found).ravel(), np.asarray(step).ravel()
        if not np.isfinite(guesses).all():
            return None
        if np.abs(last).max() <= 1e-12 * (1 + np.abs(guesses).max()):
            return guesses
    return None
