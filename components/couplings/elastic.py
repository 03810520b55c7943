"""Springs with a characteristic: torque over twist, or force over stretch."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import scipy

from lumped.components.rows import check_ascending, check_rows
from lumped.errors import EquationError
from lumped.language.expression import ConstantExpression, Expr, Number, as_expr
from lumped.language.value_types import Rows
from lumped.ops import interpolate, maximum

__all__ = ["ElasticLaw", "elastic_energy", "elastic_force"]

ElasticLaw = Rows | Callable[[Expr], Number]
"""Torque over twist, or force over stretch.

Rows of both, joined by straight lines, the first and last continued; rows that begin at zero hold
for both directions. Or a function of the twist, written with `lumped.ops`.
"""


def elastic_force(characteristic: ElasticLaw, stretch: Expr) -> Expr:
    """Torque at a twist, or force at a stretch.

    Parameters
    ----------
    characteristic : rows or function
        Torque, N.m, over twist, or force, N, over stretch.
    stretch : expression
        Twist, rad, or stretch, m.

    Returns
    -------
    Expr

    Raises
    ------
    EquationError
        If rows are missing, do not increase, hold no finite numbers, or begin at zero with a force.
    """
    if callable(characteristic):
        return as_expr(characteristic(stretch))
    places, forces = _columns(characteristic)
    return interpolate(stretch, places, forces)


def elastic_energy(characteristic: ElasticLaw, stretch: Expr) -> Expr:
    """Integral of the force from zero to a stretch, J; for a function by 20 Gauss points.

    Parameters
    ----------
    characteristic, stretch
        As for `elastic_force`.

    Returns
    -------
    Expr
    """
    if callable(characteristic):
        points, weights = scipy.special.roots_legendre(20)
        total: Expr = ConstantExpression(0.0)
        for point, weight in zip(points.tolist(), weights.tolist(), strict=True):
            at = stretch * ((point + 1) / 2)
            total = total + weight / 2 * as_expr(characteristic(at))
        return total * stretch
    places, forces = _columns(characteristic)
    slopes = [
        (forces[i + 1] - forces[i]) / (places[i + 1] - places[i]) for i in range(len(places) - 1)
    ]
    begin, first = places[0], slopes[0]
    energy = forces[0] * stretch + first / 2 * ((stretch - begin) ** 2 - begin**2)
    for place, (before, after) in zip(places[1:], itertools.pairwise(slopes), strict=False):
        beyond, at_zero = maximum(stretch - place, 0.0), max(-place, 0.0)
        energy = energy + (after - before) / 2 * (beyond**2 - at_zero**2)
    return energy


def _columns(rows: Rows) -> tuple[list[float], list[float]]:
    """Stretches and forces of rows that make sense, for both directions."""
    what, example = "twist and torque (stretch and force)", "((0, 0), (0.1, 50), (0.2, 150))"
    found = check_rows("characteristic", rows, what, f"{example}, or a function", least=2)
    check_ascending("characteristic", "twists", [x for x, _ in found])
    if found[0][0] == 0:
        if found[0][1] != 0:
            raise EquationError(
                f"characteristic begins at zero with {found[0][1]:g}. Rows that begin at zero hold "
                "for both directions, so the first is (0, 0); for a spring under preload give rows "
                "for both directions, or its length without force."
            )
        found = [(-x, -f) for x, f in reversed(found[1:])] + found
    places, forces = zip(*found, strict=True)
    return list(places), list(forces)
