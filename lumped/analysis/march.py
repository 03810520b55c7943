"""Follow a system without states through time: implicit quantities and changes of modes."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.analysis.crossing import Crossing
from lumped.analysis.stepper import CLOSED
from lumped.system import System

__all__ = ["marched", "next_change"]

_SUBSTEPS = 16
"""Newton solutions from one output time to the next."""

_SAMPLES = 1000
"""Instants of a segment at which modes are checked: no step size tells where they may change."""


def marched(
    system: System,
    theta: np.ndarray,
    begin: float,
    times: np.ndarray,
    modes: np.ndarray,
    guess: np.ndarray,
) -> np.ndarray | None:
    """Implicit quantities at times after `begin`, each from those shortly before.

    Returns
    -------
    ndarray, shape (len(times), len(guess)), or None
        None if Newton's method loses them.
    """
    count = len(times)
    if not len(guess):
        return np.zeros((count, 0))
    fine = np.interp(
        np.arange(1, count * _SUBSTEPS + 1) / _SUBSTEPS,
        np.arange(count + 1),
        np.concatenate([[begin], times]),
    )
    g, t, m = ca.MX.sym("g", len(guess)), ca.MX.sym("t"), ca.MX.sym("m", len(modes))
    found, step = system.closure(ca.MX(0, 1), theta, t, ca.vertcat(m, g))
    march = ca.Function("march", [g, t, m], [found, step]).mapaccum(len(fine))
    columns = np.repeat(modes[:, None], len(fine), axis=1)
    guesses, steps = (np.asarray(v) for v in march(guess, fine[None, :], columns))
    if not np.abs(steps).max() <= CLOSED * (1 + np.abs(guesses).max()):
        return None
    followed: np.ndarray = guesses.T[_SUBSTEPS - 1 :: _SUBSTEPS]
    return followed


def next_change(
    system: System,
    theta: np.ndarray,
    begin: float,
    end: float,
    modes: np.ndarray,
    guess: np.ndarray,
) -> Crossing | None:
    """The first change of modes after `begin`, where only the time changes anything."""
    times = np.linspace(begin, end, _SAMPLES + 1)[1:]
    guesses = marched(system, theta, begin, times, modes, guess)
    if guesses is None:
        return None
    settings = np.hstack([np.repeat(modes[None, :], _SAMPLES, axis=0), guesses])
    used_up = system.margins.map(_SAMPLES, "serial")

    def below(t: np.ndarray, settings: np.ndarray) -> np.ndarray:
        columns = np.repeat(theta[:, None], len(t), axis=1)
        function = used_up if len(t) > 1 else system.margins
        margins, slack = function(ca.DM(0, len(t)), columns, t[None, :], settings.T)
        beyond: np.ndarray = np.asarray(margins) + np.asarray(slack) < 0
        return beyond

    found = below(times, settings).any(axis=0)
    if not found.any():
        return None
    k = int(np.argmax(found))
    low, high = times[k - 1] if k else begin, times[k]
    while low < (middle := 0.5 * (low + high)) < high:
        crossed = below(np.array([middle]), settings[[k]]).any()
        low, high = (low, middle) if crossed else (middle, high)
    rows = np.flatnonzero(below(np.array([high]), settings[[k]]))
    return Crossing(0, float(high), np.zeros(0), [system.switching.rows[i] for i in rows])
