"""Follow implicit quantities through time in a system without states."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.analysis.stepper import CLOSED
from lumped.system import System

__all__ = ["marched"]

_SUBSTEPS = 16
"""Newton solutions from one output time to the next."""


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
