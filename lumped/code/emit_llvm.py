"""Functions of a plant as LLVM assembly.

A function becomes ``void name(const double* x, const double* p, double t, const double* m,
double* out)``. Operations keep their order and rounding.
"""

from __future__ import annotations

from collections.abc import Callable

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
from lumped.code.to_llvm import literal

__all__ = ["assembly"]

_CHUNK = 400
"""Operations in one LLVM function: the time to compile grows faster than linearly in them."""

_MOST_ON_STACK = 4096
"""Numbers handed from chunk to chunk on the stack; more are kept elsewhere."""

_INPUTS = {STATE: "x", PARAMETER: "p", SETTING: "m"}

_ARGUMENTS = "ptr noalias %x, ptr noalias %p, double %t, ptr noalias %m, ptr noalias %out"

_FLOAT = {ca.OP_ADD: "fadd", ca.OP_SUB: "fsub", ca.OP_MUL: "fmul", ca.OP_DIV: "fdiv"}
_COMPARED = {ca.OP_LT: "olt", ca.OP_LE: "ole", ca.OP_EQ: "oeq", ca.OP_NE: "une"}
_INTRINSIC = {
    ca.OP_FABS: "fabs",
    ca.OP_SQRT: "sqrt",
    ca.OP_FMIN: "minnum",
    ca.OP_FMAX: "maxnum",
    ca.OP_COPYSIGN: "copysign",
}
_LIBRARY = {
    getattr(ca, f"OP_{name.upper()}"): name
    for name in (
        *("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh"),
        *("asinh", "acosh", "atanh", "exp", "expm1", "log", "log1p", "erf"),
        *("floor", "ceil", "atan2", "hypot", "pow", "fmod", "remainder"),
    )
} | {ca.OP_CONSTPOW: "pow"}
_TWO = {
    *_FLOAT,
    *_COMPARED,
    *(ca.OP_AND, ca.OP_OR, ca.OP_IF_ELSE_ZERO, ca.OP_FMIN, ca.OP_FMAX, ca.OP_COPYSIGN),
    *(ca.OP_ATAN2, ca.OP_HYPOT, ca.OP_POW, ca.OP_CONSTPOW, ca.OP_FMOD, ca.OP_REMAINDER),
}


