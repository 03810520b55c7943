"""Changeover of the two mandrels of the carrousel coiler, figure 2-2 (a) to (e) of the source.

(a) Strip is wound on mandrel 1 at position 1; when it runs steadily the turret begins to turn. (b)
The turret turns by 180 degrees while mandrel 1 winds on; mandrel 2 comes to position 1. (c) Mandrel
1 speeds up to the line speed and winds at position 2 until its coil is heavy enough. (d) The strip
is cut, for which the line slows down [A]; mandrel 2 turns already, and takes the new strip. (e)
Mandrel 1 winds its tail without tension, stops and is unloaded; then all is as in (a), with the
mandrels exchanged.

The source gives the order and no speed, time, mass or distance; all of them are [A]. Left out are
rollers, belt wrapper and shear; the strip of mandrel 2 is a tension at the bare mandrel, for the
few seconds of its first wraps.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

import lumped as lp
from lumped.components import IdealGear, Inertia, Position, Torque
from lumped.errors import OptionError
from lumped.models.carrousel_coiler import drive as coiler
from lumped.models.carrousel_coiler.turret import (
    CIRCLE,
    DURATION,
    LINE,
    RADIUS_0,
    Turret,
    half_turn_angle,
)
from lumped.models.sources import Given
from lumped.ops import cos, pi, where

STEADY = Given(5.0, "s", "A", "winding at position 1 before the turret turns")
CUT_SPEED = Given(5.0, "m/s", "A", "line speed at the cut and at the first wraps")
LEAD = Given(6.0, "s", "A", "mandrel 2 speeds up before the cut")
TAIL = Given(12.0, "m", "A", "strip of the old coil behind the cut")
WAIT = Given(10.0, "s", "A", "standstill before the coil is taken off")
J_TURRET = Given(120e3, "kg.m2", "A", "turret with both mandrels, about its axis")
COIL = Given(0.8, "m", "A", "radius of the coil that is cut")


class CarriedCoil(lp.Component):
    """Mass of a coil that an arm carries about a level axis: lifting takes its weight.

    ``tau = m R_t^2 der(w) + m g R_t cos(phi)``. The strip brings its own momentum, and what is
    taken off does not push the arm, so that a change of the mass takes no torque.
    """

    flange = lp.Flange()
    R: lp.Input = lp.Input("m", "radius of the coil")
    on: lp.Input = lp.Input("1", "1 while the coil is on the arm, 0 once it is taken off")
    r: lp.Param = lp.param("m", "radius of the mandrel", coiler.MANDREL, above=0)
    r_t: lp.Param = lp.param("m", "length of the arm", CIRCLE, above=0)
    rho: lp.Param = lp.param("kg/m3", "density of the strip", coiler.DENSITY, min=0)
    b: lp.Param = lp.param("m", "width of the strip", coiler.WIDTH, above=0)
    g: lp.Param = lp.param("m/s2", "acceleration of gravity", 9.80665, min=0)
    w: lp.Var = lp.var("rad/s", "angular velocity")
    m: lp.Var = lp.var("kg", "mass")

    def equations(self) -> Iterator[lp.Equation]:
        yield self.w == lp.der(self.flange.phi)
        yield self.m == self.on * pi * self.rho * self.b * (self.R**2 - self.r**2)
        weight = self.m * self.g * self.r_t * cos(self.flange.phi)
        yield self.flange.tau == self.m * self.r_t**2 * lp.der(self.w) + weight


class Stages(NamedTuple):
    """Instants of a changeover, s.

    Attributes
    ----------
    turns, turned : float
        The turret begins and ends its half turn.
    slows, cut : float
        The line begins to slow down; the strip is cut.
    stops, unloaded : float
        Mandrel 1 stands; its coil is taken off.
    """

    turns: float
    turned: float
    slows: float
    cut: float
    stops: float
    unloaded: float


class Changeover(Turret):
    """Turret with its mass, the coil on it, and mandrel 2 with its own drive."""

    rho: lp.Param = lp.param("kg/m3", "density of the strip", coiler.DENSITY, min=0)
    mandrel: Inertia = Inertia(J=coiler.J_MANDREL)
    disc: Inertia = Inertia(J=J_TURRET)
    load: CarriedCoil = CarriedCoil(r=Turret.r, r_t=Turret.r_t, rho=rho, b=Turret.coil.b, on=1.0)
    motor_2: Position = Position(phi=0.0)
    gear_2: IdealGear = IdealGear(ratio=-1 / Turret.k)
    mandrel_2: Inertia = Inertia(J=coiler.J_MANDREL)
    strip_2: Torque = Torque(tau=0.0)

    def connections(self) -> Iterator[lp.Connection]:
        yield from super().connections()
        yield lp.connect(self.coil.flange, self.mandrel.flange_a)
        yield lp.connect(self.turn.flange, self.disc.flange_a, self.load.flange)
        yield lp.connect(self.coil.R, self.load.R)
        yield lp.connect(self.motor_2.flange, self.gear_2.flange_a)
        yield lp.connect(self.turn.flange, self.gear_2.support)
        yield lp.connect(self.gear_2.flange_b, self.mandrel_2.flange_a)
        yield lp.connect(self.mandrel_2.flange_b, self.strip_2.flange)


def plan(radius: float = COIL) -> tuple[Stages, lp.Expr]:
    """Instants of a changeover, and the strip on mandrel 1 since its beginning, m, over the time.

    Parameters
    ----------
    radius : float
        Of the coil when the strip is cut, m.

    Raises
    ------
    OptionError
        If the coil is cut before the line has its speed.
    """
    turned, braking = STEADY + DURATION, CUT_SPEED**2 / (2 * TAIL)
    reached = turned + (coiler.SPEED - LINE) / coiler.ACCELERATION
    ramps = (coiler.SPEED**2 - LINE**2) / (2 * coiler.ACCELERATION)
    ramps += (coiler.SPEED**2 - CUT_SPEED**2) / (2 * coiler.DECELERATION)
    wound = coiler.capacity(radius, r=RADIUS_0) - LINE * turned - ramps
    if not wound > 0:
        raise OptionError(
            f"plan: a coil of {radius:g} m radius does not reach {coiler.SPEED:g} m/s: cut later."
        )
    slows = reached + wound / coiler.SPEED
    cut = slows + (coiler.SPEED - CUT_SPEED) / coiler.DECELERATION
    stops = cut + CUT_SPEED / braking
    t, travel, done, v = lp.time, LINE * lp.time, LINE * turned, float(LINE)
    for begin, end, a in (
        (turned, reached, coiler.ACCELERATION),
        (reached, slows, 0.0),
        (slows, cut, -coiler.DECELERATION),
        (cut, stops, -braking),
        (stops, np.inf, 0.0),
    ):
        late = t - begin
        travel = where(t >= begin, done + v * late + a * late**2 / 2, travel)
        if np.isfinite(end):
            done += (end - begin) * (v + a * (end - begin) / 2)
            v += a * (end - begin)
    return Stages(STEADY, turned, slows, cut, stops, stops + WAIT), travel


def changeover(
    radius: float = COIL,
    model: Changeover | None = None,
    parameters: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Changeover from the steady winding on mandrel 1 until its coil is taken off.

    `held.motor` is the sun of mandrel 1, `motor_2` that of mandrel 2, `turn` the turret drive; when
    it stands, this torque is that of its lock.

    Parameters
    ----------
    radius : float
        Of the coil when the strip is cut, m.
    model : Changeover, optional
        Turret and drives; those of the source unless given.
    parameters : mapping of name to value, optional
        Parameters to change, such as ``{"disc.J": 2e5}``.
    **options
        Passed to `lumped.simulate`.

    Returns
    -------
    Trajectory
    """
    stages, travel = plan(radius)
    model, t = Changeover() if model is None else model, lp.time
    late = t - (stages.cut - LEAD)
    feed = (
        CUT_SPEED
        / Turret.r
        * where(late <= 0, 0 * t, where(late <= LEAD, late**2 / (2 * LEAD), late - LEAD / 2))
    )
    moving = {
        "turn.phi": where(t <= STEADY, 0 * t, half_turn_angle(STEADY)),
        "held.s": Turret.begun + travel,
        "held.T": where(t < stages.cut, Turret.T, 0.0),
        "load.on": where(t < stages.unloaded, 1.0, 0.0),
        "motor_2.phi": -feed / Turret.k,
        "strip_2.tau": where(t < stages.cut, 0.0, -Turret.T * Turret.r),
    }
    system = lp.assemble(model.with_(moving))
    given = {"until": stages.unloaded + 1.0} | options
    return lp.simulate(system, parameters=parameters, **given)
