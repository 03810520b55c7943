"""Prescribed torques and motions, and supports."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Flange, Input, Param, der, param

__all__ = ["Fixed", "Position", "Speed", "Torque"]


class Fixed(Component):
    """Flange held at a constant angle: ``phi = phi0``."""

    symbol = "fixed"
    flange = Flange()
    phi0: Param = param("rad", "angle", 0.0)

    def equations(self) -> Iterator[Equation]:
        yield self.flange.phi == self.phi0


class Torque(Component):
    """Torque on a shaft: ``tau_flange = -tau`` (it drives the shaft), ``tau_support = tau``.

    `tau` is given as a number, as an expression of the time, or connected to a signal.
    An open support stands still.
    """

    symbol = "torque"
    flange = Flange()
    support = Flange(grounded=True)
    tau = Input("N.m", "driving torque")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.tau == -self.tau
        yield self.support.tau == self.tau


class Speed(Component):
    """Prescribed angular velocity: ``der(phi) = w``, whatever torque that takes.

    `w` is given as a number, as an expression of the time, or connected to a signal.
    """

    symbol = "motion"
    flange = Flange()
    w = Input("rad/s", "angular velocity")

    def equations(self) -> Iterator[Equation]:
        yield der(self.flange.phi) == self.w


class Position(Component):
    """Prescribed angle: ``phi_flange = phi``, whatever torque that takes.

    `phi` is given as a number, as an expression of the time, or connected to a signal; speed and
    acceleration follow by differentiation.
    """

    symbol = "motion"
    flange = Flange()
    phi = Input("rad", "angle")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.phi == self.phi
