"""Prescribed torques and motions, and supports.

A signal with jumps or kinks cannot be a `Position`, and a `Speed` only with impulses; the filtered
sources follow any signal by a motion that a drive can make.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Input, Param, Var, der, param, var
from lumped.ops import pi

__all__ = [
    "Acceleration",
    "FilteredPosition",
    "FilteredSpeed",
    "Fixed",
    "Position",
    "RelativeSpeed",
    "Speed",
    "Torque",
]


def corner(f_crit: Expr, order: int) -> Expr:
    """Corner of equal lags in series whose amplitude is down to ``1 / sqrt(2)`` at `f_crit`.

    Tietze and Schenk, Electronic Circuits, 2nd ed., ch. 13.1 (critically damped filters).
    """
    ratio: float = (2.0 ** (1 / order) - 1) ** 0.5
    return 2 * pi * f_crit / ratio


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
    tau: Input = Input("N.m", "driving torque")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.tau == -self.tau
        yield self.support.tau == self.tau


class Speed(Component):
    """Prescribed angular velocity: ``der(phi) = w``, whatever torque that takes.

    `w` is given as a number, as an expression of the time, or connected to a signal.
    """

    symbol = "motion"
    flange = Flange()
    w: Input = Input("rad/s", "angular velocity")

    def equations(self) -> Iterator[Equation]:
        yield der(self.flange.phi) == self.w


class Position(Component):
    """Prescribed angle: ``phi_flange = phi``, whatever torque that takes.

    `phi` is given as a number, as an expression of the time, or connected to a signal; speed and
    acceleration follow by differentiation.
    """

    symbol = "motion"
    flange = Flange()
    phi: Input = Input("rad", "angle")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.phi == self.phi


class Acceleration(Component):
    """Prescribed angular acceleration: ``der(w) = a``, whatever torque that takes.

    `a` is given as a number, as an expression of the time, or connected to a signal.
    """

    symbol = "motion"
    flange = Flange()
    a: Input = Input("rad/s2", "angular acceleration")
    phi: Var = var("rad", "angle", state="prefer")
    w: Var = var("rad/s", "angular velocity", state="prefer")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.phi == self.phi
        yield self.w == der(self.phi)
        yield der(self.w) == self.a


class FilteredPosition(Component):
    """Angle that follows a signal: ``der(w) = w_c^2 (phi_ref - phi) - 2 w_c w``, ``w = der(phi)``.

    A critically damped filter of second order: it does not overshoot a step, and speed and
    acceleration exist whatever the signal does. `f_crit` is the frequency at which the amplitude is
    down to ``1 / sqrt(2)``, ``w_c = 2 pi f_crit / sqrt(sqrt(2) - 1)``.
    """

    symbol = "motion"
    flange = Flange()
    phi_ref: Input = Input("rad", "angle to be followed")
    f_crit: Param = param("Hz", "frequency up to which it follows", 50.0, above=0)
    phi: Var = var("rad", "angle", state="prefer")
    w: Var = var("rad/s", "angular velocity", state="prefer")
    a: Var = var("rad/s2", "angular acceleration")

    def equations(self) -> Iterator[Equation]:
        w_c = corner(self.f_crit, 2)
        yield self.flange.phi == self.phi
        yield self.w == der(self.phi)
        yield self.a == der(self.w)
        yield self.a == w_c**2 * (self.phi_ref - self.phi) - 2 * w_c * self.w


class FilteredSpeed(Component):
    """Speed that follows a signal: ``der(w) = w_c (w_ref - w)``, ``w = der(phi)``.

    A filter of first order, so that the acceleration exists where the signal jumps. `f_crit` is the
    frequency at which the amplitude is down to ``1 / sqrt(2)``, ``w_c = 2 pi f_crit``.
    """

    symbol = "motion"
    flange = Flange()
    w_ref: Input = Input("rad/s", "angular velocity to be followed")
    f_crit: Param = param("Hz", "frequency up to which it follows", 50.0, above=0)
    phi: Var = var("rad", "angle", state="prefer")
    w: Var = var("rad/s", "angular velocity", state="prefer")
    a: Var = var("rad/s2", "angular acceleration")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.phi == self.phi
        yield self.w == der(self.phi)
        yield self.a == der(self.w)
        yield self.a == corner(self.f_crit, 1) * (self.w_ref - self.w)


class RelativeSpeed(Component):
    """Prescribed speed between two shafts: ``der(phi_b - phi_a) = w``, whatever torque that takes.

    `tau` acts on the source at flange b and, reversed, at flange a. `w` is given as a number, as an
    expression of the time, or connected to a signal.
    """

    symbol = "motion"
    flange_a = Flange()
    flange_b = Flange()
    w: Input = Input("rad/s", "angular velocity of flange b relative to flange a")
    phi_rel: Var = var("rad", "relative angle")
    tau: Var = var("N.m", "torque on flange b")

    def equations(self) -> Iterator[Equation]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield der(self.phi_rel) == self.w
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau
