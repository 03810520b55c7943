"""A formula to read, to print, to compute and to differentiate."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any, Literal

import casadi as ca
import numpy as np

from lumped.errors import OptionError, UnknownNameError
from lumped.support.arguments import checked
from lumped.vibration.formulas.to_sympy import convert, load_sympy, shortest

_WIDTH = 100
_GREEK = {"phi": "varphi", "tau": "tau", "omega": "omega", "lambda": "lambda", "theta": "theta"}


@dataclass(frozen=True, eq=False)
class Formula:
    """An expression of parameters, perhaps with named parts.

    Attributes
    ----------
    name : str
        What it is a formula of.
    expression : sympy expression or sympy matrix
        Of the names of parameters, states, ``s``, mode components and of parts.
    parts : tuple of (sympy symbol, sympy expression)
        Named parts, each of those before it.
    numbers : mapping of str to float
        Values of the parameters in the model.
    error : float
        Relative error, at these, of the terms that `shorten` left out.
    """

    name: str
    expression: Any
    parts: tuple[tuple[Any, Any], ...] = ()
    numbers: Mapping[str, float] = field(default_factory=dict, repr=False)
    error: float = 0.0

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters and other symbols in it, sorted; parts are none."""
        known = {part for part, _ in self.parts}
        used = set(self.expression.free_symbols).union(*(e.free_symbols for _, e in self.parts))
        return tuple(sorted(str(symbol) for symbol in used - known))

    @property
    def whole(self) -> Any:
        """The expression without named parts, in SymPy; it may be long."""
        found = self.expression
        for part, value in reversed(self.parts):
            found = found.subs(part, value)
        return found

    @cached_property
    def casadi(self) -> ca.SX:
        """The expression in CasADi, its symbols listed by ``casadi.symvar``."""
        symbols = {name: ca.SX.sym(name) for name in self.names}
        found = self._evaluate(symbols, self._compile(_CASADI))
        if not hasattr(self.expression, "shape"):
            return ca.SX(found)
        matrix: ca.SX = ca.sparsify(ca.vertcat(*(ca.horzcat(*row) for row in found)))
        return matrix

    @checked
    def __call__(self, numbers: Mapping[str, Any] | None = None) -> Any:
        """Its value.

        Parameters
        ----------
        numbers : mapping of str to number, optional
            Values of names that are no parameters, or that differ from those of the model, such as
            those of a mode; complex ones and arrays are permitted.

        Returns
        -------
        number or ndarray

        Raises
        ------
        UnknownNameError
            If a name has no value, or does not occur.
        """
        given = dict(numbers or {})
        known = {**self.numbers, **given}
        missing = [name for name in self.names if name not in known]
        if missing:
            raise UnknownNameError(f"{self.name}: give values of {', '.join(missing)}.")
        for name in given:
            of_modes = name in ("omega", "s") or name.startswith(("phi.", "psi."))
            if not of_modes and name not in self.names and name not in self.numbers:
                raise UnknownNameError(f"{self.name}: there is no '{name}' in the formula.")
        found = self._evaluate({name: known[name] for name in self.names}, self._calls)
        return np.array(found) if hasattr(self.expression, "shape") else found

    @cached_property
    def _calls(self) -> list[tuple[Any, list[Any], Any]]:
        return self._compile(_NUMPY)

    def _compile(self, functions: Mapping[str, Any]) -> list[tuple[Any, list[Any], Any]]:
        """Functions of parts, then of entries: which part (or None), arguments, function."""
        sympy = load_sympy()
        whole = self.expression
        entries = list(whole) if hasattr(whole, "shape") else [whole]
        found = []
        for part, each in [*self.parts, *((None, entry) for entry in entries)]:
            used = sorted(each.free_symbols, key=str)
            found.append((part, used, sympy.lambdify(used, each, [dict(functions)], dummify=True)))
        return found

    def _evaluate(self, symbols: Mapping[str, Any], calls: list[tuple[Any, list[Any], Any]]) -> Any:
        sympy = load_sympy()
        values: dict[Any, Any] = {sympy.Symbol(name): value for name, value in symbols.items()}
        found = []
        for part, used, call in calls:
            value = call(*(values[symbol] for symbol in used))
            if part is None:
                found.append(value)
            else:
                values[part] = value
        if not hasattr(self.expression, "shape"):
            return found[0]
        columns = self.expression.cols
        return [found[k : k + columns] for k in range(0, len(found), columns)]

    @checked
    def shorten(self, share: float) -> Formula:
        """Without terms that are small in their sums at the values of the model.

        Parameters
        ----------
        share : float
            Terms below this share of the largest of their sum are left out.

        Returns
        -------
        Formula
            Its `error` tells how far its value is from the true one there.

        Raises
        ------
        OptionError
            If it holds symbols without a value in the model.
        """
        if missing := [name for name in self.names if name not in self.numbers]:
            raise OptionError(f"{self.name}: {missing[0]} has no value, so no term is small.")
        values = {load_sympy().Symbol(name): self.numbers[name] for name in self.names}
        parts = []
        for part, expression in self.parts:
            parts.append((part, _without_small(expression, values, share)))
            values[part] = float(expression.subs(values))
        short = _without_small(self.expression, values, share)
        found = replace(self, expression=short, parts=drop_unused(short, parts))
        return replace(found, error=float(abs(found() / self() - 1)))

    def __str__(self) -> str:
        lines = [_wrap(f"{self.name} = ", self.expression)]
        if self.parts:
            lines += ["where", *(_wrap(f"  {part} = ", e) for part, e in self.parts)]
        if self.error:
            lines.append(f"small terms are left out, relative error {self.error:.1e}")
        return "\n".join(lines)

    __repr__ = __str__

    def latex(self) -> str:
        """The formula in LaTeX, aligned at the signs of equality.

        Returns
        -------
        str
        """
        lines, texts = [(self.name, self.expression), *self.parts], []
        for left, right in lines:
            symbols = {s: _latex_name(str(s)) for s in right.free_symbols}
            left = _latex_name(str(left)) if str(left).isidentifier() else _latex_text(str(left))
            texts.append(f"{left} &= {_printer('latex', symbol_names=symbols).doprint(right)}")
        return "\\begin{aligned}\n" + " \\\\\n".join(texts) + "\n\\end{aligned}"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    @checked
    def code(self, language: Literal["python", "c"] = "python") -> str:
        """A function that computes it; dots of names are underscores.

        Parameters
        ----------
        language : {"python", "c"}
            A function of Python, which needs ``math`` alone, or of C99.

        Returns
        -------
        str
        """
        sympy = load_sympy()
        names = {sympy.Symbol(n): sympy.Symbol(_identifier(n)) for n in self.names}
        lines = [(str(part), _clip_angles(e.subs(names))) for part, e in self.parts]
        result = _clip_angles(self.expression.subs(names))
        head, arguments = _identifier(self.name), [str(s) for s in names.values()]
        is_matrix = hasattr(result, "shape")
        if language == "python":
            put = sympy.pycode
            body = [f"{part} = {put(e)}" for part, e in lines]
            if is_matrix:
                rows = (f"[{', '.join(map(put, row))}]" for row in result.tolist())
                body += ["return [", *(f"    {row}," for row in rows), "]"]
            else:
                body.append(f"return {put(result)}")
            text = "\n".join("    " + line for line in body)
            return f"import math\n\n\ndef {head}({', '.join(arguments)}):\n{text}\n"
        body = [f"const double {part} = {sympy.ccode(e)};" for part, e in lines]
        given = [f"double {name}" for name in arguments]
        if is_matrix:
            given.insert(0, "double *result")
            body += [f"result[{k}] = {sympy.ccode(e)};" for k, e in enumerate(result)]
        else:
            body.append(f"return {sympy.ccode(result)};")
        text = "\n".join("    " + line for line in body)
        kind = "void" if is_matrix else "double"
        return f"#include <math.h>\n\n{kind} {head}({', '.join(given)})\n{{\n{text}\n}}\n"


