"""Expressions of quantities as values that are compared, kept and sent like names."""

from __future__ import annotations

import re
from collections.abc import Callable, Hashable
from contextlib import suppress
from typing import Any, Self

from lumped.errors import UnknownNameError
from lumped.language.component import Component, path_of
from lumped.language.expression import (
    Call,
    Compare,
    ConstantExpression,
    Der,
    Expr,
    Partial,
    Piecewise,
    Ref,
    Time,
    Where,
    text,
    walk,
)
from lumped.language.quantity import Param, Quantity

_UNKNOWN = Quantity("1", "not looked up")


class Formula(str):
    """An expression of quantities of a model, by their names.

    It is the text of the expression, so it is given where the name of a quantity does. Formulas are
    equal if all their operations, numbers and names are.

    Parameters
    ----------
    nodes : tuple
        The expression, as `content_of_expression` gives it.
    """

    nodes: tuple[Any, ...]

    def __new__(cls, nodes: tuple[Any, ...]) -> Self:
        """The formula with this content."""
        named = _tree(nodes, lambda name: Ref(None, name, _UNKNOWN))
        found = super().__new__(cls, text(named))
        found.nodes = nodes
        return found

    @classmethod
    def of(cls, root: Expr) -> Self:
        """The formula of an expression.

        Raises
        ------
        UnknownNameError
            If no quantity of a model occurs in it.
        """
        found = list(walk(root))
        stray = [node for node in found if isinstance(node, Param)]
        if stray or not any(isinstance(node, Ref) for node in found):
            what = f"'{stray[0].name}' is of a class" if stray else "no quantity stands in it"
            raise UnknownNameError(
                f"{text(root)}: {what}. Write an expression of quantities of a model, such as "
                "rig.shaft.tau * rig.shaft.w."
            )
        return cls(content_of_expression(root, path_of))

    @classmethod
    def made(cls, make: Callable[..., Expr], *names: str) -> Self:
        """The formula that a function makes of quantities, which names or formulas give."""

        def named(name: str) -> Expr:
            return Ref(None, name, _UNKNOWN)

        parts = (
            name.expression(named) if isinstance(name, Formula) else named(name) for name in names
        )
        return cls(content_of_expression(make(*parts), lambda _: None))

    def expression(self, leaf: Callable[[str], Expr]) -> Expr:
        """The expression, with what a function gives for each name."""
        return _tree(self.nodes, leaf)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Formula) and self.nodes == other.nodes

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:
        return hash(self.nodes)

    def __repr__(self) -> str:
        return f"Formula({self.nodes!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.nodes,)


def content_of_expression(
    root: Expr, place: Callable[[Component], str | None]
) -> tuple[tuple[Any, ...], ...]:
    """All that an expression says, operands before the node.

    Parameters
    ----------
    root : Expr
        The expression.
    place : callable
        Path of a component.

    Returns
    -------
    tuple of (type, hashable, *int)
        Of each node its type, what it says by itself, and the places of its operands.
    """
    numbers: dict[int, int] = {}
    found: list[tuple[Any, ...]] = []
    for node in walk(root):
        what: Hashable = getattr(node, "name", None)
        if isinstance(node, ConstantExpression):
            what = repr(node.value)
        elif isinstance(node, Call):
            what = node.op
        elif isinstance(node, Piecewise):
            what = node.pieces
        elif isinstance(node, Where):
            what = node.condition.strict, node.condition.words
        elif isinstance(node, Ref):
            what = (place(node.owner), node.name, isinstance(node.quantity, Param))
        numbers[id(node)] = len(numbers)
        found.append((type(node), what, *(numbers[id(child)] for child in node.children())))
    return tuple(found)


def _tree(nodes: tuple[Any, ...], leaf: Callable[[str], Expr]) -> Expr:
    """The expression of such a content."""
    done: list[Expr] = []
    for kind, what, *places in nodes:
        parts = [done[place] for place in places]
        if kind is Ref:
            path, name, _ = what
            done.append(leaf(f"{path}.{name}" if path else name))
        elif issubclass(kind, ConstantExpression):
            done.append(kind(float(what)))
        elif kind is Call:
            done.append(Call(what, tuple(parts)))
        elif kind is Where:
            done.append(Where(Compare(parts[0], parts[1], *what), parts[2], parts[3]))
        elif kind is Piecewise:
            done.append(Piecewise(parts[0], what, tuple(parts[1:])))
        else:
            done.append(kind(*parts))
    return done[-1]


_SAME = ("+", "-", "min", "max", "neg", "abs")


def unit_of(root: Expr) -> str:
    """Unit of an expression, made of those of its quantities as they occur in it."""
    done: dict[int, str] = {}
    for node in walk(root):
        parts = [done[id(child)] for child in node.children()]
        done[id(node)] = unit_of_node(node, parts)
    return done[id(root)] or "1"


def unit_of_node(node: Expr, parts: list[str]) -> str:
    """Unit of a node from those of its operands; empty for a number."""
    if isinstance(node, Ref):
        return "" if node.quantity.unit == "1" else node.quantity.unit
    if isinstance(node, Time):
        return "s"
    if isinstance(node, Where | Piecewise):
        parts = parts[2:] if isinstance(node, Where) else parts[1:]
    elif isinstance(node, Der | Partial):
        return _over(parts[0], parts[1] if isinstance(node, Partial) else "s")
    elif isinstance(node, Call) and node.op == "*":
        return " ".join(part for part in parts if part)
    elif isinstance(node, Call) and node.op == "/":
        return _over(*parts)
    elif isinstance(node, Call) and node.op in ("**", "sqrt"):
        half = parts[0][: len(parts[0]) // 2]
        if node.op == "sqrt" and parts[0] == f"{half} {half}":
            return half
        power = text(node.args[1]) if node.op == "**" else "0.5"
        return _power(parts[0], power) if parts[0] else ""
    elif isinstance(node, Call) and node.op not in _SAME:
        return ""
    return next((part for part in parts if part), "")


def _power(unit: str, power: str) -> str:
    """Unit of a power; a root undoes the power that it is of, to the digits of the text."""
    inner = re.fullmatch(r"\((.*)\)\^([\d.]+)", unit)
    with suppress(ValueError):
        if inner and abs(float(inner[2]) * float(power) - 1) < 1e-5:
            return inner[1]
    return f"({unit})^{power}"


def _over(unit: str, by: str) -> str:
    if not by:
        return unit
    if unit == by:
        return ""
    if unit.endswith(f" {by}"):
        return unit[: -len(by) - 1]
    return f"{unit or '1'}/({by})" if " " in by or "/" in by else f"{unit or '1'}/{by}"
