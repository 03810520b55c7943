"""CasADi functions of scalar operations as LLVM assembly.

A function becomes ``void name(const double* x, const double* p, double t, const double* m,
double* out)``: four inputs as those of a `System`, the third a scalar, and the nonzeros of all
outputs one after the other. Operations keep their order and rounding.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

import casadi as ca

__all__ = ["UnsupportedError", "assembly", "literal"]

_CHUNK = 400
"""Operations in one LLVM function: the time to compile grows faster than linearly in them."""

_MOST_ON_STACK = 4096
"""Numbers that are handed from chunk to chunk; more than these are kept elsewhere."""

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


class UnsupportedError(Exception):
    """An operation that has no machine code here."""


def assembly(function: ca.Function, name: str) -> str:
    """LLVM assembly of a function (x, p, t, m) -> results.

    Raises
    ------
    UnsupportedError
        If the function is not made of scalar operations only.
    """
    if function.n_in() != 4 or not function.is_a("SXFunction"):
        raise UnsupportedError(f"{function.name()}: not a function of scalar operations")
    lines = _instructions(function)
    live = _live(lines)
    offsets, total = [], 0
    for i in range(function.n_out()):
        offsets.append(total)
        total += function.nnz_out(i)
    work, parts = max(function.sz_w(), 1), []
    count = max(1, -(-len(lines) // _CHUNK))
    needed: set[str] = set()
    for k in range(count):
        part = lines[k * _CHUNK : (k + 1) * _CHUNK]
        body = _body(part, live[min((k + 1) * _CHUNK, len(lines))], offsets, needed, k)
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


def _instructions(f: ca.Function) -> list[tuple[int, list[int], list[int], float]]:
    """Operation, places of arguments and results, constant of each instruction."""
    found = []
    for k in range(f.n_instructions()):
        op = f.instruction_id(k)
        value = f.instruction_constant(k) if op == ca.OP_CONST else 0.0
        found.append((op, f.instruction_input(k), f.instruction_output(k), value))
    return found


def _live(lines: list[tuple[int, list[int], list[int], float]]) -> dict[int, set[int]]:
    """Places that are still read, where a chunk ends."""
    held: set[int] = set()
    found = {len(lines): set(held)}
    for k in range(len(lines) - 1, -1, -1):
        op, read, written, _ = lines[k]
        if op != ca.OP_OUTPUT:
            held.discard(written[0])
        if op not in (ca.OP_INPUT, ca.OP_CONST):
            held.update(read)
        if k % _CHUNK == 0:
            found[k] = set(held)
    return found


def _body(
    lines: list[tuple[int, list[int], list[int], float]],
    live: set[int],
    offsets: list[int],
    needed: set[str],
    chunk: int,
) -> list[str]:
    """Instructions of a chunk."""
    text: list[str] = []
    held: dict[int, str] = {}
    changed: set[int] = set()
    fresh = iter(range(10 * len(lines) + 10 * len(live) + 100))

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

    for op, read, written, value in lines:
        if op == ca.OP_OUTPUT:
            text.append(
                f"  store double {get(read[0])}, ptr {at('out', offsets[written[0]] + written[1])}"
            )
            continue
        if op == ca.OP_CONST:
            found = literal(value)
        elif op == ca.OP_INPUT:
            base = "xptm"[read[0]]
            found = "%t" if base == "t" else put(f"load double, ptr {at(base, read[1])}")
        else:
            arguments = [get(place) for place in read[: 2 if op in _TWO else 1]]
            found = _operation(op, arguments, put, needed)
        held[written[0]] = found
        changed.add(written[0])
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


def literal(value: float) -> str:
    """A number in LLVM assembly, to the last digit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"
