"""Prescribed forces and motions along a line, and supports.

The names are those of the rotational twins (`lumped.components.sources`), and so are the laws.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Input, LinearFlange, Param, Var, der, param, var
from lumped.components.sources import corner

__all__ = [
    "Acceleration",
    "FilteredPosition",
    "FilteredSpeed",
    "Fixed",
    "Force",
    "Position",
    "RelativeSpeed",
    "Speed",
]


class Fixed(Component):
    """Flange held at a constant position: ``s = s0``."""

    symbol = "fixed"
    flange = LinearFlange()
    s0: Param = param("m", "position", 0.0)

    def equations(self) -> Iterator[Equation]:
        yield self.flange.s == self.s0


class Force(Component):
    """Force on a body: ``f_flange = -f`` (it drives the body), ``f_support = f``.

    `f` is given as a number, as an expression of the time, or connected to a signal.
    An open support stands still.
    """

    symbol = "force"
    flange = LinearFlange()
    support = LinearFlange(grounded=True)
    f: Input = Input("N", "driving force")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.f == -self.f
        yield self.support.f == self.f


class Speed(Component):
    """Prescribed velocity: ``der(s) = v``, whatever force that takes.

    `v` is given as a number, as an expression of the time, or connected to a signal.
    """

    symbol = "motion"
    flange = LinearFlange()
    v: Input = Input("m/s", "velocity")

    def equations(self) -> Iterator[Equation]:
        yield der(self.flange.s) == self.v


class Position(Component):
    """Prescribed position: ``s_flange = s``, whatever force that takes.

    `s` is given as a number, as an expression of the time, or connected to a signal; velocity and
    acceleration follow by differentiation.
    """

    symbol = "motion"
    flange = LinearFlange()
    s: Input = Input("m", "position")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.s == self.s


class Acceleration(Component):
    """Prescribed acceleration: ``der(v) = a``, ``v = der(s)``, whatever force that takes.

    `a` is given as a number, as an expression of the time, or connected to a signal.
    """

    symbol = "motion"
    flange = LinearFlange()
    a: Input = Input("m/s2", "acceleration")
    s: Var = var("m", "position", state="prefer")
    v: Var = var("m/s", "velocity", state="prefer")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.s == self.s
        yield self.v == der(self.s)
        yield der(self.v) == self.a


class FilteredPosition(Component):
    """Position that follows a signal: ``der(v) = w_c^2 (s_ref - s) - 2 w_c v``, ``v = der(s)``.

    A critically damped filter of second order: it does not overshoot a step, and velocity and
    acceleration exist whatever the signal does. `f_crit` is the frequency at which the amplitude is
    down to ``1 / sqrt(2)``, ``w_c = 2 pi f_crit / sqrt(sqrt(2) - 1)``.
    """

    symbol = "motion"
    flange = LinearFlange()
    s_ref: Input = Input("m", "position to be followed")
    f_crit: Param = param("Hz", "frequency up to which it follows", 50.0, above=0)
    s: Var = var("m", "position", state="prefer")
    v: Var = var("m/s", "velocity", state="prefer")
    a: Var = var("m/s2", "acceleration")

    def equations(self) -> Iterator[Equation]:
        w_c = corner(self.f_crit, 2)
        yield self.flange.s == self.s
        yield self.v == der(self.s)
        yield self.a == der(self.v)
        yield self.a == w_c**2 * (self.s_ref - self.s) - 2 * w_c * self.v


class FilteredSpeed(Component):
    """Velocity that follows a signal: ``der(v) = w_c (v_ref - v)``, ``v = der(s)``.

    A filter of first order, so that the acceleration exists where the signal jumps. `f_crit` is the
    frequency at which the amplitude is down to ``1 / sqrt(2)``, ``w_c = 2 pi f_crit``.
    """

    symbol = "motion"
    flange = LinearFlange()
    v_ref: Input = Input("m/s", "velocity to be followed")
    f_crit: Param = param("Hz", "frequency up to which it follows", 50.0, above=0)
    s: Var = var("m", "position", state="prefer")
    v: Var = var("m/s", "velocity", state="prefer")
    a: Var = var("m/s2", "acceleration")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.s == self.s
        yield self.v == der(self.s)
        yield self.a == der(self.v)
        yield self.a == corner(self.f_crit, 1) * (self.v_ref - self.v)


class RelativeSpeed(Component):
    """Prescribed velocity between two flanges: ``der(s_b - s_a) = v``, whatever force that takes.

    `f` acts on the source at flange b and, reversed, at flange a. `v` is given as a number, as an
    expression of the time, or connected to a signal.
    """

    symbol = "motion"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    v: Input = Input("m/s", "velocity of flange b relative to flange a")
    s_rel: Var = var("m", "distance of the flanges")
    f: Var = var("N", "force on flange b")

    def equations(self) -> Iterator[Equation]:
        yield self.s_rel == self.flange_b.s - self.flange_a.s
        yield der(self.s_rel) == self.v
        yield self.flange_b.f == self.f
        yield self.flange_a.f == -self.f
