"""What happens in a part of every turn: switches and loads that follow the angle of a shaft."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from lumped import Component, Equation, Expr, Flange, Output, Param, Var, param, var
from lumped.errors import EquationError
from lumped.expression import Compare
from lumped.ops import atan2, cos, pi, sin, where

__all__ = ["CamSwitch", "PulseTorque"]


class CamSwitch(Component):
    """Switch on a shaft: ``y = 1`` within half a `width` of the angle `centre`, else 0; no torque.

    It switches in every turn, in both directions; a run stops there. `rest` is ``1 - y``.
    """

    flange = Flange()
    centre: Param = param("rad", "angle in the middle of the range")
    width: Param = param("rad", "range of the angle", above=0, below=2 * pi)
    y = Output("1", "1 within the range")
    rest = Output("1", "1 outside of the range")

    def equations(self) -> Iterator[Equation]:
        inside = within(self.flange.phi, self.centre, self.width)
        yield self.flange.tau == 0
        yield self.y == where(inside, 1.0, 0.0)
        yield self.rest == 1 - self.y


class PulseTorque(Component):
    """Torque in a part of every turn: ``tau = tau_max cos(pi x / width)``, ``|x| < width / 2``.

    `x` is the angle from `centre`, and outside of the range the torque is zero. As ``"rectangle"``
    it is `tau_max` throughout the range. A positive torque drives, a negative one is a load.
    """

    flange = Flange()
    support = Flange(grounded=True)
    shape: Literal["half-sine", "rectangle"] = "half-sine"
    tau_max: Param = param("N.m", "driving torque in the middle of the range")
    centre: Param = param("rad", "angle in the middle of the range")
    width: Param = param("rad", "range of the angle", above=0, below=2 * pi)
    tau: Var = var("N.m", "driving torque")

    def equations(self) -> Iterator[Equation]:
        if self.shape not in ("half-sine", "rectangle"):
            raise EquationError(f"shape = {self.shape!r}: 'half-sine' or 'rectangle' is needed.")
        phi = self.flange.phi - self.support.phi
        x = atan2(sin(phi - self.centre), cos(phi - self.centre))
        form: Expr | float = cos(pi * x / self.width) if self.shape == "half-sine" else 1.0
        inside = within(phi, self.centre, self.width)
        yield self.tau == where(inside, self.tau_max * form, 0.0)
        yield self.flange.tau == -self.tau
        yield self.support.tau == self.tau


def within(phi: Expr, centre: Expr, width: Expr) -> Compare:
    """Whether an angle is within half a width of a centre, in any turn."""
    return cos(phi - centre) > cos(width / 2)
