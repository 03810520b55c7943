"""Gears without inertia and loss."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Flange, LinearFlange, Param, lossless, param

__all__ = ["IdealGear", "RackAndPinion"]


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


class RackAndPinion(Component):
    """Pinion rolling on a rack: ``s = radius phi``, ``tau = -radius f`` from virtual work."""

    flange_a = Flange()
    flange_b = LinearFlange()
    radius: Param = param("m", "pitch radius, travel over angle", nonzero=True)

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        a, b = self.flange_a, self.flange_b
        yield lossless(b.s == self.radius * a.phi, a, b)
