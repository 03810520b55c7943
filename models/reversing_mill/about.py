"""Quantities in the report on the reversing cold rolling mill 400."""

from lumped.models.about import Motor, read_about
from lumped.models.reversing_mill.drives import OVERLOAD
from lumped.models.reversing_mill.stand import RATED

ABOUT = read_about(
    "reversing_mill",
    until=0.4,
    varied=("M_pr",),
    watched={
        "torque of the long shaft B1": "upper.shaft.tau",
        "torque of the upper spindle": "upper.spindle.tau",
        "torque of the lower spindle": "lower.spindle.tau",
        "torque through the gap": "gap.tau",
        "slip of the rolls": "gap.w_rel",
    },
    motors=tuple(
        Motor(f"{side} motor", f"{side}.drive.tau", f"{side}.motor.w", RATED, OVERLOAD * RATED)
        for side in ("upper", "lower")
    ),
)
