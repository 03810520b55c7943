"""Quantities in the report on the turbine generator."""

from lumped.models.about import read_about

ABOUT = read_about(
    "turbine_generator",
    until=0.52,
    watched={
        "torque in the air gap": "gen.tau",
        "torque of the shaft LPB-GEN": "turbine.lpb_gen.tau",
        "torque of the shaft LPA-LPB": "turbine.lpa_lpb.tau",
        "speed of the generator": "gen.w",
    },
)
