"""Switches and loads that follow the angle of a shaft, in any number of turns.

Source of the harmonics: Dresig and Holzweissig, Dynamics of Machinery (periodic excitation).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Literal

from lumped import Component, Equation, Expr, Flange, Output, Param, Var, param, var
from lumped.components.rows import check_ascending, check_rows
from lumped.errors import EquationError
from lumped.language.expression import Compare, ConstantExpression, Datum, Number, as_expr
from lumped.language.value_types import Rows
from lumped.ops import atan2, cos, maximum, minimum, periodic_spline, pi, sin, where

__all__ = [
    "CamSwitch",
    "HarmonicTorque",
    "PeriodicTorque",
    "PulseTorque",
]


class CamSwitch(Component):
    """Switch on a shaft: ``y = 1`` within half a `width` of the angle `centre`, else 0; no torque.

    It switches in every turn, in both directions; a run stops there. `rest` is ``1 - y``.
    """

    symbol = "latch"
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


class _AngleTorque(Component):
    """Torque ``tau`` that drives the flange, as a function of its angle against the support."""

    symbol = "load"
    flange = Flange()
    support = Flange(grounded=True)
    tau: Var = var("N.m", "driving torque")

    def equations(self) -> Iterator[Equation]:
        yield self.tau == self._driving(self.flange.phi - self.support.phi)
        yield self.flange.tau == -self.tau
        yield self.support.tau == self.tau

    def _driving(self, phi: Expr) -> Expr:
        raise NotImplementedError


class PulseTorque(_AngleTorque):
    """Torque in a part of every turn: ``tau = tau_max cos(pi x / width)``, ``|x| < width / 2``.

    `x` is the angle from `centre`; outside the range the torque is zero. With the shape
    ``"rectangle"`` it is `tau_max` throughout the range. A positive torque drives, a negative one
    is a load, such as that of a cut.
    """

    shape: Literal["half-sine", "rectangle"] = "half-sine"
    tau_max: Param = param("N.m", "driving torque in the middle of the range")
    centre: Param = param("rad", "angle in the middle of the range")
    width: Param = param("rad", "range of the angle", above=0, below=2 * pi)

    def _driving(self, phi: Expr) -> Expr:
        if self.shape not in ("half-sine", "rectangle"):
            raise EquationError(f"shape = {self.shape!r}: 'half-sine' or 'rectangle' is needed.")
        if self.shape == "half-sine":
            return pulse(phi, self.centre, self.width, self.tau_max)
        return where(within(phi, self.centre, self.width), self.tau_max, 0.0)


class HarmonicTorque(_AngleTorque):
    """Torque of harmonics of the angle: ``tau = mean + sum(A sin(order phi + phase))``.

    `harmonics` are rows of the order, the amplitude ``A`` in N.m and the phase in rad, such as
    ``((2, 340.0, 0.0), (4, 120.0, 1.2))``. A cylinder of a four-stroke engine has half orders, too.
    The work of a whole number of periods is that of the mean alone. A positive torque drives.
    """

    harmonics: Rows = ()
    mean: Param = param("N.m", "mean driving torque", 0.0)

    def _driving(self, phi: Expr) -> Expr:
        waves = harmonic_sum("harmonics", self.harmonics, phi, "N.m", "((2, 340.0, 0.0),)")
        return self.mean + waves


class PeriodicTorque(_AngleTorque):
    """Torque of a table over the angle that repeats: ``tau(phi + period) = tau(phi)``.

    `points` are rows of the angle in rad and the driving torque in N.m, within one period; the
    first point also ends the period. ``"smooth"`` joins them by a periodic cubic spline (continuous
    curvature), ``"lines"`` by straight lines; a run does not stop at their kinks.
    """

    points: Rows = ()
    shape: Literal["smooth", "lines"] = "smooth"
    period: float = 2 * pi

    def _driving(self, phi: Expr) -> Expr:
        angles, values = self._table()
        if len(values) == 2:
            return Datum(values[0])
        if self.shape == "smooth":
            return periodic_spline(phi, angles, values)
        if self.shape != "lines":
            raise EquationError(f"shape = {self.shape!r}: 'smooth' or 'lines' is needed.")
        turns = 2 * pi / self.period * (phi - angles[0])
        x = self.period / 2 * (1 + atan2(-sin(turns), -cos(turns)) / pi)
        total: Expr = Datum(values[0])
        for (a, b), (u, v) in zip(pairwise(angles), pairwise(values), strict=True):
            way = minimum(maximum(x - (a - angles[0]), 0.0), b - a)
            total = total + way * Datum((v - u) / (b - a))
        return total

    def _table(self) -> tuple[list[float], list[float]]:
        """Angles and torques, with the first point again one period later."""
        rows = check_rows(
            "points", self.points, "angle (rad) and torque (N.m)", "((0, 10), (1, 20))"
        )
        if not isinstance(self.period, int | float) or not 0 < self.period < float("inf"):
            raise EquationError(
                f"period = {self.period!r} rad must be a positive number: the angle after which "
                "the torque repeats, 2 pi for a turn."
            )
        angles, values = [a for a, _ in rows], [v for _, v in rows]
        check_ascending("points", "angles", angles, "rad")
        end = angles[0] + self.period
        if not angles[-1] < end:
            raise EquationError(
                f"points: the last angle {angles[-1]:g} rad is not before {end:g} rad, where the "
                "next period begins with the first point. Angles are in rad; leave the closing "
                "point out, or give a longer period."
            )
        return [*angles, end], [*values, values[0]]


def harmonic_sum(name: str, harmonics: Rows, phi: Expr, unit: str, example: str) -> Expr:
    """``sum(A sin(order phi + phase))`` of rows of order, amplitude A and phase.

    Parameters
    ----------
    name : str
        Of the rows, for errors.
    harmonics : rows
        Order, amplitude in `unit`, phase in rad.
    phi : expression
        Angle, rad.
    unit : str
        Of the amplitude.
    example : str
        Rows that make sense.

    Returns
    -------
    Expr

    Raises
    ------
    EquationError
        If there are no rows, or an order is not positive.
    """
    total: Expr = ConstantExpression(0.0)
    for order, amplitude, phase in check_rows(
        name, harmonics, f"order, amplitude ({unit}) and phase (rad)", example, 3
    ):
        if order <= 0:
            raise EquationError(
                f"{name}: the order {order:g} is not positive. Periods in a turn are meant; "
                "a constant part, the 'mean' of a torque, is no harmonic."
            )
        total = total + Datum(amplitude) * sin(order * phi + phase)
    return total


def pulse(phi: Expr, centre: Expr, width: Expr, height: Expr) -> Expr:
    """Half sine in every turn, `height` at `centre` and zero beyond half a `width` of it."""
    x = atan2(sin(phi - centre), cos(phi - centre))
    return where(within(phi, centre, width), height * cos(pi * x / width), 0.0)


def within(phi: Expr, centre: Number, width: Number) -> Compare:
    """Whether an angle is within half a width of a centre, in any turn."""
    return cos(phi - centre) > cos(as_expr(width) / 2)
