"""Quantities in the report on the rotary arm."""

from lumped.models.about import Motor, read_about
from lumped.models.rotary_arm.loads import (
    MAXIMUM,
    RATED,
)

ABOUT = read_about(
    "rotary_arm",
    until=10.98,
    watched={
        "motor torque": "motor.tau",
        "speed of the arm": "arm.trays.w",
        "angle of the arm": "arm.phi",
        "friction in the journals": "arm.journal.tau",
    },
    motors=(Motor("motor of 250 kW", "motor.tau", "motor.w", RATED, MAXIMUM),),
)
