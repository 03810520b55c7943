"""The language of the time loop as LLVM assembly (see `translate`)."""

from __future__ import annotations

import ast
import struct
from collections.abc import Callable, Mapping
from typing import Any

from lumped.code.records import Field
from lumped.code.translate import TranslationError, Value, Writer, reached
from lumped.code.words import Kernel

__all__ = ["as_llvm", "literal"]

_TYPES = {"int": "i64", "float": "double", "bool": "i1", "void": "void"}
_ELEMENT = {"ints": ("i64", "int"), "numbers": ("double", "float")}
_INTEGER = {"+": "add", "-": "sub", "*": "mul", "/": "sdiv", "%": "srem"}
_NUMBER = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
_ORDER = {"<": "lt", "<=": "le", ">": "gt", ">=": "ge", "==": "eq", "!=": "ne"}
_INTRINSIC = {"sqrt": "sqrt", "fabs": "fabs", "pow": "pow", "copysign": "copysign"}
_INTRINSIC |= {"fmin": "minnum", "fmax": "maxnum"}
_LARGE = 40
"""Instructions above which a function is not inlined."""


def literal(value: float) -> str:
    """A number in LLVM assembly, to the last digit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


def as_llvm(functions: Mapping[str, Callable[..., object]]) -> str:
    """LLVM assembly of functions and all that they call; they are visible under these symbols."""
    kernels: Any = list(functions.values())
    found: list[_LlvmFunction] = reached(kernels, lambda k: _LlvmFunction(k, k in kernels))
    declared = sorted({line for function in found for line in function.declared})
    text = "\n".join([*(function.text for function in found), *declared])
    for symbol, kernel in zip(functions, kernels, strict=True):
        text = text.replace(f'@"{kernel.name}"', f"@{symbol}")
    return text


def _type(kind: Any) -> str:
    return _TYPES.get(kind, "ptr") if isinstance(kind, str) else "ptr"


class _LlvmFunction(Writer):
    """One function, instruction after instruction."""

    def __init__(self, kernel: Kernel, visible: bool = False) -> None:
        super().__init__(kernel)
        self.declared: set[str] = set()
        self._visible = visible
        self._lines: list[str] = []
        self._places: dict[str, str] = {}
        self._head: list[str] = []
        self._tables: list[str] = []
        self._loops: list[tuple[str, str]] = []
        self._count = 0

    @property
    def text(self) -> str:
        """LLVM assembly of the function."""
        linkage = "" if self._visible else "internal "
        given = ", ".join(f"{_type(kind)} %{name}" for name, kind in self.arguments)
        # inlining a large function gains nothing and takes long to compile
        apart = " noinline" if len(self._lines) > _LARGE else ""
        head = f'define {linkage}{_type(self.result)} @"{self.kernel.name}"({given}){apart} {{'
        return "\n".join([*self._tables, head, "entry:", *self._head, *self._lines, "}"])

    def read(self) -> None:
        """Write all instructions."""
        for name, kind in self.arguments:
            self.variables[name] = kind
            self.write_variable(name, Value(f"%{name}", kind))
        super().read()
        self._lines.append("  ret void" if self.result == "void" else "  unreachable")

    # -- blocks ------------------------------------------------------------------------------

    def _fresh(self, word: str = "v") -> str:
        self._count += 1
        return f"{word}.{self._count}"

    def _put(self, instruction: str, kind: Any) -> Value:
        symbol = f"%{self._fresh()}"
        self._lines.append(f"  {symbol} = {instruction}")
        return Value(symbol, kind)

    def _enter(self, label: str) -> None:
        self._lines += [f"  br label %{label}", f"{label}:"]

    def _branch(self, test: ast.expr, yes: str, no: str) -> None:
        condition = self.converted(self.value(test), "bool").text
        self._lines.append(f"  br i1 {condition}, label %{yes}, label %{no}")

    def _room(self, kind: Any) -> str:
        symbol = f"%{self._fresh('place')}"
        self._head.append(f"  {symbol} = alloca {_type(kind)}")
        return symbol

    def _store(self, value: Value, place: str) -> None:
        self._lines.append(f"  store {_type(value.kind)} {value.text}, ptr {place}")

    def _load(self, place: str, kind: Any) -> Value:
        return self._put(f"load {_type(kind)}, ptr {place}", kind)

    # -- statements --------------------------------------------------------------------------

    def write_if(self, test: ast.expr, yes: list[ast.stmt], no: list[ast.stmt]) -> None:
        labels = [self._fresh(word) for word in ("yes", "no", "end")]
        self._branch(test, *labels[:2])
        for label, body in zip(labels, (yes, no), strict=False):
            self._lines.append(f"{label}:")
            self.block(body)
            self._lines.append(f"  br label %{labels[2]}")
        self._lines.append(f"{labels[2]}:")

    def write_while(self, test: ast.expr, body: list[ast.stmt]) -> None:
        again, inside, end = (self._fresh(word) for word in ("test", "body", "end"))
        self._enter(again)
        self._branch(test, inside, end)
        self._lines.append(f"{inside}:")
        self._looped(end, again, body)
        self._lines += [f"  br label %{again}", f"{end}:"]

    def write_for(
        self, name: str, bounds: tuple[Value, Value, Value], down: bool, body: list[ast.stmt]
    ) -> None:
        begin, end, step = bounds
        again, inside, following, after = (
            self._fresh(word) for word in ("test", "body", "next", "end")
        )
        self.write_variable(name, begin)
        self._enter(again)
        more = self.compared(">" if down else "<", self.variable(name), end)
        self._lines.append(f"  br i1 {more.text}, label %{inside}, label %{after}")
        self._lines.append(f"{inside}:")
        self._looped(after, following, body)
        self._enter(following)
        self.write_variable(name, self.arithmetic("+", self.variable(name), step))
        self._lines += [f"  br label %{again}", f"{after}:"]

    def _looped(self, end: str, following: str, body: list[ast.stmt]) -> None:
        self._loops.append((end, following))
        self.block(body)
        self._loops.pop()

    def _leave(self, instruction: str) -> None:
        # code after a jump is never reached
        self._lines += [f"  {instruction}", f"{self._fresh('after')}:"]

    def write_return(self, value: Value | None) -> None:
        self._leave("ret void" if value is None else f"ret {_type(value.kind)} {value.text}")

    def write_break(self) -> None:
        self._leave(f"br label %{self._loops[-1][0]}")

    def write_continue(self) -> None:
        self._leave(f"br label %{self._loops[-1][1]}")

    def write_expression(self, value: Value) -> None:
        """Its instructions are written already."""

    def write_variable(self, name: str, value: Value) -> None:
        if name not in self._places:
            self._places[name] = self._room(value.kind)
        self._store(value, self._places[name])

    def write_element(self, base: Value, index: Value, value: Value) -> None:
        self._store(value, self.moved(base, index).text)

    def write_field(self, record: Value, field: Field, value: Value) -> None:
        self._store(value, self._word(record, field))

    # -- values ------------------------------------------------------------------------------

    def number(self, value: float) -> Value:
        if isinstance(value, bool):
            return Value("true" if value else "false", "bool")
        if isinstance(value, int):
            return Value(str(value), "int")
        return Value(literal(value), "float")

    def table(self, name: str, numbers: tuple[float, ...]) -> Value:
        symbol = f'@"{self.kernel.name}.{name}"'
        listed = ", ".join(f"double {literal(value)}" for value in numbers)
        text = f"{symbol} = private constant [{len(numbers)} x double] [{listed}]"
        if text not in self._tables:
            self._tables.append(text)
        return Value(symbol, "numbers")

    def variable(self, name: str) -> Value:
        return self._load(self._places[name], self.variables[name])

    def kept(self, value: Value) -> Value:
        return value

    def _word(self, record: Value, field: Field) -> str:
        return self._put(
            f"getelementptr inbounds i64, ptr {record.text}, i64 {field.place}", ""
        ).text

    def field(self, record: Value, field: Field) -> Value:
        return self._load(self._word(record, field), field.kind)

    def element(self, base: Value, index: Value) -> Value:
        return self._load(self.moved(base, index).text, _ELEMENT[base.kind][1])

    def moved(self, base: Value, offset: Value) -> Value:
        kind = _ELEMENT[base.kind][0]
        place = f"getelementptr inbounds {kind}, ptr {base.text}, i64 {offset.text}"
        return self._put(place, base.kind)

    def converted(self, value: Value, kind: Any) -> Value:
        if value.kind == kind:
            return value
        if (value.kind, kind) == ("bool", "int"):
            return self._put(f"zext i1 {value.text} to i64", kind)
        if (value.kind, kind) == ("int", "float"):
            return self._put(f"sitofp i64 {value.text} to double", kind)
        if (value.kind, kind) == ("int", "bool"):
            return self._put(f"icmp ne i64 {value.text}, 0", kind)
        raise TranslationError(f"{self.kernel.name}: a {value.kind} where a {kind} is needed")

    def truncated(self, value: Value) -> Value:
        return self._put(f"fptosi double {value.text} to i64", "int")

    def arithmetic(self, sign: str, a: Value, b: Value) -> Value:
        word = (_INTEGER if a.kind == "int" else _NUMBER)[sign]
        return self._put(f"{word} {_type(a.kind)} {a.text}, {b.text}", a.kind)

    def negative(self, value: Value) -> Value:
        if value.kind == "float":
            return self._put(f"fneg double {value.text}", "float")
        return self._put(f"sub i64 0, {value.text}", "int")

    def negated(self, value: Value) -> Value:
        return self._put(f"xor i1 {value.text}, true", "bool")

    def compared(self, order: str, a: Value, b: Value) -> Value:
        word = _ORDER[order]
        if a.kind == "float":
            word = "une" if word == "ne" else f"o{word}"
            return self._put(f"fcmp {word} double {a.text}, {b.text}", "bool")
        word = word if word in ("eq", "ne") else f"s{word}"
        return self._put(f"icmp {word} {_type(a.kind)} {a.text}, {b.text}", "bool")

    def logical(self, both: bool, parts: list[ast.expr]) -> Value:
        place, end = self._room("bool"), self._fresh("end")
        for part in parts:
            value = self.converted(self.value(part), "bool")
            self._store(value, place)
            if part is not parts[-1]:
                more = self._fresh("more")
                yes, no = (more, end) if both else (end, more)
                self._lines.append(f"  br i1 {value.text}, label %{yes}, label %{no}")
                self._lines.append(f"{more}:")
        self._enter(end)
        return self._load(place, "bool")

    def choice(self, test: ast.expr, yes: ast.expr, no: ast.expr) -> Value:
        labels = [self._fresh(word) for word in ("yes", "no", "end")]
        self._branch(test, *labels[:2])
        before, found = self._lines, []
        for part in (yes, no):
            self._lines = []
            found.append((self.value(part), self._lines))
        kinds = {value.kind for value, _ in found}
        kind = kinds.pop() if len(kinds) == 1 else "float" if "float" in kinds else "int"
        place = self._room(kind)
        for label, (value, lines) in zip(labels, found, strict=False):
            self._lines = lines
            self._store(self.converted(value, kind), place)
            before += [f"{label}:", *self._lines, f"  br label %{labels[2]}"]
        self._lines = before
        self._lines.append(f"{labels[2]}:")
        return self._load(place, kind)

    def extreme(self, least: bool, a: Value, b: Value) -> Value:
        other = self.compared("<" if least else ">", b, a)
        kind = _type(a.kind)
        return self._put(f"select i1 {other.text}, {kind} {b.text}, {kind} {a.text}", a.kind)

    def library(self, name: str, values: list[Value]) -> Value:
        symbol = f"llvm.{_INTRINSIC[name]}.f64" if name in _INTRINSIC else name
        self.declared.add(f"declare double @{symbol}({', '.join(['double'] * len(values))})")
        listed = ", ".join(f"double {value.text}" for value in values)
        return self._put(f"call double @{symbol}({listed})", "float")

    def called_kernel(self, kernel: Kernel, values: list[Value], result: Any) -> Value:
        return self._called(f'@"{kernel.name}"', values, result)

    def called_by_address(self, values: list[Value]) -> Value:
        address = self._put(f"inttoptr i64 {values[0].text} to ptr", "")
        return self._called(address.text, values[1:], "void")

    def _called(self, function: str, values: list[Value], result: Any) -> Value:
        listed = ", ".join(f"{_type(value.kind)} {value.text}" for value in values)
        text = f"call {_type(result)} {function}({listed})"
        if result == "void":
            self._lines.append(f"  {text}")
            return Value("", "void")
        return self._put(text, result)
