"""Load torques of the rotary arm at one position, and the sizes of its motors.

The source adds T_grav, T_fric = mu k (sum of weights) D / 2 [R; the formula's image is lost, the
printed sum leaves 13 369 +- 25 N.m] and T_acc = (sum J) eps with the mandrel at the horizontal, where all
are greatest, divides by 50, and applies the efficiency to the power, but not to the torque. With the
torque it takes 9533 N.m; with the rotor, which the source leaves out though it is as heavy as the
load, 10 416 N.m: more than the chosen motor has. The first motor has 0.2 % more than lifting takes.
"""

from __future__ import annotations

import numpy as np

import lumped as lp
from lumped.components import Speed, Torque
from lumped.models.rotary_arm_arm import EPS, ETA, PRINTED, RATIO, SLOW, Driven

RPM = np.pi / 30  # rad/s
RATED_SPEED = 480 * RPM  # rad/s [P]
RATED = 250e3 / RATED_SPEED  # N.m, the chosen motor [P]
FIRST = 210e3 / RATED_SPEED  # N.m, the first motor [P]
OVERLOAD = 2.0  # [P]
MAXIMUM = 9948.0  # N.m, the chosen motor [P]


FREE_WEIGHTS = ("arm.trays.tau_g", "arm.arms.tau_g", "arm.weights.tau_g")


def at(
    drive: Speed | Torque,
    phi: float = 0.0,
    loaded: bool = True,
    parameters: dict[str, float] | None = None,
) -> lp.OperatingPoint:
    """The arm turning upward through an angle at slow speed.

    Parameters
    ----------
    drive : Speed or Torque
        Of the motor.
    phi : float
        Angle of the arm, rad.
    loaded : bool
        Whether it carries the mandrel.
    parameters : dict, optional
        Changed parameters.
    """
    system = lp.assemble(Driven(drive=drive), keep=["arm.angle.phi"])
    start = {"arm.phi": phi, "arm.carried.x": float(loaded), "rotor.w": RATIO * SLOW}
    if loaded:
        changed = parameters or {}
        start |= {"arm.mandrel.phi": phi, "arm.trays_hold.w_rel": 0.0}
    return lp.start_point(system, parameters=parameters or {}, start=start)


def lifting(eps: float) -> Speed:
    """Motion of the motor from slow speed with an acceleration of the arm in rad/s2."""
    return Speed(w=RATIO * (SLOW + eps * lp.time))


def static_torque(phi: float, eta: float = ETA) -> float:
    """Motor torque that holds the empty arm against gravity, without friction in the journals."""
    point = at(lifting(0.0), phi, loaded=False)
    return sum(point[name] for name in FREE_WEIGHTS) / (RATIO * eta)


def load_inertia(loaded: bool, parameters: dict[str, float] | None = None) -> float:
    """Inertia behind the reducer, kg.m2."""
    still, raised = (
        at(lifting(eps), 0.0, loaded, (parameters or {}) | {"reducer.eta": 1.0})
        for eps in (0.0, 1.0)
    )
    return RATIO * (raised["reducer.flange_a.tau"] - still["reducer.flange_a.tau"])
