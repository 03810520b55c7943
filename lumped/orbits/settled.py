"""What small disturbances leave of themselves where constraints are closed."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.flattening.hold_modes import DEMAND
from lumped.support.made_once import made_once
from lumped.timeloop.results.trajectory import Trajectory


def settle_at_start(run: Trajectory, seed: np.ndarray) -> np.ndarray:
    """States right after the start of a run, differentiated as they are given before it.

    A small disturbance of a speed that is held, or of a gap that is closed, is taken away at once:
    by the impulse that brings the speed to zero, or as the gap closes.

    Parameters
    ----------
    seed : ndarray, shape (parameters, k)
        Derivatives of the parameters by what is varied.

    Returns
    -------
    ndarray, shape (n, n + k)
        By the states, then by what is varied.
    """
    system, first, theta = run.system, run.pieces[0], run.theta
    x, t, settings = first.x[0], float(first.t[0]), first.settings[0]
    n, switching = len(x), system.switching
    found = np.eye(n, n + seed.shape[1])
    stuck = np.flatnonzero(settings[switching.first_modes] > 0.5)
    place = {node: i for i, node in enumerate(system.structure.states)}
    before = np.asarray(system.rhs(x, theta, t, settings)).ravel()
    pushed = np.eye(n)
    for h in stuck:
        i = place.get(switching.speeds[h])
        if i is not None:
            push = settings.copy()
            push[switching.first_modes[h] + DEMAND] += switching.speed_signs[h]
            pushed[:, i] += before - np.asarray(system.rhs(x, theta, t, push)).ravel()
    closed = stuck[switching.has_gap[stuck]]
    if len(closed):
        slopes = np.asarray(_gap_slopes(system)(x, theta, t, settings))[closed]
        by_states, by_parameters = np.split(slopes, [n], axis=1)
        gaps = by_states @ found
        gaps[:, n:] += by_parameters @ seed
        found -= np.linalg.pinv(by_states) @ gaps
    return pushed @ found


@made_once
def _gap_slopes(system: System) -> ca.Function:
    """Derivatives of all gaps by states and parameters: (x, p, t, m)."""
    x, p, _, _ = system.inputs
    gaps = system.structure.in_states(system.switching.gap)
    slopes = ca.densify(ca.jacobian(gaps, ca.vertcat(x, p)))
    return ca.Function("gap_slopes", system.inputs, [slopes])