def _clip_angles(expression: Any) -> Any:
    """Cosines of angles kept between -1 and 1, which rounding leaves at repeated roots."""
    sympy = load_sympy()

    def clip(x: Any) -> Any:
        return sympy.acos(sympy.Max(-1, sympy.Min(1, x, evaluate=False), evaluate=False))

    return expression.replace(sympy.acos, clip)


def drop_unused(expression: Any, parts: list[tuple[Any, Any]]) -> tuple[tuple[Any, Any], ...]:
    """Parts on which an expression depends."""
    used, kept = set(expression.free_symbols), []
    for part, value in reversed(parts):
        if part in used:
            used |= value.free_symbols
            kept.append((part, value))
    return tuple(reversed(kept))


def formula_of(
    name: str, found: ca.SX, symbols: ca.SX, names: list[str], numbers: Mapping[str, float]
) -> Formula:
    """A scalar expression of CasADi as a formula, in the shortest way."""
    return Formula(name, shortest(convert(found, symbols, names)[0, 0]), (), numbers)


def _without_small(expression: Any, values: Mapping[Any, float], share: float) -> Any:
    if expression.is_Atom:
        return expression
    arguments = [_without_small(a, values, share) for a in expression.args]
    if expression.is_Add:
        sizes = [abs(float(a.subs(values))) for a in expression.args]
        arguments = [
            a for a, size in zip(arguments, sizes, strict=True) if size >= share * max(sizes)
        ]
    return expression.func(*arguments)


