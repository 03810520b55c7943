"""Massless elastic and viscous shafts."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Param, Var, der, param, var
from lumped.components.couplings.elastic import ElasticLaw, elastic_energy, elastic_force

__all__ = ["Damper", "LossSpring", "NonlinearSpring", "Spring", "SpringDamper"]


class Spring(Component):
    """Linear torsional spring: ``tau = c (phi_rel - phi_rel0)``, ``phi_rel = phi_b - phi_a``.

    `tau` acts on the spring at flange b and, reversed, at flange a: it is positive when flange b
    leads, and negative while flange a drives, as in the Modelica library.
    """

    symbol = "spring"
    flange_a = Flange()
    flange_b = Flange()
    c: Param = param("N.m/rad", "torsional stiffness", above=0)
    phi_rel0: Param = param("rad", "twist without torque", 0.0)
    phi_rel: Var = var("rad", "twist", nominal=1e-4, state="prefer")
    tau: Var = var("N.m", "torque on flange b")

    def equations(self) -> Iterator[Equation]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.tau == self.c * (self.phi_rel - self.phi_rel0)
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return 0.5 * self.c * (self.phi_rel - self.phi_rel0) ** 2


class NonlinearSpring(Component):
    """Torsional spring with a characteristic: ``tau = F(phi_rel - phi_rel0)``.

    `characteristic` is F, torque in N.m over twist in rad: rows of both, joined by straight lines,
    the first and last continued; rows that begin at zero hold for both directions. Or a function of
    the twist in `lumped.ops`. For progressive couplings, and shafts whose stiffness was measured.
    """

    symbol = "spring"
    flange_a = Flange()
    flange_b = Flange()
    characteristic: ElasticLaw = ()
    phi_rel0: Param = param("rad", "twist at which the characteristic has its zero", 0.0)
    phi_rel: Var = var("rad", "twist", nominal=1e-4, state="prefer")
    tau: Var = var("N.m", "torque on flange b")

    def equations(self) -> Iterator[Equation]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.tau == elastic_force(self.characteristic, self.phi_rel - self.phi_rel0)
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return elastic_energy(self.characteristic, self.phi_rel - self.phi_rel0)


class Damper(Component):
    """Linear viscous damper: ``tau = d w_rel``, ``w_rel = der(phi_b - phi_a)``."""

    symbol = "damper"
    flange_a = Flange()
    flange_b = Flange()
    d: Param = param("N.m.s/rad", "viscous damping", min=0)
    phi_rel: Var = var("rad", "relative angle")
    w_rel: Var = var("rad/s", "relative angular velocity")
    tau: Var = var("N.m", "torque on flange b")

    def equations(self) -> Iterator[Equation]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.w_rel == der(self.phi_rel)
        yield self.tau == self.d * self.w_rel
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.d * self.w_rel**2


class SpringDamper(Component):
    """Spring and damper in parallel: ``tau = c (phi_rel - phi_rel0) + d w_rel``."""

    symbol = "spring_damper"
    flange_a = Flange()
    flange_b = Flange()
    c: Param = param("N.m/rad", "torsional stiffness", above=0)
    d: Param = param("N.m.s/rad", "viscous damping", 0.0, min=0)
    phi_rel0: Param = param("rad", "twist without torque", 0.0)
    phi_rel: Var = var("rad", "twist", nominal=1e-4, state="prefer")
    w_rel: Var = var("rad/s", "relative angular velocity")
    tau: Var = var("N.m", "torque on flange b")

    def equations(self) -> Iterator[Equation]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.w_rel == der(self.phi_rel)
        yield self.tau == self.c * (self.phi_rel - self.phi_rel0) + self.d * self.w_rel
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.d * self.w_rel**2

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return 0.5 * self.c * (self.phi_rel - self.phi_rel0) ** 2


class LossSpring(Component):
    """Spring of a material with a loss factor: ``tau = c phi_rel + c eta / w_loss w_rel``.

    A vibration of the angular frequency `w_loss` loses ``2 pi eta`` of its largest elastic energy
    in each period (relative damping psi of couplings). In runs it is a spring with the viscous
    damper that loses as much at `w_loss`, which is stated; responses to a vibration put its own
    frequency there, which makes the stiffness ``c (1 + j eta)``.

    Source: Den Hartog, Mechanical Vibrations (1956), on hysteresis damping.
    """

    symbol = "spring_damper"
    flange_a = Flange()
    flange_b = Flange()
    c: Param = param("N.m/rad", "torsional stiffness", above=0)
    eta: Param = param("1", "loss factor", min=0)
    w_loss: Param = param(
        "rad/s", "angular frequency of vibration to which eta applies", above=0, vibrates=True
    )
    phi_rel0: Param = param("rad", "twist without torque", 0.0)
    phi_rel: Var = var("rad", "twist", nominal=1e-4, state="prefer")
    w_rel: Var = var("rad/s", "relative angular velocity")
    tau_c: Var = var("N.m", "torque of the stiffness on flange b")
    tau: Var = var("N.m", "torque on flange b")

    def equations(self) -> Iterator[Equation]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.w_rel == der(self.phi_rel)
        yield self.tau_c == self.c * (self.phi_rel - self.phi_rel0)
        yield self.tau == self.tau_c + self.c * self.eta / self.w_loss * self.w_rel
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.c * self.eta / self.w_loss * self.w_rel**2

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return 0.5 * self.c * (self.phi_rel - self.phi_rel0) ** 2
