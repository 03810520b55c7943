"""Crank drive of the cold pilger mill LG90 with a vertical counterweight.

Source: Zhang Yuning, Li Shulei, Wu Jinping, Zhang Kancang, Li Jianqiang, Analysis and optimization
of vertical sliding block dynamic balancing system of LG90 cold-rolling pipe mill (in Chinese),
Steel Pipe 42 (2013) no. 6, 54-57; equations (1) to (30), tables 1 and 2. Figures and some brackets
are damaged in the copy used. Marks: [P] printed, [R] restored by derivation, [I] inferred from the
published results, [A] assumed.

One crank pin carries two rods of the stand, which slides to and fro, and two of the counterweight,
which slides up and down; four sectors on the shaft lie opposite the pin. The pinions of the two
rolls run on fixed racks. x points to the right, y up, the pin is at ``-R (cos f, sin f)``::

    stand          at (X, e):   X  = -(R cos f + L cos t),    sin t  = (R sin f + e) / L     (1, 3)
    counterweight  at (0, Y1):  Y1 = -(R sin f + L1 cos t1),  sin t1 = R cos f / L1          (2, 4)

Errors of the print, restored here: brackets of (3); mass of a rod at its two ends swapped in (14,
16, 19, 20); sign of the rotating masses in (21, 22), with which the sectors would add to the force
of the stand; the torque (24, 26) gives the centre of a rod the velocity of the slider (`AsPrinted`;
in set P 102 instead of 90 kN.m from crest to trough); gravity is left out although it makes +-6 to
+-14 kN.m; ``ms Rs`` is in kg m, not N m; the moments of inertia of the rods have the wrong sign of
the shift, one of them the wrong length; the friction of the necks in (29) is twice ``P f d / 2``.

Of the masses only those of the counterweight and the sectors are printed, and the speed is not. No
single set explains table 2: its force needs more than 127 revolutions a minute, its power, taken as
the greatest one, less than 90. So there are two sets [I]: F meets the forces, P the torque and the
power at a plausible speed. Five published numbers cannot fix their ten unknowns; half of these stay
free.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.components import (
    CrankSlider,
    Inertia,
    Position,
    RackAndPinion,
    RotatingMass,
    SignTorque,
    StrokeLoad,
    Torque,
    translation,
)
from lumped.models.sources import Given
from lumped.ops import maximum, pi, sqrt

RADIUS = Given(0.59, "m", "P", "crank radius R")
ROD = Given(4.25, "m", "P", "rod of the stand, L")
ROD_1 = Given(3.4, "m", "P", "rod of the counterweight, L1")
OFFSET = Given(0.33, "m", "P", "offset of the stand's guide from the crankshaft, e")
IDLE = Given(0.04, "1", "P", "idle friction as a share of the crank torque, mu")
CENTRE = Given(0.45, "1", "A", "centre of a rod from the crank pin, as a share of its length")
ROLL = Given(1100.0, "kg", "A", "mass of a roll, mG")
ROLL_RADIUS = Given(0.21, "m", "A", "radius of a roll, R0")
PINION = Given(0.19, "m", "A", "radius of the pinion of a roll")
SECTOR_RADIUS = Given(0.9, "m", "A", "radius at which the sectors' mass counts, Rs")
SLENDER = Given(
    1 / 12 - (CENTRE - 0.5) ** 2,
    "1",
    "A",
    "moment of inertia of a rod over its mass and the square of its length",
)

SPEED = {
    "P": Given(63.982 * np.pi / 30, "rad/s", "I", "speed of the crank, set P"),
    "F": Given(136.471 * np.pi / 30, "rad/s", "I", "speed of the crank, set F"),
}
_FITTED = (  # name in `Mill`, unit, what it is, set P, set F
    ("m1", "kg", "stand", 8431.17, 9004.15),
    ("m_rod", "kg", "a rod of the stand", 1048.95, 2182.70),
    ("m_rod_1", "kg", "a rod of the counterweight", 1832.40, 2789.72),
    ("m_pin", "kg", "crank pin", 8714.52, 5244.44),
    ("T_f", "N.m", "greatest rolling torque at the crank", 58298.95, 110418.0),
    ("back", "1", "rolling force on the way back over that on the way out", 0.690, 0.844),
    ("al", "1", "exponent of the rolling force at the outer end", 1.000, 2.235),
    ("be", "1", "exponent of the rolling force at the inner end", 0.659, 0.662),
    ("M0", "N.m", "torque of the feed and turning gear", 9719.6, 0.0),
)
SETS = {
    letter: {
        name: Given(row[i], unit, "I", f"{text}, set {letter}")
        for name, unit, text, *row in _FITTED
    }
    for i, letter in enumerate("PF")
}
RATIO = {
    "P": Given(
        1.0, "1", "I", "speed of the shaft at which F2 is meant over that of the crank, set P"
    ),
    "F": Given(
        6.193, "1", "I", "speed of the shaft at which F2 is meant over that of the crank, set F"
    ),
}
DESIGNS = {
    "before": {
        "m2": Given(7142.0, "kg", "P", "counterweight before the optimisation, m2"),
        "U": Given(3349.96, "kg.m", "P", "mass moment of a sector before it, ms Rs"),
    },
    "after": {
        "m2": Given(7228.0, "kg", "P", "counterweight after the optimisation, m2"),
        "U": Given(3124.73, "kg.m", "P", "mass moment of a sector after it, ms Rs"),
    },
}


class Mill(lp.Component):
    """Stand, counterweight and rotating masses on the crank, with the rolling load."""

    crank = lp.Flange()
    m1: lp.Param = lp.param("kg", "stand", above=0)
    m2: lp.Param = lp.param("kg", "counterweight", min=0)
    m_rod: lp.Param = lp.param("kg", "a rod of the stand", min=0)
    m_rod_1: lp.Param = lp.param("kg", "a rod of the counterweight", min=0)
    m_pin: lp.Param = lp.param("kg", "crank pin", min=0)
    U: lp.Param = lp.param("kg.m", "mass moment of a sector", min=0)
    T_f: lp.Param = lp.param("N.m", "greatest rolling torque at the crank", min=0)
    back: lp.Param = lp.param("1", "rolling force on the way back over that on the way out", min=0)
    al: lp.Param = lp.param("1", "exponent of the rolling force at the outer end", above=0)
    be: lp.Param = lp.param("1", "exponent of the rolling force at the inner end", above=0)
    M0: lp.Param = lp.param("N.m", "torque of the feed and turning gear")
    R: lp.Param = lp.param("m", "crank radius", RADIUS, above=0)
    L: lp.Param = lp.param("m", "rod of the stand", ROD, above=0)
    L1: lp.Param = lp.param("m", "rod of the counterweight", ROD_1, above=0)
    e: lp.Param = lp.param("m", "offset of the stand", OFFSET)
    g: lp.Param = lp.param("m/s2", "gravity; the source leaves it out", 0.0)

    stand: CrankSlider = CrankSlider(
        r=R,
        L=L,
        e=e,
        m=m1,
        m_rod=2 * m_rod,
        J_rod=2 * m_rod * L**2 * SLENDER,
        k=CENTRE,
        phase=pi,
        g=g,
        assembly=-1,
    )
    weight: CrankSlider = CrankSlider(
        r=R,
        L=L1,
        m=m2,
        m_rod=2 * m_rod_1,
        J_rod=2 * m_rod_1 * L1**2 * SLENDER,
        k=CENTRE,
        axis=pi / 2,
        phase=pi,
        g=g,
        assembly=-1,
    )
    pin: RotatingMass = RotatingMass(m=m_pin, r=R, phase=pi, g=g)
    sectors: RotatingMass = RotatingMass(m=4 * U / SECTOR_RADIUS, r=SECTOR_RADIUS, g=g)
    pinions: RackAndPinion = RackAndPinion(radius=PINION)
    rolls: Inertia = Inertia(J=ROLL * ROLL_RADIUS**2)  # two solid cylinders
    load: StrokeLoad = StrokeLoad(
        forward=T_f / R,
        backward=back * T_f / R,
        s_0=-sqrt((L + R) ** 2 - e**2),
        s_1=-sqrt(maximum((L - R) ** 2 - e**2, 0.0)),
        p=al,
        q=be,
    )
    feed: Torque | SignTorque = Torque(tau=-M0)
    base_x: translation.Fixed = translation.Fixed()
    base_y: translation.Fixed = translation.Fixed()

    def connections(self) -> Iterator[lp.Connection]:
        cranks = (self.stand, self.weight, self.pin, self.sectors)
        yield lp.connect(self.crank, self.feed.flange, *(c.flange for c in cranks))
        yield lp.connect(self.stand.slider, self.pinions.flange_b, self.load.flange)
        yield lp.connect(self.pinions.flange_a, self.rolls.flange_a)
        ground = (self.pinions.support, self.load.support)  # racks and tube stand on the foundation
        yield lp.connect(self.base_x.flange, *ground, *(c.frame_x for c in cranks))
        yield lp.connect(self.base_y.flange, *(c.frame_y for c in cranks))


class AsPrinted(Mill):
    """Torque by (24) and (26): rods that move with the slider and turn besides.

    At constant speed the torque is that of the source. The forces are not.
    """

    stand: CrankSlider = CrankSlider(
        r=Mill.R,
        L=Mill.L,
        e=Mill.e,
        m=Mill.m1 + 2 * Mill.m_rod,
        J_rod=2 * Mill.m_rod * Mill.L**2 * SLENDER,
        phase=pi,
        assembly=-1,
    )
    weight: CrankSlider = CrankSlider(
        r=Mill.R,
        L=Mill.L1,
        m=Mill.m2 + 2 * Mill.m_rod_1,
        J_rod=2 * Mill.m_rod_1 * Mill.L1**2 * SLENDER,
        axis=pi / 2,
        phase=pi,
        assembly=-1,
    )


def mill(name: str, design: str = "after", kind: type[Mill] = Mill, **changes: float) -> Mill:
    """A mill by set ("P", "F") and design ("before", "after" the published optimisation)."""
    return kind().with_(SETS[name] | DESIGNS[design] | changes)


def turn_mill(part: Mill, motion: lp.Expr) -> lp.System:
    """The mill with a prescribed crank angle."""

    def connections(model: Any) -> Iterator[lp.Connection]:
        yield lp.connect(model.turn.flange, model.mill.crank)

    return lp.assemble(
        lp.compose(mill=part, turn=Position(phi=motion), connections=connections, name="Turned")
    )


def revolution(
    system: lp.System,
    w: float,
    degrees: np.ndarray,
    parameters: Mapping[str, float] | None = None,
) -> lp.Trajectory:
    """One revolution of `turn_mill(mill, w * time)`, at the given angles.

    Parameters
    ----------
    system : System
        From `turn_mill`.
    w : float
        Speed of the crank, rad/s.
    degrees : ndarray, shape (n,)
        Crank angles, from 0 upwards.
    parameters : mapping of name to float, optional
        Parameters to change.
    """
    times = np.radians(degrees) / w
    return lp.simulate(system, until=times[-1], grid=times, parameters=parameters)


def crank_torque(run: lp.Trajectory, mu: float = 0.0) -> np.ndarray:
    """Torque at the crank shaft, N.m; with the source's friction (30): divided by ``1 - mu``."""
    return -run["turn.flange.tau"] / (1 - mu)


def shaking_force(run: lp.Trajectory) -> np.ndarray:
    """Force on the foundation, N, shape (n, 2)."""
    return run.table(["mill.base_x.flange.f", "mill.base_y.flange.f"])
