"""Functions of CasADi as text of the Modelica language."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi as ca

from lumped.errors import ExportError

__all__ = ["ModelicaWriter", "TextTerm", "real"]

_ATOM, _POWER, _PRODUCT, _SUM, _LOOSE = 4, 3, 2, 1, 0
"""How tightly the outermost operator of a text binds."""

_NEVER = 1e300
"""What stands for infinity, an instant that never comes."""

_LONGEST = 160
"""Characters from which on a part becomes a variable of its own."""

_FUNCTIONS = {
    ca.OP_SQRT: "sqrt",
    ca.OP_SIN: "sin",
    ca.OP_COS: "cos",
    ca.OP_TAN: "tan",
    ca.OP_ASIN: "asin",
    ca.OP_ACOS: "acos",
    ca.OP_ATAN: "atan",
    ca.OP_ATAN2: "atan2",
    ca.OP_SINH: "sinh",
    ca.OP_COSH: "cosh",
    ca.OP_TANH: "tanh",
    ca.OP_EXP: "exp",
    ca.OP_LOG: "log",
    ca.OP_FABS: "abs",
    ca.OP_FMIN: "min",
    ca.OP_FMAX: "max",
    ca.OP_FLOOR: "floor",
    ca.OP_CEIL: "ceil",
    ca.OP_SIGN: "sign",
    ca.OP_FMOD: "rem",
}
_INFIX = {
    ca.OP_ADD: (" + ", _SUM),
    ca.OP_SUB: (" - ", _SUM),
    ca.OP_MUL: (" * ", _PRODUCT),
    ca.OP_DIV: (" / ", _PRODUCT),
    ca.OP_POW: ("^", _POWER),
    ca.OP_CONSTPOW: ("^", _POWER),
}
_COMPARED = {ca.OP_LT: " < ", ca.OP_LE: " <= "}
_JOINED = {ca.OP_AND: " and ", ca.OP_OR: " or "}


@dataclass(frozen=True)
class TextTerm:
    """An expression in text.

    Attributes
    ----------
    text : str
        As it is written.
    binds : int
        How tightly its outermost operator does.
    logical : bool
        Whether it is true or false.
    only_if : tuple of Term, optional
        Condition and value of what is zero otherwise.
    contrary_of : TextTerm, optional
        What it is the contrary of.
    """

    text: str
    binds: int = _ATOM
    logical: bool = False
    only_if: tuple[TextTerm, TextTerm] | None = None
    contrary_of: TextTerm | None = None


@dataclass
class ModelicaWriter:
    """Writes functions; parts that are used more than once become variables.

    Attributes
    ----------
    variables : list of (str, Term)
        Those made so far, with what they are.
    """

    variables: list[tuple[str, TextTerm]] = field(default_factory=list)

    def written(
        self, function: ca.Function, given: Sequence[Sequence[TextTerm]], *, inline: bool = False
    ) -> list[list[TextTerm]]:
        """Each result of a function of expanded scalars, entry by entry.

        Raises
        ------
        ExportError
            If an operation has no counterpart.
        """
        steps = [
            (
                function.instruction_id(k),
                function.instruction_input(k),
                function.instruction_output(k),
            )
            for k in range(function.n_instructions())
        ]
        uses = _uses(steps)
        held: dict[int, TextTerm] = {}
        results = [[TextTerm("0")] * function.nnz_out(i) for i in range(function.n_out())]
        for k, (operation, inputs, outputs) in enumerate(steps):
            if operation == ca.OP_OUTPUT:
                results[outputs[0]][outputs[1]] = held[inputs[0]]
                continue
            if operation == ca.OP_INPUT:
                held[outputs[0]] = given[inputs[0]][inputs[1]]
                continue
            if operation == ca.OP_CONST:
                held[outputs[0]] = _constant(function.instruction_constant(k))
                continue
            term = _combined(operation, [held[i] for i in inputs])
            if not inline and (uses[k] > 1 or len(term.text) > _LONGEST):
                term = self._variable(term)
            held[outputs[0]] = term
        return results

    def _variable(self, term: TextTerm) -> TextTerm:
        if term.binds == _ATOM and "(" not in term.text:
            return term
        name = f"v{len(self.variables) + 1}"
        self.variables.append((name, term))
        return TextTerm(name, _ATOM, term.logical, contrary_of=term.contrary_of)


def _uses(steps: Sequence[tuple[int, list[int], list[int]]]) -> Counter[int]:
    """How often the result of each step is used; registers are written again and again."""
    uses: Counter[int] = Counter()
    writer: dict[int, int] = {}
    for k, (operation, inputs, outputs) in enumerate(steps):
        if operation not in (ca.OP_INPUT, ca.OP_CONST):
            for i in {inputs[0]} if operation == ca.OP_OUTPUT else set(inputs):
                uses[writer[i]] += 1
        if operation != ca.OP_OUTPUT:
            writer[outputs[0]] = k
    return uses


def _constant(value: float) -> TextTerm:
    if value != value:
        raise ExportError("an undefined number stands in the equations")
    value = min(max(value, -_NEVER), _NEVER)
    text = repr(int(value)) if value == int(value) and abs(value) < 1e9 else repr(float(value))
    return TextTerm(text, _ATOM if value >= 0 else _SUM)


def real(term: TextTerm) -> TextTerm:
    """The term as a number."""
    if not term.logical:
        return term
    return TextTerm(f"if {term.text} then 1 else 0", _LOOSE)


def _condition(term: TextTerm) -> TextTerm:
    if term.logical:
        return term
    return TextTerm(f"abs({term.text}) > 0", _LOOSE, logical=True)


def _within(term: TextTerm, binds: int) -> str:
    return term.text if term.binds >= binds else f"({term.text})"


def _combined(operation: int, parts: list[TextTerm]) -> TextTerm:
    """One operation."""
    if operation in (ca.OP_NOT, *_JOINED):
        return _logic(operation, [_condition(p) for p in parts])
    if operation == ca.OP_IF_ELSE_ZERO:
        condition, value = _condition(parts[0]), real(parts[1])
        text = f"if {condition.text} then {value.text} else 0"
        return TextTerm(text, _LOOSE, only_if=(condition, value))
    if operation == ca.OP_ADD and all(p.only_if for p in parts):
        chosen = _chosen(parts[0].only_if, parts[1].only_if)
        if chosen is not None:
            return chosen
    return _arithmetic(operation, [real(p) for p in parts])


def _logic(operation: int, parts: list[TextTerm]) -> TextTerm:
    if operation == ca.OP_NOT:
        (part,) = parts
        return TextTerm(f"not {_within(part, _POWER)}", _LOOSE, logical=True, contrary_of=part)
    text = _JOINED[operation].join(_within(p, _SUM) for p in parts)
    return TextTerm(text, _LOOSE, logical=True)


def _chosen(
    yes: tuple[TextTerm, TextTerm] | None, no: tuple[TextTerm, TextTerm] | None
) -> TextTerm | None:
    """One expression out of two that are zero when the other is not."""
    if yes is None or no is None:
        return None
    contrary = no[0].contrary_of
    if contrary is None or contrary.text != yes[0].text:
        return None
    return TextTerm(f"if {yes[0].text} then {yes[1].text} else {_within(no[1], _LOOSE)}", _LOOSE)


def _arithmetic(operation: int, parts: list[TextTerm]) -> TextTerm:
    a = parts[0]
    if operation in _FUNCTIONS:
        return TextTerm(f"{_FUNCTIONS[operation]}({', '.join(p.text for p in parts)})")
    if operation in _INFIX:
        sign, binds = _INFIX[operation]
        tighter = binds + (operation not in (ca.OP_ADD, ca.OP_MUL))
        left = _within(a, _ATOM if binds == _POWER else binds)
        return TextTerm(f"{left}{sign}{_within(parts[1], tighter)}", binds)
    if operation in _COMPARED:
        text = _COMPARED[operation].join(_within(p, _SUM) for p in parts)
        return TextTerm(text, _LOOSE, logical=True)
    if operation in (ca.OP_EQ, ca.OP_NE):  # numbers are not compared for equality in Modelica
        one, other = (_within(p, _SUM) for p in parts)
        differ = TextTerm(f"{one} < {other} or {one} > {other}", _LOOSE, logical=True)
        return differ if operation == ca.OP_NE else _logic(ca.OP_NOT, [differ])
    simple = {
        ca.OP_ASSIGN: TextTerm(a.text, a.binds),
        ca.OP_NEG: TextTerm(f"-{_within(a, _PRODUCT)}", _SUM),
        ca.OP_SQ: TextTerm(f"{_within(a, _ATOM)}^2", _POWER),
        ca.OP_TWICE: TextTerm(f"2 * {_within(a, _PRODUCT)}", _PRODUCT),
        ca.OP_INV: TextTerm(f"1 / {_within(a, _POWER)}", _PRODUCT),
        ca.OP_LOG1P: TextTerm(f"log(1 + {_within(a, _SUM)})"),
        ca.OP_EXPM1: TextTerm(f"exp({a.text}) - 1", _SUM),
    }
    if operation == ca.OP_HYPOT:
        return TextTerm(f"sqrt({_within(a, _ATOM)}^2 + {_within(parts[1], _ATOM)}^2)")
    if operation not in simple:
        raise ExportError(f"operation {operation} of CasADi has no counterpart in Modelica")
    return simple[operation]
