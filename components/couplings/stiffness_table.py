"""Torque over twist from what a catalogue states: stiffness over torque, or torque over twist."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import scipy

from lumped.components.rows import check_ascending, check_rows
from lumped.errors import EquationError, shown
from lumped.language.expression import ConstantExpression, Expr, Piecewise
from lumped.language.pieces import Pieces
from lumped.language.value_types import Rows
from lumped.ops import exp, interpolate, smooth

__all__ = ["Elasticity", "ends", "factor", "from_stiffness", "from_twist"]

_EVEN = 1e-8
"""Relative change of stiffness over a row below which it counts as constant."""
_FAR = 1e9
"""Beyond the last row of factors, over its place: where the line that continues it is given."""


class _Piece(NamedTuple):
    """``torque + linear s + growth (exp(rate s) - 1)`` from a twist on, s from another."""

    begin: float
    base: float
    torque: float
    linear: float
    growth: float
    rate: float
    energy: float


class Elasticity:
    """Torque over twist, equal in both directions.

    Parameters
    ----------
    pieces : list of _Piece
        Those of positive twists; the last one has no end.
    highest : float
        Largest torque of the rows, N.m.
    """

    def __init__(self, pieces: list[_Piece], highest: float) -> None:
        self.highest = highest
        ends = [piece.begin for piece in pieces[1:]] + [pieces[-1].begin + 1.0]
        every = [
            _Piece(-end, -p.base, -p.torque, p.linear, -p.growth, -p.rate, p.energy)
            for p, end in zip(reversed(pieces), reversed(ends), strict=True)
        ] + pieces
        new = [i == 0 or every[i][1:] != every[i - 1][1:] for i in range(len(every))]
        self._pieces = [piece for piece, is_new in zip(every, new, strict=True) if is_new]
        self._bends = any(piece.growth for piece in pieces)

    def torque(self, twist: Expr) -> Expr:
        """Torque, N.m."""
        s = twist - self._number("base", twist)
        found = self._number("torque", twist) + self._number("linear", twist) * s
        if not self._bends:
            return found
        return found + self._number("growth", twist) * (self._grow(s, twist) - 1)

    def slope(self, twist: Expr) -> Expr:
        """Stiffness, N.m/rad."""
        found = self._number("linear", twist)
        if not self._bends:
            return found
        s = twist - self._number("base", twist)
        bent = self._number("growth", twist) * self._number("rate", twist)
        return found + bent * self._grow(s, twist)

    def energy(self, twist: Expr) -> Expr:
        """Integral of the torque from no twist on, J."""
        s = twist - self._number("base", twist)
        found = self._number("energy", twist) + self._number("torque", twist) * s
        found = found + 0.5 * self._number("linear", twist) * s**2
        if not self._bends:
            return found
        more = (self._grow(s, twist) - 1) / self._number("rate", twist) - s
        return found + self._number("growth", twist) * more

    def _grow(self, s: Expr, twist: Expr) -> Expr:
        return exp(self._number("rate", twist) * s)

    def _number(self, name: str, twist: Expr) -> Expr:
        """A number of the piece at a twist."""
        values = [getattr(piece, name) for piece in self._pieces]
        if len(values) == 1:
            return ConstantExpression(values[0])
        begins = tuple(piece.begin for piece in self._pieces)
        return smooth(Piecewise(twist, Pieces(begins, tuple((value,) for value in values))))


def from_stiffness(rows: Rows) -> Elasticity:
    """The law whose slope is the stiffness that rows state over the torque.

    Where the stiffness is linear in the torque, ``d tau / d phi = c + m (tau - T)`` makes
    ``tau = T + c / m (exp(m (phi - phi_T)) - 1)``; beyond the last row it is constant.

    Parameters
    ----------
    rows : rows
        Torque, N.m, from zero on, and stiffness, N.m/rad.

    Raises
    ------
    EquationError
        If the torques do not begin at zero and increase, or a stiffness is not positive.
    """
    torques, values = _columns(
        "stiffness", rows, "torque (N.m)", "stiffness (N.m/rad)", "((0, 6e4), (3000, 2e5))"
    )
    _from_zero("stiffness", "torques", "N.m", torques)
    for torque, value in zip(torques, values, strict=True):
        if not value > 0:
            raise EquationError(
                f"stiffness: {value:g} N.m/rad at {torque:g} N.m must be above zero."
            )
    pieces: list[_Piece] = []
    twist = energy = 0.0
    for i, (T, c) in enumerate(zip(torques, values, strict=True)):
        if i + 1 == len(torques) or abs(values[i + 1] / c - 1) <= _EVEN:
            mean = c if i + 1 == len(torques) else 0.5 * (c + values[i + 1])
            if not pieces or pieces[-1].growth or pieces[-1].linear != mean:
                pieces.append(_Piece(twist, twist, T, mean, 0.0, 1.0, energy))
            if i + 1 < len(torques):
                width = (torques[i + 1] - T) / mean
                energy += 0.5 * (T + torques[i + 1]) * width
                twist += width
            continue
        m = (values[i + 1] - c) / (torques[i + 1] - T)
        width = float(scipy.special.log1p(values[i + 1] / c - 1)) / m
        pieces.append(_Piece(twist, twist, T, 0.0, c / m, m, energy))
        bent = (values[i + 1] / c - 1) / m - width
        energy += T * width + c / m * bent
        twist += width
    return Elasticity(pieces, torques[-1])


def from_twist(rows: Rows) -> Elasticity:
    """Straight lines through points of twist and torque.

    Parameters
    ----------
    rows : rows
        Twist, rad, from zero on, and torque, N.m.

    Raises
    ------
    EquationError
        If they do not begin with zeros, or either does not increase.
    """
    twists, torques = _columns(
        "twist", rows, "twist (rad)", "torque (N.m)", "((0, 0), (0.05, 2000), (0.1, 5000))"
    )
    _from_zero("twist", "twists", "rad", twists)
    _from_zero("twist", "torques", "N.m", torques)
    if len(twists) < 2:
        raise EquationError(f"twist = {shown(rows)}: at least two rows are needed.")
    pieces: list[_Piece] = []
    energy = 0.0
    for (x, T), (after, more) in itertools.pairwise(zip(twists, torques, strict=True)):
        pieces.append(_Piece(x, x, T, (more - T) / (after - x), 0.0, 1.0, energy))
        energy += 0.5 * (T + more) * (after - x)
    return Elasticity(pieces, torques[-1])


def factor(name: str, rows: Rows, at: Expr, what: str, *, both: bool = False) -> Expr:
    """Lines through rows of a place and a factor; the first and last factor are continued.

    Parameters
    ----------
    both : bool
        Rows begin at zero and hold for both directions.

    Raises
    ------
    EquationError
        If the places do not increase or begin as they must, or a factor is negative.
    """
    if not rows:
        return ConstantExpression(1.0)
    places, values = _columns(name, rows, what, "factor", "((0, 1.0), (1000, 0.9))")
    for place, value in zip(places, values, strict=True):
        if value < 0:
            raise EquationError(f"{name}: the factor {value:g} at {place:g} must not be negative.")
    far = _FAR * max(abs(places[0]), abs(places[-1]), 1.0)
    xs, ys = [*places, far], [*values, values[-1]]
    if both:
        _from_zero(name, "rows", "N.m", places)
        xs, ys = [-x for x in reversed(xs[1:])] + xs, [*reversed(ys[1:]), *ys]
    else:
        xs, ys = [-far, *xs], [values[0], *ys]
    return smooth(interpolate(at, xs, ys))


def ends(rows: Rows) -> tuple[float, float]:
    """First and last place of rows."""
    return float(rows[0][0]), float(rows[-1][0])


def _columns(
    name: str, rows: Rows, first: str, second: str, example: str
) -> tuple[list[float], list[float]]:
    """Columns of rows of two finite numbers, the first of which increases."""
    found = check_rows(name, rows, f"{first} and {second}", example)
    check_ascending(name, first, [x for x, _ in found])
    return [x for x, _ in found], [y for _, y in found]


def _from_zero(name: str, what: str, unit: str, values: list[float]) -> None:
    if values[0] != 0:
        raise EquationError(
            f"{name} begins at {values[0]:g} {unit}; its {what} must begin at zero, as the law "
            "holds for both directions."
        )
    check_ascending(name, what, values, unit)
