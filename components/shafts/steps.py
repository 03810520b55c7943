"""Length that a sudden step of diameter adds to the thinner part of a shaft.

The twist of the thinner part goes on for a while into the thicker one, as if the step stood further
inside it: the thinner part is longer, the thicker one shorter, both by the same length. It is given
as a share of the smaller diameter, for a sharp corner, solid parts, and no other step within three
diameters.
"""

from __future__ import annotations

from collections.abc import Callable

from lumped.language.expression import Expr
from lumped.ops import interpolate, log, maximum, minimum, sign

__all__ = ["RULES", "lengthen"]


def _compute_share(small: Expr, large: Expr) -> Expr:
    """``u (0.106436 - 0.151035 ln u + 0.217521 u - 0.248238 u^2 + 0.0824799 u^3)``, u = 1 - d/D.

    Fitted to finite-volume solutions of ``div(r^3 grad psi) = 0`` at nine ratios D/d from 1.05 to
    6, whose own error is below 4e-4 of d; the largest deviation is 1.6e-4 of the length. For a
    shaft in a half space it gives 0.158 d, between the bounds 0.147 (rigid disc) and 0.170 (linear
    stress).
    """
    u = 1 - small / large
    bend = 0.2175208 + u * (-0.24823753 + u * 0.08247986)
    return u * (0.10643566 - 0.15103485 * log(u + 1e-30) + u * bend)  # u log(u) is 0 at 0


def _read_textbook(small: Expr, large: Expr) -> Expr:
    """Rows D/d = 1, 1.25, 1.5, 2, 3, infinity: 0, 0.055, 0.085, 0.1, 0.107, 0.125, joined by lines.

    Beyond 3 the line is over d/D. The table is often printed in the trade, but no source of it
    could be read, so it is from memory. Up to 30 % shorter than computed.
    """
    inside = interpolate(minimum(large / small, 3.0), (1, 1.25, 1.5, 2, 3), _ROWS)
    return inside + 0.018 * maximum(1 - 3 * small / large, 0.0)


_ROWS = (0.0, 0.055, 0.085, 0.100, 0.107)

RULES: dict[str, Callable[[Expr, Expr], Expr | float]] = {
    "computed": _compute_share,
    "textbook": _read_textbook,
    "none": lambda small, large: 0.0,
}
"""Rules by name: share of the smaller diameter, from the smaller and the larger one."""


def lengthen(rule: str, own: Expr, other: Expr) -> Expr:
    """Length by which a part is longer than drawn at a step, m; negative for the thicker part.

    Parameters
    ----------
    rule : str
        One of `RULES`.
    own, other : expression
        Outside diameters at the step, m.

    Returns
    -------
    Expr
    """
    small, large = minimum(own, other), maximum(own, other)
    return sign(other - own) * small * RULES[rule](small, large)
