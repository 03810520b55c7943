"""Texts of the report on the pilger mill LG90."""

from lumped.models.about import About, Motor
from lumped.models.pilger_mill.drive import BREAKDOWN

ABOUT = About(
    introduction=(
        "A crank drives the stand of a cold pilger mill to and fro by 1.18 m. A counterweight on "
        "the same crank pin moves up and down, and four sectors lie opposite the pin; together "
        "they balance most of the force on the foundation. Asked are the masses that shake the "
        "foundation and load the motor least."
    ),
    source=(
        "Zhang Yuning, Li Shulei, Wu Jinping, Zhang Kancang, Li Jianqiang, Analysis and "
        "optimization of vertical sliding block dynamic balancing system of LG90 cold-rolling pipe "
        "mill (in Chinese), Steel Pipe 42 (2013) no. 6, 54-57; equations (1) to (30), tables 1 and "
        "2. Figures and some brackets are damaged in the copy used.",
        "Equations (14), (16), (19), (20) swap the masses of a rod at its two ends; in (21) and "
        "(22) the sign of the rotating masses is wrong: with it the sectors would add to the force "
        "of the stand.",
        "The torque of (24) and (26) gives the centre of a rod the velocity of the slider, which "
        "makes the inertia torque of set P 102 instead of 90 kN.m from crest to trough.",
        "Gravity is left out, although it makes 6 to 14 kN.m; (29) takes the friction of the necks "
        "twice and divides the rolling torque by the gear ratio twice; ms Rs is in kg m, not N m.",
    ),
    findings=(
        "The paper adds 86 kg to the counterweight and takes 225 kg m from each sector. The "
        "optimum of the same objective adds 95.6 kg with set F and 1.7 kg with set P: the "
        "objective is so flat that table 2 does not fix it.",
        "The force falls by 34.7 %, as printed, with both sets, which are fitted to it.",
        "No one set of masses and speed explains table 2: its force needs more than 127 "
        "revolutions a minute, its power as the greatest one less than 90. No set explains the "
        "printed drop of the power by 9 kW.",
    ),
    assumptions=(
        "Speed and all masses but those of counterweight and sectors are not printed. Two sets are "
        "fitted: F to the force, torque and mean power; P to torque, peak power and the relative "
        "reduction of the force, at a plausible speed. Five printed numbers cannot fix ten.",
        "Rolls, pinions, centres of the rods, radius of the sectors.",
        "Motor, gear, control and flywheel: the source has none of them.",
    ),
    scene=(
        "Start from rest with set P after the optimisation: the wanted speed rises evenly for 6 s; "
        "feed and turning gear act as dry friction."
    ),
    until=9.0,
    captions={
        "kinematics": "Positions, speeds and accelerations of stand and counterweight over a turn",
        "inertia_force": "Force on the foundation over a turn, before and after the optimisation",
        "inertia_torque": "Inertia torque at the crank, by the paper and exact",
        "motor_torque": "Torque over a turn, before and after the optimisation",
        "optimum": "Force against fluctuation of the torque: all best designs, and the published",
        "running": "Two turns on the motor: speed and torque",
        "start_up": "Start from rest: speed and torque",
    },
    watched={
        "motor torque": "motor.tau",
        "speed of the crank": "shaft.w",
        "speed of the motor": "motor.w",
        "position of the stand": "mill.stand.s",
    },
    motors=(Motor("motor", "motor.tau", "motor.w", maximum=BREAKDOWN),),
)
