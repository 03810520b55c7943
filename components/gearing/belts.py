"""Belts and chains between two pulleys."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Output, Param, Var, der, param, var
from lumped.components.winding import pulling
from lumped.ops import sqrt

__all__ = ["Belt"]


class Belt(Component):
    """Elastic belt or chain: ``tau_a = r_a (T_1 - T_2)``, ``T = F_0 + c e`` and ``F_0 - c e``.

    Two strands of the free length ``l``, each of the stiffness ``c = EA / l``, run between pulleys
    on which they do not slip. ``e = r_a phi_a - r_b phi_b`` is how much strand 1 is stretched and
    strand 2 shortened; a crossed belt turns the pulleys in opposite directions,
    ``e = r_a phi_a + r_b phi_b``. A strand only pulls: at ``c |e| = F_0`` one goes slack, which is
    an event, and then has ``T = 0``. Damping is at most as strong as the spring. Angles count from
    the support, the frame of both axes, which takes ``-tau_a - tau_b``; it stands still if open.

    With the distance D of the axes and ``r = r_b - r_a`` (crossed: ``-r_b - r_a``) the strands are
    ``l = sqrt(D^2 - r^2)`` long, and pull axis a towards axis b with ``F = (T_1 + T_2) l / D`` and
    aside with ``Q = (T_1 - T_2) r / D``, to the left of the direction a to b where positive angles
    turn left. Axis b feels the reverse of both. Mass and centrifugal force of the belt are left
    out. The rigid limit is an `IdealGear` of the ratio ``r_b / r_a``, crossed its negative.

    Source: Niemann and Winter, Maschinenelemente, vol. 3, ch. 27 (geometry and shaft load).
    """

    symbol = "belt"
    flange_a = Flange()
    flange_b = Flange()
    support = Flange(grounded=True)
    F = Output("N", "force on axis a towards axis b")
    Q = Output("N", "force on axis a across, to the left of the direction to b")
    r_a: Param = param("m", "pitch radius of pulley a", above=0)
    r_b: Param = param("m", "pitch radius of pulley b", above=0)
    distance: Param = param("m", "distance of the axes", above=r_a + r_b)
    EA: Param = param("N", "modulus of elasticity times section of one strand", above=0)
    d: Param = param("N.s/m", "viscous damping of one strand", 0.0, min=0)
    F_0: Param = param("N", "pretension of each strand", min=0)
    crossed: bool = False
    e: Var = var("m", "stretch of strand 1 by the load", nominal=1e-4, state="prefer")
    v: Var = var("m/s", "rate of stretch of strand 1")
    c: Var = var("N/m", "stiffness of one strand")
    T_1: Var = var("N", "tension of strand 1, which pulls where a drives forward")
    T_2: Var = var("N", "tension of strand 2")

    def equations(self) -> Iterator[Equation]:
        a, b, frame = self.flange_a, self.flange_b, self.support
        r_b = -self.r_b if self.crossed else self.r_b
        offset = r_b - self.r_a
        length = sqrt(self.distance**2 - offset**2)
        yield self.e == self.r_a * (a.phi - frame.phi) - r_b * (b.phi - frame.phi)
        yield self.v == der(self.e)
        yield self.c == self.EA / length
        yield self.T_1 == pulling(self.F_0 / self.c + self.e, self.v, self.c, self.d)
        yield self.T_2 == pulling(self.F_0 / self.c - self.e, -self.v, self.c, self.d)
        yield a.tau == self.r_a * (self.T_1 - self.T_2)
        yield b.tau == -r_b * (self.T_1 - self.T_2)
        yield frame.tau == offset * (self.T_1 - self.T_2)
        yield self.F == (self.T_1 + self.T_2) * length / self.distance
        yield self.Q == (self.T_1 - self.T_2) * offset / self.distance

    def loss(self) -> Expr:
        """Dissipated power, W."""
        first = self.T_1 - pulling(self.F_0 / self.c + self.e, self.v, self.c, 0.0)
        second = self.T_2 - pulling(self.F_0 / self.c - self.e, self.v, self.c, 0.0)
        return (first - second) * self.v
