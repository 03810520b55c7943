"""Mass of the shafts of the reversing mill 400, both branches, by equation (45).

The node of vibration divides a shaft into two pieces, and each end takes a third of the moment of
inertia of its piece. In two masses the pieces are inverse to the inertias at the ends (45); in
three masses the node must be found first, for each mode, from the shape without shafts [R]. Where
the ends move alike the node lies beyond an end, and the piece beyond counts negative [R]; then the
thirds together still have the energy of a shaft that twists evenly.

The source gives no dimensions of the shafts. For a steel bar J = C (L / 3192 m/s)^2, whatever the
ratio by which both are referred: the spindle of 0.0026 kgf m s2 is 1.7 m long, shaft B1 is taken as
3 m long [A].
"""

from __future__ import annotations

import lumped as lp
from lumped.models.reversing_mill import stand as mill
from lumped.models.sources import Given

J_SPINDLE = Given(
    0.0026 * mill.KGF, "kg.m2", "I", "a spindle that explains the printed influence of 0.1 Hz"
)
J_SHAFT = Given(0.023 * mill.KGF, "kg.m2", "A", "shaft B1, a steel bar 3 m long of its stiffness")


def thirds(J: float, before: float, after: float) -> tuple[float, float]:
    """Inertias that a shaft adds to its ends, kg.m2.

    Parameters
    ----------
    J : float
        Moment of inertia of the shaft, kg.m2.
    before, after : float
        Amplitudes of its ends; those of two masses are inverse to their inertias.
    """
    piece = J * before / (before - after)
    return piece / 3, (J - piece) / 3


def lower_with_spindle(J: float = J_SPINDLE) -> mill.LowerBranch:
    """Lower branch whose spindle has a moment of inertia, kg.m2."""
    rolls, drive = mill.J_BACKUP + mill.J_WORK, mill.J_MOTOR + mill.J_GEARBOX
    at_rolls, at_drive = thirds(J, drive, -rolls)
    return mill.LowerBranch().with_(
        {"rolls.J": rolls + at_rolls, "gearbox.J": mill.J_GEARBOX + at_drive}
    )


def nodes(mode: int) -> tuple[float, float]:
    """Nodes of a mode of the upper branch, as parts of the lengths of shaft B1 and spindle B2.

    Parameters
    ----------
    mode : int
        Number from 0, the lower one.

    Returns
    -------
    tuple of float
        From the motor along B1 and from the gearbox along B2; outside 0 to 1 there is none in it.
    """
    motor, gearbox, rolls = _amplitudes(mode)
    return motor / (motor - gearbox), gearbox / (gearbox - rolls)


def upper_with_shafts(
    mode: int, shaft: float = J_SHAFT, spindle: float = J_SPINDLE
) -> mill.UpperBranch:
    """Upper branch with the mass of its shafts, as it counts in one mode.

    Parameters
    ----------
    mode : int
        Number from 0, the lower one; only this frequency of the branch is meant.
    shaft, spindle : float
        Moments of inertia of B1 and B2, kg.m2.
    """
    motor, gearbox, rolls = _amplitudes(mode)
    at_motor, at_gearbox = thirds(shaft, motor, gearbox)
    beyond, at_rolls = thirds(spindle, gearbox, rolls)
    return mill.UpperBranch().with_(
        {
            "motor.J": mill.J_MOTOR + at_motor,
            "gearbox.J": mill.J_GEARBOX + at_gearbox + beyond,
            "rolls.J": mill.J_BACKUP + mill.J_WORK + at_rolls,
        }
    )


def _amplitudes(mode: int) -> tuple[float, float, float]:
    """Amplitudes of motor, gearbox and rolls in a mode of the upper branch without shafts."""
    modes = lp.modes(lp.assemble(mill.UpperBranch()))
    motor, gearbox, rolls = (
        float(modes.shape(f"{body}.phi")[mode]) for body in ("motor", "gearbox", "rolls")
    )
    return motor, gearbox, rolls