def _wrap(head: str, expression: Any) -> str:
    if hasattr(expression, "shape"):
        rows = [[_text(e) for e in row] for row in expression.tolist()]
        width = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = ["  ".join(t.ljust(w) for t, w in zip(r, width, strict=True)) for r in rows]
        return "\n".join([head.rstrip(), *(f"  [ {line} ]" for line in lines)])
    indent = " " * (len(head) - len(head.lstrip()) + 4)
    words = [
        word if len(word) < _WIDTH - 20 else re.sub(r"([*/])\(", r"\1 (", word)
        for word in _text(expression).split()
    ]
    return textwrap.fill(
        head + " ".join(words),
        _WIDTH,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )


def _text(expression: Any) -> str:
    found: str = _printer("text").doprint(expression)
    return found


def _printer(kind: str, **options: Any) -> Any:
    return _printers()[kind](options)


@cache
def _printers() -> dict[str, Any]:
    """What prints text and LaTeX, with the powers of the variable of polynomials descending."""
    from sympy.printing.latex import LatexPrinter
    from sympy.printing.str import StrPrinter

    variables = [load_sympy().Symbol(name) for name in ("s", "lambda")]

    def power(term: Any) -> int:
        used = [x for x in variables if term.has(x)]
        return -int(term.as_coeff_exponent(used[0])[1]) if used else 0

    def in_order(kind: Any) -> Any:
        def order_terms(self: Any, expression: Any, order: Any = None) -> Any:
            return sorted(kind._as_ordered_terms(self, expression, order), key=power)

        return type(kind.__name__, (kind,), {"_as_ordered_terms": order_terms})

    return {"text": in_order(StrPrinter), "latex": in_order(LatexPrinter)}


def _identifier(name: str) -> str:
    found = re.sub(r"\W+", "_", name).strip("_")
    return f"{found}_" if found in {"lambda", "double", "return", "in", "is"} else found


def _latex_name(name: str) -> str:
    """``upper.motor.J`` as J with the index upper.motor; ``a1`` as a with the index 1."""
    *owner, own = name.split(".")
    base, index = re.fullmatch(r"(.*?)_?(\d*)", own).groups()  # type: ignore[union-attr]
    base, _, word = base.partition("_")
    if owner and own in {"w", "v", "phi"} and owner[0] == "phi":
        owner = owner[1:]
    if name.startswith("phi."):
        base, index, word, owner = "phi", "", "", name.split(".")[1:]
    letter = f"\\{_GREEK[base]}" if base in _GREEK else base
    letter = letter if len(base) == 1 or base in _GREEK else rf"\mathrm{{{base}}}"
    texts = [t for t in (index, word, ".".join(owner)) if t]
    if not texts:
        return letter
    inner = ",".join(t if t.isdigit() else rf"\text{{{t}}}" for t in texts).replace("_", r"\_")
    return f"{letter}_{{{inner}}}"


def _latex_text(name: str) -> str:
    if found := re.fullmatch(r"p\((\w+)\)", name):
        return f"p({_latex_name(found[1])})"
    escaped = name.replace("_", r"\_")
    return rf"\text{{{escaped}}}"


def _clipped(arccos: Callable[[Any], Any], least: Any, most: Any) -> Callable[[Any], Any]:
    return lambda x: arccos(most(least(x, 1.0), -1.0))


_CASADI = {
    name: getattr(ca, name)
    for name in (
        *("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "atan", "atan2"),
        *("sinh", "cosh", "tanh"),
    )
} | {"acos": _clipped(ca.acos, ca.fmin, ca.fmax), "pi": np.pi}
_NUMPY: dict[str, Any] = {
    name: getattr(np, {"asin": "arcsin", "atan": "arctan", "atan2": "arctan2"}.get(name, name))
    for name in _CASADI
    if name not in ("acos", "pi")
} | {"acos": _clipped(np.arccos, np.minimum, np.maximum), "pi": np.pi}
