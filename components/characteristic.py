"""Friction over sliding speed, and the constraint that sticks and slides with it."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from casadi import SX

from lumped.errors import EquationError
from lumped.language.expression import (
    Call,
    Compare,
    ConstantExpression,
    Datum,
    Expr,
    Number,
    as_expr,
    walk,
)
from lumped.language.lowering import has_range, lower
from lumped.language.switch import Hold, hold
from lumped.language.value_types import Rows
from lumped.ops import exp, interpolate, maximum, sign, smooth

__all__ = [
    "Characteristic",
    "PowerLaw",
    "Stribeck",
    "coulomb",
    "drag_at",
    "dry_friction",
    "friction_at",
    "refuse_zero",
]

Characteristic = Rows | Sequence[Sequence[Number]] | Callable[[Expr], Number]
"""Friction at a sliding speed that is not negative.

Rows of speed and friction, joined by straight lines and continued by the last one, but not below
zero; or a function of the speed, written with `lumped.ops`. The frictions, and numbers in a
function, may be parameters of the enclosing component.
"""


@dataclass(frozen=True)
class Stribeck:
    """Stribeck curve: ``coulomb + (static - coulomb) exp(-decay v) + viscous v``.

    Coulomb friction that is higher near standstill, and viscous friction (Armstrong-Helouvry,
    Dupont, Canudas de Wit, Automatica 30 (1994) 1083). At standstill it equals `static`, which is
    also the greatest static friction if `peak` is 1.

    Parameters
    ----------
    coulomb, static : float or expression
        Kinetic friction without the other terms, and friction at standstill; N.m, N, or 1 for a
        friction coefficient.
    decay : float or expression
        Decay of their difference with the speed, s/rad or s/m.
    viscous : float or expression
        Rise with the speed, in the unit of `coulomb` times s/rad or s/m.
    """

    coulomb: Number
    static: Number
    decay: Number
    viscous: Number = 0.0

    def __call__(self, speed: Number) -> Expr:
        """Friction at a speed that is not negative.

        Raises
        ------
        EquationError
            If a number is out of its range.
        """
        ranges: tuple[tuple[str, Number], ...] = (
            ("coulomb", 0.0),
            ("static", self.coulomb),
            ("decay", 0.0),
            ("viscous", 0.0),
        )
        for name, least in ranges:
            value = getattr(self, name)
            if isinstance(value, Expr) or isinstance(least, Expr):
                continue
            if not least <= value < float("inf"):
                bound = "coulomb" if name == "static" else "0"
                raise EquationError(
                    f"{self}: {name} = {value:g} must be at least {bound} and finite."
                )
        coulomb, static, decay, viscous = (
            value if isinstance(value, Expr) else Datum(float(value))
            for value in (self.coulomb, self.static, self.decay, self.viscous)
        )
        v = as_expr(speed)
        return coulomb + (static - coulomb) * exp(-decay * v) + viscous * v


@dataclass(frozen=True)
class PowerLaw:
    """Drag by a power of the speed: ``nominal (v / v_nominal)^n``, linear below `v_low`.

    Parameters
    ----------
    nominal : float or expression
        Drag at `v_nominal`, N.m or N.
    v_nominal : float or expression
        Speed of the nominal drag, rad/s or m/s.
    n : float or expression
        Exponent.
    v_low : float or expression
        Speed below which the drag is proportional to the speed, as the slope of a power below 1
        has no bound at standstill.
    """

    nominal: Number
    v_nominal: Number
    n: Number
    v_low: Number

    def __call__(self, speed: Number) -> Expr:
        """Drag at a speed that is not negative.

        Raises
        ------
        EquationError
            If a number is out of its range.
        """
        for name in ("nominal", "v_nominal", "n", "v_low"):
            value = getattr(self, name)
            if not isinstance(value, Expr) and not 0 < value < float("inf"):
                raise EquationError(f"{self}: {name} = {value:g} must be above 0 and finite.")
        nominal, v_nominal, n, v_low = (
            value if isinstance(value, Expr) else Datum(float(value))
            for value in (self.nominal, self.v_nominal, self.n, self.v_low)
        )
        v = as_expr(speed)
        return nominal * v / v_nominal * (maximum(v, v_low) / v_nominal) ** (n - 1)


def friction_at(characteristic: Characteristic, speed: Number) -> Expr:
    """Friction at a sliding speed that is not negative.

    Parameters
    ----------
    characteristic : rows or function
        Friction over speed.
    speed : expression
        Sliding speed, rad/s or m/s.

    Returns
    -------
    Expr
        In the unit of the characteristic.

    Raises
    ------
    EquationError
        If rows are missing, do not begin at standstill, do not increase in speed or hold a
        negative friction.
    """
    if callable(characteristic):
        found = as_expr(characteristic(as_expr(speed)))
        if any(has_range(node) for node in walk(found)):  # a step may end beyond standstill
            found = as_expr(characteristic(smooth(abs(as_expr(speed)))))
        _refuse_negative(as_expr(characteristic(as_expr(0.0))))
        return found
    speeds, values = _columns(characteristic)
    found = interpolate(speed, speeds, values)
    numbers = [value for value in values[-2:] if isinstance(value, float)]
    falling = len(values) > 1 and (len(numbers) < 2 or numbers[1] < numbers[0])
    return maximum(found, 0.0) if falling else found


def drag_at(characteristic: Characteristic, speed: Expr) -> Expr:
    """Drag against a speed in both directions, which vanishes at standstill.

    Parameters
    ----------
    characteristic : rows or function
        Drag over speed, as for `friction_at`.
    speed : expression
        Speed, rad/s or m/s, or slip.

    Raises
    ------
    EquationError
        If the characteristic is none, or begins with a friction.
    """
    if callable(characteristic):
        standstill: Number | None = _number(friction_at(characteristic, 0.0))
    else:
        standstill = _columns(characteristic)[1][0]
    if isinstance(standstill, float) and standstill:
        raise EquationError(
            f"characteristic begins at standstill with {standstill:g}; it must begin with 0. For "
            "parts that stick use a friction element such as Clutch."
        )
    return smooth(sign(speed)) * friction_at(characteristic, smooth(abs(speed)))


def refuse_zero(characteristic: Characteristic) -> None:
    """Refuse a friction that vanishes, at standstill or in a row.

    Raises
    ------
    EquationError
        If it does.
    """
    values: list[Number | None]
    if callable(characteristic):
        values = [_number(friction_at(characteristic, 0.0))]
    else:
        values = [*_columns(characteristic)[1]]
    if 0.0 in [value for value in values if isinstance(value, float)]:
        raise EquationError(
            "characteristic: the friction must be above 0 at standstill and in every row, since "
            "the bend of the bristles is divided by it."
        )


def _number(found: Expr) -> float | None:
    """Value of an expression that depends on nothing."""
    if not all(isinstance(node, ConstantExpression | Call) for node in walk(found)):
        return None  # it depends on parameters or conditions
    return float(lower(found, lambda leaf: SX.nan()))


def _refuse_negative(standstill: Expr) -> None:
    """Refuse a friction at standstill that is a negative number."""
    value = _number(standstill)
    if value is not None and not 0 <= value < float("inf"):
        raise EquationError(
            f"characteristic: friction {value:g} at standstill must be a finite number that is not "
            "negative; it counts against the motion by itself."
        )


def _columns(rows: Rows | Sequence[Sequence[Number]]) -> tuple[list[float], list[Number]]:
    """Speeds and frictions of rows that make sense."""
    hint = "Give rows of sliding speed and friction such as ((0, 12), (50, 9)), or a function."
    try:
        pairs = [(v, f if isinstance(f, Expr) else float(f)) for v, f in rows]
        if any(isinstance(v, Expr) for v, _ in pairs):
            raise EquationError(
                f"characteristic = {rows!r}: the sliding speeds must be numbers; only the "
                "frictions may be parameters."
            )
        speeds, values = zip(*((float(v), f) for v, f in pairs), strict=True)
    except (TypeError, ValueError):
        raise EquationError(
            f"characteristic = {rows!r} has no rows of two numbers. {hint}"
        ) from None
    if speeds[0] != 0:
        raise EquationError(
            f"characteristic begins at the sliding speed {speeds[0]:g}; its first row must be that "
            "of standstill, speed 0. It counts for both directions."
        )
    for before, after in itertools.pairwise(speeds):
        if not before < after < float("inf"):
            raise EquationError(
                f"characteristic: the sliding speeds must increase, but {before:g} -> {after:g}."
            )
    for v, f in zip(speeds, values, strict=True):
        if not isinstance(f, Expr) and not 0 <= f < float("inf"):
            raise EquationError(
                f"characteristic: friction {f:g} at the sliding speed {v:g} must be a finite "
                "number that is not negative; it counts against the motion by itself."
            )
    return list(speeds), list(values)


def dry_friction(
    reaction: Expr,
    speed: Expr,
    characteristic: Characteristic,
    *,
    peak: Expr,
    position: Expr,
    grip: Number = 1.0,
    engaged: Compare | None = None,
) -> Hold:
    """Friction against a sliding speed, equal in both directions.

    Sliding: ``reaction = grip F(speed)`` against the motion; at standstill up to
    ``peak grip F(0)``.

    Parameters
    ----------
    reaction, speed, mode : quantity
        See `lumped.hold`.
    characteristic : rows or function
        F, friction over speed.
    peak : expression
        Greatest static over kinetic friction at standstill.
    grip : expression
        Factor of the friction, such as a normal force.
    engaged : relation, optional
        While this is false there is no friction.

    Returns
    -------
    Hold
    """
    most = peak * grip * friction_at(characteristic, 0.0)
    return hold(
        reaction,
        speed,
        forward=grip * friction_at(characteristic, speed),
        backward=-grip * friction_at(characteristic, -speed),
        upper=most,
        lower=-most,
        engaged=engaged,
        position=position,
    )


def coulomb(
    reaction: Expr,
    speed: Expr,
    sliding: Expr,
    holding: Expr,
    *,
    position: Expr,
    engaged: Compare | None = None,
) -> Hold:
    """Friction of one amount at all speeds, equal in both directions.

    Parameters
    ----------
    reaction, speed, mode : quantity
        See `lumped.hold`.
    sliding, holding : expression
        Amount of the reaction while it slides, and the greatest while it sticks.
    engaged : relation, optional
        While this is false there is no friction.

    Returns
    -------
    Hold
    """
    return hold(
        reaction,
        speed,
        forward=sliding,
        backward=-sliding,
        upper=holding,
        lower=-holding,
        engaged=engaged,
        position=position,
    )
