"""Texts of the report on the eccentric shear."""

from lumped.models.about import About, Motor

ABOUT = About(
    introduction=(
        "A shear of 14 MN cuts slabs of 200 mm. Its crank shaft floats between two supports: first "
        "it turns in the lower one and lets the upper one down; when that meets the strip, the pin "
        "stands still and the shaft lifts the lower support, which cuts. A pair of elliptical "
        "gears turns the crank slowly where it cuts. Asked is by how much that reduces the torque "
        "of the motor."
    ),
    source=(
        "V. F. Egorov, M. I. Stupakov, M. L. Bosnyak, Loads of eccentric shears with "
        "transmissions of variable ratio (in Russian), Omsk Scientific Bulletin 2010 no. 2 (90), "
        "CC BY; equations (1) to (23) and figure 3, whose values are damaged in the copy used.",
        "Equations (5) and (6) count the angle from the level, so that sine and cosine change "
        "places; (10) drops a constant, with which the phase of the ellipses cancels.",
        "Equation (22) puts the greatest ratio at -26.3 deg for an eccentricity of 0.4 and at 9.9 "
        "deg for 0.5 instead of in the cut; the torque would rise 2.33 and 2.86 times.",
        "Equation (19) does not hold where the carriage changes: speeds jump there.",
        "1.05 rad/s and 4 cuts a minute are both printed; without pauses that is 0.419 rad/s.",
    ),
    findings=(
        "The printed reduction of the peak, 2.5 to 3 times for eccentricities of 0.4 to 0.5, comes "
        "out as 2.32 to 2.85 with a half-sine of the cutting torque.",
        "It cannot come from the rectangle with which the study says it computed: constant torque "
        "over 68 deg is reduced at most 1 / sin(34 deg) = 1.79 times.",
        "The reduction of the RMS torque, 1.6 to 1.7, comes out as 1.69 and 1.63; beyond an "
        "eccentricity of 0.4 it falls.",
        "The landing of the pin takes 4.7 % of the speed of the crank. With ellipses of 0.5 the "
        "second landing of a turn loads the motor 1.68 times as much as the cut.",
    ),
    assumptions=(
        "Lengths of both rods: twice the distance of their centres of mass.",
        "Motor and control: the source has none. Idle torque: 8.5 % of the greatest, fitted to the "
        "printed reductions; the text has 5 to 10 %.",
        "Inertia of the motor: the copy used is damaged there; 54 t m2 is one reading.",
        "What happens after the overlap: the way back mirrors the way down.",
    ),
    scene=(
        "Two turns of the crank with circular gears, the motor under control of its angle, speed "
        "free; each change of the carriage is an impact."
    ),
    until=12.0,
    captions={
        "inertia": "Inertia of shaft and supports at the crank, over the crank angle",
        "ellipses": "Ratio of the elliptical gears, and the motor's inertia at the crank",
        "torque": "Motor torque at constant crank speed, for two shapes of the cutting torque",
        "ratios": "Reduction of peak and RMS torque over the eccentricity, beside the printed "
        "ranges",
        "free_run": "Two turns at free speed: speeds of crank and motor, and motor torque",
    },
    watched={
        "motor torque": "motor.tau",
        "speed of the motor": "motor.w",
        "speed of the crank": "loaded.shear.shaft.body.w",
        "current of the motor": "motor.i",
    },
    motors=(Motor("motor", "motor.tau", "motor.w"),),
)
