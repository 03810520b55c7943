"""Functions of a plant as LLVM assembly.

A function becomes ``void name(const double* x, const double* p, double t, const double* m,
double* out)``. Operations keep their order and rounding. For several lanes each number is a vector
of as many, and the time is handed over by its address. A function of columns is linear in its last
states, which are vectors, as its results are; all else are single numbers. Of its last results only
the first half of the columns is given.
"""

from __future__ import annotations

import ast
import sys
from typing import Any

import casadi as ca

from lumped.code.llvm_words import literal
from lumped.code.operations import (
    FORMULAS,
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

_CHUNK = 400
"""Operations in one LLVM function: the time to compile grows faster than linearly in them."""

_MOST_ON_STACK = 4096
"""Numbers handed from chunk to chunk on the stack; more are kept elsewhere."""

_INPUTS = {STATE: "x", PARAMETER: "p", SETTING: "m"}

ARGUMENTS = "ptr noalias %x, ptr noalias %p, {} %t, ptr noalias %m, ptr noalias %out"

_NUMBER = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
_ORDER = {ast.Lt: "olt", ast.LtE: "ole", ast.Gt: "ogt", ast.Eq: "oeq", ast.NotEq: "une"}
_INTRINSIC = {"abs": "fabs", "fmin": "minnum", "fmax": "maxnum"}
_INTRINSIC |= {name: name for name in ("sqrt", "copysign", "floor", "ceil")}
_PARSED = {op: ast.parse(text, mode="eval").body for op, text in FORMULAS.items()}


def assembly(
    function: Operations,
    name: str,
    lanes: int = 1,
    columns_from: int | None = None,
    halved_from: int = 0,
    *,
    in_one: bool = False,
) -> str:
    """LLVM assembly of a function.

    Parameters
    ----------
    columns_from : int, optional
        The first of the states that have several columns, as many as lanes.
    halved_from : int
        The first of the results of which half of the columns is given.
    in_one : bool
        Whether it is one piece however long it is: slower to compile, faster to run.

    Raises
    ------
    UnsupportedError
        If it has an operation that is not known here.
    """
    rows, constants = function.table.tolist(), function.constants.tolist()
    work, parts = function.work, []
    needed: set[str] = set()
    time = "double" if lanes == 1 or columns_from is not None else "ptr"
    given = ARGUMENTS.format(time)
    wide: set[int] = set()
    for k, (part, after) in enumerate(split_in_parts(rows, sys.maxsize if in_one else _CHUNK)):
        body = Body(constants, needed, lanes)
        if columns_from is not None:
            body = _ColumnBody(constants, needed, lanes, columns_from, halved_from, wide)
        lines = body.lines(part, after)
        parts.append(
            f"define internal void @{name}_{k}({given}, ptr noalias %w) noinline {{\n"
            + "\n".join(lines)
            + "\n  ret void\n}"
        )
    passed = f"ptr %x, ptr %p, {time} %t, ptr %m, ptr %out, ptr %w"
    calls = "\n".join(f"  call void @{name}_{k}({passed})" for k in range(len(parts)))
    begin, end = make_room("w", work * lanes, work * lanes <= _MOST_ON_STACK, needed)
    whole = f"define void @{name}({given}) {{\n{begin}\n{calls}\n{end}  ret void\n}}"
    declared = "\n".join(sorted(needed))
    return "\n".join([*parts, whole, declared])


def make_room(symbol: str, count: int, on_stack: bool, needed: set[str]) -> tuple[str, str]:
    """Instructions that make room for numbers, and that free it."""
    if on_stack:
        return f"  %{symbol} = alloca [{count} x double], align 64", ""
    needed.update(("declare ptr @malloc(i64)", "declare void @free(ptr)"))
    begin = f"  %{symbol} = call ptr @malloc(i64 {8 * count})"
    return begin, f"  call void @free(ptr %{symbol})\n"


class Body:
    """Instructions of a chunk.

    Parameters
    ----------
    constants : list of float
    needed : set of str
        Takes the declarations of what it calls.
    lanes : int
        Numbers side by side.
    """

    def __init__(self, constants: list[float], needed: set[str], lanes: int) -> None:
        self._constants, self._needed = constants, needed
        self._text: list[str] = []
        self._count = 0
        self._set_lanes(lanes)

    def _set_lanes(self, lanes: int) -> None:
        """Write instructions for so many numbers side by side."""
        self._lanes = lanes
        self._number = "double" if lanes == 1 else f"<{lanes} x double>"
        self._truth = "i1" if lanes == 1 else f"<{lanes} x i1>"
        self._suffix = "f64" if lanes == 1 else f"v{lanes}f64"

    def lines(self, rows: list[list[int]], live: set[int]) -> list[str]:
        """Instructions of operations; those of the places that are still read are kept."""
        held: dict[int, str] = {}
        changed: set[int] = set()

        def get(place: int) -> str:
            if place not in held:
                held[place] = self._load_kept(place)
            return held[place]

        for op, written, a, b in rows:
            if op == RESULT:
                self._give(get(a), written)
                continue
            if op == ca.OP_CONST:
                found = self._constant(self._constants[a])
            elif op == TIME:
                found = "%t" if self._lanes == 1 else self._load("t", 0)
            elif op in _INPUTS:
                found = self._input(_INPUTS[op], a)
            else:
                arguments = [get(place) for place in places_read(op, a, b)]
                found = self._operation(op, arguments)
            held[written] = found
            changed.add(written)
        for place in sorted(changed & live):
            self._keep(held[place], place)
        return self._text

    def _load_kept(self, place: int) -> str:
        """A number that a chunk before this one has kept."""
        return self._load("w", place)

    def _keep(self, value: str, place: int) -> None:
        self._store(value, "w", place)

    def _give(self, value: str, place: int) -> None:
        """Write a result."""
        self._store(value, "out", place)

    def _input(self, base: str, index: int) -> str:
        return self._load(base, index)

    def _put(self, expression: str) -> str:
        symbol = f"%v{self._count}"
        self._count += 1
        self._text.append(f"  {symbol} = {expression}")
        return symbol

    def _at(self, base: str, index: int) -> str:
        return self._put(f"getelementptr inbounds {self._number}, ptr %{base}, i64 {index}")

    def _load(self, base: str, index: int) -> str:
        return self._put(f"load {self._number}, ptr {self._at(base, index)}, align 8")

    def _store(self, value: str, base: str, index: int) -> None:
        place = self._at(base, index)
        self._text.append(f"  store {self._number} {value}, ptr {place}, align 8")

    def _constant(self, value: float) -> str:
        if self._lanes == 1:
            return literal(value)
        return f"<{', '.join([f'double {literal(value)}'] * self._lanes)}>"

    def _spread(self, number: str, lanes: int) -> str:
        """A single number in all lanes."""
        if lanes == 1:
            return number
        kind, zeros = f"<{lanes} x double>", f"<{lanes} x i32> zeroinitializer"
        one = self._put(f"insertelement {kind} undef, double {number}, i32 0")
        return self._put(f"shufflevector {kind} {one}, {kind} undef, {zeros}")

    def _select(self, condition: str, yes: str, no: str) -> str:
        kind = self._number
        return self._put(f"select {self._truth} {condition}, {kind} {yes}, {kind} {no}")

    def _intrinsic(self, name: str, arguments: list[str]) -> str:
        symbol, kind = f"llvm.{name}.{self._suffix}", self._number
        self._needed.add(f"declare {kind} @{symbol}({', '.join([kind] * len(arguments))})")
        return self._put(f"call {kind} @{symbol}({', '.join(f'{kind} {s}' for s in arguments)})")

    def _library(self, name: str, arguments: list[str]) -> str:
        """A function of the C library, for one lane after the other."""
        self._needed.add(f"declare double @{name}({', '.join(['double'] * len(arguments))})")
        if self._lanes == 1:
            return self._put(f"call double @{name}({', '.join(f'double {s}' for s in arguments)})")
        found = "undef"
        for lane in range(self._lanes):
            own = [self._put(f"extractelement {self._number} {s}, i32 {lane}") for s in arguments]
            one = self._put(f"call double @{name}({', '.join(f'double {s}' for s in own)})")
            found = self._put(f"insertelement {self._number} {found}, double {one}, i32 {lane}")
        return found

    def _operation(self, op: int, arguments: list[str]) -> str:
        """One operation."""
        if op not in _PARSED:
            raise UnsupportedError(f"operation {op} of CasADi")
        return self._formula(_PARSED[op], {"a": arguments[0], "b": arguments[-1]})

    def _formula(self, node: Any, held: dict[str, str]) -> str:
        """A number or, of a comparison, a truth; nothing branches."""
        if isinstance(node, ast.Name):
            return held[node.id]
        if isinstance(node, ast.Constant):
            assert isinstance(node.value, float)
            return self._constant(node.value)
        parts = [self._formula(part, held) for part in _parts(node)]
        listed = f"{self._number} {', '.join(parts)}"
        if isinstance(node, ast.UnaryOp):
            return self._put(f"fneg {listed}")
        if isinstance(node, ast.BinOp):
            return self._put(f"{_NUMBER[type(node.op)]} {listed}")
        if isinstance(node, ast.Compare):
            return self._put(f"fcmp {_ORDER[type(node.ops[0])]} {listed}")
        if isinstance(node, ast.BoolOp):
            word = "and" if isinstance(node.op, ast.And) else "or"
            return self._put(f"{word} {self._truth} {', '.join(parts)}")
        if isinstance(node, ast.IfExp):
            return self._select(*parts)
        if (name := node.func.id) in _INTRINSIC:
            return self._intrinsic(_INTRINSIC[name], parts)
        if name in OWN:
            return self._put(f"call {self._number} @{name}({listed})")
        return self._library(name, parts)


def _parts(node: Any) -> list[ast.expr]:
    """What a formula is made of."""
    if isinstance(node, ast.UnaryOp):
        return [node.operand]
    if isinstance(node, ast.BinOp | ast.Compare):
        return [node.left, *(node.comparators if isinstance(node, ast.Compare) else [node.right])]
    if isinstance(node, ast.IfExp):
        return [node.test, node.body, node.orelse]
    return node.values if isinstance(node, ast.BoolOp) else node.args


class _ColumnBody(Body):
    """Instructions of a chunk, in which only what depends on columns is wide.

    Parameters
    ----------
    constants, needed, lanes
        As for `Body`.
    columns_from, halved_from : int
        The first of the states that have columns; of the results of which half of them is given.
    wide : set of int
        Places kept for later chunks that hold wide numbers.
    """

    def __init__(
        self,
        constants: list[float],
        needed: set[str],
        lanes: int,
        columns_from: int,
        halved_from: int,
        wide: set[int],
    ) -> None:
        super().__init__(constants, needed, 1)
        self._columns, self._from, self._wide_places = lanes, columns_from, wide
        self._halved_from = halved_from
        self._wide: set[str] = set()

    def _widen(self, value: str) -> str:
        return value if value in self._wide else self._spread(value, self._columns)

    def _load_one(self, base: str, index: int, is_wide: bool) -> str:
        kind = f"<{self._columns} x double>" if is_wide else "double"
        found = self._put(f"load {kind}, ptr {self._at(base, index)}, align 8")
        if is_wide:
            self._wide.add(found)
        return found

    def _store_one(self, value: str, base: str, place: int, is_wide: bool) -> None:
        kind = f"<{self._columns} x double>" if is_wide else "double"
        at = self._at(base, self._columns * place)
        self._text.append(f"  store {kind} {value}, ptr {at}, align 8")

    def _load_kept(self, place: int) -> str:
        return self._load_one("w", self._columns * place, place in self._wide_places)

    def _keep(self, value: str, place: int) -> None:
        is_wide = value in self._wide
        (self._wide_places.add if is_wide else self._wide_places.discard)(place)
        self._store_one(value, "w", place, is_wide)

    def _give(self, value: str, place: int) -> None:
        value, columns = self._widen(value), self._columns
        if place < self._halved_from:
            self._store_one(value, "out", place, True)
            return
        half = columns // 2
        kept = ", ".join(f"i32 {k}" for k in range(half))
        kind = f"<{columns} x double>"
        first = self._put(f"shufflevector {kind} {value}, {kind} undef, <{half} x i32> <{kept}>")
        at = self._at("out", columns * self._halved_from + half * (place - self._halved_from))
        self._text.append(f"  store <{half} x double> {first}, ptr {at}, align 8")

    def _input(self, base: str, index: int) -> str:
        is_wide = base == "x" and index >= self._from
        first = self._from + self._columns * (index - self._from)
        return self._load_one(base, first if is_wide else index, is_wide)

    def _operation(self, op: int, arguments: list[str]) -> str:
        if not any(a in self._wide for a in arguments):
            return super()._operation(op, arguments)
        given = [self._widen(a) for a in arguments]
        self._set_lanes(self._columns)
        found = super()._operation(op, given)
        self._set_lanes(1)
        self._wide.add(found)
        return found
