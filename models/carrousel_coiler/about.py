"""Texts of the report on the carrousel coiler."""

from math import inf

from lumped.models.about import About, Motor
from lumped.models.carrousel_coiler.sizing import (
    chosen_motor,
    limit_rows,
)

ABOUT = About(
    introduction=(
        "Behind a cold mill, strip is wound at 20 m/s under 80 kN on one of two mandrels of a "
        "turret. The motor drives the mandrel through a gear of two ratios. Radius and inertia of "
        "the coil grow meanwhile, and the strip that enters brings its momentum along. Asked are "
        "power and speed range of the motor, and how far the tension is off."
    ),
    source=(
        "Zhang Fei, Structural and kinetic characteristic analysis of carrousel coiler (in "
        "Chinese), graduation thesis, supervisor Wang Yongqin, College of Mechanical Engineering, "
        "Chongqing University, June 2011, 54 pages; of its equations (3.1) to (3.54) the model "
        "follows (3.1) to (3.14). Nearly all formulas are damaged in the copy used.",
        "Equation (3.5) adds a motor torque w dJ/dt. The strip that enters brings just this "
        "momentum with it: 4.9 % of the torque of the tension too much at 20 m/s.",
        "Examples 3.1 and 3.2 use different line speeds, 20 m/s and 1300 m/min.",
        "The printed digits are cut off, not rounded.",
    ),
    findings=(
        "The printed motor power of 2347 kW is 1.25 times the power of the tension. The factor is "
        "not in print; it makes rated torque suffice for the full coil in high gear.",
        "Printed is that bending and friction take 5 to 10 % of the total power. With strip of 1 "
        "mm they take 0.35 to 0.59 % of the torque of the tension; strip of 5 mm reaches 10 %.",
        "Without compensation of the inertia the tension is 15 % too high on the empty coil at "
        "20 m/s and 22 % too low in speeding up.",
    ),
    assumptions=(
        "Everything inertial: motor, gears, mandrel. The strip: width, thickness, density, yield "
        "stress. The source has none of them.",
        "Acceleration and deceleration of the line, friction and diameter of the bearings.",
        "10 m of strip before the coil, with 5 % damping.",
        "The printed efficiency of 0.92 is a total with friction; the model takes it as that of "
        "the gears and adds the friction of the bearings.",
        "Turret, safety coupling, long shaft and play: named in the source, without values.",
    ),
    scene=(
        "A full coil is wound from rest to rest under torque control; the strip is elastic and the "
        "controller compensates the inertia."
    ),
    until=inf,
    captions={
        "winding_run": "A whole coil: speeds, radius, inertia, torque and power",
        "tension_deviation": "Deviation of the tension over the radius without compensation",
        "elastic_strip": "Tension of elastic strip, compensated in part or wholly",
        "gear_map": "Tension that the motor holds over the line speed, in both gears",
        "gear_change": "Speeds when the gear is changed while turning",
        "turret": "Half a turn of the turret while winding: speeds, torques, lengths",
        "jam": "Torques and speeds when the mandrel jams, with and without safety coupling",
    },
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
            chosen_motor().torque,
            limit_rows(chosen_motor()),
        ),
    ),
)
