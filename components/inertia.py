"""Rotating bodies."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Param, Var, der, param, var

__all__ = ["Inertia"]


class Inertia(Component):
    """Rigid body turning about a fixed axis between two flanges.

    ``J a = tau_a + tau_b`` with ``w = der(phi)``, ``a = der(w)``.
    Either flange may stay open (free shaft end).
    """

    symbol = "inertia"
    flange_a = Flange(free=True)
    flange_b = Flange(free=True)
    J: Param = param("kg.m2", "moment of inertia", above=0)
    phi: Var = var("rad", "angle")
    w: Var = var("rad/s", "angular velocity")
    a: Var = var("rad/s2", "angular acceleration")

    def equations(self) -> Iterator[Equation]:
        yield self.flange_a.phi == self.phi
        yield self.flange_b.phi == self.phi
        yield self.w == der(self.phi)
        yield self.a == der(self.w)
        yield self.J * self.a == self.flange_a.tau + self.flange_b.tau

    def stored(self) -> Expr:
        """Kinetic energy, J."""
        return 0.5 * self.J * self.w**2
