"""Functions of a plant as C99.

A function becomes ``void name(const double *x, const double *p, double t, const double *m,
double *out)``. Operations keep their order and rounding (see `interpret`).
"""

from __future__ import annotations

import re
from functools import cache

import casadi as ca

from lumped.code import words
from lumped.code.operations import (
    FORMULAS,
    FUNCTIONS,
    OWN,
    PARAMETER,
    RESULT,
    SETTING,
    STATE,
    TIME,
    Operations,
    UnsupportedError,
    places_read,
    split_in_parts,
)
from lumped.code.to_c import number, write_result

_CHUNK = 400
"""Operations in one C function: the time to compile grows faster than linearly in them."""

_INPUTS = {STATE: "x", PARAMETER: "p", SETTING: "m"}
_ARGUMENTS = "const double *x, const double *p, double t, const double *m, double *out"
_SPACE = {**FUNCTIONS, "__name__": __name__}


@cache
def _template(op: int) -> str:
    """C of an operation on {a} and {b}.

    Raises
    ------
    UnsupportedError
        If it has no formula.
    """
    if op not in FORMULAS:
        raise UnsupportedError(f"operation {op} of CasADi")
    text = f"def formula(a: float, b: float) -> float:\n    return {FORMULAS[op]}"
    return re.sub(
        r"\b([ab])\b", r"{\1}", write_result(words.make_kernel("formula", text, _SPACE), OWN)
    )


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
    whole_parts = split_in_parts(rows, _CHUNK)
    if len(whole_parts) == 1:
        body = _body(whole_parts[0][0], constants, set())
        return f"void {name}({_ARGUMENTS})\n{{\n{_name_arguments(body)}}}\n"
    parts = []
    for k, (part, after) in enumerate(whole_parts):
        body = _body(part, constants, after)
        head = f"static void {name}_{k}({_ARGUMENTS}, double *w)"
        parts.append(f"{head}\n{{\n{_name_arguments(body, 'w')}}}\n")
    calls = "".join(f"    {name}_{k}(x, p, t, m, out, w);\n" for k in range(len(parts)))
    whole = f"void {name}({_ARGUMENTS})\n{{\n    double w[{function.work}];\n{calls}}}\n"
    return "\n".join([*parts, whole])


def _name_arguments(body: str, *more: str) -> str:
    """A body that names all arguments."""
    names = ("x", "p", "t", "m", "out", *more)
    return "    " + ", ".join(f"(void){name}" for name in names) + ";\n" + body


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
            else:
                read = [get(place) for place in places_read(op, a, b)]
                text = _template(op).format(a=read[0], b=read[-1])
            lines.append(f"    const double v{k} = {text};")
            held[written] = f"v{k}"
        changed.add(written)
    lines += [f"    w[{place}] = {held[place]};" for place in sorted(changed & handed)]
    return "\n".join(lines) + "\n"
