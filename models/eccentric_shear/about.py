"""Quantities in the report on the eccentric shear."""

from lumped.models.about import Motor, read_about

ABOUT = read_about(
    "eccentric_shear",
    until=12.0,
    watched={
        "motor torque": "motor.tau",
        "speed of the motor": "motor.w",
        "speed of the crank": "loaded.shear.shaft.body.w",
        "current of the motor": "motor.i",
    },
    motors=(Motor("motor", "motor.tau", "motor.w"),),
)
