"""Gears without inertia and loss."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Flange, LinearFlange, Param, lossless, param

__all__ = ["IdealGear", "Planetary", "RackAndPinion"]


class IdealGear(Component):
    """Gear with constant ratio: ``phi_a = ratio phi_b``, angles counted from the housing.

    The torques follow from virtual work: ``tau_b = -ratio tau_a``, and the housing takes
    ``tau_support = -tau_a - tau_b``. An open support stands still.
    """

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

    sun = Flange()
    carrier = Flange()
    ring = Flange(free=True)
    ratio: Param = param("1", "ring teeth over sun teeth", above=0)

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        sun, carrier, ring, k = self.sun, self.carrier, self.ring, self.ratio
        yield lossless(carrier.phi == (sun.phi + k * ring.phi) / (1 + k), sun, carrier, ring)


class RackAndPinion(Component):
    """Pinion on a rack, or wheel that rolls without slip: ``s = radius phi``.

    ``tau = -radius f`` follows from virtual work. `s` counts from the support, where the axle of a
    moving rack or the rack of a moving axle is held; an open support stands still.
    """

    flange_a = Flange()
    flange_b = LinearFlange()
    support = LinearFlange(grounded=True)
    radius: Param = param("m", "pitch radius, travel over angle", nonzero=True)

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        a, b, base = self.flange_a, self.flange_b, self.support
        yield lossless(b.s == base.s + self.radius * a.phi, a, b, base)
