"""Piece of a shaft between two flanges: a spring with its inertia at the ends."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Output, Param, Var, der, param, var

__all__ = ["ShaftElement"]


class ShaftElement(Component):
    """Short piece of a shaft: ``tau = c phi_rel``, its inertia at both ends, ``stress = tau / W``.

    ``J_a der(w_a) = tau_a + tau`` and ``J_b der(w_b) = tau_b - tau``, ``phi_rel = phi_b - phi_a``;
    `tau` acts at flange b as in `Spring`. Sections of shafts are rows of such elements. Either
    flange may stay open.
    """

    symbol = "shaft"
    flange_a = Flange(free=True)
    flange_b = Flange(free=True)
    stress = Output("Pa", "nominal shear stress at the surface of the thinner end")
    c: Param = param("N.m/rad", "torsional stiffness", above=0)
    J_a: Param = param("kg.m2", "moment of inertia at flange a", above=0)
    J_b: Param = param("kg.m2", "moment of inertia at flange b", above=0)
    W: Param = param("m3", "polar section modulus of the thinner end", above=0)
    phi_rel: Var = var("rad", "twist", nominal=1e-4, state="prefer")
    w_a: Var = var("rad/s", "angular velocity of flange a")
    w_b: Var = var("rad/s", "angular velocity of flange b")
    tau: Var = var("N.m", "torque")

    def equations(self) -> Iterator[Equation]:
        a, b = self.flange_a, self.flange_b
        yield self.phi_rel == b.phi - a.phi
        yield self.w_a == der(a.phi)
        yield self.w_b == der(b.phi)
        yield self.tau == self.c * self.phi_rel
        yield a.tau == self.J_a * der(self.w_a) - self.tau
        yield b.tau == self.J_b * der(self.w_b) + self.tau
        yield self.stress == self.tau / self.W

    def stored(self) -> Expr:
        """Elastic and kinetic energy, J."""
        moving = self.J_a * self.w_a**2 + self.J_b * self.w_b**2
        return 0.5 * (moving + self.c * self.phi_rel**2)
