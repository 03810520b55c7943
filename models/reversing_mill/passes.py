"""Passes of the reversing mill 400 whose spindles have play: bite, rolling, tail-out.

Before the bite the couplings lie on the flank that the pass before, in the other direction, has
left them on. So the drives run through the whole play before they take the load.
"""

from __future__ import annotations

import lumped as lp
from lumped.components import ElastoBacklash, Spring, SpringDamper, Torque
from lumped.models.reversing_mill import stand as mill
from lumped.models.reversing_mill.scenes import PLAY, StripGap, between
from lumped.models.sources import Given

D_SHAFT = Given(80.0, "N.m.s/rad", "A", "damping of the long shaft, 2 % of critical at 21.6 Hz")
D_SPINDLE = Given(30.0, "N.m.s/rad", "A", "damping of a spindle, 2 % of critical at 21.6 Hz")
BITE = Given(0.1, "s", "A", "instant of the bite")
TAIL_OUT = Given(1.6, "s", "A", "instant at which the strip leaves")
END = 2.2
"""End of a pass, s."""
LEVELS = (1.2, -1.1, 1.0, -0.85, 0.7)
"""Rolling torque of the passes of a coil over rated torque; negative in reverse [A]."""


class _Driven(mill.Branch):
    """Branch whose motor takes the load while there is strip, and whose spindle has play."""

    load: lp.Param = lp.param("N.m", "torque of the motor", mill.RATED)
    enters: lp.Param = lp.param("s", "instant of the bite", BITE)
    leaves: lp.Param = lp.param("s", "instant at which the strip leaves", TAIL_OUT)
    play: lp.Param = lp.param("rad", "play of the couplings of the spindle", PLAY, min=0)
    side: lp.Param = lp.param("1", "direction: 1, or -1 in reverse", 1.0)
    drive: lp.Component = Torque(tau=load * between(enters, leaves))
    spindle: Spring | ElastoBacklash = ElastoBacklash(
        c=mill.C_SPINDLE, d=D_SPINDLE, b=play, phi_rel0=side * play / 2
    )


class DrivenUpper(_Driven, mill.UpperBranch):
    """Upper branch of a pass."""

    shaft: Spring | SpringDamper = SpringDamper(c=mill.C_SHAFT, d=D_SHAFT)


class DrivenLower(_Driven, mill.LowerBranch):
    """Lower branch of a pass."""


class Pass(StripGap):
    """A pass: the motors take rated torque times `level` while there is strip."""

    play: lp.Param = lp.param("rad", "play of the couplings of a spindle", PLAY, min=0)
    level: lp.Param = lp.param("1", "rolling torque over rated torque; negative in reverse", 1.0)
    enters: lp.Param = lp.param("s", "instant of the bite", BITE)
    leaves: lp.Param = lp.param("s", "instant at which the strip leaves", TAIL_OUT)
    M_pr: lp.Param = lp.param("N.m", "rolling torque on each pair of rolls", level * mill.RATED)
    side: lp.Param = lp.param("1", "direction: 1, or -1 in reverse", lp.ops.where(level < 0, -1, 1))
    upper: DrivenUpper = DrivenUpper(load=M_pr, enters=enters, leaves=leaves, play=play, side=side)
    lower: DrivenLower = DrivenLower(load=M_pr, enters=enters, leaves=leaves, play=play, side=side)
