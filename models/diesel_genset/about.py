"""Quantities in the report on the diesel engine and its generator."""

from lumped.models.about import read_about

ABOUT = read_about(
    "diesel_genset",
    until=0.6,
    watched={
        "torque of the coupling": "coupling.tau",
        "torque of shaft 8": "shaft_8.tau",
        "heat of the damper": "damper.power",
        "speed of the flywheel": "flywheel.w",
    },
)
