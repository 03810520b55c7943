"""Pendulums in the field of centrifugal forces."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Param, Var, der, param, var
from lumped.ops import cos, sin

__all__ = ["CentrifugalPendulum"]


class CentrifugalPendulum(Component):
    """Centrifugal pendulum on a carrier: a mass on a circle about a point that turns with it.

    The mass does not turn about itself relative to the carrier (two rollers guide it), so that its
    own inertia belongs to the carrier. With ``a = phi_rel``, the swing, w of the carrier,
    ``v = w + w_rel`` of the pendulum, and the torque on the carrier tau::

        m r (r der(v) + R cos(a) der(w) + R sin(a) w^2) == -d w_rel
        tau == d w_rel - m R (R der(w) + r cos(a) der(v) - r sin(a) v^2)

    Small swings have ``sqrt(R / r)`` periods for each turn, at every speed: a torque of this order
    on the carrier is balanced, and does not shake it. Large swings are slower.

    Source: Den Hartog, Mechanical Vibrations (1956), ch. 5.
    """

    symbol = "pendulum"
    flange = Flange()
    m: Param = param("kg", "mass of all pendulums together", above=0)
    R: Param = param("m", "distance of the centre of the path from the axis", above=0)
    r: Param = param("m", "radius of the path, length of the pendulum", above=0)
    d: Param = param("N.m.s/rad", "viscous damping of the swing", 0.0, min=0)
    phi_rel: Var = var("rad", "swing", state="prefer")
    w_rel: Var = var("rad/s", "angular velocity of the swing", state="prefer")
    w: Var = var("rad/s", "angular velocity of the carrier")
    tau: Var = var("N.m", "torque on the carrier")
    power: Var = var("W", "dissipated power")

    def equations(self) -> Iterator[Equation]:
        yield self.w == der(self.flange.phi)
        yield self.w_rel == der(self.phi_rel)
        a, w, turning = self.phi_rel, self.w, self.w + self.w_rel
        arm, side = self.R * cos(a), self.R * sin(a)
        swinging = self.r * der(turning) + arm * der(w) + side * w**2
        yield self.m * self.r * swinging == -self.d * self.w_rel
        # the carrier holds the mass at the centre of its path, at the distance R from the axis
        held = self.R**2 * der(w) + self.r * (arm * der(turning) - side * turning**2)
        yield self.tau == self.d * self.w_rel - self.m * held
        yield self.flange.tau == -self.tau
        yield self.power == self.d * self.w_rel**2

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.power

    def stored(self) -> Expr:
        """Kinetic energy, J."""
        turning = self.w + self.w_rel
        both = 2 * self.R * self.r * cos(self.phi_rel) * self.w * turning
        return 0.5 * self.m * ((self.R * self.w) ** 2 + (self.r * turning) ** 2 + both)
