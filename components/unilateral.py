"""Contacts that only press or only pull."""

from __future__ import annotations

from lumped.language.expression import Expr, Number, as_expr
from lumped.ops import where

__all__ = ["one_sided"]


def one_sided(elastic: Expr, damping: Expr, d: Number, what: str) -> Expr:
    """Force of a spring that can only press (or only pull), with a damper at most as strong.

    So the force begins and ends at zero, and never changes its sign.

    Parameters
    ----------
    elastic : expression
        Force of the spring, N or N.m, positive in contact.
    damping : expression
        Force of the damper, of the same sign while the contact gets closer.
    d : expression
        Coefficient of the damper; with zero there is nothing to limit.
    what : str
        What events call it.

    Returns
    -------
    Expr
        In the unit of `elastic`.
    """
    meets = (damping >= elastic).called(f"{what}: damping limited", f"{what}: damping in full")
    parts = (damping <= -elastic).called(f"{what}: no force left", f"{what}: force left")
    limited = where(meets, elastic, where(parts, -elastic, damping))
    return elastic + where(as_expr(d) > 0, limited, 0)
