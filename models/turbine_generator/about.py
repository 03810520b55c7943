"""Texts of the report on the turbine generator."""

from lumped.models.about import About

ABOUT = About(
    introduction=(
        "A steam turbine with four stages drives a generator of 892 MVA and its exciter on one "
        "shaft. A short circuit at the terminals lets the torque in the air gap swing with one "
        "and two times the line frequency. Asked are the torsional frequencies and the largest "
        "torques of the shafts, during the fault, after it is cleared, and after reclosing."
    ),
    source=(
        "A reconstructed example of IEEE Subsynchronous Resonance Task Force, First benchmark "
        "model for computer simulation of subsynchronous resonance, IEEE Trans. Power Apparatus "
        "and Systems 96 (1977) 1565-1572.",
        "The paper itself was not read; inertia constants, stiffnesses, shares of the torque, "
        "network and synchronous reactances are a copy, found alike in two public programs.",
        "Transient and subtransient reactances and time constants are the usual ones; no second "
        "copy of them was found. No torque curve is published.",
    ),
    findings=(
        "The five published torsional frequencies come out in all printed digits.",
        "During a three-phase fault the torque in the air gap reaches 8.00 times the rated one "
        "after 3.8 ms, that of the shaft LPB-GEN 3.16 times after 10.4 ms; another calculation "
        "of the same equations in SciPy agrees within 1e-6 of the rated torque.",
        "From line to line the torque in the air gap reaches 12.0 times the rated one, half as "
        "much again, but that of the shaft LPB-GEN only 3.07 times.",
        "Clearing makes it worse: after 47 ms of fault the shaft LPB-GEN reaches 3.92 and LPA-LPB "
        "3.19 times the rated torque. The second step of the torque meets the swing that the first "
        "one left.",
    ),
    assumptions=(
        "Shafts without damping; constant torque of the steam and constant excitation.",
        "The resistance of the stator is 0.0025 pu, where the benchmark has none. Its series "
        "capacitor is left out, so that there is no subsynchronous resonance.",
        "The fault has no resistance and begins where the voltage of phase a is at its maximum, "
        "the worst instant for a fault from b to c. Contacts open where their current is zero.",
        "Instants of clearing, opening and closing are examples.",
    ),
    scene=(
        "From rated load, all three terminals are shorted at 0.02 s, and stay so. The generator "
        "swings against the turbine."
    ),
    until=0.52,
    captions={
        "shapes": "Shapes of the torsional modes, angles relative to the largest",
        "fault": "Torques in the air gap and in a shaft during both faults",
        "cleared": "Largest torque of each shaft over the duration of a three-phase fault",
        "reclosed": "Torques of a fault, its clearing, load rejection and reclosing",
    },
    watched={
        "torque in the air gap": "gen.tau",
        "torque of the shaft LPB-GEN": "turbine.lpb_gen.tau",
        "torque of the shaft LPA-LPB": "turbine.lpa_lpb.tau",
        "speed of the generator": "gen.w",
    },
)
