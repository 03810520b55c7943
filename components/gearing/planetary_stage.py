"""Planetary stage whose meshes are elastic."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Param, Var, der, param, var

__all__ = ["ElasticPlanetary"]


class ElasticPlanetary(Component):
    """Planetary stage with springs in its meshes: ``f_s = c_s s_s + d_s der(s_s)`` at each planet.

    Deflections along the lines of action, with base radii ``r_p = (r_r - r_s) / 2`` of the planets
    and ``ratio = r_r / r_s``::

        s_s = r_s (phi_sun - phi_c) + r_p (phi_p - phi_c)
        s_r = r_r (phi_ring - phi_c) - r_p (phi_p - phi_c)
        J_p der(w_p) = r_p (f_r - f_s)

    The `n` planets move alike, so the stage has its rotational modes but none in which planets move
    against each other. The torques follow from virtual work. Add the mass of the planets as an
    `Inertia` on the carrier, ``n m r_c^2``. With rigid meshes it is a `Planetary`.

    Source: Kahraman, Natural modes of planetary gear trains, J. Sound and Vibration 173 (1994) 125
    (purely torsional model).
    """

    symbol = "planetary"
    sun = Flange()
    carrier = Flange()
    ring = Flange(free=True)
    ratio: Param = param("1", "ring teeth over sun teeth", above=1)
    r_s: Param = param("m", "base radius of the sun", above=0)
    n: Param = param("1", "number of planets", min=1)
    J_p: Param = param("kg.m2", "moment of inertia of one planet about its pin", above=0)
    c_s: Param = param("N/m", "stiffness of a mesh with the sun", above=0)
    c_r: Param = param("N/m", "stiffness of a mesh with the ring", above=0)
    d_s: Param = param("N.s/m", "viscous damping of a mesh with the sun", 0.0, min=0)
    d_r: Param = param("N.s/m", "viscous damping of a mesh with the ring", 0.0, min=0)
    s_s: Var = var("m", "deflection of a mesh with the sun", nominal=1e-5, state="prefer")
    s_r: Var = var("m", "deflection of a mesh with the ring", nominal=1e-5, state="prefer")
    v_s: Var = var("m/s", "rate of the deflection at the sun")
    v_r: Var = var("m/s", "rate of the deflection at the ring")
    f_s: Var = var("N", "force of a mesh with the sun")
    f_r: Var = var("N", "force of a mesh with the ring")
    phi_p: Var = var("rad", "angle of the planets", state="avoid")
    w_p: Var = var("rad/s", "angular velocity of the planets")

    def equations(self) -> Iterator[Equation]:
        sun, carrier, ring = self.sun, self.carrier, self.ring
        r_s, r_r = self.r_s, self.ratio * self.r_s
        r_p = (r_r - r_s) / 2
        spin = self.phi_p - carrier.phi
        yield self.s_s == r_s * (sun.phi - carrier.phi) + r_p * spin
        yield self.s_r == r_r * (ring.phi - carrier.phi) - r_p * spin
        yield self.v_s == der(self.s_s)
        yield self.v_r == der(self.s_r)
        yield self.f_s == self.c_s * self.s_s + self.d_s * self.v_s
        yield self.f_r == self.c_r * self.s_r + self.d_r * self.v_r
        yield self.w_p == der(self.phi_p)
        yield self.J_p * der(self.w_p) == r_p * (self.f_r - self.f_s)
        yield sun.tau == self.n * r_s * self.f_s
        yield ring.tau == self.n * r_r * self.f_r
        yield carrier.tau == -self.n * (r_s + r_p) * (self.f_s + self.f_r)

    def stored(self) -> Expr:
        """Elastic energy of the meshes and energy of spin, J."""
        elastic = self.c_s * self.s_s**2 + self.c_r * self.s_r**2
        return 0.5 * self.n * (elastic + self.J_p * self.w_p**2)

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.n * (self.d_s * self.v_s**2 + self.d_r * self.v_r**2)
