"""Texts of the report on the rotary arm."""

from lumped.models.about import About, Motor
from lumped.models.rotary_arm.loads import (
    MAXIMUM,
    RATED,
)

ABOUT = About(
    introduction=(
        "Five arms on one shaft take a mandrel of 31.7 t from a table, swing it over half a turn "
        "and put it down on rollers, one turn in 9 s. Gears in the arms keep the trays upright, so "
        "that the mandrel moves on a circle without turning. Asked is which motor lifts it."
    ),
    source=(
        "Li Enxue (Jiangsu Tianhuai Steel Tube), Drive of the front-table mandrel rotary arm of a "
        "508 mm PQF pipe mill (in Chinese), Steel Pipe 2016 no. 2, 45-49. Figures 4 to 7, table 1 "
        "and two formulas are damaged in the copy used.",
        "It lets the mandrel spin with the arm, which it does not: 2.8 % too much inertia.",
        "It leaves out the rotor, which has as much inertia as the whole load.",
        "It applies the efficiency to the power, but not to the torque, and takes g = 10 m/s2.",
        "It says that an accurately computed counterweight balances the arm; its own sum leaves "
        "6.3 % of the load.",
        "An efficiency of 0.85 stands beside the choice of the motor without a name; it is taken "
        "as that of the reducer.",
    ),
    findings=(
        "All printed torques, inertias and powers come out to their rounding with the errors of "
        "the source. Without these errors, and if 0.85 is the efficiency of the reducer, the motor "
        "needs 10 416 N.m where it has 9948.",
        "The first motor has 0.2 % more than lifting takes, and lifts only if the reducer "
        "has more than 0.832. This is the reported 'cannot kick the mandrel in'.",
        "The angles of the cycle are not legible. With pick-up and release level, and nothing "
        "fitted, the RMS torque is 4064 N.m; 4100 are printed. Several readings reach 4100 "
        "exactly, because one number of each is solved for it.",
        "At the pick-up the arm keeps 52 % of its speed.",
    ),
    assumptions=(
        "The cycle: four slow zones of equal angle, ramps of 1.38 rad/s2, 9 s in all. Pick-up and "
        "release 1.47 deg below the level are inferred from the printed RMS torque.",
        "Gains, braking and bandwidth of the control, lag of the motor torque.",
        "The mandrel is taken without rebound; shaft and gears are rigid.",
    ),
    scene=(
        "One turn under square-root position control, from rest before the pick-up to rest one "
        "turn later. Taking the mandrel is an impact."
    ),
    until=10.98,
    captions={
        "cycle": "One turn by prescribed motion: speed and torque, corrected and as the source "
        "reckons",
        "control": "One turn under position control: speed, torque and the way left",
        "pick_up": "Pick-up with speed controls of different bandwidth",
        "first_motor": "The first motor lifts, or stalls, by the efficiency of the reducer",
    },
    watched={
        "motor torque": "motor.tau",
        "speed of the arm": "arm.trays.w",
        "angle of the arm": "arm.phi",
        "friction in the journals": "arm.journal.tau",
    },
    motors=(Motor("motor of 250 kW", "motor.tau", "motor.w", RATED, MAXIMUM),),
)
