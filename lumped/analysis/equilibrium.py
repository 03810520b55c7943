"""States at which nothing changes."""

from __future__ import annotations

import numpy as np
from scipy.linalg import lstsq

from lumped.analysis.result import OperatingPoint
from lumped.analysis.settings import settings_at
from lumped.analysis.start import given_states, start_point
from lumped.errors import SolverError
from lumped.system import Changes, System

__all__ = ["equilibrium"]

_MOST_CLOSING = 20
"""Times that a linkage is closed anew at what looked like an equilibrium."""


def equilibrium(
    system: System,
    *,
    parameters: Changes | None = None,
    start: Changes | None = None,
    time: float = 0.0,
    tolerance: float = 1e-10,
) -> OperatingPoint:
    """Find states whose derivatives all vanish, nearest to the start values.

    Newton iteration with minimum-norm steps (Deuflhard, Newton Methods for Nonlinear Problems,
    ch. 4). States with given start values keep them if an equilibrium allows it, so a free drive
    turns at the speed that was given.

    Parameters
    ----------
    system : System
        From `assemble`.
    parameters, start : mapping of name to float, optional
        Parameters to change, start values to set.
    time : float
        Instant at which functions of time are taken, s.
    tolerance : float
        Largest remaining derivative, relative to the derivatives' own scale.

    Raises
    ------
    SolverError
        If there is no equilibrium near the start; the text names the worst equation.
    """
    begin = start_point(system, parameters, start)
    count = len(system._values.implicit)
    settings = settings_at(
        system, begin.x, begin.theta, time + 1e-300, begin.modes[len(begin.modes) - count :]
    )
    held = given_states(system, start)
    for movable in (~held, np.ones_like(held)):
        x, closed = begin.x, settings
        for _ in range(_MOST_CLOSING):
            x, residual, found = _newton(system, x, begin.theta, time, closed, movable, tolerance)
            if not found:
                break
            before = closed
            guesses = before[len(before) - count :]
            closed = settings_at(system, x, begin.theta, time + 1e-300, guesses)
            if np.allclose(closed, before, rtol=1e-9, atol=1e-12):
                return OperatingPoint(system, time, x, begin.theta, closed)
    worst = int(np.argmax(np.where(np.isfinite(residual), np.abs(residual), np.inf)))
    name = system.state_names[worst]
    raise SolverError(
        f"{system.name}: no equilibrium near the start values: der({name}) stays at "
        f"{residual[worst]:.4g}. A free drive with a net torque accelerates for ever: add a load "
        "or damper, or set torques that balance."
    )


def _newton(
    system: System,
    begin: np.ndarray,
    theta: np.ndarray,
    time: float,
    settings: np.ndarray,
    movable: np.ndarray,
    tolerance: float,
) -> tuple[np.ndarray, np.ndarray, bool]:
    """States, derivatives there, and whether they vanish; only movable states change."""
    x = begin.copy()
    args = (theta, time, settings)
    residual = np.asarray(system.rhs(x, *args)).ravel()
    for _ in range(100):
        if not np.isfinite(residual).all():
            break
        jacobian = system.jacobian(x, *args)[0].full()
        scale = np.abs(jacobian) @ (np.abs(x) + 1e-3) + 1e-9
        if (np.abs(residual) <= tolerance * scale).all():
            return x, residual, True
        if not movable.any():
            break
        step = np.zeros(len(x))
        matrix = jacobian[:, movable] / scale[:, None]
        step[movable] = lstsq(matrix, -residual / scale, lapack_driver="gelsy")[0]
        x, residual, moved = _line_search(system, x, step, residual, scale, args)
        if not moved:
            break
    return x, residual, False


def _line_search(
    system: System,
    x: np.ndarray,
    step: np.ndarray,
    residual: np.ndarray,
    scale: np.ndarray,
    args: tuple[np.ndarray, float, np.ndarray],
) -> tuple[np.ndarray, np.ndarray, bool]:
    """Shorten the step until it helps."""
    before = float(np.linalg.norm(residual / scale))
    for power in range(12):
        trial = x + 0.5**power * step
        found = np.asarray(system.rhs(trial, *args)).ravel()
        if np.isfinite(found).all() and np.linalg.norm(found / scale) < before * (1 - 1e-4):
            return trial, found, True
    return x, residual, False
