"""Texts of the report on the diesel engine and its generator."""

from lumped.models.about import About

ABOUT = About(
    introduction=(
        "A six-cylinder diesel engine, four strokes, firing order 1-5-3-6-2-4, from the pulley to "
        "the flywheel. Asked are its natural frequencies, the orders that excite them, and the "
        "vibratory torques of its shafts over the speed, with all cylinders firing and with one "
        "that does not. Then a viscous damper, an elastic coupling and a generator are added."
    ),
    source=(
        "A reconstructed example of Mendes, Meirelles, Zampieri, Analysis of torsional vibration "
        "in internal combustion engines: modelling and experimental validation, Proc. IMechE Part "
        "K 222 (2008) 155-178.",
        "The paper itself was not read; numbers, digitised pressures and curves are a copy, from "
        "an example of Aalto-Arotor/openTorsion (MIT licence).",
        "The example plots the sum of the amplitudes of all orders, without their phases. A later "
        "version of it counts the phases of the cylinders the other way round, which changes the "
        "sums by up to 3.7 %.",
    ),
    findings=(
        "The published peaks of the sums, 9530 N.m in shaft 8 and 867 N.m in shaft 1 near 2170 "
        "turns a minute, come out as 9444 and 863 N.m at 2175.",
        "Order 6 excites the first mode there; the orders 3, 6, 9 and 12 add up all cylinders in "
        "phase. All orders in their phases reach 8833 N.m in shaft 8, 6 % less than their sum.",
        "A cylinder that does not fire lessens the largest torque of the crankshaft by 12 to 18 "
        "%, as its share of order 6 is missing, but the coupling to the generator then vibrates "
        "12 to 18 times as much at 1500 turns a minute, by the orders 0.5, 1 and 1.5.",
        "The damper lessens the largest vibratory torque of the crankshaft from 9.4 to 5.1 kN.m.",
    ),
    assumptions=(
        "Constant inertias; the masses excite by the series of the source.",
        "The pressure follows the mean speed of the engine, not the speed within a vibration.",
        "Damper, coupling and generator are examples. The fluid of the damper is that of Den "
        "Hartog's optimum for the first mode.",
        "In the start the damping of the throws against the housing is left out: at 1500 turns a "
        "minute it would brake with 1885 N.m, more than the engine gives. The loss of shafts and "
        "coupling is that at one frequency.",
    ),
    scene=(
        "The starter has brought the engine to 120 turns a minute. It fires with 0.3 of the "
        "pressure and takes the generator to about 500, without load. Near 190 order 3 meets the "
        "first natural frequency, that of the coupling."
    ),
    until=0.6,
    captions={
        "shapes": "Angles of the inertias and torques of the shafts in the first mode",
        "phases": "Phase diagrams of the firing order in the first mode",
        "orders": "Vibratory torque of shaft 8: largest orders over the speed",
        "synthesis": "Vibratory torques of the shafts 8 and 1, all orders together",
        "misfire": "Shaft 8 and the coupling, with a cylinder that does not fire",
        "damper": "Vibratory torques of all shafts with and without the damper",
        "start": "Speeds and torque of the coupling while the engine starts",
    },
    watched={
        "torque of the coupling": "coupling.tau",
        "torque of shaft 8": "shaft_8.tau",
        "heat of the damper": "damper.power",
        "speed of the flywheel": "flywheel.w",
    },
)
