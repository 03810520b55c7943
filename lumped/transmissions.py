"""Transmission functions of gears whose ratio varies: through points, or with a wanted ratio.

`through` and `from_ratio` give the angle of one shaft as a function of that of another, for any
number of turns, as a component takes it:
``NonCircularGear(transmission=lp.transmissions.through(points))``. The function is a mean ratio
and a periodic spline (`lumped.ops.periodic_spline`), so it is smooth at the end of a turn too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from lumped.errors import OptionError
from lumped.language.expression import Expr, Number, as_expr, time
from lumped.language.lowering import lower
from lumped.ops import periodic_spline, pi
from lumped.support.arguments import checked

__all__ = ["from_ratio", "through"]

Transmission = Callable[[Expr], Number]


@dataclass(frozen=True)
class _Periodic:
    """Transmission ``mean x`` plus a correction that repeats with every turn of flange a."""

    mean: float
    angles: tuple[float, ...]
    corrections: tuple[float, ...]
    degree: int = 3

    def __call__(self, x: Expr) -> Expr:
        """Angle of flange b, rad."""
        return self.mean * x + periodic_spline(x, self.angles, self.corrections, degree=self.degree)


def through(points: Sequence[Sequence[float]]) -> Transmission:
    """Transmission function through points, continued turn after turn.

    A mean ratio and a correction that is a periodic cubic spline, so that ratio and acceleration
    have no jump, at the end of a turn neither. What b turns from the first row to the last is what
    it turns in each turn of a.

    Parameters
    ----------
    points : rows of float, shape (n, 2), n >= 4
        Angle of flange a, rad, increasing over one whole turn, and angle of flange b, rad.

    Returns
    -------
    callable
        Angle of flange b over that of flange a.

    Raises
    ------
    OptionError
        If the rows are no pairs of numbers, do not cover exactly one turn of flange a, or b would
        stand still or turn back somewhere.
    EquationError
        If there are fewer than four rows, or the angles of a do not increase.
    """
    try:
        a, b = (np.array(column, dtype=float) for column in zip(*points, strict=True))
    except (TypeError, ValueError):
        raise OptionError(
            "through(points): rows of two numbers are needed, angle of flange a and of b in rad."
        ) from None
    if abs(a[-1] - a[0] - 2 * pi) > 1e-9:
        raise OptionError(
            f"through(points): flange a goes from {a[0]:g} to {a[-1]:g} rad, which is "
            f"{(a[-1] - a[0]) / (2 * pi):.6g} turns; the rows must cover exactly one, with the "
            "angle of b at its end in the last row."
        )
    return _transmission("through(points)", a, b, 3)


@checked
def from_ratio(ratio: Transmission, *, turns: float = 1.0, pieces: int = 120) -> Transmission:
    """Transmission function with a wanted ratio: the integral of ``w_b / w_a``.

    The ratio is integrated over a turn by Gauss's rule with eight points in each piece, and the
    angle at the ends of the pieces joined by a periodic spline of degree 5, whose error falls with
    the sixth power of their length. Flange b stands at zero with a. What the integral misses of
    `turns`, up to one part in a million, is made up by a factor.

    Parameters
    ----------
    ratio : callable
        ``w_b / w_a`` over the angle of flange a in rad, period 2 pi, written with `lumped.ops`;
        negative throughout for external mesh.
    turns : float
        Turns of b in one turn of a, with the sign of the ratio. For closed pitch curves a ratio of
        small whole numbers.
    pieces : int
        Pieces of the spline, at least 6.

    Returns
    -------
    callable
        Angle of flange b over that of flange a.

    Raises
    ------
    OptionError
        If the ratio is not the same at both ends of the turn, its integral is not `turns` within
        1e-6, it changes its sign or is not finite, or there are too few pieces.
    """
    if pieces < 6:
        raise OptionError(f"from_ratio: pieces = {pieces}: at least 6 are needed.")
    angle = ca.SX.sym("angle")
    wanted = lower(as_expr(ratio(time)), _no_leaf, time=angle)
    begin, end = _values(wanted, angle, np.array([0.0, 2 * pi]))
    if abs(end - begin) > 1e-9 * abs(begin):
        raise OptionError(
            f"from_ratio: the ratio is {begin:g} at 0 and {end:g} at 2 pi rad of flange a; the "
            "pitch curve would not close."
        )
    nodes, weights = np.polynomial.legendre.leggauss(8)
    ends = np.linspace(0, 2 * pi, pieces + 1)
    places = (ends[:-1, None] + (pi / pieces) * (1 + nodes)).ravel()
    heights = _values(wanted, angle, places)
    _refuse_reversal("from_ratio", places, heights, turns)
    driven = np.cumsum([0.0, *(heights.reshape(pieces, -1) @ weights * (pi / pieces))])
    found = driven[-1] / (2 * pi)
    if abs(found - turns) > 1e-6 * abs(turns):
        raise OptionError(
            f"from_ratio: over one turn of flange a this ratio turns b by {found:.9g} turns, not "
            f"turns = {turns:g}; multiply the ratio by {turns / found:.9g}."
        )
    return _transmission("from_ratio", ends, driven * (turns / found), 5)


def _transmission(what: str, a: np.ndarray, b: np.ndarray, degree: int) -> Transmission:
    """Spline through angles of both flanges over a turn, checked between the points."""
    mean = float((b[-1] - b[0]) / (2 * pi))
    correction = (b - mean * a).tolist()
    correction[-1] = correction[0]
    found = _Periodic(mean, tuple(a.tolist()), tuple(correction), degree)
    fine = (a[:-1, None] + np.diff(a)[:, None] * np.linspace(0, 1, 9)[:-1]).ravel()
    angle = ca.SX.sym("angle")
    slope = ca.gradient(lower(found(time), _no_leaf, time=angle), angle)
    _refuse_reversal(what, fine, _values(slope, angle, fine), mean)
    return found


def _no_leaf(leaf: Expr) -> ca.SX:
    raise OptionError(f"from_ratio: '{leaf!r}' is no number; only the angle may vary.")


def _values(expression: ca.SX, angle: ca.SX, places: np.ndarray) -> np.ndarray:
    """Values at many angles, shape (n,)."""
    found = ca.Function("values", [angle], [expression])(ca.DM(places).T)
    return np.asarray(found).ravel()


def _refuse_reversal(what: str, places: np.ndarray, ratio: np.ndarray, turns: float) -> None:
    """Refuse a ratio that is not finite, zero, or of the other sign than the turns of b."""
    wrong = ~(np.isfinite(ratio) & (ratio * turns > 0))
    if wrong.any():
        i = int(np.argmax(wrong))
        raise OptionError(
            f"{what}: the ratio w_b / w_a is {ratio[i]:.3g} at {places[i]:.4g} rad of flange a, "
            f"but b makes {turns:g} turns in one of a; the ratio of two gears keeps the sign of "
            "these turns. It is negative throughout for external mesh."
        )
