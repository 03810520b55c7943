"""Lower expression trees to CasADi SX."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from lumped.derive import partials
from lumped.errors import EquationError
from lumped.expression import (
    Call,
    Compare,
    Constant,
    Der,
    Expr,
    Partial,
    Periodic,
    Time,
    Where,
    walk,
)

__all__ = ["lower"]

_UNARY = {
    "neg": lambda x: -x,
    "abs": ca.fabs,
    **{
        name: getattr(ca, name)
        for name in (
            "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh",
            "sqrt", "exp", "log", "sign",
        )
    },
}  # fmt: skip
_BINARY = {
    "+": lambda x, y: x + y,
    "-": lambda x, y: x - y,
    "*": lambda x, y: x * y,
    "/": lambda x, y: x / y,
    "**": lambda x, y: x**y,
    "min": ca.fmin,
    "max": ca.fmax,
    "atan2": ca.atan2,
}


def lower(
    root: Expr,
    leaf: Callable[[Expr], ca.SX],
    *,
    time: ca.SX | None = None,
    derivative: Callable[[ca.SX], ca.SX] | None = None,
    relation: Callable[[Compare, ca.SX, ca.SX], ca.SX] | None = None,
) -> ca.SX:
    """The CasADi form of an expression.

    Parameters
    ----------
    root : Expr
        What to lower.
    leaf : callable
        Symbol of a reference or parameter.
    time : SX, optional
        Symbol of the time; without it the expression must not depend on the time.
    derivative : callable, optional
        Time derivative of an SX expression; without it ``der`` is refused.
    relation : callable, optional
        Mode (0 or 1) of a relation, from its lowered sides; without it ``where`` is refused.

    Raises
    ------
    EquationError
        If the expression holds something that has no meaning at this place.
    """
    done: dict[int, ca.SX] = {}

    def refuse(what: str) -> EquationError:
        return EquationError(f"'{root!r}' binds a parameter or start value and cannot hold {what}.")

    for node in walk(root):
        args = [done[id(child)] for child in node.children()]
        if isinstance(node, Constant):
            value = ca.SX(node.value)
        elif isinstance(node, Call):
            table = _UNARY if len(args) == 1 else _BINARY
            value = table[node.op](*args)
        elif isinstance(node, Time):
            if time is None:
                raise refuse("the time")
            value = time
        elif isinstance(node, Der):
            if derivative is None:
                raise refuse("a time derivative")
            value = derivative(args[0])
        elif isinstance(node, Periodic):
            value = _periodic(node, args[0])
        elif isinstance(node, Partial):
            value = partials(args[0], args[1])
        elif isinstance(node, Where):
            if relation is None:
                raise refuse("a condition")
            value = ca.if_else(relation(node.condition, args[0], args[1]), args[2], args[3])
        else:
            value = leaf(node)
        done[id(node)] = value
    return done[id(root)]


def _periodic(node: Periodic, x: ca.SX) -> ca.SX:
    """Piece by piece: of the coefficients, those of the piece that holds are selected.

    The selection is exact, has no derivative, and is shared by all derivatives.
    """
    knots, rows = ca.DM(node.knots), ca.DM(node.rows)
    begin = node.knots[0]
    place = x - node.period * ca.floor((x - begin) / node.period)
    beyond = ca.vertcat(1, place >= knots[1:], 0)
    selected = ca.mtimes((beyond[:-1] - beyond[1:]).T, ca.horzcat(knots, rows))
    run, value = place - selected[0], selected[1]
    for i in range(2, selected.numel()):
        value = value * run + selected[i]
    return value
