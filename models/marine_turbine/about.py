"""Texts of the report on the marine turbine."""

from lumped.models.about import About

ABOUT = About(
    introduction=(
        "Two steam turbines drive the propeller of a ship at 85 turns a minute, each through two "
        "gear stages. The five blades of the propeller excite the drive five times a turn. Asked "
        "are its natural frequencies, the critical speeds of the propeller, and the vibratory "
        "torque in the shafts over the speed."
    ),
    source=(
        "A reconstructed example of Gunter and Chen, Introduction to Dynamics of Rotor-Bearing "
        "Systems (2001), example 8.1, figure 8.10-5.",
        "The book itself was not read; numbers and points of the figure are a copy, from an "
        "example of Aalto-Arotor/openTorsion (MIT licence).",
        "The copy prints the frequencies with the unit Hz; they are those for each minute.",
    ),
    findings=(
        "The three published natural frequencies come out in all printed digits.",
        "The peak of the torque in the propeller shaft, 469 kN.m at 35.5 turns a minute in the "
        "digitised figure, comes out as 472 kN.m at 35.6.",
        "The two lowest modes lie below half of the rated speed: mode 1 moves both turbines "
        "against the propeller, mode 2 the turbines against each other, which the blades hardly "
        "excite.",
    ),
    assumptions=(
        "Shafts without mass, pinions without inertia, rigid meshes, as in the source.",
        "The run up: the torque of the steam, at the bull gear, raises the speed evenly. The "
        "mean torque of the water follows its damper and is not that of a propeller. The damping "
        "that the source adds to every mode is left out there.",
    ),
    scene=(
        "The propeller runs up from 25 to 50 turns a minute in 4 minutes. At 35.5 the blades meet "
        "the first natural frequency."
    ),
    until=240.0,
    captions={
        "shapes": "Relative angles of the inertias and torques of the shafts in the first mode",
        "campbell": "Natural frequencies and the order of the blades over the propeller's speed",
        "torque": "Vibratory torque of the propeller shaft over the speed, beside the figure",
        "shafts": "Vibratory torques of all shafts over the speed of the propeller",
        "run_up": "Orders of the torque in the propeller shaft over the speed, from the run up",
    },
    watched={
        "torque of the propeller shaft": "shaft.tau",
        "torque of the LP turbine shaft": "low.shaft.tau",
        "torque of the HP turbine shaft": "high.shaft.tau",
        "speed of the propeller": "propeller.w",
    },
)
