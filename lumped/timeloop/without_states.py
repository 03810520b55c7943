"""Follow implicit quantities through time in a system without states."""

from __future__ import annotations

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.timeloop.stepper import CLOSED

__all__ = ["first_change", "marched"]

_SUBSTEPS = 16
"""Newton solutions from one output time to the next."""

_LOOKS = 4000
"""Instants of a segment at which margins are looked at."""


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


def first_change(
    system: System,
    theta: np.ndarray,
    span: tuple[float, float],
    modes: np.ndarray,
    guess: np.ndarray,
) -> tuple[float, list[tuple[str, int]]] | None:
    """The first instant at which a margin is used up, and which; None if there is none.

    What is used up for less than 1/4000 of the span is not noticed.
    """
    t = np.linspace(*span, _LOOKS + 1)
    followed = marched(system, theta, span[0], t[1:], modes, guess)
    if followed is None:
        return None
    guesses = np.vstack([guess[None, :], followed])
    settings = np.hstack([np.repeat(modes[None, :], len(t), axis=0), guesses])
    none = np.zeros((0, len(t)))
    margins, slack = (np.asarray(v) for v in system.margins(none, theta, t[None, :], settings.T))
    used_up = margins + slack < 0
    used_up[:, 0] = False
    if not used_up.any():
        return None
    k = int(np.argmax(used_up.any(axis=0)))

    def at(time: float) -> np.ndarray:
        closed, _ = system.closure(none[:, 0], theta, time, settings[k - 1])
        now = np.concatenate([modes, np.asarray(closed).ravel()])
        return np.asarray(system.margins(none[:, 0], theta, time, now)[0]).ravel()

    find, roots = scipy.optimize.brentq, {}
    for i in np.flatnonzero(used_up[:, k]).tolist():
        before = at(t[k - 1])[i] > 0
        roots[i] = find(lambda s, i=i: at(s)[i], t[k - 1], t[k], xtol=1e-15) if before else t[k - 1]
    first = min(roots.values())
    near = 1e-13 * span[1]
    return first, [system.switching.rows[i] for i, root in roots.items() if root <= first + near]
