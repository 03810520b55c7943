"""Dampers of torsional vibration on a shaft: a ring in a fluid, a ring on springs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from lumped import Component, Equation, Expr, Flange, Param, Var, der, param, var
from lumped.errors import OptionError

__all__ = ["TunedDamper", "TunedLossDamper", "ViscousDamper", "ViscousOptimum"]


class ViscousOptimum(NamedTuple):
    """Best damping of a ring in a fluid on an inertia J on a spring (Den Hartog).

    Attributes
    ----------
    ring : float
        ``d / (2 J_ring w_n)``, with the natural frequency w_n of J on its spring.
    main : float
        ``d / (2 J w_n)``.
    frequency : float
        Frequency of the largest vibration over w_n.
    peak : float
        Largest vibration over the static twist.
    """

    ring: float
    main: float
    frequency: float
    peak: float


class _RingDamper(Component):
    """A ring that a shaft drags along; the housing counts to the shaft."""

    flange = Flange()
    J_ring: Param = param("kg.m2", "moment of inertia of the ring", above=0)
    w: Var = var("rad/s", "angular velocity of the ring")
    w_rel: Var = var("rad/s", "angular velocity of the shaft relative to the ring")
    tau: Var = var("N.m", "torque on the ring")
    power: Var = var("W", "dissipated power")

    def equations(self) -> Iterator[Equation]:
        yield self.w_rel == der(self.flange.phi) - self.w
        yield self.J_ring * der(self.w) == self.tau
        yield self.flange.tau == self.tau

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.power

    def stored(self) -> Expr:
        """Energy of the ring, J."""
        return 0.5 * self.J_ring * self.w**2


class ViscousDamper(_RingDamper):
    """Viscous damper, Houdaille: a ring in fluid, ``tau = d (w_shaft - w)``.

    Source: Den Hartog, Mechanical Vibrations (1956), ch. 3.
    """

    symbol = "ring_damper"
    d: Param = param("N.m.s/rad", "viscous damping by the fluid", min=0)

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self.tau == self.d * self.w_rel
        yield self.power == self.tau * self.w_rel

    @staticmethod
    def optimum(mu: float) -> ViscousOptimum:
        """Damping that makes the largest vibration as small as possible.

        Parameters
        ----------
        mu : float
            Inertia of the ring over that of the vibrating body, housing included.

        Raises
        ------
        OptionError
            If it is not positive.
        """
        if not 0 < mu < float("inf"):
            raise OptionError(f"ViscousDamper.optimum: mu = {mu!r} must be above zero.")
        ring = (2 * (1 + mu) * (2 + mu)) ** -0.5
        return ViscousOptimum(ring, mu * ring, (2 / (2 + mu)) ** 0.5, 1 + 2 / mu)


class _SprungRingDamper(_RingDamper):
    """A ring on springs."""

    symbol = "ring_damper"
    c: Param = param("N.m/rad", "torsional stiffness of its springs", above=0)
    phi_rel: Var = var("rad", "angle of the shaft before the ring", nominal=1e-4, state="prefer")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield der(self.phi_rel) == self.w_rel
        yield self.tau == self.c * self.phi_rel + self._damping() * self.w_rel
        yield self.power == self._damping() * self.w_rel**2

    def stored(self) -> Expr:
        """Energy of the ring and of its springs, J."""
        return super().stored() + 0.5 * self.c * self.phi_rel**2

    def _damping(self) -> Expr:
        raise NotImplementedError


class TunedDamper(_SprungRingDamper):
    """Tuned damper: a ring on springs with damping, ``tau = c phi_rel + d w_rel``.

    It acts near ``w = sqrt(c / J_ring)``. Source: Den Hartog, Mechanical Vibrations (1956), ch. 3.
    """

    d: Param = param("N.m.s/rad", "viscous damping", min=0)

    def _damping(self) -> Expr:
        return self.d


class TunedLossDamper(_SprungRingDamper):
    """Tuned damper of rubber: ``tau = c phi_rel + c eta / w_loss w_rel``.

    Its stiffness has a loss factor, as that of `LossSpring`: in responses ``c (1 + j eta)``.
    """

    eta: Param = param("1", "loss factor", min=0)
    w_loss: Param = param(
        "rad/s", "angular frequency of vibration to which eta applies", above=0, vibrates=True
    )

    def _damping(self) -> Expr:
        return self.c * self.eta / self.w_loss
