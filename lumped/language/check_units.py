"""Check that equations add and compare only quantities of the same kind."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from lumped.errors import UnitError, told_by
from lumped.language.component import Component
from lumped.language.connection import label
from lumped.language.expression import (
    Call,
    Compare,
    ConstantExpression,
    Datum,
    Der,
    Equation,
    Expr,
    Partial,
    Piecewise,
    Ref,
    Smooth,
    Time,
    Where,
    text,
    walk,
)
from lumped.language.quantity import Param
from lumped.language.switch import Hold, Item, When
from lumped.support.arguments import checked
from lumped.support.units import Dimension, dimension, format_dimension

_NUMBER: Dimension = {}
_SAME = {"+", "-", "min", "max"}
_ALIKE = {*_SAME, "atan2"}


class _ClashError(Exception):
    """Two sides of different kinds, or a function argument that must be a number and is none."""


@checked
def check_units(model: Component) -> int:
    """Check the dimensions of all equations of a model and its parts.

    Angles count as numbers, so that ``v == w r`` holds; zero and the entries of tables fit
    everywhere. A number added to a quantity, compared with it or equal to it is in its unit;
    factors and arguments of functions are numbers. Signals that are joined must be of the same
    kind, unless one is a plain number.

    Parameters
    ----------
    model : Component
        Any component with its parts.

    Returns
    -------
    int
        How many equations, conditions and limits were checked.

    Raises
    ------
    UnitError
        With path, equation and both units of each fault. Needs pint (``lumped[units]``).
    """
    faults: list[str] = []
    count = 0
    for path, part in _parts(model, type(model).__name__):
        with told_by(path, "equations()"):
            pairs = list(_pairs(part))
        for left, right, shown in pairs:
            count += 1
            try:
                _dimension(Call("-", (left, right)))
            except _ClashError as clash:
                faults.append(f"{path}: {shown}: {clash}")
    if faults:
        more = f"\n  ... {len(faults) - 20} more" if len(faults) > 20 else ""
        raise UnitError("Dimensions do not fit:\n  " + "\n  ".join(faults[:20]) + more)
    return count


def check_terms(root: Expr) -> None:
    """Check that an expression adds and compares only quantities of one kind.

    A number added to a quantity, or compared with it, is in the unit of that quantity.

    Raises
    ------
    UnitError
        With both units. Needs pint (``lumped[units]``).
    """
    try:
        _dimension(root)
    except _ClashError as clash:
        raise UnitError(f"dimensions do not fit: {clash}") from None


def _parts(part: Component, path: str) -> Iterator[tuple[str, Component]]:
    yield f"{path} ({type(part).__name__})", part
    for name, inner in part._children():
        yield from _parts(inner, f"{path}.{name}")


def _pairs(part: Component) -> Iterator[tuple[Expr, Expr, str]]:
    """Pairs that must be of the same kind, with a text of each."""
    for item in [*part.equations(), *part.initial_equations()]:
        for single in item if isinstance(item, tuple) else (item,):
            yield from _sides(single)
    for connection in part.connections():
        # blocks of plain numbers take any signal
        signals = [e for e in connection.ends if isinstance(e, Ref) and e.quantity.unit != "1"]
        for one, other in pairwise(signals):
            yield one, other, f"{label(one)} joined to {label(other)}"


def _sides(item: Item) -> Iterator[tuple[Expr, Expr, str]]:
    if isinstance(item, Equation):
        yield item.left, item.right, repr(item)
    elif isinstance(item, When):
        yield from _condition(item.condition)
        for state, value in item.changes:
            yield state, value, f"{text(state)} becomes {text(value)}"
    elif isinstance(item, Hold):
        for name in ("forward", "backward", "upper", "lower"):
            limit = getattr(item, name)
            if limit is not None:
                yield item.reaction, limit, f"{name} of {text(item.reaction)} = {text(limit)}"
        if item.gap is not None:
            yield Der(item.gap), item.speed, f"gap = {text(item.gap)}"
        factor = Call("sign", (item.restitution,))  # a number, in whose unit none is taken
        yield factor, item.restitution, f"restitution = {text(item.restitution)}"
        if item.engaged is not None:
            yield from _condition(item.engaged)


def _condition(condition: Compare) -> Iterator[tuple[Expr, Expr, str]]:
    yield condition.greater, condition.less, repr(condition)


def _dimension(root: Expr) -> Dimension | None:
    """Dimension of an expression; None if it fits everywhere.

    Numbers beside quantities fit. A choice between numbers, or a sum of them, is a number too.
    """
    done: dict[int, Dimension | None] = {}
    numbers: set[int] = set()
    for node in walk(root):
        children = node.children()
        parts = [done[id(child)] for child in children]
        are = [id(child) in numbers for child in children]
        if isinstance(node, ConstantExpression):
            numbers.add(id(node))
        elif isinstance(node, Where) or (isinstance(node, Call) and node.op in _ALIKE):
            first = 2 if isinstance(node, Where) else 0  # of what is chosen from
            if all(are[first:]):
                numbers.add(id(node))
                are[first:] = [False] * len(are[first:])
            parts = [None if free else part for part, free in zip(parts, are, strict=True)]
        done[id(node)] = _of(node, parts)
    return done[id(root)]


def _of(node: Expr, parts: list[Dimension | None]) -> Dimension | None:
    if isinstance(node, Datum):
        return None
    if isinstance(node, Piecewise):
        return _match_dimensions(parts[1:])
    if isinstance(node, Smooth):
        return parts[0]
    if isinstance(node, ConstantExpression):
        return None if node.value == 0 else _NUMBER
    if isinstance(node, Time):
        return dimension("s")
    if isinstance(node, Ref):
        return dimension(node.quantity.unit)
    if isinstance(node, Param):
        return dimension(node.unit)
    if isinstance(node, Der):
        return _times(parts[0], dimension("s"), -1)
    if isinstance(node, Partial):
        return _times(parts[0], parts[1], -1)
    if isinstance(node, Where):
        _match_dimensions(parts[:2])
        return _match_dimensions(parts[2:])
    assert isinstance(node, Call)
    return _check_call(node, parts)


def _check_call(node: Call, parts: list[Dimension | None]) -> Dimension | None:
    if node.op in _SAME:
        return _match_dimensions(parts)
    if node.op in ("*", "/"):
        return _times(parts[0], parts[1], 1 if node.op == "*" else -1)
    if node.op in ("neg", "abs"):
        return parts[0]
    if node.op == "sign":
        return _NUMBER
    if node.op == "sqrt":
        return _power(parts[0], 0.5)
    if node.op == "**":
        _match_dimensions([parts[1], _NUMBER])
        exponent = node.args[1]
        if isinstance(exponent, ConstantExpression):
            return _power(parts[0], exponent.value)
        return _match_dimensions([parts[0], _NUMBER])
    if node.op == "atan2":
        _match_dimensions(parts)
        return _NUMBER
    for part in parts:
        _match_dimensions([part, _NUMBER])
    return _NUMBER


def _match_dimensions(parts: list[Dimension | None]) -> Dimension | None:
    known = [part for part in parts if part is not None]
    for part in known[1:]:
        if part != known[0]:
            raise _ClashError(f"{format_dimension(known[0])} against {format_dimension(part)}")
    return known[0] if known else None


def _times(a: Dimension | None, b: Dimension | None, sign: int) -> Dimension | None:
    if a is None or b is None:
        return None
    found = dict(a)
    for name, power in b.items():
        found[name] = found.get(name, 0) + sign * power
    return {name: power for name, power in found.items() if power}


def _power(part: Dimension | None, exponent: float) -> Dimension | None:
    return None if part is None else {k: v * exponent for k, v in part.items() if exponent}
