"""Quantities in the report on the pilger mill LG90."""

from lumped.models.about import Motor, read_about
from lumped.models.pilger_mill.drive import BREAKDOWN

ABOUT = read_about(
    "pilger_mill",
    until=9.0,
    watched={
        "motor torque": "motor.tau",
        "speed of the crank": "shaft.w",
        "speed of the motor": "motor.w",
        "position of the stand": "mill.stand.s",
    },
    motors=(Motor("motor", "motor.tau", "motor.w", maximum=BREAKDOWN),),
)
