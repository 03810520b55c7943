"""Texts of the report on the reversing cold rolling mill 400."""

from lumped.models.about import About, Motor
from lumped.models.reversing_mill.drives import OVERLOAD
from lumped.models.reversing_mill.stand import RATED

ABOUT = About(
    introduction=(
        "Two motors, each with gearbox and spindle, drive the two backup rolls of a four-high "
        "stand. The branches meet only in the roll gap: through the strip the rolls stick to each "
        "other, skid, or are free. Asked are the natural frequencies, the torques when the strip "
        "enters or breaks, and what passes from one branch to the other through the gap."
    ),
    source=(
        "A. S. Filatov, Electric drive and automation of reversing cold rolling mills (in "
        "Russian), book, pages 70 to 73, equations (43) to (56). The copy used names neither "
        "publisher nor year; the exponents of both stiffnesses are illegible in it.",
        "Equation (53) has the speed of the upper gearbox where that of the lower motor belongs.",
        "Equation (55) leaves out the inertia of the rolls; for a small creep coefficient it is "
        "wrong.",
        "A bracket of (56) is illegible; without it the frequencies become complex.",
        "The work roll of 0.0001 kgf m s2 would be 12.5 mm thick; a more likely value does not "
        "give the printed frequency of the lower branch.",
        "6.36 Hz at 10 m/s is cut off, not rounded.",
    ),
    findings=(
        "The printed frequencies follow from the printed inertias and stiffnesses to 0.6 %, and "
        "within the rounding of each printed number exactly.",
        "With the gap closed there is a mode of 6.34 Hz that the source does not have: motors "
        "against each other, rolls at rest. The eccentricity of the backup rolls excites it at "
        "9.97 m/s. The source finds no resonance in the working range, but only of the upper and "
        "lower systems by themselves.",
        "When the strip breaks, the spindles swing back to -0.94 of the rated torque: their play "
        "opens.",
        "Rolls of unequal diameter between two speed controllers without droop load each other "
        "ever more until the gap skids. Droop bounds that, a load-share trim removes it.",
    ),
    assumptions=(
        "Friction in the gap: it sticks up to 0.40 of the rated torque and skids with 0.30.",
        "Motors: 140 rad/s, torque to 2.5 times the rated one, a torque loop of 5 ms, PI speed "
        "control. The source has no motor data.",
        "Play of the spindles, difference of the roll diameters, creep coefficient.",
        "No damping but in the gap. All inertias and stiffnesses count at the motor shaft.",
    ),
    scene=(
        "Steady rolling at 140 rad/s; for the first 120 ms the upper motor has 1.6 and the lower "
        "one 0.4 of the rated torque, so that the gap skids; then both have rated torque again."
    ),
    until=0.4,
    captions={
        "modes_upper": "Natural modes of the upper branch, gap open",
        "modes_lower": "Natural modes of the lower branch, gap open",
        "modes_closed": "Natural modes of the whole stand, gap closed",
        "strip_entry": "Shaft torques when the strip enters",
        "eccentricity": "Torques that the eccentricity of the backup rolls excites, over the strip "
        "speed",
        "creep": "Damping of the modes by creep in the gap, over the creep coefficient",
        "skidding": "Shaft torques and slip of the rolls while the gap skids and sticks",
        "strip_break": "Shaft torques when the strip breaks, with and without play",
        "strip_entry_unequal_speeds": "Strip that enters between branches of different speeds",
        "unequal_rolls": "Torque through the gap between rolls of unequal diameter",
        "motors": "Motors on converters: strip entry between unequal rolls, with droop and trim",
    },
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
