"""Gears without inertia and without loss in the mesh, and differentials."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import (
    Component,
    Equation,
    Flange,
    Input,
    LinearFlange,
    Param,
    Var,
    der,
    hold,
    lossless,
    param,
    var,
)
from lumped.language.switch import Item
from lumped.ops import where

__all__ = [
    "BevelDifferential",
    "BevelGear",
    "IdealGear",
    "Planetary",
    "RackAndPinion",
    "SelectableGear",
]


class IdealGear(Component):
    """Gear with constant ratio: ``phi_a = ratio phi_b``, angles counted from the housing.

    The torques follow from virtual work: ``tau_b = -ratio tau_a``, and the housing takes
    ``tau_support = -tau_a - tau_b``. An open support stands still.

    With its support on a turning carrier it is a mesh between two wheels of a planetary set,
    ``w_a - w_c = ratio (w_b - w_c)`` (Willis, Principles of Mechanism, 1841): `ratio` is the teeth
    of b over those of a, negative for two external gears and positive for one in a ring. Such
    meshes, one for each pair of wheels, compose any set.
    """

    symbol = "gear"
    flange_a = Flange()
    flange_b = Flange()
    support = Flange(grounded=True)
    ratio: Param = param("1", "gear ratio, speed of a over speed of b", nonzero=True)

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        a, b, housing = self.flange_a, self.flange_b, self.support
        yield lossless(a.phi == housing.phi + self.ratio * (b.phi - housing.phi), a, b, housing)


class Planetary(Component):
    """Planetary gear: ``(1 + ratio) phi_carrier = phi_sun + ratio phi_ring``.

    The torques follow from virtual work: ``tau_ring = ratio tau_sun``, and the carrier takes
    ``tau_carrier = -(1 + ratio) tau_sun``. The planets have no inertia of their own. A free ring
    takes no torque, so the others take none either.
    """

    symbol = "planetary"
    sun = Flange()
    carrier = Flange()
    ring = Flange(free=True)
    ratio: Param = param("1", "ring teeth over sun teeth", above=0)

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        sun, carrier, ring, k = self.sun, self.carrier, self.ring, self.ratio
        yield lossless(carrier.phi == (sun.phi + k * ring.phi) / (1 + k), sun, carrier, ring)


class BevelGear(Component):
    """Gear between crossing shafts: ``phi_a = ratio phi_b``, each angle counted from its support.

    The housing takes the torque of each shaft about the axis of that shaft, so it has two supports:
    ``tau_support_a = -tau_a`` and ``tau_support_b = -tau_b = ratio tau_a``. They are two components
    of its motion, so the housing may swing only by a small angle. Open supports stand still.
    """

    symbol = "bevel"
    flange_a = Flange()
    flange_b = Flange()
    support_a = Flange(grounded=True)
    support_b = Flange(grounded=True)
    ratio: Param = param("1", "gear ratio, speed of a over speed of b", nonzero=True)

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        a, b, at_a, at_b = self.flange_a, self.flange_b, self.support_a, self.support_b
        yield lossless(a.phi == at_a.phi + self.ratio * (b.phi - at_b.phi), a, b, at_a, at_b)


class BevelDifferential(Component):
    """Open differential with its crown gear: ``w_a = ratio (w_left + w_right) / 2``.

    Both outputs take the same torque, ``tau_left = tau_right = -ratio tau_a / 2``, however fast
    they turn. The housing takes ``tau_support_a = -tau_a`` about the axis of the pinion at flange a
    and ``tau_support_b = ratio tau_a`` about that of the outputs (see `BevelGear`). With
    ``ratio = 1`` flange a is the cage itself. Wheels inside have no inertia of their own.
    """

    symbol = "bevel"
    flange_a = Flange()
    left = Flange()
    right = Flange()
    support_a = Flange(grounded=True)
    support_b = Flange(grounded=True)
    ratio: Param = param("1", "speed of the pinion over that of the crown gear", nonzero=True)

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        a, left, right = self.flange_a, self.left, self.right
        at_a, at_b = self.support_a, self.support_b
        cage = (left.phi + right.phi) / 2 - at_b.phi
        yield lossless(a.phi == at_a.phi + self.ratio * cage, a, left, right, at_a, at_b)


class RackAndPinion(Component):
    """Pinion on a rack, or wheel that rolls without slip: ``s = radius phi``.

    ``tau = -radius f`` follows from virtual work. `s` counts from `support`, where the axle of a
    moving rack or the rack of a moving axle is held, and `phi` from `support_a`, on which the
    drive of the pinion reacts. An open support stands still.
    """

    symbol = "rack"
    flange_a = Flange()
    flange_b = LinearFlange()
    support_a = Flange(grounded=True)
    support = LinearFlange(grounded=True)
    radius: Param = param("m", "pitch radius, travel over angle", nonzero=True)

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        a, b, at_a, base = self.flange_a, self.flange_b, self.support_a, self.support
        yield lossless(b.s == base.s + self.radius * (a.phi - at_a.phi), a, b, at_a, base)


class SelectableGear(Component):
    """Gear of two ratios and a neutral position: ``w_a = ratio_1 w_b`` or ``w_a = ratio_2 w_b``.

    The command `u` engages gear 1 between 0.5 and 1.5, gear 2 from 1.5 on; below 0.5 no gear is
    engaged and both sides turn freely. Speeds count from the support. Change gear at standstill: if
    a gear is engaged while its dogs turn against each other (`w_1`, `w_2`, at side b), the speeds
    of everything that is rigidly joined jump to common ones, with momentum kept, and the energy
    lost is the `loss` of the event. If a run starts turning, give the speeds of both sides. The
    torques are ``tau_b = -ratio tau_a``.
    """

    symbol = "gearbox"
    flange_a = Flange()
    flange_b = Flange()
    support = Flange(grounded=True)
    ratio_1: Param = param("1", "speed of a over speed of b in gear 1", nonzero=True)
    ratio_2: Param = param("1", "speed of a over speed of b in gear 2", nonzero=True)
    u: Input = Input("1", "command: 0 neutral, 1 and 2 the gears")
    phi_1: Var = var("rad", "angle between the dogs of gear 1", state="avoid")
    phi_2: Var = var("rad", "angle between the dogs of gear 2", state="avoid")
    w_1: Var = var("rad/s", "speed between the dogs of gear 1", state="prefer")
    w_2: Var = var("rad/s", "speed between the dogs of gear 2", state="prefer")
    tau_1: Var = var("N.m", "torque of gear 1 against w_1")
    tau_2: Var = var("N.m", "torque of gear 2 against w_2")

    def equations(self) -> Iterator[Item]:
        a, b, housing = self.flange_a, self.flange_b, self.support
        phi_a, phi_b = a.phi - housing.phi, b.phi - housing.phi
        yield self.phi_1 == phi_a / self.ratio_1 - phi_b
        yield self.phi_2 == phi_a / self.ratio_2 - phi_b
        yield self.w_1 == der(self.phi_1)
        yield self.w_2 == der(self.phi_2)
        yield a.tau == self.tau_1 / self.ratio_1 + self.tau_2 / self.ratio_2
        yield b.tau == -self.tau_1 - self.tau_2
        yield housing.tau == -a.tau - b.tau
        first = where(self.u < 1.5, self.u, 0.0)
        yield hold(self.tau_1, self.w_1, engaged=first > 0.5)
        yield hold(self.tau_2, self.w_2, engaged=self.u >= 1.5)
