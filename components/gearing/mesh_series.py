"""Harmonics over the pitch of a gear mesh: those that are given, and those of curves."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from lumped import ops
from lumped.components.rows import check_rows
from lumped.errors import EquationError
from lumped.language.expression import Datum, Expr
from lumped.language.value_types import Rows

if TYPE_CHECKING:
    from lumped.numerics.harmonics import Harmonics

__all__ = ["mean_of_curve", "of_contact", "of_curve", "of_rows", "positive", "summed"]


def of_rows(name: str, rows: Rows) -> Harmonics:
    """Harmonics that are given, if any.

    Parameters
    ----------
    name : str
        What messages call them.
    rows : rows
        Harmonic, amplitude and phase, rad.

    Returns
    -------
    Harmonics
    """
    if not len(rows):
        return []
    what, example = "harmonic, amplitude and phase (rad)", "((1, 0.2, 0.0), (2, 0.1, 0.0))"
    found = [(k, amplitude, p) for k, amplitude, p in check_rows(name, rows, what, example, 3)]
    for k, _, _ in found:
        if k <= 0:
            raise EquationError(f"{name}: the harmonic {k:g} must be above 0, 1 at each tooth.")
    return found


def of_curve(name: str, rows: Rows, harmonics: int) -> Harmonics:
    """First harmonics of a curve of straight lines over one pitch, which repeats.

    Parameters
    ----------
    name : str
        What messages call it.
    rows : rows
        Position over the pitch and value; a position that stands twice is a jump.
    harmonics : int
        How many.

    Returns
    -------
    Harmonics
    """
    from lumped.numerics.harmonics import harmonics_of_lines

    return harmonics_of_lines(_closed(name, rows), harmonics)


def of_contact(ratio: float, overlap: float, harmonics: int) -> Harmonics:
    """First harmonics of the length of the lines of contact over its mean.

    Parameters
    ----------
    ratio, overlap, harmonics
        Of `lumped.life.mesh_stiffness.lines_of_contact`.

    Returns
    -------
    Harmonics
    """
    from lumped.life.mesh_stiffness import lines_of_contact

    for name, value, least in (("contact_ratio", ratio, 1), ("overlap_ratio", overlap, 0)):
        if not least <= value < float("inf"):
            raise EquationError(f"{name} = {value!r}: at least {least} is needed.")
    return lines_of_contact(ratio, overlap, harmonics)


def positive(rows: Harmonics) -> Harmonics:
    """Shares by which a stiffness varies, refused where they make it negative.

    Parameters
    ----------
    rows : Harmonics
        Relative to the mean.

    Returns
    -------
    Harmonics
    """
    from lumped.numerics.harmonics import lowest_of_harmonics

    low, at = lowest_of_harmonics(rows)
    if low <= -1:
        raise EquationError(
            f"the stiffness is not positive at x = {at:.3g} rad, {1 + low:.3g} of its mean; give "
            "smaller shares, or fewer harmonics."
        )
    return rows


def mean_of_curve(name: str, rows: Rows) -> float:
    """Mean of such a curve.

    Parameters
    ----------
    name, rows
        As for `of_curve`.

    Returns
    -------
    float
    """
    return sum((b - a) * (u + v) / 2 for (a, u), (b, v) in pairwise(_closed(name, rows)))


def summed(rows: Harmonics, x: Expr) -> tuple[Expr, Expr]:
    """Sum of harmonics of an angle, and its derivative by the angle.

    Parameters
    ----------
    rows : Harmonics
        What is summed.
    x : expression
        Angle of the mesh, rad.

    Returns
    -------
    (Expr, Expr)
    """
    total: Expr = Datum(0.0)
    slope: Expr = Datum(0.0)
    for k, amplitude, p in rows:
        total = total + Datum(amplitude) * ops.cos(k * x + p)
        slope = slope - k * Datum(amplitude) * ops.sin(k * x + p)
    return total, slope


def _closed(name: str, rows: Rows) -> list[tuple[float, float]]:
    """Points of a curve over exactly one pitch."""
    example = "((0, 4e8), (0.5, 4e8), (0.6, 2.5e8), (0.9, 2.5e8))"
    found = [
        (x, y) for x, y in check_rows(name, rows, "position over the pitch and value", example)
    ]
    if any(b < a for (a, _), (b, _) in pairwise(found)) or found[-1][0] > found[0][0] + 1:
        raise EquationError(
            f"{name}: positions must increase, over one pitch at most, such as {example}."
        )
    if found[-1][0] < found[0][0] + 1:
        found.append((found[0][0] + 1, found[0][1]))
    return found
