"""Torque of ice on the blades of a ship's propeller."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Param, Var, der, param, var
from lumped.components.cams import pulse
from lumped.components.rows import check_rows
from lumped.errors import EquationError
from lumped.language.expression import ConstantExpression, Datum
from lumped.language.validity import Range
from lumped.language.value_types import Rows
from lumped.ops import maximum, minimum, pi, smooth, where

__all__ = ["IceTorque"]


class IceTorque(Component):
    """Torque of ice against a propeller over its angle: half sines, one sequence for each blade.

    A blade meets each of `blocks` once in a turn, ``tau = C_q Q_max sin(pi x / alpha)`` while
    ``0 < x < alpha``, with the angle x since the block's begin. The torques of the Z blades add,
    each ``2 pi / Z`` after the one before. The sequence lasts `turns` from the angle `begin` on and
    rises and falls in proportion to the angle over the first and the last `ramp`.

    `blocks` are rows of the factor C_q, the width alpha and the angle of its begin, both in rad.
    They are a user's: ice class rules (Finnish-Swedish Ice Class Rules, IACS UR I3) give them by
    case, and Q_max by the propeller and the ice. They are those of a propeller that turns forward,
    with growing angle; a run in which the ice would drive one that turns back ends with an error.
    """

    symbol = "load"
    flange = Flange()
    support = Flange(grounded=True)
    blocks: Rows = ()
    Z: int = 4
    Q_max: Param = param("N.m", "greatest torque of ice on a blade", min=0)
    turns: Param = param("1", "turns of the sequence", above=0)
    ramp: Param = param("rad", "angle of its rise, and of its fall", 1.5 * pi, above=0)
    begin: Param = param("rad", "angle at which it begins", 0.0)
    a: Var = var("rad", "angle since the begin", state="avoid")
    w: Var = var("rad/s", "speed of the propeller")
    tau: Var = var("N.m", "torque of the ice against the motion")

    def equations(self) -> Iterator[Equation]:
        yield self.a == self.flange.phi - self.support.phi - self.begin
        yield self.w == der(self.a)
        yield self.tau == self.Q_max * self._ramped() * self._sequence()
        yield self.flange.tau == self.tau
        yield self.support.tau == -self.tau

    def valid(self) -> Iterator[Range]:
        inside = smooth(where(self.tau > 0, self.w, 0.0))
        hint = "The ice is that of forward motion; keep the propeller from turning back in it"
        yield Range(inside, 0.0, float("inf"), "rad/s", "speed in the ice", hint)

    def _ramped(self) -> Expr:
        """From 0 to 1 and back over the sequence."""
        nearest: Expr = minimum(self.a, 2 * pi * self.turns - self.a)
        share: Expr = minimum(nearest / self.ramp, 1.0)
        return maximum(share, 0.0)

    def _sequence(self) -> Expr:
        """Sum of the half sines of all blades over Q_max."""
        if not isinstance(self.Z, int) or self.Z < 1:
            raise EquationError(f"Z = {self.Z!r}: the number of blades, at least 1, is needed.")
        rows = check_rows(
            "blocks", self.blocks, "factor, width (rad) and begin (rad)", "((0.75, 1.57, 0.0),)", 3
        )
        total: Expr = ConstantExpression(0.0)
        for factor, width, first in rows:
            if factor < 0 or not 0 < width < 2 * pi:
                raise EquationError(
                    f"blocks: the factor {factor:g} must not be negative, and the width {width:g} "
                    "rad must be between 0 and a turn of 2 pi. Angles are in rad."
                )
            for blade in range(self.Z):
                centre = first + width / 2 + 2 * pi * blade / self.Z
                total = total + pulse(self.a, Datum(centre), Datum(width), Datum(factor))
        return total
