"""Lower expression trees to CasADi SX."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Protocol

import casadi as ca

from lumped.errors import EquationError
from lumped.language.derivatives import partials
from lumped.language.expression import (
    Call,
    Compare,
    ConstantExpression,
    Der,
    Expr,
    Partial,
    Piecewise,
    Smooth,
    Time,
    Where,
    walk,
)
from lumped.language.pieces import FIXED
from lumped.support.follow_operations import follow_operations

_UNARY = {
    "neg": lambda x: -x,
    **{
        name: getattr(ca, name)
        for name in (
            "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh",
            "sqrt", "exp", "log",
        )
    },
}  # fmt: skip
_BINARY = {
    "+": lambda x, y: x + y,
    "-": lambda x, y: x - y,
    "*": lambda x, y: x * y,
    "/": lambda x, y: x / y,
    "**": lambda x, y: x**y,
    "atan2": ca.atan2,
}
OPERATIONS: dict[str, Callable[..., ca.SX]] = {**_UNARY, **_BINARY}
"""Smooth operators and functions, by how a `Call` names them."""
_STEPS = {
    *(ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_SIGN, ca.OP_FLOOR, ca.OP_CEIL),
    *(ca.OP_FABS, ca.OP_FMIN, ca.OP_FMAX, ca.OP_FMOD, ca.OP_COPYSIGN),
}
_KINKED = ("abs", "sign", "min", "max")


Branches = tuple[tuple[ca.SX, bool], ...]
"""Modes of conditions, and whether they hold."""


class Kinks(Protocol):
    """How expressions that are not smooth are lowered."""

    def mode(self, condition: Compare, greater: ca.SX, less: ca.SX) -> ca.SX:
        """1 while a relation holds, else 0; its lowered sides are given."""

    def piece(self, node: Piecewise, place: ca.SX) -> ca.SX:
        """Settings of the piece that contains a place (see `Pieces.table`)."""

    def note_branches(self, mode: ca.SX, branches: Branches) -> None:
        """Note the values, 1 or 0, that other modes must have for a mode to matter."""

    def inside_smooth(self) -> Kinks:
        """Kinks inside `smooth`."""


class Plain:
    """Kinks that are not watched: each evaluation chooses the piece."""

    def mode(self, condition: Compare, greater: ca.SX, less: ca.SX) -> ca.SX:
        """1 where the relation holds."""
        return greater > less if condition.strict else greater >= less

    def piece(self, node: Piecewise, place: ca.SX) -> ca.SX:
        """Settings of the piece, selected by comparisons that all derivatives share."""
        pieces = node.pieces
        table, begin, back = ca.DM(pieces.table), pieces.begins[0], ca.SX(0)
        if pieces.period is not None:
            back = pieces.period * ca.floor((place - begin) / pieces.period)
        beyond = ca.vertcat(1, place - back >= ca.DM(pieces.begins[1:]), 0)
        selected = ca.mtimes((beyond[:-1] - beyond[1:]).T, table).T
        selected[1] += back
        return selected

    def note_branches(self, mode: ca.SX, branches: Branches) -> None:
        """Nothing to note, as no mode is watched."""

    def inside_smooth(self) -> Kinks:
        """They are not watched there either."""
        return Plain()


def lower(
    root: Expr,
    leaf: Callable[[Expr], ca.SX],
    *,
    time: ca.SX | None = None,
    derivative: Callable[[ca.SX], ca.SX] | None = None,
    kinks: Kinks | None = None,
) -> ca.SX:
    """The CasADi form of an expression.

    Parameters
    ----------
    root : Expr
        Expression to lower.
    leaf : callable
        Symbol of a reference or parameter.
    time : SX, optional
        Symbol of the time; without it the expression must not depend on the time.
    derivative : callable, optional
        Time derivative of an SX expression; without it ``der`` is refused.
    kinks : Kinks, optional
        How kinks are lowered; by default they are not watched.

    Raises
    ------
    EquationError
        If the expression holds something that has no meaning at this place.
    """
    done: dict[int, ca.SX] = {}
    watched = kinks or Plain()

    def refuse(what: str) -> EquationError:
        return EquationError(f"'{root!r}' binds a parameter or start value and cannot hold {what}.")

    nodes = list(walk(root, closed=Smooth))
    places, bounded = _branches(nodes), _find_bounded(nodes)
    chosen: dict[int, ca.SX] = {}
    for node in nodes:
        if isinstance(node, Smooth):
            done[id(node)] = lower(
                node.of, leaf, time=time, derivative=derivative, kinks=watched.inside_smooth()
            )
            continue
        args = [done[id(child)] for child in node.children()]
        if isinstance(node, ConstantExpression):
            value = ca.SX(node.value)
        elif isinstance(node, Call) and node.op in _KINKED:
            found = _modes(node, args, watched)
            chosen[id(node)] = ca.vertcat(*found)
            if id(node) in bounded:
                found = _modes(node, args, Plain())
            value = _choose_piece(node, args, found)
        elif isinstance(node, Call):
            value = OPERATIONS[node.op](*args)
        elif isinstance(node, Time):
            if time is None:
                raise refuse("the time")
            value = time
        elif isinstance(node, Der):
            if derivative is None:
                raise refuse("a time derivative")
            value = derivative(args[0])
        elif isinstance(node, Piecewise):
            value = _piecewise(node, args[0], args[1:], watched)
        elif isinstance(node, Partial):
            value = partials(args[0], args[1])
        elif isinstance(node, Where):
            mode = chosen[id(node)] = watched.mode(node.condition, args[0], args[1])
            value = ca.if_else(mode, args[2], args[3])
        else:
            value = leaf(node)
        done[id(node)] = value
    for key, modes in chosen.items():
        branches = tuple((chosen[other], holds) for other, holds in places[key])
        for mode in ca.vertsplit(modes):
            watched.note_branches(mode, branches)
    return done[id(root)]


def _branches(nodes: list[Expr]) -> dict[int, tuple[tuple[int, bool], ...]]:
    """Branches of `where` around each node; for several places, those common to all."""
    found: dict[int, tuple[tuple[int, bool], ...]] = {id(nodes[-1]): ()}
    for node in reversed(nodes):
        if isinstance(node, Smooth):
            continue
        own = found[id(node)]
        for i, child in enumerate(node.children()):
            place = own
            if isinstance(node, Where) and i >= 2:
                place = (*own, (id(node), i == 2))
            known = found.get(id(child))
            if known is not None:
                pairs = zip(known, place, strict=False)
                place = tuple(a for a, _ in itertools.takewhile(lambda p: p[0] == p[1], pairs))
            found[id(child)] = place
    return found


def _find_bounded(nodes: list[Expr]) -> set[int]:
    """Nodes under a function that is not defined everywhere, such as a root.

    Within a step that passes a kink, the piece before it would leave the range of the function, so
    each evaluation chooses the piece there. The run stops at the kink all the same.
    """
    found: set[int] = set()
    for node in reversed(nodes):
        own = id(node) in found
        own = own or has_range(node)
        if own and not isinstance(node, Where | Smooth):
            found.update(id(child) for child in node.children())
    return found


def has_range(node: Expr) -> bool:
    """Whether a node is a function that is not defined everywhere, such as a root."""
    if not isinstance(node, Call):
        return False
    power = node.args[-1]
    whole = isinstance(power, ConstantExpression) and power.value == int(power.value)
    return node.op in ("sqrt", "log", "asin", "acos") or (node.op == "**" and not whole)


def _modes(node: Call, args: list[ca.SX], kinks: Kinks) -> list[ca.SX]:
    """Modes of functions that abbreviate conditions."""
    zero, none, x = ConstantExpression(0.0), ca.SX(0), node.args[0]
    if node.op == "abs":
        return [kinks.mode(Compare(x, zero), args[0], none)]
    if node.op == "sign":
        above = kinks.mode(Compare(x, zero, strict=True), args[0], none)
        return [above, kinks.mode(Compare(zero, x, strict=True), none, args[0])]
    return [kinks.mode(Compare(node.args[0], node.args[1]), *args)]


def _choose_piece(node: Call, args: list[ca.SX], modes: list[ca.SX]) -> ca.SX:
    """The value that such a function chooses by its modes."""
    x, y = args[0], args[-1]
    if node.op == "abs":
        return (2 * modes[0] - 1) * x
    if node.op == "sign":
        return modes[0] - modes[1]
    return ca.if_else(modes[0], x, y) if node.op == "max" else ca.if_else(modes[0], y, x)


def _piecewise(node: Piecewise, place: ca.SX, heights: list[ca.SX], kinks: Kinks) -> ca.SX:
    """The polynomial of the current piece."""
    if node.pieces.count == 1 and node.pieces.period is None:
        kinks = Plain()
    settings = kinks.piece(node, place)
    run, coefficients = place - settings[1], settings[FIXED:]
    if heights:
        return _between(settings[0], run * coefficients[0], heights)
    value = coefficients[0]
    for i in range(1, coefficients.numel()):
        value = value * run + coefficients[i]
    return value


def _between(number: ca.SX, share: ca.SX, heights: list[ca.SX]) -> ca.SX:
    """Interpolation between the two heights of a piece."""
    left = right = ca.SX(0)
    for i in range(len(heights) - 1):
        here = number == i
        left += ca.if_else(here, heights[i], 0)
        right += ca.if_else(here, heights[i + 1], 0)
    return left + share * (right - left)


def is_even(argument: ca.SX, time: ca.SX) -> bool:
    """Whether an expression is linear in the time between changes of modes."""
    slope = ca.jacobian(argument, time)
    return not ca.depends_on(slope, time) and not has_steps(argument, time)


def has_steps(expression: ca.SX, symbols: ca.SX) -> bool:
    """Whether functions with jumps or kinks, such as a floor, depend on some of the symbols."""
    rest = [s for s in ca.symvar(expression) if not ca.depends_on(symbols, s)]
    function = ca.Function("f", [symbols, ca.vertcat(ca.SX(0, 1), *rest)], [expression])
    moved: set[int] = set()

    def apply(operation: int, moves: list[bool]) -> bool:
        if any(moves):
            moved.add(operation)
        return any(moves)

    follow_operations(function, lambda which, _: which == 0, lambda _: False, apply)
    return not moved.isdisjoint(_STEPS)
