"""Contacts that only press or only pull, and play between two of them."""

from __future__ import annotations

from lumped.language.expression import Expr, Number, as_expr
from lumped.ops import where

__all__ = ["across_play", "force_across_play", "one_sided"]


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


def across_play(
    x: Expr, b: Expr, flanks: tuple[Number, Number], without: Expr, names: tuple[str, str, str]
) -> Expr:
    """What acts across a play, nothing within ``|x| <= b / 2``.

    Parameters
    ----------
    x, b : expression
        Place, from the middle of the play, and the whole play.
    flanks : (expression, expression)
        Beyond the upper and the lower end.
    without : expression
        Where the play is below 1e-10, which is none.
    names : (str, str, str)
        Of the upper and the lower flank and of the state between, as events tell them.

    Returns
    -------
    Expr
    """
    upper, lower, between = names
    on_upper = (x > b / 2).called(upper, between)
    on_lower = (x < -b / 2).called(lower, between)
    return where(b >= 1e-10, where(on_upper, flanks[0], where(on_lower, flanks[1], 0)), without)


def force_across_play(
    x: Expr,
    b: Expr,
    c: Number,
    damping: Expr,
    d: Number,
    names: tuple[str, str, str],
    *,
    limited: bool,
) -> Expr:
    """Force of two flanks with springs and dampers, which push and never pull.

    Parameters
    ----------
    x, b, names
        As for `across_play`; without play the flanks are a spring and damper that also pulls.
    c : expression
        Stiffness of a flank.
    damping, d : expression
        Force of the damper and its coefficient.
    limited : bool
        Whether the damper is at most as strong as the spring; else the force jumps where a flank
        is met.

    Returns
    -------
    Expr
        Positive on the upper flank.
    """

    def push(elastic: Expr, damping: Expr, flank: str) -> Expr:
        if limited:
            return one_sided(elastic, damping, d, flank)
        # in contact, this changes only when the push ends
        pushes = (elastic + damping > 0).called(f"{flank} pushes", f"{flank} has let go")
        return where(pushes, elastic + damping, 0)

    upper = push(c * (x - b / 2), damping, names[0])
    lower = -push(-c * (x + b / 2), -damping, names[1])
    return across_play(x, b, (upper, lower), c * x + damping, names)
