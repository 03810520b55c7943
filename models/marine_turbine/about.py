"""Quantities in the report on the marine turbine."""

from lumped.models.about import read_about

ABOUT = read_about(
    "marine_turbine",
    until=240.0,
    watched={
        "torque of the propeller shaft": "shaft.tau",
        "torque of the LP turbine shaft": "low.shaft.tau",
        "torque of the HP turbine shaft": "high.shaft.tau",
        "speed of the propeller": "propeller.w",
    },
)
