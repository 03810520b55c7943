"""Torque converters and fluid couplings by their measured capacity.

Source: VDI 2153 (hydrodynamic power transmission: speed ratio, torque ratio, capacity), as the
manual of VECTO tells it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from lumped import Component, Equation, Expr, Flange, Var, der, var
from lumped.components.rows import check_ascending, check_rows
from lumped.errors import EquationError
from lumped.language.expression import Datum, Piecewise
from lumped.language.pieces import Pieces
from lumped.language.value_types import Rows
from lumped.ops import maximum, sign, smooth, where

__all__ = ["FluidCoupling", "TorqueConverter"]

_STILL = Datum(1e-15)
"""Speed in rad/s that avoids a division by zero."""

Form = tuple[float, float, float]
"""Torque over squares of speeds: factors of ``w_p^2``, ``w_p w_t`` and ``w_t^2``."""


class TorqueConverter(Component):
    """Hydrodynamic torque converter: ``tau_p = C(nu) w_p^2``, ``tau_t = mu(nu) tau_p``.

    The pump is at flange a, the turbine at flange b, and the support takes the torque of the
    stator, ``tau_t - tau_p``. Speeds count from the support; `tau_p` is what the pump takes up,
    `tau_t` what the turbine gives.

    `characteristic` are rows of speed ratio ``nu = w_t / w_p``, torque ratio mu and capacity C in
    N.m.s2/rad2, straight lines between them. One row is (1, 1, 0). Rows above 1 are those of
    overrun, where the turbine drives and C is negative; rows below 0 those of a turbine that turns
    backwards, and without them it keeps the torques of stall. Beyond the last row, up to a pump
    that stands still, the torques follow the square of the speed of the turbine. No row gives more
    power than it takes. Both directions are alike, and near standstill of both sides the torques
    and their slopes go to zero.

    For tables of the K factor ``w_p / sqrt(tau_p)`` the capacity is ``1 / K^2``, for a torque at a
    reference speed that torque over the square of the speed. A lock-up is a `Clutch` between the
    same shafts.
    """

    symbol = "converter"
    flange_a = Flange()
    flange_b = Flange()
    support = Flange(grounded=True)
    characteristic: Rows = ()
    w_p: Var = var("rad/s", "speed of the pump")
    w_t: Var = var("rad/s", "speed of the turbine")
    tau_p: Var = var("N.m", "torque that the pump takes up")
    tau_t: Var = var("N.m", "torque that the turbine gives")

    def equations(self) -> Iterator[Equation]:
        begins, pumps, turbines = _forms(_converter_rows(self.characteristic))
        yield self.w_p == der(self.flange_a.phi - self.support.phi)
        yield self.w_t == der(self.flange_b.phi - self.support.phi)
        way = where(self.w_p >= 0, 1.0, -1.0)
        p, t = way * self.w_p, way * self.w_t
        place = t / (p + abs(t) + _STILL)
        for torque, forms in ((self.tau_p, pumps), (self.tau_t, turbines)):
            pp, pt, tt = (_steps(place, begins, column) for column in zip(*forms, strict=True))
            yield torque == smooth(way * (pp * p**2 + pt * p * t + tt * t**2))
        yield self.flange_a.tau == self.tau_p
        yield self.flange_b.tau == -self.tau_t
        yield self.support.tau == self.tau_t - self.tau_p

    def loss(self) -> Expr:
        """Heat in the oil, W."""
        return self.tau_p * self.w_p - self.tau_t * self.w_t


class FluidCoupling(Component):
    """Fluid coupling: ``tau = C(s) w^2`` against the slip, w the faster of both speeds.

    ``s = |w_b - w_a| / w``. `characteristic` are rows of slip from (0, 0) on, and capacity C in
    N.m.s2/rad2; straight lines between them, the last capacity is kept. Slip 1 is stall, beyond it
    both sides turn against each other. Either side may drive, as pump and turbine are alike. Near
    standstill of both sides the torque and its slope go to zero. `tau` acts at flange b and,
    reversed, at flange a.
    """

    symbol = "converter"
    flange_a = Flange()
    flange_b = Flange()
    characteristic: Rows = ()
    w_a: Var = var("rad/s", "speed of flange a")
    w_b: Var = var("rad/s", "speed of flange b")
    tau: Var = var("N.m", "torque on flange b")

    def equations(self) -> Iterator[Equation]:
        rows = _coupling_rows(self.characteristic)
        lines = [
            (c - (after - c) / (more - s) * s, (after - c) / (more - s))
            for (s, c), (more, after) in itertools.pairwise(rows)
        ]
        begins, columns = [s for s, _ in rows], zip(*lines, (rows[-1][1], 0.0), strict=True)
        yield self.w_a == der(self.flange_a.phi)
        yield self.w_b == der(self.flange_b.phi)
        w, w_rel = maximum(abs(self.w_a), abs(self.w_b)), self.w_b - self.w_a
        level, slope = (_steps(abs(w_rel) / (w + _STILL), begins, column) for column in columns)
        yield self.tau == smooth(level * w**2 * sign(w_rel) + slope * w * w_rel)
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau

    def loss(self) -> Expr:
        """Heat in the oil, W."""
        return self.tau * (self.w_b - self.w_a)


def _steps(place: Expr, begins: Sequence[float], values: Sequence[float]) -> Expr:
    """A number for each piece of a line."""
    return Piecewise(place, Pieces(tuple(begins), tuple((value,) for value in values)))


def _forms(rows: Sequence[tuple[float, ...]]) -> tuple[list[float], list[Form], list[Form]]:
    """Begins of the pieces in ``nu / (1 + |nu|)``, and the torques of pump and turbine in each."""
    if rows[0][0] == 0:
        rows = [(-rows[-1][0], *rows[0][1:]), *rows]
    pumps: list[Form] = []
    turbines: list[Form] = []
    for (nu, mu, C), (after, more, D) in itertools.pairwise(rows):
        n, b = (more - mu) / (after - nu), (D - C) / (after - nu)
        m, a = mu - n * nu, C - b * nu
        pumps.append((a, b, 0.0))
        turbines.append((m * a, m * b + n * a, n * b))
    # by the speed of the pump over that of the turbine, from the last row to the first reversed
    (nu, mu, C), (last, more, D) = rows[0], rows[-1]
    for forms, first, end in ((pumps, C, D), (turbines, mu * C, more * D)):
        high, low = end / last**2, -first / nu**2
        slope = (high - low) / (1 / last - 1 / nu)
        level = high - slope / last
        forms.insert(0, (0.0, -slope, -level))
        forms.append((0.0, slope, level))
    return [-1.0, *(nu / (1 + abs(nu)) for nu, *_ in rows)], pumps, turbines


def _converter_rows(rows: Rows) -> list[tuple[float, ...]]:
    """Rows of a converter that gives no more power than it takes.

    Raises
    ------
    EquationError
        If rows are missing, or one has a sign or an efficiency that cannot be.
    """
    what = "speed ratio, torque ratio and capacity (N.m.s2/rad2)"
    example = "((0, 2, 0.02), (0.85, 1, 0.015), (1, 1, 0), (2, 1, -0.03))"
    found = check_rows("characteristic", rows, what, example, 3, 2)
    check_ascending("characteristic", "speed ratios", [nu for nu, *_ in found])
    if found[0][0] > 0:
        raise EquationError(
            f"characteristic begins at the speed ratio {found[0][0]:g}; give the row of stall, "
            "speed ratio 0."
        )
    if (1.0, 1.0, 0.0) not in found or found[-1][0] <= 1:
        raise EquationError(
            "characteristic: one row must be (1, 1, 0), no torque at equal speeds, and at least "
            "one must follow for overrun, speed ratio above 1 and capacity below 0."
        )
    for nu, mu, C in found:
        if mu < 0 or C * (1 - nu) < 0 or (nu != 1 and C == 0):
            raise EquationError(
                f"characteristic: torque ratio {mu:g} and capacity {C:g} N.m.s2/rad2 at the speed "
                f"ratio {nu:g}; the torque ratio is not negative, the capacity above 0 below the "
                "speed ratio 1 and below 0 above it."
            )
    for (nu, mu, _), (after, more, _) in itertools.pairwise(found):
        n = (more - mu) / (after - nu)
        top = (n * nu - mu) / (2 * n) if n else nu  # where mu nu is extreme
        for at in (nu, after, min(max(top, nu), after)):
            eta = (mu + n * (at - nu)) * at
            if (eta > 1 + 1e-12) if after <= 1 else (eta < 1 - 1e-12):
                raise EquationError(
                    f"characteristic: at the speed ratio {at:g} the torque ratio gives the "
                    f"efficiency {eta if after <= 1 else 1 / eta:g}; it must be at most 1."
                )
    return found


def _coupling_rows(rows: Rows) -> list[tuple[float, ...]]:
    """Rows of a coupling that brakes its slip.

    Raises
    ------
    EquationError
        If rows are missing, do not begin with (0, 0), or hold a negative capacity.
    """
    example = "((0, 0), (0.05, 0.01), (1, 0.03))"
    found = check_rows("characteristic", rows, "slip and capacity (N.m.s2/rad2)", example, least=2)
    check_ascending("characteristic", "slips", [slip for slip, _ in found])
    if found[0] != (0.0, 0.0):
        raise EquationError(
            f"characteristic begins at slip {found[0][0]:g} with {found[0][1]:g} N.m.s2/rad2; the "
            "first row must be (0, 0), no torque without slip."
        )
    for slip, C in found:
        if C < 0:
            raise EquationError(
                f"characteristic: the capacity {C:g} N.m.s2/rad2 at slip {slip:g} must not be "
                "negative; it counts against the slip by itself."
            )
    return found
