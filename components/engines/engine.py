"""Cylinders of reciprocating engines and compressors.

Source: Dresig and Holzweissig, Dynamics of Machinery, ch. 2.4 (reduced inertia of a crank drive);
Nestorides, A Handbook on Torsional Vibration (1958), ch. 5 (harmonic components of cylinders).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any, Literal

from lumped import Component, Equation, Expr, Flange, Param, Var, der, param, var
from lumped.components.rows import check_ascending, check_rows
from lumped.errors import EquationError, shown
from lumped.language.expression import ConstantExpression, Datum
from lumped.language.value_types import Numbers, Rows
from lumped.ops import cos, interpolate, periodic_spline, pi, sin, smooth, sqrt, where

__all__ = ["Cylinder", "Misfire"]

Misfire = Literal["none", "no gas", "compression"]

_STEPS = 32
"""Angles of a turn at which a mean is taken."""
_HARMONICS = "order and amplitudes of cosine and sine"
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
    over a cycle; they are multiplied by `load`. With `loads`, `pressure` holds such a table for
    each of these loads, and p lies between those of the loads beside `load`; the first and the
    last also count beyond. ``"lines"`` joins rows by straight lines, ``"smooth"`` by a periodic
    cubic spline; a run does not stop at their kinks. The ends of a table may differ by 1 % of its
    range, which is then a jump. `over_speed` are rows of the speed, rad/s, and a further factor of
    the pressure, joined by straight lines.

    Instead, `tangential` are harmonics of the pressure reduced to the crank pin, rows of order and
    the amplitudes of cosine and sine, Pa: ``tau_gas = load pi D^2 / 4 r sum(A cos(k a) + B
    sin(k a))``. Order 0 is the mean. `p` is then zero.

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
    pressure: Rows | Sequence[Any] = ()
    loads: Numbers = ()
    over_speed: Rows = ()
    tangential: Rows = ()
    strokes: Literal[2, 4] = 4
    shape: Literal["lines", "smooth"] = "lines"
    masses: Literal["exact", "excitation", "series"] = "exact"
    series: Rows = ()
    misfire: Misfire = "none"
    bore: Param = param("m", "diameter of the piston", above=0)
    r: Param = param("m", "crank radius, half of the stroke", above=0)
    L: Param = param("m", "length of the rod", above=r)
    m: Param = param("kg", "mass that moves with the piston", 0.0, min=0)
    phase: Param = param("rad", "angle of the flange at which a cycle begins", 0.0)
    load: Param = param("1", "load, or factor of the pressure", 1.0, min=0)
    compression: Param = param("1", "compression ratio", 17.0, above=1)
    n: Param = param("1", "exponent of compression without firing", 1.33, above=0)
    a: Var = var("rad", "crank angle after top dead centre", state="avoid")
    w: Var = var("rad/s", "angular velocity", state="avoid")
    p: Var = var("Pa", "pressure above that of the crankcase", nominal=1e5)
    tau_gas: Var = var("N.m", "driving torque of the gas")
    tau_mass: Var = var("N.m", "driving torque of the masses")
    tau: Var = var("N.m", "driving torque")

    def equations(self) -> Iterator[Equation]:
        a, w = self.flange.phi - self.phase, der(self.flange.phi)
        lever, slope = self._lever(a)
        yield self.a == a
        yield self.w == w
        gas = self._pressure(a, w)
        yield self.p == gas
        if self.tangential:
            yield self.tau_gas == self._area() * self.r * self._tangential(a, w)
        else:
            yield self.tau_gas == gas * self._area() * lever
        if self.masses == "exact":
            yield self.tau_mass == -self.m * lever * (lever * der(w) + slope * w**2)
        elif self.masses == "excitation":
            yield self.tau_mass == -self.m * (lever * slope * w**2 + self._mean_square() * der(w))
        elif self.masses == "series":
            yield self.tau_mass == -self.m * self.r * w**2 * self._series(a) * lever
        else:
            raise EquationError(
                f"masses = {self.masses!r}: 'exact', 'excitation' or 'series' is needed."
            )
        yield self.tau == self.tau_gas + self.tau_mass
        yield self.flange.tau == -self.tau

    def stored(self) -> Expr:
        """Kinetic energy of the masses, J."""
        if self.masses == "exact":
            return 0.5 * self.m * (self._lever(self.a)[0] * self.w) ** 2
        if self.masses == "excitation":
            return 0.5 * self.m * self._mean_square() * self.w**2
        return ConstantExpression(0.0)

    def loss(self) -> Expr:
        """Power that gas and excitation by masses take, W; negative while they drive."""
        if self.masses == "exact":
            return -self.tau_gas * self.w
        if self.masses == "series":
            return -self.tau * self.w
        lever, slope = self._lever(self.a)
        return (self.m * lever * slope * self.w**2 - self.tau_gas) * self.w

    def _area(self) -> Expr:
        return pi * self.bore**2 / 4

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
        rows = check_rows("series", self.series, "order and coefficient", "((1, 1.0), (2, 0.25))")
        total: Expr = ConstantExpression(0.0)
        for order, coefficient in rows:
            total = total + coefficient * cos(order * a)
        return total

    def _tangential(self, a: Expr, w: Expr) -> Expr:
        """Gas force reduced to the crank pin, over the area of the piston."""
        if self.pressure:
            raise EquationError("pressure and tangential: give one of them.")
        if self.misfire == "compression":
            raise EquationError(
                "misfire = 'compression' needs the pressure over the crank angle, pressure=."
            )
        if self.misfire == "no gas":
            return ConstantExpression(0.0)
        total: Expr = ConstantExpression(0.0)
        rows = check_rows(
            "tangential", self.tangential, _HARMONICS, "((0, 4e5, 0), (0.5, 1e5, 2e5))", 3
        )
        for order, cosine, sine in rows:
            total = total + Datum(cosine) * cos(order * a) + Datum(sine) * sin(order * a)
        return self._factor(w) * total

    def _pressure(self, a: Expr, w: Expr) -> Expr:
        if self.misfire not in ("none", "no gas", "compression"):
            raise EquationError(
                f"misfire = {self.misfire!r}: 'none', 'no gas' or 'compression' is needed."
            )
        if self.misfire == "no gas" or not self.pressure:
            return ConstantExpression(0.0)
        return self._factor(w) * self._over_angle(a)

    def _factor(self, w: Expr) -> Expr:
        """Factor of what the gas does."""
        factor: Expr = ConstantExpression(1.0) if self.loads else self.load
        if not self.over_speed:
            return factor
        rows = check_rows(
            "over_speed", self.over_speed, "speed and factor", "((50, 0.8), (200, 1.0))"
        )
        speeds, factors = zip(*rows, strict=True)
        return factor * smooth(interpolate(w, speeds, factors))

    def _over_angle(self, a: Expr) -> Expr:
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
        """Pressure of the load over the crank angle."""
        if not self.loads:
            return self._interpolate(a, self.pressure)
        loads = [
            x for (x,) in check_rows("loads", [(x,) for x in self.loads], "loads", "(0.5, 1)", 1)
        ]
        if len(loads) != len(self.pressure):
            raise EquationError(
                f"loads = {shown(self.loads)}: {len(loads)} loads and {len(self.pressure)} tables "
                "in pressure; one table for each load is needed."
            )
        total: Expr = ConstantExpression(0.0)
        # beyond the first and the last load the shares stay
        places = [loads[0] - 1, *loads, loads[-1] + 1]
        for i, table in enumerate(self.pressure):
            own = [float(k == i) for k in range(len(loads))]
            share = interpolate(self.load, places, [own[0], *own, own[-1]])
            total = total + smooth(share) * self._interpolate(a, table)
        return total

    def _interpolate(self, a: Expr, table: Rows) -> Expr:
        """The curve through the rows of a table."""
        angles, values = self._table(table)
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

    def _table(self, table: Rows) -> tuple[list[float], list[float]]:
        """Angles and pressures over a cycle, with the value at its end."""
        if self.strokes not in (2, 4):
            raise EquationError(f"strokes = {self.strokes!r}: 2 or 4 is needed.")
        cycle = self.strokes * pi
        rows = check_rows(
            "pressure", table, "crank angle (rad) and pressure (Pa)", "((0, 1e5), (6, 9e6))"
        )
        angles, values = [a for a, _ in rows], [v for _, v in rows]
        check_ascending("pressure", "angles", angles, "rad")
        length = angles[-1] - angles[0]
        if length > cycle * (1 + 1e-9):
            raise EquationError(
                f"pressure: the table covers {length:.6g} rad, more than the cycle of "
                f"{cycle:.6g} rad; give angles in rad, or strokes=4."
            )
        if length < cycle * (1 - 1e-9):
            largest = max((b - a for a, b in itertools.pairwise(angles)), default=0.0)
            if cycle - length > largest * (1 + 1e-6):
                raise EquationError(
                    f"pressure: the table ends at {angles[-1]:.6g} rad, before the end of the "
                    f"cycle at {angles[0] + cycle:.6g} rad by more than its largest step; give "
                    "rows up to there, the last with the pressure of the first."
                )
            angles, values = [*angles, angles[0] + cycle], [*values, values[0]]
        jump, span = abs(values[-1] - values[0]), max(values) - min(values)
        if jump > _CLOSES * span:
            raise EquationError(
                f"pressure: the table does not close: it ends with {values[-1]:g} Pa and begins "
                f"with {values[0]:g} Pa, {jump / span:.1%} of its range."
            )
        angles[-1] = angles[0] + cycle
        return angles, values
