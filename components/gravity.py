"""Masses on arms that turn about a horizontal axis.

The angle counts upward from the horizontal on the side to which a positive radius points. Gravity
acts downward, so that lifting takes a positive torque.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Flange, Input, Param, Var, der, param, var
from lumped.language.component import Outline
from lumped.ops import cos, sin

__all__ = ["SwingingMass", "Weight"]


class SwingingMass(Component):
    """Body on an arm: ``(J + m R^2) der(w) = tau_flange - m g R cos(phi + phi0)``.

    `J` is the inertia about the own centre of gravity of a body that turns with the arm, such as a
    rod. It is zero for a point, and for a body that a parallel guide carries on a circle without
    turning it; the height of such a body above the end of the arm does not matter. A counterweight
    has a negative radius.
    """

    symbol = "arm"
    flange = Flange()
    m: Param = param("kg", "mass", above=0)
    R: Param = param("m", "radius of the centre of gravity, negative on the far side")
    J: Param = param(
        "kg.m2", "inertia about the centre of gravity if it turns with the arm", 0.0, min=0
    )
    phi0: Param = param("rad", "angle of the arm above the horizontal at the angle zero", 0.0)
    g: Param = param("m/s2", "gravity", 9.80665)
    phi: Var = var("rad", "angle of the flange")
    w: Var = var("rad/s", "angular velocity")
    tau_g: Var = var("N.m", "torque that gravity asks for")

    def equations(self) -> Iterator[Equation]:
        yield self.phi == self.flange.phi
        yield self.w == der(self.phi)
        yield self.tau_g == self.m * self.g * self.R * cos(self.phi + self.phi0)
        yield (self.J + self.m * self.R**2) * der(self.w) == self.flange.tau - self.tau_g

    def outline(self) -> Iterator[Outline]:
        yield from _arm(self)


class Weight(Component):
    """Downward force on an arm, without mass: ``tau_flange = f R cos(phi + phi0)``.

    For loads that come and go, and for the weight of a body whose inertia is a separate part.
    """

    symbol = "weight"
    flange = Flange()
    f: Input = Input("N", "downward force")
    R: Param = param("m", "radius, negative on the far side")
    phi0: Param = param("rad", "angle of the arm above the horizontal at the angle zero", 0.0)
    tau: Var = var("N.m", "torque that the force asks for")

    def equations(self) -> Iterator[Equation]:
        yield self.tau == self.f * self.R * cos(self.flange.phi + self.phi0)
        yield self.flange.tau == self.tau

    def outline(self) -> Iterator[Outline]:
        yield from _arm(self)


def _arm(part: SwingingMass | Weight) -> Iterator[Outline]:
    """Arm from the shaft to the body."""
    angle = part.flange.phi + part.phi0
    end = (part.R * cos(angle), part.R * sin(angle))
    yield "arm", ((0.0, 0.0), end)
    yield "body", (end,)
