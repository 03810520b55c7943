"""Cylinders of reciprocating engines and compressors.

Source: Dresig and Holzweissig, Dynamics of Machinery, ch. 2.4 (reduced inertia of a crank drive);
Nestorides, A Handbook on Torsional Vibration (1958), ch. 5 (harmonic components of cylinders).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Literal

from lumped import Component, Equation, Expr, Flange, Param, Var, der, param, var
from lumped.errors import EquationError, shown
from lumped.language.expression import ConstantExpression
from lumped.ops import cos, interpolate, periodic_spline, pi, sin, smooth, sqrt, where

__all__ = ["Cylinder"]

_STEPS = 32
"""Angles of a turn at which a mean is taken."""
_CLOSES = 0.01
"""Jump between the ends of a pressure table, over its range, that counts as reading accuracy."""


class Cylinder(Component):
    """Cylinder on a crank: torque of the gas and of the masses that move to and fro.

    The crank angle ``a = phi - phase`` counts from top dead centre, in a four-stroke engine from
    that of gas exchange, so that it fires near ``a = 2 pi``. With ``sin(b) = r/L sin(a)``::

        h(a) = r sin(a + b) / cos(b)            way of the piston for each radian
        tau_gas = p(a) pi D^2 / 4 h(a)
        tau_mass = -m h (h der(w) + h' w^2)      of the masses

    `pressure` are rows of the crank angle, rad, and the pressure above that of the crankcase, Pa,
    over a cycle; they are multiplied by `load`. ``"lines"`` joins them by straight lines,
    ``"smooth"`` by a periodic cubic spline; a run does not stop at their kinks. The ends of the
    table may differ by 1 % of its range, which is then a jump.

    `masses` says what the masses do: ``"exact"`` is the torque above, so that the inertia varies
    with the angle; ``"excitation"`` leaves ``h der(w)`` out and adds the mean of ``m h^2`` to the
    inertia, as calculations with constant inertias do; ``"series"`` takes the slider's acceleration
    from `series`, rows of order and coefficient of ``r w^2 cos(order a)``, and adds no inertia.

    `misfire` leaves gas forces out (``"no gas"``), or compresses and expands the charge without
    firing between the dead centres at pi and 3 pi (``"compression"``): ``p V^n`` is constant there,
    with the volume V from the compression ratio.
    """

    symbol = "crank"
    flange = Flange()
    pressure: Sequence[Sequence[float]] = ()
    strokes: Literal[2, 4] = 4
    shape: Literal["lines", "smooth"] = "lines"
    masses: Literal["exact", "excitation", "series"] = "exact"
    series: Sequence[Sequence[float]] = ()
    misfire: Literal["none", "no gas", "compression"] = "none"
    bore: Param = param("m", "diameter of the piston", above=0)
    r: Param = param("m", "crank radius, half of the stroke", above=0)
    L: Param = param("m", "length of the rod", above=r)
    m: Param = param("kg", "mass that moves with the piston", 0.0, min=0)
    phase: Param = param("rad", "angle of the flange at which a cycle begins", 0.0)
    load: Param = param("1", "factor of the pressure", 1.0, min=0)
    compression: Param = param("1", "compression ratio", 17.0, above=1)
    n: Param = param("1", "exponent of compression without firing", 1.33, above=0)
    p: Var = var("Pa", "pressure above that of the crankcase", nominal=1e5)
    tau_gas: Var = var("N.m", "driving torque of the gas")
    tau_mass: Var = var("N.m", "driving torque of the masses")
    tau: Var = var("N.m", "driving torque")

    def equations(self) -> Iterator[Equation]:
        a = self.flange.phi - self.phase
        lever, slope = self._lever(a)
        w = der(self.flange.phi)
        area = pi * self.bore**2 / 4
        yield self.p == self.load * self._pressure(a)
        yield self.tau_gas == self.p * area * lever
        if self.masses == "exact":
            yield self.tau_mass == -self.m * lever * (lever * der(w) + slope * w**2)
        elif self.masses == "excitation":
            mean = self._mean_square()
            yield self.tau_mass == -self.m * (lever * slope * w**2 + mean * der(w))
        else:
            yield self.tau_mass == -self.m * self.r * w**2 * self._series(a) * lever
        yield self.tau == self.tau_gas + self.tau_mass
        yield self.flange.tau == -self.tau

    def _lever(self, a: Expr) -> tuple[Expr, Expr]:
        """Way of the piston for each radian, m, and its derivative by the angle."""
        r, share = self.r, self.r / self.L
        tilt = share * sin(a)
        upright = sqrt(1 - tilt**2)
        turn = share * cos(a) / upright
        lever = r * (sin(a) + cos(a) * tilt / upright)
        bend = cos(a) * turn * (1 + (tilt / upright) ** 2) - sin(a) * tilt / upright
        return lever, r * (cos(a) + bend)

    def _mean_square(self) -> Expr:
        """Mean of the squared lever over a turn, m2; to rounding by equal steps."""
        total: Expr = ConstantExpression(0.0)
        for i in range(_STEPS):
            total = total + self._lever(ConstantExpression(2 * pi * i / _STEPS))[0] ** 2
        return total / _STEPS

    def _series(self, a: Expr) -> Expr:
        """Acceleration of the piston over ``r w^2``."""
        rows = _rows("series", self.series, "order and coefficient", "((1, 1.0), (2, 0.25))")
        total: Expr = ConstantExpression(0.0)
        for order, coefficient in rows:
            total = total + coefficient * cos(order * a)
        return total

    def _pressure(self, a: Expr) -> Expr:
        if self.misfire not in ("none", "no gas", "compression"):
            raise EquationError(
                f"misfire = {self.misfire!r}: 'none', 'no gas' or 'compression' is needed."
            )
        if self.misfire == "no gas" or not self.pressure:
            return ConstantExpression(0.0)
        curve = self._curve(a)
        if self.misfire == "none":
            return curve
        closing = ConstantExpression(pi)
        stroke = self._volume(closing) / self._volume(a)
        squeezed = self._curve(closing) * stroke**self.n
        if self.strokes == 2:
            return squeezed
        return smooth(where(cos(a / 2) < 0, squeezed, curve))

    def _curve(self, a: Expr) -> Expr:
        angles, values = self._table()
        if self.shape == "smooth":
            return periodic_spline(a, angles, [*values[:-1], values[0]])
        if self.shape != "lines":
            raise EquationError(f"shape = {self.shape!r}: 'lines' or 'smooth' is needed.")
        return smooth(interpolate(a, angles, values, period=angles[-1] - angles[0]))

    def _volume(self, a: Expr) -> Expr:
        """Volume over the area of the piston, m."""
        tilt = self.r / self.L * sin(a)
        way = self.r * (1 - cos(a)) + self.L * (1 - sqrt(1 - tilt**2))
        return way + 2 * self.r / (self.compression - 1)

    def _table(self) -> tuple[list[float], list[float]]:
        """Angles and pressures over a cycle, with the value at its end."""
        if self.strokes not in (2, 4):
            raise EquationError(f"strokes = {self.strokes!r}: 2 or 4 is needed.")
        cycle = self.strokes * pi
        rows = _rows(
            "pressure", self.pressure, "crank angle (rad) and pressure (Pa)", "((0, 1e5), (6, 9e6))"
        )
        angles, values = [a for a, _ in rows], [v for _, v in rows]
        for before, after in itertools.pairwise(angles):
            if not after > before:
                raise EquationError(
                    f"pressure: the angles must increase, but {before:g} -> {after:g} rad."
                )
        length = angles[-1] - angles[0]
        if length > cycle * (1 + 1e-9):
            raise EquationError(
                f"pressure: the table covers {length:.6g} rad, more than the cycle of "
                f"{cycle:.6g} rad; give angles in rad, or strokes=4."
            )
        if length < cycle * (1 - 1e-9):
            angles, values = [*angles, angles[0] + cycle], [*values, values[0]]
        jump, span = abs(values[-1] - values[0]), max(values) - min(values)
        if jump > _CLOSES * span:
            raise EquationError(
                f"pressure: the table does not close: it ends with {values[-1]:g} Pa and begins "
                f"with {values[0]:g} Pa, {jump / span:.1%} of its range."
            )
        angles[-1] = angles[0] + cycle
        return angles, values


def _rows(
    name: str, rows: Sequence[Sequence[float]], what: str, example: str
) -> list[tuple[float, float]]:
    """Rows of two finite numbers."""
    infinite = float("inf")
    try:
        found = [(float(x), float(y)) for x, y in rows]
    except (TypeError, ValueError):
        found = []
    if not found or not all(abs(x) < infinite and abs(y) < infinite for x, y in found):
        raise EquationError(
            f"{name} = {shown(rows)}: rows of {what} are needed, finite numbers, such as {example}."
        )
    return found
