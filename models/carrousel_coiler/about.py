"""Quantities in the report on the carrousel coiler."""

from math import inf

from lumped.models.about import Motor, read_about
from lumped.models.carrousel_coiler.sizing import (
    choose_motor,
    limit_rows,
)

ABOUT = read_about(
    "carrousel_coiler",
    until=inf,
    watched={
        "tension of the strip": "strip.T",
        "motor torque": "drive.motor.tau",
        "speed of the motor": "drive.rotor.w",
        "radius of the coil": "drive.coil.R",
    },
    motors=(
        Motor(
            "motor of 2348 kW",
            "drive.motor.tau",
            "drive.rotor.w",
            choose_motor().torque,
            limit_rows(choose_motor()),
        ),
    ),
)
