"""Synchronous machine on a stiff grid as a spring to its rotating field."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Param, Var, der, param, var
from lumped.ops import cos, sin

__all__ = ["AirGap"]


class AirGap(Component):
    """Air gap of a synchronous machine on the grid: ``tau = tau_max sin(p theta) + d w_rel``.

    The rotor is ahead of the field of the grid, which turns at `w_s`, by the angle theta:
    ``w_rel = der(theta) = w - w_s``. It takes the torque `tau` from the shaft as a generator, and
    drives with a negative one. About a load angle it is a spring of the stiffness
    ``p tau_max cos(p theta) = p sqrt(tau_max^2 - tau^2)``, with a damper, between the rotor and the
    field. ``tau_max = 3 p U E / (w X)`` from voltages of a phase, field frequency w and reactance
    X; X is the transient one for vibrations faster than the field winding follows.

    Source: Kundur, Power System Stability and Control (1994) (torque over the load angle of a round
    rotor on an infinite bus, synchronising torque).
    """

    symbol = "motor"
    flange = Flange()
    support = Flange(grounded=True)
    tau_max: Param = param("N.m", "pull-out torque", above=0)
    p: Param = param("1", "pole pairs", min=1)
    d: Param = param("N.m.s/rad", "damping by damper windings", 0.0, min=0)
    w_s: Param = param("rad/s", "speed of the field")
    theta: Var = var("rad", "angle of the rotor ahead of the field", state="prefer")
    w_rel: Var = var("rad/s", "speed of the rotor relative to the field")
    tau: Var = var("N.m", "torque taken from the shaft")

    def equations(self) -> Iterator[Equation]:
        yield self.w_rel == der(self.flange.phi) - der(self.support.phi) - self.w_s
        yield der(self.theta) == self.w_rel
        yield self.tau == self.tau_max * sin(self.p * self.theta) + self.d * self.w_rel
        yield self.flange.tau == self.tau
        yield self.support.tau == -self.tau

    def stored(self) -> Expr:
        """Energy of the spring, J."""
        return self.tau_max * (1 - cos(self.p * self.theta)) / self.p

    def loss(self) -> Expr:
        """Power dissipated, and given to the grid, W."""
        return self.d * self.w_rel**2 + self.tau * self.w_s
