"""Expressions of CasADi as those of SymPy, and the shortest way to write one."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import casadi as ca
import numpy as np

from lumped.errors import OptionError
from lumped.support.optional_packages import extra

_DIGITS = 12
"""A number of more digits is none that someone wrote."""


def load_sympy() -> Any:
    """SymPy.

    Raises
    ------
    OptionError
        If it is not installed.
    """
    return extra("sympy", "formulas", "A formula to read")


def convert(found: ca.SX, symbols: ca.SX, names: list[str]) -> Any:
    """A matrix of expressions of symbols as a matrix of SymPy, with names for the symbols.

    Raises
    ------
    OptionError
        If it holds a function that has no formula, such as a table.
    """
    sympy = load_sympy()
    function = ca.Function("found", [symbols], [found])
    known = [sympy.Symbol(name) for name in names]
    rows, columns = function.sparsity_out(0).get_triplet()
    work: dict[int, Any] = {}
    matrix = sympy.zeros(*found.shape)
    for k in range(function.n_instructions()):
        code, to, of = (
            function.instruction_id(k),
            function.instruction_output(k),
            function.instruction_input(k),
        )
        if code == ca.OP_CONST:
            work[to[0]] = exact(function.instruction_constant(k))
        elif code == ca.OP_INPUT:
            work[to[0]] = known[of[1]]
        elif code == ca.OP_OUTPUT:
            matrix[rows[to[1]], columns[to[1]]] = work[of[0]]
        elif code in _operations():
            work[to[0]] = _operations()[code](sympy, *(work[i] for i in of))
        else:
            raise OptionError(
                "a formula holds a comparison or a table, which have no closed form; linearise "
                "gives numbers."
            )
    return matrix


def exact(value: float) -> Any:
    """A number as a fraction, if someone may have written it so, or of pi."""
    sympy = load_sympy()
    if len(f"{value:.17g}") <= _DIGITS or len(repr(value).strip("-0.")) <= _DIGITS:
        return sympy.Rational(repr(value))
    for whole, unit in ((1.0, sympy.Integer(1)), (np.pi, sympy.pi)):
        near = Fraction(value / whole).limit_denominator(1000)
        if abs(float(near) * whole - value) <= 4e-16 * abs(value):
            return sympy.Rational(near.numerator, near.denominator) * unit
    return sympy.Rational(value)


def _operations() -> dict[int, Callable[..., Any]]:
    """What SymPy does for each operation of CasADi."""
    return {
        ca.OP_ASSIGN: lambda _, a: a,
        ca.OP_ADD: lambda _, a, b: a + b,
        ca.OP_SUB: lambda _, a, b: a - b,
        ca.OP_MUL: lambda _, a, b: a * b,
        ca.OP_DIV: lambda _, a, b: a / b,
        ca.OP_NEG: lambda _, a: -a,
        ca.OP_SQ: lambda _, a: a**2,
        ca.OP_TWICE: lambda _, a: 2 * a,
        ca.OP_INV: lambda _, a: 1 / a,
        ca.OP_POW: lambda _, a, b: a**b,
        ca.OP_CONSTPOW: lambda _, a, b: a**b,
        ca.OP_SQRT: lambda sympy, a: sympy.sqrt(a),
        ca.OP_EXP: lambda sympy, a: sympy.exp(a),
        ca.OP_LOG: lambda sympy, a: sympy.log(a),
        ca.OP_SIN: lambda sympy, a: sympy.sin(a),
        ca.OP_COS: lambda sympy, a: sympy.cos(a),
        ca.OP_TAN: lambda sympy, a: sympy.tan(a),
        ca.OP_ASIN: lambda sympy, a: sympy.asin(a),
        ca.OP_ACOS: lambda sympy, a: sympy.acos(a),
        ca.OP_ATAN: lambda sympy, a: sympy.atan(a),
        ca.OP_ATAN2: lambda sympy, a, b: sympy.atan2(a, b),
        ca.OP_SINH: lambda sympy, a: sympy.sinh(a),
        ca.OP_COSH: lambda sympy, a: sympy.cosh(a),
        ca.OP_TANH: lambda sympy, a: sympy.tanh(a),
    }


def shortest(found: Any) -> Any:
    """The shortest of the usual ways to write an expression: as it is, in terms, in factors."""
    sympy = load_sympy()
    if found.is_Atom:
        return found
    if found.has(sympy.sin, sympy.cos):  # whose powers in terms may be thousands
        ways = [found, sympy.factor(found), sympy.simplify(found)]
    else:
        terms, factors = sympy.expand(found), sympy.factor(found)
        ways = [found, terms, factors, sympy.collect(terms, _denominators(factors))]
    return min(ways, key=lambda way: (sympy.count_ops(way), len(str(way))))


def by_squares(form: Any) -> Any:
    """A quadratic form of mode components by what it is linear in: ``c (a - b)^2 + ...``."""
    sympy = load_sympy()
    rest, found = sympy.expand(form), sympy.Integer(0)
    for symbol in sorted(rest.free_symbols, key=str):
        coefficient = rest.diff(symbol)
        if str(symbol)[:4] in ("phi.", "psi.") or coefficient.has(symbol):
            continue
        found += symbol * sympy.factor(coefficient)
        rest = sympy.expand(rest - symbol * coefficient)
    return found + sympy.factor(rest)


def _denominators(found: Any) -> list[Any]:
    """Powers of what divides an expression."""
    return [1 / factor for factor in load_sympy().fraction(found)[1].as_ordered_factors()]
