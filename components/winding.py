"""Coils that grow while they are wound, the strip before them, and its path to a turning turret.

A coil is an open system: strip enters with mass flow ``q = rho b h v``, with the circumferential
speed of the coil. Angular momentum about its axis: ``d(J w)/dt = tau - R T - M_b + q v R``. As
``dJ/dt = q R^2``, the term ``w dJ/dt`` is the momentum that the strip brings in, so that
``J dw/dt = tau - R T - M_b`` (Sommerfeld, Mechanics, 1952, par. I.4: an added mass that already
has the speed of the body does not push it; a torque ``w dJ/dt`` on top would count the strip
twice). The strip also brings the power ``q v^2 / 2``.

Angles and positions count positive in the sense of winding. Continuous winding is a spiral:
``dR = h dtheta / (2 pi fill)``.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import (
    Component,
    Expr,
    Flange,
    Input,
    LinearFlange,
    Output,
    Param,
    Var,
    der,
    param,
    var,
)
from lumped.components.characteristic import coulomb
from lumped.components.unilateral import one_sided
from lumped.language.expression import Number, Partial
from lumped.language.switch import Item
from lumped.ops import asin, atan2, cos, pi, sin, sqrt, where

__all__ = ["Coil", "Strip", "StripPath", "pulling"]


class Coil(Component):
    """Coil on a mandrel: ``J dw/dt = tau + R f - M_b``, ``R = r + h theta / (2 pi fill)``.

    The mandrel turns at `flange`; `strip` is the strip where it touches the coil, its position the
    wound length ``s = r theta + h theta^2 / (4 pi fill)``, its force ``f = -T`` a tension. `theta`
    is the angle wound: the angle of the flange relative to the direction of the strip, `tangent`,
    which is fixed if open. ``J = pi rho b fill (R^4 - r^4) / 2`` is the wound strip alone; add the
    mandrel. Bending the strip plastically takes ``M_b = sigma_s b h^2 / 4`` against the motion,
    at standstill up to that.

    To begin a run with some strip wound, give a start value, ``Coil(..., L=120.0)``. `state`
    changes, with an event, when the coil grows beyond `R_max` or is pulled off the mandrel.
    """

    symbol = "coil"
    flange = Flange()
    tangent = Flange(grounded=True)
    strip = LinearFlange()
    R = Output("m", "radius of the coil")
    load = Output("N", "force on the bearings: weight and a level tension")
    r: Param = param("m", "radius of the mandrel", above=0)
    R_max: Param = param("m", "radius of a full coil", above=r)
    h: Param = param("m", "thickness of the strip", min=0)
    b: Param = param("m", "width of the strip", above=0)
    rho: Param = param("kg/m3", "density of the strip", min=0)
    fill: Param = param("1", "strip in the coil over volume of the coil", 1.0, above=0, max=1)
    sigma_s: Param = param("Pa", "yield stress of the strip", 0.0, min=0)
    m_0: Param = param("kg", "mass of the mandrel, for the load on the bearings alone", 0.0, min=0)
    g: Param = param("m/s2", "acceleration of gravity", 9.80665, min=0)
    theta: Var = var("rad", "angle wound on the bare mandrel", state="prefer")
    w_wound: Var = var("rad/s", "rate of the angle wound")
    w: Var = var("rad/s", "angular velocity", state="avoid")
    L: Var = var("m", "wound length")
    J: Var = var("kg.m2", "moment of inertia of the wound strip")
    m: Var = var("kg", "mass of the wound strip")
    T: Var = var("N", "tension of the strip")
    M_b: Var = var("N.m", "bending torque")
    position: Var = var("1", "1 winding, 0 stuck, -1 unwinding, 2 no bending torque")
    state: Var = var("1", "0 winding, 1 over-full, -1 pulled off the mandrel")

    def equations(self) -> Iterator[Item]:
        pitch = self.h / (2 * pi * self.fill)
        yield self.theta == self.flange.phi - self.tangent.phi
        yield self.w_wound == der(self.theta)
        yield self.w == der(self.flange.phi)
        yield self.R == self.r + pitch * self.theta
        yield self.L == (self.r + pitch * self.theta / 2) * self.theta
        yield self.strip.s == self.L
        yield self.m == self.rho * self.b * self.h * self.L
        yield self.J == self.m * (self.R**2 + self.r**2) / 2
        yield self.T == -self.strip.f
        yield self.flange.tau == self.J * der(self.w) + self.R * self.T + self.M_b
        yield self.tangent.tau == -self.R * self.T - self.M_b
        yield self.load == sqrt(self.T**2 + (self.g * (self.m + self.m_0)) ** 2)
        limit = self.sigma_s * self.b * self.h**2 / 4
        yield coulomb(
            self.M_b, self.w_wound, limit, limit, engaged=limit > 0, position=self.position
        )
        full, off = self.R > self.R_max, self.theta < 0
        yield self.state == where(full, 1.0, where(off, -1.0, 0.0))

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.M_b * self.w_wound


class Strip(Component):
    """Elastic strip that only pulls: ``T = c s_rel + d v_rel`` while ``s_rel > 0``, else 0.

    ``s_rel = s_b - s_a`` is its stretch, flange b being ahead in the sense of winding.
    ``c = E b h / l`` for a free length l. Damping is at most as strong as the spring, so that the
    tension begins and ends at zero. Losing the tension and finding it again are events.
    """

    symbol = "strip"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    c: Param = param("N/m", "stiffness", above=0)
    d: Param = param("N.s/m", "viscous damping", 0.0, min=0)
    s_rel: Var = var("m", "stretch", nominal=1e-4, state="prefer")
    v_rel: Var = var("m/s", "rate of stretch")
    T: Var = var("N", "tension")

    def equations(self) -> Iterator[Item]:
        yield self.s_rel == self.flange_b.s - self.flange_a.s
        yield self.v_rel == der(self.s_rel)
        yield self.T == pulling(self.s_rel, self.v_rel, self.c, self.d)
        yield self.flange_b.f == self.T
        yield self.flange_a.f == -self.T


class StripPath(Component):
    """Straight strip from a fixed roll to a coil on a turret: ``s_line = s_strip + l``.

    The axis of the coil is `r_t` from that of the turret and stands at the angle
    ``alpha = phi_0 + phi_carrier`` from the direction roll to turret, `d` long. Then
    ``D^2 = d^2 + r_t^2 + 2 d r_t cos(alpha)``, the free length is ``l = sqrt(D^2 - R^2)``, and the
    strip points at the angle ``atan2(r_t sin(alpha), d + r_t cos(alpha)) - asin(R / D)``, that of
    `tangent`. Torques follow from virtual work at the present radius R. Its growth does no work: it
    shortens l by as much as the strip turns. Join `strip` and `tangent` to those of a `Coil`
    and `R` to its radius; the carrier then takes the reaction of the tension. The mass of the strip
    between the rolls is left out, and the roll must be outside of the circle of the coil.
    """

    symbol = "strip"
    line = LinearFlange()
    strip = LinearFlange()
    tangent = Flange()
    carrier = Flange(grounded=True)
    r_t: Param = param("m", "distance of the axes of turret and coil", min=0)
    d: Param = param("m", "distance of the roll from the axis of the turret", above=r_t)
    phi_0: Param = param("rad", "angle of the coil on the turret where phi_carrier = 0", 0.0)
    R: Input = Input("m", "radius of the coil")
    alpha: Var = var("rad", "angle of the coil from the direction roll to turret", state="prefer")
    length: Var = var("m", "free length of the strip")
    psi: Var = var("rad", "direction of the strip", state="avoid")

    def equations(self) -> Iterator[Item]:
        f, at = self.line.f, self.carrier.phi
        alpha = self.phi_0 + at
        across, along = self.r_t * sin(alpha), self.d + self.r_t * cos(alpha)
        D = sqrt(across**2 + along**2)
        free = sqrt(across**2 + along**2 - self.R**2)
        direction = atan2(across, along) - asin(self.R / D)
        turned = Partial(direction, at)
        yield self.alpha == alpha
        yield self.length == free
        yield self.psi == direction
        yield self.line.s == self.strip.s + self.length
        yield self.tangent.phi == self.psi
        yield self.strip.f == -f
        yield self.carrier.tau == -Partial(free, at) * f - turned * self.tangent.tau


def pulling(s_rel: Expr, v_rel: Expr, c: Expr, d: Number) -> Expr:
    """Tension of a strip that only pulls, N.

    Parameters
    ----------
    s_rel, v_rel : expression
        Stretch, m, and its rate, m/s.
    c, d : expression
        Stiffness, N/m, and damping, N.s/m, which is at most as strong as the spring.

    Returns
    -------
    Expr
    """
    elastic = c * s_rel
    return where((s_rel > 0).called("tight", "slack"), one_sided(elastic, d * v_rel, d, "strip"), 0)
