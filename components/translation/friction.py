"""Dry friction of straight-line motion: guides, brakes, friction pairs, a slide with stops.

The laws are those of `lumped.components.friction`; import from `lumped.components.translation`.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Expr, Input, LinearFlange, Param, Var, der, param, var
from lumped.components.characteristic import Characteristic, coulomb, dry_friction, friction_at
from lumped.language.switch import Item, hold
from lumped.ops import where

__all__ = ["Brake", "FrictionPair", "GuideFriction", "MassWithStopAndFriction", "SupportFriction"]


class _OnRod(Component):
    """Between a rod and its support: ``s = s_a - s_support``, ``f_a + f_b = f``."""

    flange_a = LinearFlange(free=True)
    flange_b = LinearFlange(free=True)
    support = LinearFlange(grounded=True)
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    s: Var = var("m", "position relative to the support", state="avoid")
    v: Var = var("m/s", "sliding speed", state="prefer")
    f: Var = var("N", "friction force")
    position: Var = var("1", "1 forward, 0 stuck, -1 backward, 2 free")

    def equations(self) -> Iterator[Item]:
        yield self.flange_a.s == self.support.s + self.s
        yield self.flange_b.s == self.support.s + self.s
        yield self.v == der(self.s)
        yield self.flange_a.f + self.flange_b.f == self.f
        yield self.support.f == -self.f

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.f * self.v


class SupportFriction(_OnRod):
    """Friction of a rod in its guide: ``f = f_k(v)``, against the motion.

    The rod goes through from flange a to flange b. `characteristic` gives the friction force in N
    over the sliding speed in m/s: rows of both, or a function such as
    `lumped.components.Stribeck`.
    """

    symbol = "bearing"
    characteristic: Characteristic = ()

    def rating(self) -> tuple[str, Expr]:
        return "N", friction_at(self.characteristic, 0.0)

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield dry_friction(
            self.f, self.v, self.characteristic, peak=self.peak, position=self.position
        )


class GuideFriction(_OnRod):
    """Friction of a rod in a guide under a load: ``f = mu |load|`` against the motion.

    The rod goes through from flange a to flange b. `load` is the force across, of either sign, such
    as the force `guide` of a `CrankSlider`. It may depend on the friction itself; if both grow
    without limit, the mechanism jams and a run ends with an error. At standstill the friction bears
    up to `peak` times that force.
    """

    symbol = "bearing"
    mu: Param = param("1", "friction coefficient", min=0)
    load: Input = Input("N", "force across the guide, of either sign")

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        grip = self.mu * where(self.load >= 0, self.load, -self.load)
        yield coulomb(self.f, self.v, grip, self.peak * grip, position=self.position)


class Brake(_OnRod):
    """Brake on a rod: ``f = mu(v) c_geo f_n`` against the motion, ``f_n = f_max u``.

    The rod goes through from flange a to flange b. `characteristic` gives the friction
    coefficient over the sliding speed in m/s: rows of both, or a function such as
    `lumped.components.Stribeck`. Without normal force the rod is free.
    """

    symbol = "brake"
    characteristic: Characteristic = ((0.0, 0.5),)
    c_geo: Param = param("1", "sum of the friction forces over that of one face", 1.0, min=0)
    f_max: Param = param("N", "normal force at u = 1", min=0)
    u: Input = Input("1", "normal force over its greatest value")
    f_n: Var = var("N", "normal force")

    def rating(self) -> tuple[str, Expr]:
        return "N", friction_at(self.characteristic, 0.0) * self.c_geo * self.f_max

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield self.f_n == self.f_max * self.u
        yield dry_friction(
            self.f,
            self.v,
            self.characteristic,
            grip=self.c_geo * self.f_n,
            engaged=self.f_n > 0,
            peak=self.peak,
            position=self.position,
        )


class FrictionPair(Component):
    """Two bodies pressed together and sliding: ``f = mu(v_rel) f_n``, ``f_n = f_max u``.

    `f` acts on the pair at flange b and, reversed, at flange a; `v_rel` is the velocity of b
    relative to a. `characteristic` gives the friction coefficient over the sliding speed in m/s:
    rows of both, or a function such as `lumped.components.Stribeck`. Without normal force the
    bodies are free.
    """

    symbol = "friction"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    characteristic: Characteristic = ((0.0, 0.5),)
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    f_max: Param = param("N", "normal force at u = 1", min=0)
    u: Input = Input("1", "normal force over its greatest value")
    s_rel: Var = var("m", "distance of the flanges", state="avoid")
    v_rel: Var = var("m/s", "sliding speed", state="prefer")
    f: Var = var("N", "friction force on flange b")
    f_n: Var = var("N", "normal force")
    position: Var = var("1", "1 forward, 0 stuck, -1 backward, 2 free")

    def rating(self) -> tuple[str, Expr]:
        return "N", friction_at(self.characteristic, 0.0) * self.f_max

    def equations(self) -> Iterator[Item]:
        yield self.s_rel == self.flange_b.s - self.flange_a.s
        yield self.v_rel == der(self.s_rel)
        yield self.flange_b.f == self.f
        yield self.flange_a.f == -self.f
        yield self.f_n == self.f_max * self.u
        yield dry_friction(
            self.f,
            self.v_rel,
            self.characteristic,
            grip=self.f_n,
            engaged=self.f_n > 0,
            peak=self.peak,
            position=self.position,
        )

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.f * self.v_rel


class MassWithStopAndFriction(Component):
    """Sliding mass with friction between two hard stops: ``m der(v) = f_a + f_b - f - f_stop``.

    `characteristic` gives the friction force `f` in N over the sliding speed in m/s: rows of both,
    or a function such as `lumped.components.Stribeck`. At a stop the mass comes to rest at once,
    held by `f_stop` alone; it leaves when it is pulled away by more than `peak` times the friction
    at standstill.
    """

    symbol = "mass_stops"
    flange_a = LinearFlange(free=True)
    flange_b = LinearFlange(free=True)
    characteristic: Characteristic = ()
    m: Param = param("kg", "mass", above=0)
    length: Param = param("m", "distance of the flanges", 0.0, min=0)
    s_min: Param = param("m", "stop for flange a")
    s_max: Param = param("m", "stop for flange b")
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    s: Var = var("m", "position of the centre")
    v: Var = var("m/s", "velocity", state="prefer")
    v_back: Var = var("m/s", "velocity from flange b to flange a")
    f: Var = var("N", "friction force between the stops")
    f_low: Var = var("N", "force of the stop for flange a, positive towards it")
    f_high: Var = var("N", "force of the stop for flange b, positive towards it")
    f_stop: Var = var("N", "force of the stops, positive against a positive velocity")
    sliding: Var = var("1", "1 forward, 0 stuck, -1 backward, 2 at a stop")
    free_low: Var = var("1", "0 at the stop for flange a, else 1")
    free_high: Var = var("1", "0 at the stop for flange b, else 1")
    position: Var = var("1", "1 forward, 0 stuck or at a stop, -1 backward")

    def equations(self) -> Iterator[Item]:
        yield self.flange_a.s == self.s - self.length / 2
        yield self.flange_b.s == self.s + self.length / 2
        yield self.v == der(self.s)
        yield self.v_back == -self.v
        yield self.m * der(self.v) == self.flange_a.f + self.flange_b.f - self.f - self.f_stop
        yield dry_friction(
            self.f,
            self.v,
            self.characteristic,
            engaged=self.free_low * self.free_high > 0.5,
            peak=self.peak,
            position=self.sliding,
        )
        most = self.peak * friction_at(self.characteristic, 0.0)
        low = self.s - self.length / 2 - self.s_min
        high = self.s_max - self.s - self.length / 2
        yield hold(self.f_low, self.v, gap=low, upper=most, position=self.free_low)
        yield hold(self.f_high, self.v_back, gap=high, upper=most, position=self.free_high)
        yield self.f_stop == self.f_low - self.f_high
        yield self.position == self.sliding * self.free_low * self.free_high