def assembly(function: Operations, name: str) -> str:
    """LLVM assembly of a function.

    Raises
    ------
    UnsupportedError
        If it has an operation that is not known here.
    """
    rows = function.table.tolist()
    live = _live(rows)
    work, parts = function.work, []
    count = max(1, -(-len(rows) // _CHUNK))
    needed: set[str] = set()
    for k in range(count):
        part = rows[k * _CHUNK : (k + 1) * _CHUNK]
        after = live[min((k + 1) * _CHUNK, len(rows))]
        body = _body(part, function.constants.tolist(), after, needed)
        parts.append(
            f"define internal void @{name}_{k}({_ARGUMENTS}, ptr noalias %w) noinline {{\n"
            + "\n".join(body)
            + "\n  ret void\n}"
        )
    passed = "ptr %x, ptr %p, double %t, ptr %m, ptr %out, ptr %w"
    calls = "\n".join(f"  call void @{name}_{k}({passed})" for k in range(count))
    begin, end = f"  %w = alloca [{work} x double], align 64\n", ""
    if work > _MOST_ON_STACK:
        begin, end = f"  %w = call ptr @malloc(i64 {8 * work})\n", "\n  call void @free(ptr %w)"
        needed |= {"declare ptr @malloc(i64)", "declare void @free(ptr)"}
    whole = f"define void @{name}({_ARGUMENTS}) {{\n{begin}{calls}{end}\n  ret void\n}}"
    declared = "\n".join(sorted(needed))
    return "\n".join([*parts, whole, declared])


def _live(rows: list[list[int]]) -> dict[int, set[int]]:
    """Places of the work vector that are still read, where a chunk ends."""
    held: set[int] = set()
    found = {len(rows): set(held)}
    for k in range(len(rows) - 1, -1, -1):
        op, written, *read = rows[k]
        if op == RESULT:
            held.add(read[0])
        else:
            held.discard(written)
            if op > RESULT and op != ca.OP_CONST:
                held.update(read)
        if k % _CHUNK == 0:
            found[k] = set(held)
    return found


def _body(
    rows: list[list[int]], constants: list[float], live: set[int], needed: set[str]
) -> list[str]:
    """Instructions of a chunk."""
    text: list[str] = []
    held: dict[int, str] = {}
    changed: set[int] = set()
    fresh = iter(range(10 * len(rows) + 10 * len(live) + 100))

    def put(expression: str) -> str:
        symbol = f"%v{next(fresh)}"
        text.append(f"  {symbol} = {expression}")
        return symbol

    def at(base: str, index: int) -> str:
        return put(f"getelementptr inbounds double, ptr %{base}, i64 {index}")

    def get(place: int) -> str:
        if place not in held:
            held[place] = put(f"load double, ptr {at('w', place)}")
        return held[place]

    for op, written, a, b in rows:
        if op == RESULT:
            text.append(f"  store double {get(a)}, ptr {at('out', written)}")
            continue
        if op == ca.OP_CONST:
            found = literal(constants[a])
        elif op == TIME:
            found = "%t"
        elif op in _INPUTS:
            found = put(f"load double, ptr {at(_INPUTS[op], a)}")
        else:
            arguments = [get(place) for place in ((a, b) if op in _TWO else (a,))]
            found = _operation(op, arguments, put, needed)
        held[written] = found
        changed.add(written)
    for place in sorted(changed & live):
        text.append(f"  store double {held[place]}, ptr {at('w', place)}")
    return text


def _operation(op: int, arguments: list[str], put: Callable[[str], str], needed: set[str]) -> str:
    """One operation."""
    a = arguments[0]
    b = arguments[-1]
    zero, one = literal(0.0), literal(1.0)

    def truth(symbol: str) -> str:
        return put(f"fcmp une double {symbol}, {zero}")

    def real(condition: str) -> str:
        return put(f"uitofp i1 {condition} to double")

    if op in _FLOAT:
        return put(f"{_FLOAT[op]} double {a}, {b}")
    if op in _COMPARED:
        return real(put(f"fcmp {_COMPARED[op]} double {a}, {b}"))
    if op in _INTRINSIC or op in _LIBRARY:
        name = f"llvm.{_INTRINSIC[op]}.f64" if op in _INTRINSIC else _LIBRARY[op]
        needed.add(f"declare double @{name}({', '.join(['double'] * len(arguments))})")
        return put(f"call double @{name}({', '.join(f'double {s}' for s in arguments)})")
    if op in (ca.OP_ASSIGN, ca.OP_LIFT):
        return a
    if op == ca.OP_NEG:
        return put(f"fneg double {a}")
    if op == ca.OP_SQ:
        return put(f"fmul double {a}, {a}")
    if op == ca.OP_TWICE:
        return put(f"fadd double {a}, {a}")
    if op == ca.OP_INV:
        return put(f"fdiv double {one}, {a}")
    if op == ca.OP_NOT:
        return real(put(f"fcmp oeq double {a}, {zero}"))
    if op in (ca.OP_AND, ca.OP_OR):
        kind = "and" if op == ca.OP_AND else "or"
        return real(put(f"{kind} i1 {truth(a)}, {truth(b)}"))
    if op == ca.OP_IF_ELSE_ZERO:
        return put(f"select i1 {truth(a)}, double {b}, double {zero}")
    if op == ca.OP_SIGN:
        sign = put(f"select i1 {put(f'fcmp ogt double {a}, {zero}')}, double {one}, double {a}")
        low = put(f"fcmp olt double {a}, {zero}")
        return put(f"select i1 {low}, double {literal(-1.0)}, double {sign}")
    raise UnsupportedError(f"operation {op} of CasADi")
