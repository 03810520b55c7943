"""Turret of the carrousel coiler: half a turn while strip is wound.

The sun wheel on the axis of the turret drives the wheel of the mandrel, one external mesh of ratio
k on the turret as carrier: ``w_mandrel = Omega (1 + k) - k w_sun`` (Willis) [R]. The dimensions
are [A]. Angles count positive in the sense of winding and of the turret, clockwise as drawn.

Here the turret has no mass; `changeover` has it, with the weight of the coil.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

import lumped as lp
from lumped.components import Coil, IdealGear, Position, StripPath
from lumped.models.carrousel_coiler import drive as coiler
from lumped.models.sources import Given
from lumped.ops import cos, pi, sqrt, where

CIRCLE = Given(1.25, "m", "A", "radius of the circle of the mandrels")
ROLL = (
    Given(-4.0, "m", "A", "fixed point of the strip, level distance from the turret's axis"),
    Given(1.8, "m", "A", "fixed point of the strip, height above the turret's axis"),
)
RADIUS_0 = Given(0.45, "m", "A", "coil where the turret begins to turn")
RATIO = Given(1.0, "1", "A", "teeth of the sun over those of the mandrel's wheel, k")
LINE = Given(5.0, "m/s", "A", "line speed while the turret turns")
DURATION = Given(12.0, "s", "A", "half a turn of the turret")
RAMP = Given(3.0, "s", "A", "speeding up and slowing down of the turret")

DISTANCE = float(np.hypot(*ROLL))
BEGIN = float(-np.pi + np.arctan2(*ROLL[::-1]) - np.pi)
"""Angle of the mandrel at the start, opposite to the side where the turn ends, from the direction
of the roll to the turret."""


class HeldTension(lp.Component):
    """Line that prescribes motion ``s`` and tension ``T`` of the strip, and the motor for them.

    The motor has whatever torque and speed they need: inverse dynamics of a drive.
    """

    line = lp.LinearFlange()
    motor = lp.Flange()
    s: lp.Input = lp.Input("m", "position of the strip")
    T: lp.Input = lp.Input("N", "tension")

    def equations(self) -> Iterator[lp.Equation]:
        yield self.line.s == self.s
        yield self.line.f == self.T


class Turret(lp.Component):
    """Turret, sun drive, coil and strip to the fixed roll."""

    T: lp.Param = lp.param("N", "tension", coiler.TENSION)
    v: lp.Param = lp.param("m/s", "line speed", LINE)
    r: lp.Param = lp.param("m", "radius of the mandrel", coiler.MANDREL, above=0)
    R_0: lp.Param = lp.param("m", "radius of the coil at the start", RADIUS_0, above=r)
    h: lp.Param = lp.param("m", "thickness of the strip", coiler.THICKNESS, above=0)
    r_t: lp.Param = lp.param("m", "radius of the circle of the mandrels", CIRCLE, above=0)
    d: lp.Param = lp.param("m", "roll from the axis of the turret", DISTANCE, above=0)
    rho: lp.Param = lp.param("kg/m3", "density of the strip; 0: without inertia", 0.0, min=0)
    k: lp.Param = lp.param("1", "teeth of the sun over those of the mandrel", RATIO, above=0)
    turn: Position = Position(phi=0.0)
    gear: IdealGear = IdealGear(ratio=-1 / k)
    coil: Coil = Coil(
        r=r, R_max=coiler.RADIUS, h=h, b=coiler.WIDTH, rho=rho, theta=2 * pi * (R_0 - r) / h
    )
    path: StripPath = StripPath(r_t=r_t, d=d, phi_0=BEGIN)
    to_roll = r_t**2 + d**2 + 2 * r_t * d * cos(path.phi_0)  # m2  square of mandrel to roll
    begun = pi * (R_0**2 - r**2) / h + sqrt(to_roll - R_0**2)  # m  strip behind the roll
    held: HeldTension = HeldTension(s=begun + v * lp.time, T=T)

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(self.held.motor, self.gear.flange_a)
        yield lp.connect(self.gear.flange_b, self.coil.flange)
        yield lp.connect(self.turn.flange, self.gear.support, self.path.carrier)
        yield lp.connect(self.coil.tangent, self.path.tangent)
        yield lp.connect(self.coil.strip, self.path.strip)
        yield lp.connect(self.coil.R, self.path.R)
        yield lp.connect(self.path.line, self.held.line)


def half_turn_angle(begin: float = 0.0) -> lp.Expr:
    """Angle of the turret over the time: even acceleration, steady turning, even slowing down.

    Parameters
    ----------
    begin : float
        Instant at which it begins, s.
    """
    t, top = lp.time - begin, np.pi / (DURATION - RAMP)
    left = DURATION - t
    ends = where(left <= RAMP, pi - top * left**2 / (2 * RAMP), top * (t - RAMP / 2))
    return where(t < RAMP, top * t**2 / (2 * RAMP), where(left <= 0, pi + 0 * t, ends))


def half_turn(turning: bool = True, turret: Turret | None = None, **options: Any) -> lp.Trajectory:
    """Half a turn while winding; `held.motor` is the sun, `turn` the turret drive.

    Parameters
    ----------
    turning : bool
        Whether the turret turns.
    turret : Turret, optional
        Turret; that of the source unless given.
    **options
        Passed to `lumped.simulate`, among them `parameters` such as ``{"h": 2e-3}``.
    """
    turret = Turret() if turret is None else turret
    if turning:
        turret = turret.with_({"turn.phi": half_turn_angle()})
    system = lp.assemble(turret, keep=["turn.phi"])
    return lp.simulate(system, **({"until": DURATION} | options))
