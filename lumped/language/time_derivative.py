"""The time derivative of an expression."""

from __future__ import annotations

from lumped.errors import EquationError
from lumped.language.expression import Der, Expr, Ref, Time, walk


def der(of: Expr) -> Expr:
    """Time derivative of an expression.

    Parameters
    ----------
    of : expression
        Expression to differentiate.

    Returns
    -------
    Expr

    Raises
    ------
    EquationError
        If `of` is not an expression of the model.
    """
    if not isinstance(of, Expr):
        raise EquationError(f"der({of!r}): only quantities of the model have a time derivative.")
    kinds = {leaf.quantity.kind for leaf in walk(of) if isinstance(leaf, Ref)}
    if kinds == {"parameter"} and not any(isinstance(leaf, Time) for leaf in walk(of)):
        raise EquationError(f"der({of!r}): a parameter is constant; its derivative is zero.")
    return Der(of)
