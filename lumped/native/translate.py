"""A small part of Python as LLVM assembly.

Functions take and give integers, numbers, truth values and addresses. There are assignments,
``if``, ``while``, ``for`` over a range, arithmetic, comparisons and calls; integers are not
negative where they are divided. A name that is not assigned to is a constant of its module: a
number, a tuple of numbers or another function of this kind. Operations keep their order and
rounding.
"""

from __future__ import annotations

import ast
import math
import struct
import textwrap
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from lumped.native import words
from lumped.native.words import Kernel

__all__ = ["TranslationError", "translated"]

_KINDS = {"int": "i64", "float": "double", "bool": "i1", "Integers": "ints", "Numbers": "reals"}
_INTEGER = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.BitAnd: "and", ast.BitOr: "or"}
_INTEGER |= {ast.FloorDiv: "sdiv", ast.Mod: "srem"}
_REAL = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
_ORDER = {ast.Lt: "lt", ast.LtE: "le", ast.Gt: "gt", ast.GtE: "ge", ast.Eq: "eq", ast.NotEq: "ne"}
_ELEMENT = {"ints": "i64", "reals": "double"}
_DECLARED = "\n".join(
    f"declare double @llvm.{name}.f64({', '.join(['double'] * count)})"
    for name, count in (("fabs", 1), ("sqrt", 1), ("pow", 2))
)


class TranslationError(Exception):
    """Something that the language does not have."""


class _Value(NamedTuple):
    text: str
    kind: str


def translated(functions: Mapping[str, Callable[..., object]]) -> str:
    """LLVM assembly of functions and all that they call; they are visible under these symbols."""
    kernels: Any = list(functions.values())
    found: dict[str, str] = {}
    waiting: list[Kernel] = list(kernels)
    while waiting:
        now = waiting.pop()
        if now.name not in found:
            own = _Translator(now)
            found[now.name] = own.text("" if now in kernels else "internal ")
            waiting += own.called
    text = "\n".join([*found.values(), _DECLARED])
    for symbol, kernel in zip(functions, kernels, strict=True):
        text = text.replace(f'@"{kernel.name}"', f"@{symbol}")
    return text


def _ir(kind: str) -> str:
    return "ptr" if kind in _ELEMENT else kind


