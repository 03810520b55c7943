"""Both approaches of the source to the equalizing torque that the roll gap carries.

The first is equation (55): the rolls creep, and K_s is taken from measured curves, one for each
speed of rolling. Of their form only dM is legible; read as dM / M, the difference of both torques
over their mean, against the relative slip dw / w [I]. As M_3v - M_2n = K_s (w_v - w_n), a curve of
the slope k gives K_s = k M / w [R]: the faster the rolls turn, the weaker the same curve binds
them. The curves are not in the copy; their slope is [A].

Of the second approach the pages at hand say only that it exists. That of kinematics is inferred
[I]: the rolls do not slip, w_v R_v = w_n R_n, and the torque is what the joint needs (`ClosedGap`,
`scenes.StripGap`, `scenes.with_droop`).
"""

from __future__ import annotations

import numpy as np

import lumped as lp
from lumped.components import Damper
from lumped.models.reversing_mill import scenes
from lumped.models.reversing_mill import stand as mill
from lumped.models.sources import Given

SLOPE = Given(80.0, "1", "A", "slope of the curve of the difference of torques over relative slip")


def creep_coefficient(speed: float = scenes.SPEED, slope: float = SLOPE) -> float:
    """K_s of (55), N.m.s/rad, from a curve's slope and a motor speed in rad/s, at rated torque."""
    return slope * mill.RATED / speed


def peak_at_entry(gap: mill.OpenGap, until: float = 2.0) -> float:
    """Greatest equalizing over rated torque after strip entry, motors stepping to rated torque.

    Parameters
    ----------
    gap : ClosedGap, CreepingGap or PrintedGap
        Stand.
    until : float
        End, s.
    """
    run = mill.strip_entry(gap, mill.RATED, until=until, grid=20_000, rtol=1e-8)
    closed = isinstance(gap, mill.ClosedGap)
    torque = run["upper.barrel.tau"] + mill.RATED if closed else run["creep.tau"]
    return float(np.abs(torque).max() / mill.RATED)


def creeping_with_droop(s: float, K_s: float, eps: float = scenes.DIFFERENCE) -> float:
    """Equalizing over rated torque in steady rolling by (55): unequal rolls, drives with droop.

    Parameters
    ----------
    s : float
        Droop of both drives.
    K_s : float
        Creep coefficient, N.m.s/rad.
    eps : float
        Diameter of the upper over that of the lower rolls, less 1.
    """
    stand = scenes.with_droop(s).with_({"gap": Damper(d=K_s / 2)})
    rolling = lp.equilibrium(lp.assemble(stand), parameters={"eps": eps})
    return float(rolling["gap.tau"] / mill.RATED)
