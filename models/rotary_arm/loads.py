"""Load torques of the rotary arm at one position, and the sizes of its motors.

The source adds T_grav, T_fric = mu k (sum of weights) D / 2 [R; the formula is missing, the
printed sum leaves 13 369 +- 25 N.m] and T_acc = (sum J) eps with the mandrel at the horizontal,
where all are greatest, divides by 50, and applies the efficiency to the power, but not to the
torque. With the efficiency the torque is 9533 N.m; with the rotor, which the source leaves out
though it has as much inertia as the load, 10 416 N.m: more than the chosen motor has. The first
motor has 0.2 % more than lifting needs.
"""

from __future__ import annotations

import numpy as np

import lumped as lp
from lumped.components import Speed, Torque
from lumped.models.rotary_arm import parts
from lumped.models.sources import Given

KW_RPM = Given(9550.0, "N.m", "P", "torque of one kW at one revolution a minute, rounded")
SPEED = Given(480.0, "1/min", "P", "rated speed of both motors")
RATED = Given(KW_RPM * 250 / SPEED, "N.m", "R", "rated torque of the chosen motor, from 250 kW")
FIRST = Given(KW_RPM * 210 / SPEED, "N.m", "R", "rated torque of the first motor, from 210 kW")
OVERLOAD = Given(2.0, "1", "P", "greatest over rated torque of the motors")
MAXIMUM = Given(9948.0, "N.m", "P", "greatest torque of the chosen motor")
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
        Speed or torque of the motor.
    phi : float
        Angle of the arm, rad.
    loaded : bool
        Whether it carries the mandrel.
    parameters : dict, optional
        Changed parameters.
    """
    system = lp.assemble(parts.Driven(drive=drive), keep=["arm.angle.phi"])
    start = {"arm.phi": phi, "arm.carried.x": float(loaded), "rotor.w": parts.RATIO * parts.SLOW}
    if loaded:
        start |= {"arm.mandrel.phi": phi, "arm.trays_hold.w_rel": 0.0}
    return lp.start_point(system, parameters=parameters or {}, start=start)


def lifting(eps: float) -> Speed:
    """Motion of the motor from slow speed with an acceleration of the arm in rad/s2."""
    return Speed(w=parts.RATIO * (parts.SLOW + eps * lp.time))


def load_inertia(loaded: bool, parameters: dict[str, float] | None = None) -> float:
    """Inertia behind the reducer, kg.m2."""
    still, raised = (
        at(lifting(eps), 0.0, loaded, (parameters or {}) | {"reducer.eta": 1.0})
        for eps in (0.0, 1.0)
    )
    return parts.RATIO * (raised["reducer.flange_a.tau"] - still["reducer.flange_a.tau"])


def printed_loads(missing: str = "") -> dict[str, float]:
    """Torques of the source's calculation at the horizontal: gravity, friction, acceleration.

    Parameters
    ----------
    missing : str
        "counterweights" or "mandrel" for a case without them; else the arm is complete.

    Returns
    -------
    dict
        ``grav``, ``fric``, ``acc`` behind the reducer, N.m; ``motor``, their sum at the motor.
    """
    changed = dict(parts.PRINTED)
    if missing == "counterweights":
        changed["arm.m_w"] = 1e-12  # kg
    point = at(lifting(parts.EPS), loaded=missing != "mandrel", parameters=changed)
    mandrel = point["arm.weight.tau"] if missing != "mandrel" else 0.0
    grav = sum(point[name] for name in FREE_WEIGHTS) + mandrel
    fric, motor = point["arm.journal.tau"], point["reducer.flange_a.tau"]
    return {"grav": grav, "fric": fric, "acc": parts.RATIO * motor - grav - fric, "motor": motor}


def greatest_acceleration(torque: float, parameters: dict[str, float] | None = None) -> float:
    """Acceleration of the arm at the horizontal, mandrel on it, rad/s2."""
    point = at(Torque(tau=torque), parameters=parameters)
    return point["rotor.a"] / parts.RATIO


def critical_efficiency(torque: float, parameters: dict[str, float] | None = None) -> float:
    """Efficiency of the reducer below which a motor torque cannot lift at the horizontal."""
    still = at(lifting(0.0), parameters=(parameters or {}) | {"reducer.eta": 1.0})
    return still["reducer.flange_a.tau"] / torque


def tray_twist(teeth: float) -> float:
    """Twist of a tray over half a turn of the arm, rad, for a ratio of teeth."""
    system = lp.assemble(parts.TrayGuide(teeth=teeth), keep=["tray.phi"])
    run = lp.simulate(system, until=np.pi, grid=1)
    return float(run["tray.phi"][-1])