class _Translator:
    """One function."""

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self.called: list[Kernel] = []
        tree = ast.parse(textwrap.dedent(kernel.source)).body[0]
        assert isinstance(tree, ast.FunctionDef)
        self.tree = tree
        self.lines: list[str] = []
        self.head: list[str] = []
        self.constants: list[str] = []
        self.places: dict[str, _Value] = {}
        self.loops: list[tuple[str, str]] = []
        self.count = 0

    def text(self, linkage: str) -> str:
        given = []
        for argument in self.tree.args.args:
            kind = self._annotated(argument.annotation)
            given.append(f"{_ir(kind)} %{argument.arg}")
            self._store(argument.arg, _Value(f"%{argument.arg}", kind))
        self.result = self._annotated(self.tree.returns)
        self._block(self.tree.body)
        self.lines.append("  ret void" if self.result == "void" else "  unreachable")
        head = f'define {linkage}{_ir(self.result)} @"{self.kernel.name}"({", ".join(given)}) {{'
        body = "\n".join(["entry:", *self.head, *self.lines, "}"])
        return "\n".join([*self.constants, head, body])

    def _annotated(self, node: ast.expr | None) -> str:
        if node is None or (isinstance(node, ast.Constant) and node.value is None):
            return "void"
        return _KINDS[ast.unparse(node)]

    # -- writing ---------------------------------------------------------------------------

    def _fresh(self, word: str = "v") -> str:
        self.count += 1
        return f"{word}.{self.count}"

    def _put(self, expression: str, kind: str) -> _Value:
        symbol = f"%{self._fresh()}"
        self.lines.append(f"  {symbol} = {expression}")
        return _Value(symbol, kind)

    def _label(self, label: str) -> None:
        self.lines.append(f"{label}:")

    def _jump(self, label: str) -> None:
        self.lines.append(f"  br label %{label}")
        self._label(self._fresh("after"))  # what follows a jump is never reached

    def _enter(self, label: str) -> None:
        self.lines.append(f"  br label %{label}")
        self._label(label)

    def _branch(self, node: ast.expr, yes: str, no: str) -> None:
        condition = self._as(self._value(node), "i1")
        self.lines.append(f"  br i1 {condition.text}, label %{yes}, label %{no}")

    def _place(self, kind: str) -> str:
        symbol = f"%{self._fresh('place')}"
        self.head.append(f"  {symbol} = alloca {_ir(kind)}")
        return symbol

    def _store(self, name: str, value: _Value) -> None:
        if name not in self.places:
            self.places[name] = _Value(self._place(value.kind), value.kind)
        place = self.places[name]
        value = self._as(value, place.kind)
        self.lines.append(f"  store {_ir(place.kind)} {value.text}, ptr {place.text}")

    def _as(self, value: _Value, kind: str) -> _Value:
        """The value as another kind."""
        if value.kind == kind:
            return value
        if (value.kind, kind) == ("i1", "i64"):
            return self._put(f"zext i1 {value.text} to i64", kind)
        if (value.kind, kind) == ("i64", "double"):
            return self._put(f"sitofp i64 {value.text} to double", kind)
        if (value.kind, kind) == ("i64", "i1"):
            return self._put(f"icmp ne i64 {value.text}, 0", kind)
        raise TranslationError(f"{self.kernel.name}: a {value.kind} where a {kind} is needed")

    def _unknown(self, node: ast.AST) -> TranslationError:
        return TranslationError(f"{self.kernel.name}: {ast.unparse(node)}")

    # -- statements ------------------------------------------------------------------------

    def _block(self, body: list[ast.stmt]) -> None:
        for node in body:
            self._statement(node)

    def _statement(self, node: ast.stmt) -> None:
        if isinstance(node, ast.Assign):
            self._assign(node)
        elif isinstance(node, ast.AugAssign):
            old = ast.unparse(node.target)
            now = ast.BinOp(ast.parse(old, mode="eval").body, node.op, node.value)
            self._set(node.target, self._value(now))
        elif isinstance(node, ast.If):
            yes, no, end = (self._fresh(w) for w in ("yes", "no", "end"))
            self._branch(node.test, yes, no)
            for label, body in ((yes, node.body), (no, node.orelse)):
                self._label(label)
                self._block(body)
                self.lines.append(f"  br label %{end}")
            self._label(end)
        elif isinstance(node, ast.While):
            self._while(node)
        elif isinstance(node, ast.For):
            self._for(node)
        elif isinstance(node, ast.Return):
            if node.value is None:
                self.lines.append("  ret void")
            else:
                value = self._as(self._value(node.value), self.result)
                self.lines.append(f"  ret {_ir(self.result)} {value.text}")
            self._label(self._fresh("after"))
        elif isinstance(node, ast.Break | ast.Continue):
            self._jump(self.loops[-1][isinstance(node, ast.Continue)])
        elif isinstance(node, ast.Expr):
            if not isinstance(node.value, ast.Constant):
                self._value(node.value)
        elif not isinstance(node, ast.Pass):
            raise self._unknown(node)

    def _assign(self, node: ast.Assign) -> None:
        first = node.targets[0]
        if isinstance(first, ast.Tuple) and isinstance(node.value, ast.Tuple):
            found = [self._value(part) for part in node.value.elts]
            for target, value in zip(first.elts, found, strict=True):
                self._set(target, value)
            return
        value = self._value(node.value)
        for target in node.targets:
            self._set(target, value)

    def _set(self, target: ast.expr, value: _Value) -> None:
        if isinstance(target, ast.Name):
            self._store(target.id, value)
        elif isinstance(target, ast.Subscript):
            place = self._element(target)
            value = self._as(value, place.kind)
            self.lines.append(f"  store {place.kind} {value.text}, ptr {place.text}")
        else:
            raise self._unknown(target)

    def _while(self, node: ast.While) -> None:
        test, body, end = (self._fresh(w) for w in ("test", "body", "end"))
        self._enter(test)
        self._branch(node.test, body, end)
        self._label(body)
        self.loops.append((end, test))
        self._block(node.body)
        self.loops.pop()
        self.lines.append(f"  br label %{test}")
        self._label(end)

    def _for(self, node: ast.For) -> None:
        assert isinstance(node.target, ast.Name)
        assert isinstance(node.iter, ast.Call)
        bounds = [self._value(argument) for argument in node.iter.args]
        begin = bounds[0] if len(bounds) > 1 else _Value("0", "i64")
        stop = bounds[min(1, len(bounds) - 1)].text
        step = bounds[2].text if len(bounds) > 2 else "1"
        test, body, following, end = (self._fresh(w) for w in ("test", "body", "next", "end"))
        name = node.target.id
        self._store(name, begin)
        self._enter(test)
        now = self._load(name)
        order = "sgt" if step.startswith("-") else "slt"
        more = self._put(f"icmp {order} i64 {now.text}, {stop}", "i1")
        self.lines.append(f"  br i1 {more.text}, label %{body}, label %{end}")
        self._label(body)
        self.loops.append((end, following))
        self._block(node.body)
        self.loops.pop()
        self._enter(following)
        self._store(name, self._put(f"add nsw i64 {self._load(name).text}, {step}", "i64"))
        self.lines.append(f"  br label %{test}")
        self._label(end)

    # -- values ----------------------------------------------------------------------------

    def _load(self, name: str) -> _Value:
        place = self.places[name]
        return self._put(f"load {_ir(place.kind)}, ptr {place.text}", place.kind)

    def _element(self, node: ast.Subscript) -> _Value:
        """Where an element stands, and of what kind it is."""
        index = self._as(self._value(node.slice), "i64")
        if isinstance(node.value, ast.Name) and node.value.id not in self.places:
            base, kind = self._table(node.value.id), "double"
        else:
            pointer = self._value(node.value)
            base, kind = pointer.text, _ELEMENT[pointer.kind]
        place = self._put(f"getelementptr inbounds {kind}, ptr {base}, i64 {index.text}", kind)
        return _Value(place.text, kind)

    def _table(self, name: str) -> str:
        """A tuple of numbers of the module."""
        numbers = self.kernel.space[name]
        symbol = f'@"{self.kernel.name}.{name}"'
        listed = ", ".join(f"double {_number(value)}" for value in numbers)
        text = f"{symbol} = private constant [{len(numbers)} x double] [{listed}]"
        if text not in self.constants:
            self.constants.append(text)
        return symbol

    def _value(self, node: ast.expr) -> _Value:
        if isinstance(node, ast.Name) and node.id in self.places:
            return self._load(node.id)
        if isinstance(node, ast.Constant | ast.Name | ast.Attribute):
            return self._constant(node)
        if isinstance(node, ast.Subscript):
            place = self._element(node)
            return self._put(f"load {place.kind}, ptr {place.text}", place.kind)
        if isinstance(node, ast.BinOp):
            return self._binary(node)
        if isinstance(node, ast.UnaryOp):
            return self._unary(node)
        if isinstance(node, ast.Compare):
            return self._comparison(node)
        if isinstance(node, ast.BoolOp):
            return self._logical(node)
        if isinstance(node, ast.IfExp):
            return self._choice(node)
        if isinstance(node, ast.Call):
            return self._call(node)
        raise self._unknown(node)

    def _constant(self, node: ast.Constant | ast.Name | ast.Attribute) -> _Value:
        value = eval(ast.unparse(node), self.kernel.space)
        if isinstance(value, bool):
            return _Value("true" if value else "false", "i1")
        if isinstance(value, int):
            return _Value(str(value), "i64")
        if isinstance(value, float):
            return _Value(_number(value), "double")
        raise self._unknown(node)

    def _binary(self, node: ast.BinOp) -> _Value:
        a, b = self._value(node.left), self._value(node.right)
        op: Any = type(node.op)
        if a.kind == b.kind == "i64" and op in _INTEGER:
            return self._put(f"{_INTEGER[op]} i64 {a.text}, {b.text}", "i64")
        a, b = self._as(a, "double"), self._as(b, "double")
        if op is ast.Pow:
            return self._intrinsic("pow", a, b)
        if op not in _REAL:
            raise self._unknown(node)
        return self._put(f"{_REAL[op]} double {a.text}, {b.text}", "double")

    def _unary(self, node: ast.UnaryOp) -> _Value:
        value = self._value(node.operand)
        if isinstance(node.op, ast.Not):
            return self._put(f"xor i1 {self._as(value, 'i1').text}, true", "i1")
        if isinstance(node.operand, ast.Constant):
            number = -eval(ast.unparse(node.operand))
            return _Value(_number(number) if value.kind == "double" else str(number), value.kind)
        if value.kind == "double":
            return self._put(f"fneg double {value.text}", "double")
        return self._put(f"sub i64 0, {value.text}", "i64")

    def _comparison(self, node: ast.Compare) -> _Value:
        if len(node.ops) > 1:
            raise self._unknown(node)
        a, b = self._value(node.left), self._value(node.comparators[0])
        return self._compared(_ORDER[type(node.ops[0])], a, b)

    def _compared(self, order: str, a: _Value, b: _Value) -> _Value:
        kind = "double" if "double" in (a.kind, b.kind) else "i64"
        kind = "i1" if a.kind == b.kind == "i1" else kind
        a, b = self._as(a, kind), self._as(b, kind)
        if kind == "double":
            word = "une" if order == "ne" else f"o{order}"
            return self._put(f"fcmp {word} double {a.text}, {b.text}", "i1")
        word = order if order in ("eq", "ne") else f"s{order}"
        return self._put(f"icmp {word} {kind} {a.text}, {b.text}", "i1")

    def _logical(self, node: ast.BoolOp) -> _Value:
        place, end = self._place("i1"), self._fresh("end")
        for part in node.values:
            value = self._as(self._value(part), "i1")
            self.lines.append(f"  store i1 {value.text}, ptr {place}")
            if part is not node.values[-1]:
                more = self._fresh("more")
                labels = (more, end) if isinstance(node.op, ast.And) else (end, more)
                self.lines.append(f"  br i1 {value.text}, label %{labels[0]}, label %{labels[1]}")
                self._label(more)
        self._enter(end)
        return self._put(f"load i1, ptr {place}", "i1")

    def _choice(self, node: ast.IfExp) -> _Value:
        yes, no, end = (self._fresh(w) for w in ("yes", "no", "end"))
        self._branch(node.test, yes, no)
        before, found = self.lines, []
        for part in (node.body, node.orelse):
            self.lines = []
            found.append((self._value(part), self.lines))
        kinds = {value.kind for value, _ in found}
        kind = kinds.pop() if len(kinds) == 1 else "double" if "double" in kinds else "i64"
        place = self._place(kind)
        for label, (value, lines) in zip((yes, no), found, strict=True):
            self.lines = lines
            value = self._as(value, kind)
            before += [f"{label}:", *lines, f"  store {_ir(kind)} {value.text}, ptr {place}"]
            before.append(f"  br label %{end}")
        self.lines = before
        self._label(end)
        return self._put(f"load {_ir(kind)}, ptr {place}", kind)

    def _intrinsic(self, name: str, *values: _Value) -> _Value:
        listed = ", ".join(f"double {self._as(value, 'double').text}" for value in values)
        return self._put(f"call double @llvm.{name}.f64({listed})", "double")

    def _call(self, node: ast.Call) -> _Value:
        word = eval(ast.unparse(node.func), self.kernel.space)
        values = [self._value(argument) for argument in node.args]
        if word is words.at:
            kind = values[0].kind
            place = f"getelementptr inbounds {_ELEMENT[kind]}, ptr {values[0].text}"
            return self._put(f"{place}, i64 {values[1].text}", kind)
        if word in (words.doubles, words.integers):
            kind = "reals" if word is words.doubles else "ints"
            return self._put(f"inttoptr i64 {values[0].text} to ptr", kind)
        if word is words.evaluate:
            address = self._put(f"inttoptr i64 {values[0].text} to ptr", "ptr")
            return self._called("void", address.text, values[1:])
        if word is math.sqrt:
            return self._intrinsic("sqrt", values[0])
        if word is abs:
            return self._intrinsic("fabs", values[0])
        if word is float:
            return self._as(values[0], "double")
        if word is int:
            return self._put(f"fptosi double {values[0].text} to i64", "i64")
        if word in (min, max):
            a, b = values
            kind = "double" if "double" in (a.kind, b.kind) else "i64"
            a, b = self._as(a, kind), self._as(b, kind)
            other = self._compared("lt" if word is min else "gt", b, a)
            return self._put(f"select i1 {other.text}, {kind} {b.text}, {kind} {a.text}", kind)
        if isinstance(word, Kernel):
            self.called.append(word)
            tree = ast.parse(textwrap.dedent(word.source)).body[0]
            assert isinstance(tree, ast.FunctionDef)
            kinds = [self._annotated(argument.annotation) for argument in tree.args.args]
            given = [self._as(v, k) for v, k in zip(values, kinds, strict=True)]
            return self._called(self._annotated(tree.returns), f'@"{word.name}"', given)
        raise self._unknown(node)

    def _called(self, kind: str, function: str, values: list[_Value]) -> _Value:
        listed = ", ".join(f"{_ir(value.kind)} {value.text}" for value in values)
        call = f"call {_ir(kind)} {function}({listed})"
        if kind == "void":
            self.lines.append(f"  {call}")
            return _Value("", "void")
        return self._put(call, kind)


def _number(value: float) -> str:
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"
