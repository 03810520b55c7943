"""Functions of a plant as C99.

A function becomes ``void name(const double *x, const double *p, double t, const double *m,
double *out)``. Operations keep their order and rounding (see `interpret`).
"""

from __future__ import annotations

import casadi as ca

from lumped.code.operations import (
    PARAMETER,
    RESULT,
    SETTING,
    STATE,
    TIME,
    Operations,
    UnsupportedError,
)
from lumped.code.to_c import number

__all__ = ["c_text", "declaration"]

_CHUNK = 400
"""Operations in one C function: the time to compile grows faster than linearly in them."""

_INPUTS = {STATE: "x", PARAMETER: "p", SETTING: "m"}
_ARGUMENTS = "const double *x, const double *p, double t, const double *m, double *out"
_ONE = {
    getattr(ca, f"OP_{name.upper()}"): f"{name}({{a}})"
    for name in (
        *("tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh"),
        *("atanh", "exp", "expm1", "log", "log1p", "erf", "floor", "ceil", "sqrt", "fabs"),
    )
} | {
    ca.OP_SIN: "lumped_sin({a})",
    ca.OP_COS: "lumped_cos({a})",
    ca.OP_ASSIGN: "{a}",
    ca.OP_LIFT: "{a}",
    ca.OP_NEG: "-{a}",
    ca.OP_SQ: "{a} * {a}",
    ca.OP_TWICE: "{a} + {a}",
    ca.OP_INV: "1.0 / {a}",
    ca.OP_NOT: "{a} == 0.0 ? 1.0 : 0.0",
    ca.OP_SIGN: "{a} < 0.0 ? -1.0 : {a} > 0.0 ? 1.0 : {a}",
}
_TWO = {
    getattr(ca, f"OP_{name.upper()}"): f"{name}({{a}}, {{b}})"
    for name in ("atan2", "hypot", "pow", "fmod", "remainder", "copysign", "fmin", "fmax")
} | {
    ca.OP_CONSTPOW: "pow({a}, {b})",
    ca.OP_ADD: "{a} + {b}",
    ca.OP_SUB: "{a} - {b}",
    ca.OP_MUL: "{a} * {b}",
    ca.OP_DIV: "{a} / {b}",
    ca.OP_LT: "{a} < {b} ? 1.0 : 0.0",
    ca.OP_LE: "{a} <= {b} ? 1.0 : 0.0",
    ca.OP_EQ: "{a} == {b} ? 1.0 : 0.0",
    ca.OP_NE: "{a} != {b} ? 1.0 : 0.0",
    ca.OP_AND: "{a} != 0.0 && {b} != 0.0 ? 1.0 : 0.0",
    ca.OP_OR: "{a} != 0.0 || {b} != 0.0 ? 1.0 : 0.0",
    ca.OP_IF_ELSE_ZERO: "{a} != 0.0 ? {b} : 0.0",
}


def declaration(name: str) -> str:
    """Prototype of a function."""
    return f"void {name}({_ARGUMENTS});"


def c_text(function: Operations, name: str) -> str:
    """C of a function; ``math.h`` must be included before.

    Raises
    ------
    UnsupportedError
        If it has an operation that is not known here.
    """
    rows, constants = function.table.tolist(), function.constants.tolist()
    count = max(1, -(-len(rows) // _CHUNK))
    if count == 1:
        body = _body(rows, constants, set())
        return f"void {name}({_ARGUMENTS})\n{{\n{_unused(body)}}}\n"
    handed = _handed(rows)
    parts = []
    for k in range(count):
        part = rows[k * _CHUNK : (k + 1) * _CHUNK]
        body = _body(part, constants, handed[min((k + 1) * _CHUNK, len(rows))])
        head = f"static void {name}_{k}({_ARGUMENTS}, double *w)"
        parts.append(f"{head}\n{{\n{_unused(body, 'w')}}}\n")
    calls = "".join(f"    {name}_{k}(x, p, t, m, out, w);\n" for k in range(count))
    whole = f"void {name}({_ARGUMENTS})\n{{\n    double w[{function.work}];\n{calls}}}\n"
    return "\n".join([*parts, whole])


def _unused(body: str, *more: str) -> str:
    """A body that names all arguments."""
    names = ("x", "p", "t", "m", "out", *more)
    return "    " + ", ".join(f"(void){name}" for name in names) + ";\n" + body


def _handed(rows: list[list[int]]) -> dict[int, set[int]]:
    """Places of the work vector that are still read, where a chunk ends."""
    held: set[int] = set()
    found = {len(rows): set(held)}
    for k in range(len(rows) - 1, -1, -1):
        op, written, a, b = rows[k]
        if op == RESULT:
            held.add(a)
        else:
            held.discard(written)
            if op in _ONE or op in _TWO:
                held.update((a, b) if op in _TWO else (a,))
        if k % _CHUNK == 0:
            found[k] = set(held)
    return found


def _body(rows: list[list[int]], constants: list[float], handed: set[int]) -> str:
    """Statements of a chunk; each value has a name of its own."""
    lines: list[str] = []
    held: dict[int, str] = {}
    changed: set[int] = set()

    def get(place: int) -> str:
        if place not in held:
            held[place] = f"w[{place}]"
        return held[place]

    for k, (op, written, a, b) in enumerate(rows):
        if op == RESULT:
            lines.append(f"    out[{written}] = {get(a)};")
            continue
        if op == ca.OP_CONST:
            text = number(constants[a])
            held[written] = f"({text})" if text.startswith("-") else text
        elif op == TIME:
            held[written] = "t"
        else:
            if op in _INPUTS:
                text = f"{_INPUTS[op]}[{a}]"
            elif op in _ONE:
                text = _ONE[op].format(a=get(a))
            elif op in _TWO:
                text = _TWO[op].format(a=get(a), b=get(b))
            else:
                raise UnsupportedError(f"operation {op} of CasADi")
            lines.append(f"    const double v{k} = {text};")
            held[written] = f"v{k}"
        changed.add(written)
    lines += [f"    w[{place}] = {held[place]};" for place in sorted(changed & handed)]
    return "\n".join(lines) + "\n"
