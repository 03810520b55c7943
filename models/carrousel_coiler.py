"""Winding drive of a carrousel coiler: published numbers beside computed ones.

The drive and its source are described in `lumped.models.carrousel_coiler_drive`, its sizing in
`carrousel_coiler_sizing`, the elastic strip in `carrousel_coiler_scenes`, the turret in
`carrousel_coiler_turret`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lumped.models import Row
from lumped.models import carrousel_coiler_sizing as sizing
from lumped.models.carrousel_coiler_drive import (
    I_HIGH,
    I_LOW,
    MANDREL,
    RADIUS,
    winding,
)
from lumped.models.carrousel_coiler_scenes import elastic_winding, gear_change, tension_deviation
from lumped.models.carrousel_coiler_turret import half_turn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NOT = "not published"
CUT = "print cut off, not rounded"
PUBLISHED = (  # quantity, unit, value, place, remark
    ("motor power, 20 m/s", "kW", 2347.0, "example 3.1", f"{CUT}; a factor 1.25 is not in print"),
    ("range of motor speeds, high gear only", "1", 10.65, "example 3.2", f"{CUT}; 1300 m/min"),
    ("range of motor speeds, both gears", "1", 7.21, "example 3.2", f"{CUT}; 1300 m/min"),
    (
        "motor power, drawing",
        "kW",
        2160.0,
        "drawing",
        "no formula in print: 1.150 times (3.4), computed is (3.4) alone",
    ),
)
UNPUBLISHED = (  # quantity, unit, None, place, reference and its origin
    ("base speed of the motor, 20 m/s", "rpm", None, NOT, "323.24 from (3.12), a = 1.25"),
    ("base speed of the motor, 1300 m/min", "rpm", None, NOT, "350.2, perhaps 350 was meant"),
    ("tension at full coil, high gear", "kN", None, NOT, "80 as a = 1.25 says"),
    ("tension at full coil, low gear", "kN", None, NOT, "118.17 from (3.4) and the envelope"),
    ("tension at full coil, 2160 kW, high gear", "kN", None, NOT, "73.6: 80 kN only to 0.92 m"),
    ("greatest motor power, whole run", "kW", None, NOT, "1892.0 closed form; (3.4) 1878.3"),
    ("greatest motor torque, whole run", "kN.m", None, NOT, "61.9386 closed form"),
    ("RMS motor torque over rated torque", "1", None, NOT, "0.648 closed form"),
    ("deviation of tension, steady, empty", "kN", None, NOT, "11.771 from A / R^4 + B"),
    ("deviation of tension, steady, full", "kN", None, NOT, "1.0746 from A / R^4 + B"),
    ("deviation of tension, 1 m/s2, empty", "kN", None, NOT, "-17.200 from -a J / R^2"),
    ("elastic strip at 10 s, not compensated", "N", None, NOT, "67070.5 by DOP853, no loss"),
    ("elastic strip at 10 s, compensated", "N", None, NOT, "80000.0 by DOP853, no loss"),
    ("energy lost by a gear change at 20 rad/s", "kJ", None, NOT, "15.649 from momentum"),
    ("turret drive, least torque of half a turn", "kN.m", None, NOT, "29 from plane geometry"),
    ("turret drive, greatest torque", "kN.m", None, NOT, "174 from plane geometry"),
)


def rows() -> list[Row]:
    """Published and computed numbers."""
    motor, second = sizing.chosen_motor(), sizing.chosen_motor(sizing.SPEED_2)
    drawn = sizing.Motor(sizing.DRAWN / motor.base, sizing.DRAWN, motor.speed)
    slow = np.array([5.0])
    rpm = 30 / np.pi
    run = winding(grid=20_000, rtol=1e-9)
    torque = -run["drive.motor.flange.tau"]
    power = torque * run["drive.rotor.w"]
    steady = tension_deviation(np.array([MANDREL, RADIUS]))
    at = np.array([0.0, 10.0])
    elastic = [
        elastic_winding(share, until=10.0, grid=at, rtol=1e-9, parameters={"eta": 1.0, "mu": 0.0})
        for share in (0.0, 1.0)
    ]
    turret = -half_turn(grid=1200)["turn.flange.tau"]
    computed = [
        motor.power / 1e3,
        sizing.speed_range(),
        sizing.speed_range(I_LOW),
        sizing.tension_power() / 1e3,
        motor.base * rpm,
        second.base * rpm,
        sizing.greatest_tension(motor, slow, I_HIGH)[0] / 1e3,
        sizing.greatest_tension(motor, slow, I_LOW)[0] / 1e3,
        sizing.greatest_tension(drawn, slow, I_HIGH)[0] / 1e3,
        power.max() / 1e3,
        torque.max() / 1e3,
        np.sqrt(np.trapezoid(torque**2, run.t) / run.t[-1]) / motor.torque,
        *(steady / 1e3),
        tension_deviation(np.array([MANDREL]), v=0.0, a=1.0)[0] / 1e3,
        *(run["strip.T"][-1] for run in elastic),
        sum(event.loss for event in gear_change().events) / 1e3,
        turret.min() / 1e3,
        turret.max() / 1e3,
    ]
    return [
        Row(quantity, unit, value, float(found), place, remark)
        for (quantity, unit, value, place, remark), found in zip(
            (*PUBLISHED, *UNPUBLISHED), computed, strict=True
        )
    ]


def plots() -> dict[str, Figure]:
    """Figures by name."""
    from lumped.models.carrousel_coiler_figures import figures

    return figures()
