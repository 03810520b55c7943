"""Derivatives of CasADi SX expressions with the common parts that one would share by hand.

CasADi's own derivatives keep factors that cancel, such as ``2 x`` of a square over ``2 sqrt(r)``
of a root, and multiply a rate into each term. Here a derivative keeps its numeric factor and its
rate apart until it is added to one with another rate, and a quotient or root is used again in its
own derivative. So the slope ``g'`` of ``q == g(phi)`` is the same expression in the torque law, in
``der(q) == g' der(phi)`` and as the coefficient of an acceleration.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import casadi as ca


class _Term(NamedTuple):
    """The product of a number, a rate and an expression."""

    number: float
    rate: ca.SX
    body: ca.SX

    def value(self) -> ca.SX:
        product = _times(self.body, self.rate)
        return product if self.number == 1.0 else self.number * product


_Slopes = dict[int, _Term]
"""Derivatives that are not zero, by the number of their direction."""

_ONE = ca.SX(1)


def partials(expression: ca.SX, symbols: ca.SX) -> ca.SX:
    """Partial derivatives of a scalar by symbols.

    Parameters
    ----------
    expression : SX, shape (1, 1)
        Expression to differentiate.
    symbols : SX, shape (n, 1)
        Symbols by which to differentiate.

    Returns
    -------
    SX, shape (n, 1)
        The derivatives, dense.
    """
    leaves = {s.element_hash(): {i: _Term(1.0, _ONE, _ONE)} for i, s in _each(symbols)}
    found = _slopes(expression, leaves)
    values = (found[i].value() if i in found else ca.SX(0) for i in range(symbols.numel()))
    return ca.vertcat(ca.SX(0, 1), *values)


def along(expression: ca.SX, symbols: ca.SX, rates: ca.SX) -> ca.SX:
    """Rate of a scalar when symbols change at given rates.

    Parameters
    ----------
    expression : SX, shape (1, 1)
        Expression to differentiate.
    symbols, rates : SX, shape (n, 1)
        Symbols that change, and their rates: symbols or numbers.

    Returns
    -------
    SX, shape (1, 1)
        ``sum_i d(expression)/d(symbols[i]) rates[i]``.
    """
    each = dict(_each(rates))
    found = _slopes(
        expression, {s.element_hash(): {0: _Term(1.0, each[i], _ONE)} for i, s in _each(symbols)}
    )
    return found[0].value() if found else ca.SX(0)


def _each(vector: ca.SX) -> Iterator[tuple[int, ca.SX]]:
    return enumerate(ca.vertsplit(vector) if vector.numel() else [])


def _slopes(root: ca.SX, leaves: dict[int, _Slopes]) -> _Slopes:
    """Derivatives of an expression from those of its symbols (forward, each node once)."""
    done = dict(leaves)
    stack = [(root, root.element_hash(), False)]
    while stack:
        node, key, ready = stack.pop()
        if key in done:
            continue
        operands = [node.dep(i) for i in range(node.n_dep())]
        if ready or not operands:
            inner = [done[x.element_hash()] for x in operands]
            done[key] = _slopes_of(node, operands, inner) if any(inner) else {}
        else:
            stack.append((node, key, True))
            stack += [(x, x.element_hash(), False) for x in operands]
    return done[root.element_hash()]


def _slopes_of(node: ca.SX, operands: list[ca.SX], inner: list[_Slopes]) -> _Slopes:
    """Chain rule for one operation."""
    op, x, y = node.op(), operands[0], operands[-1]
    u, v = inner[0], inner[-1]
    if op == ca.OP_ADD:
        return _sum(u, v)
    if op == ca.OP_SUB:
        return _sum(u, _scale_slopes(v, -1.0))
    if op == ca.OP_MUL:
        return _sum(_product(u, y), _product(v, x, left=True))
    if op == ca.OP_DIV:
        return _quotient(_sum(u, _scale_slopes(_product(v, node), -1.0)), y)
    if op == ca.OP_NEG:
        return _scale_slopes(u, -1.0)
    if op == ca.OP_TWICE:
        return _scale_slopes(u, 2.0)
    if op == ca.OP_SQ:
        return _scale_slopes(_product(u, x), 2.0)
    if op == ca.OP_SQRT:
        return _quotient(_scale_slopes(u, 0.5), node)
    if op == ca.OP_SIN:
        return _product(u, ca.cos(x))
    if op == ca.OP_COS:
        return _scale_slopes(_product(u, ca.sin(x)), -1.0)
    if op == ca.OP_ATAN2:
        across = _sum(_product(u, y), _scale_slopes(_product(v, x), -1.0))
        return _quotient(across, x * x + y * y)
    total: _Slopes = {}
    for slopes, factor in zip(inner, _elementary(op, len(operands)).call(operands), strict=True):
        total = _sum(total, _product(slopes, factor))
    return total


@lru_cache
def _elementary(op: int, count: int) -> ca.Function:
    """Partial derivatives of one operation by its operands, from CasADi."""
    symbols = [ca.SX.sym("operand") for _ in range(count)]
    result = (ca.SX.unary if count == 1 else ca.SX.binary)(op, *symbols)
    return ca.Function("slopes", symbols, [ca.gradient(result, s) for s in symbols])


def _scale_slopes(slopes: _Slopes, number: float) -> _Slopes:
    return {i: t._replace(number=t.number * number) for i, t in slopes.items()} if number else {}


def _product(slopes: _Slopes, factor: ca.SX, left: bool = False) -> _Slopes:
    if factor.is_constant():
        return _scale_slopes(slopes, float(factor))
    return {
        i: t._replace(body=_times(factor, t.body) if left else _times(t.body, factor))
        for i, t in slopes.items()
    }


def _quotient(slopes: _Slopes, divisor: ca.SX) -> _Slopes:
    if divisor.is_constant() and float(divisor):
        return {i: t._replace(number=t.number / float(divisor)) for i, t in slopes.items()}
    return {i: t._replace(body=t.body / divisor) for i, t in slopes.items()}


def _sum(left: _Slopes, right: _Slopes) -> _Slopes:
    both = {i: _total(left[i], right[i]) for i in left.keys() & right.keys()}
    return {**left, **right, **both}


def _times(x: ca.SX, y: ca.SX) -> ca.SX:
    """Product, without the 10 microseconds that CasADi takes to multiply by one."""
    return y if x is _ONE else x if y is _ONE else x * y


def _total(a: _Term, b: _Term) -> _Term:
    if not ca.is_equal(a.rate, b.rate):
        a, b = (t._replace(rate=_ONE, body=_times(t.body, t.rate)) for t in (a, b))
    if a.number == b.number:
        return a._replace(body=a.body + b.body)
    if a.number == -b.number:
        return a._replace(body=a.body - b.body)
    return _Term(1.0, a.rate, a.number * a.body + b.number * b.body)
