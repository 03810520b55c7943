"""Crank torque of the pilger mill LG90 by the parts of equations (29) and (30).

``M = 2 (wG / w) (MZ + Mf) + Mk + Md``: rolling torque MZ and friction Mf of the necks of each roll,
idle friction ``Mk = mu M`` of the stand on its rails, inertia torque Md. wG is the speed of the
rolls. The print divides it by the speed of the motor, w is right, as M is the torque at the crank.
It takes ``Mf = P f d``; with the diameter d of a neck, its friction is ``P f d / 2``. The feed's
torque M0 of the fitted sets is added.

The load of a set stands for ``MZ + Mf``. Rolling force and neck are not printed [A]; the force has
a constant arm, so that Mf is the same share of the load everywhere.
"""

from __future__ import annotations

import numpy as np

import lumped as lp
from lumped.models.pilger_mill.stand import IDLE, PINION, crank_torque
from lumped.models.sources import Given

NECK_FRICTION = Given(0.001, "1", "P", "friction of the necks of the rolls, f")
NECK = Given(0.25, "m", "A", "diameter of a roll's neck, d")
ROLLING_FORCE = Given(2.0e6, "N", "A", "greatest rolling force, P")


def split_torque(run: lp.Trajectory, w: float) -> dict[str, np.ndarray]:
    """Parts of the crank torque (30), N.m; their sum is ``crank_torque(run, IDLE)``.

    Parameters
    ----------
    run : Trajectory
        From `lumped.models.pilger_mill.stand.revolution`.
    w : float
        Speed of the crank, rad/s.

    Returns
    -------
    dict of str to ndarray
        "rolling", "necks", "idle", "feed", "inertia".
    """
    force, feed = -run["mill.load.f"], -run["mill.feed.tau"]
    load = force * run["mill.stand.v"] / w
    friction = ROLLING_FORCE * NECK_FRICTION * NECK / 2
    share = friction / (np.abs(force).max() * PINION / 2)
    total = crank_torque(run, IDLE)
    return {
        "rolling": (1 - share) * load,
        "necks": share * load,
        "idle": IDLE * total,
        "feed": feed,
        "inertia": (1 - IDLE) * total - load - feed,
    }


def rod_motion(run: lp.Trajectory) -> dict[str, np.ndarray]:
    """Angular speeds and accelerations of the rods with the signs of (9) to (12).

    The source counts the angle of the stand's rod against the model's.

    Returns
    -------
    dict of str to ndarray
        Speeds "wL", "wL1", rad/s, and accelerations "xiL", "xiL1", rad/s2, of the rods of stand and
        counterweight.
    """
    stand, weight = "mill.stand", "mill.weight"
    return {
        "wL": -run[f"{stand}.w_rod"],
        "wL1": run[f"{weight}.w_rod"],
        "xiL": -run[f"{stand}.a_rod"],
        "xiL1": run[f"{weight}.a_rod"],
    }
