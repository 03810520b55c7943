"""Expressions of the language of the time loop as LLVM instructions (see `translate`)."""

from __future__ import annotations

import ast
import math
import textwrap
from typing import Any, NamedTuple

from lumped.kernel import words
from lumped.kernel.emit_llvm import literal
from lumped.kernel.words import Kernel

__all__ = ["Expressions", "TranslationError", "Value", "definition", "ir_type"]

_KINDS = {"int": "i64", "float": "double", "bool": "i1", "Integers": "ints", "Numbers": "reals"}
_INTEGER = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.BitAnd: "and", ast.BitOr: "or"}
_INTEGER |= {ast.FloorDiv: "sdiv", ast.Mod: "srem"}
_REAL = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
_ORDER = {ast.Lt: "lt", ast.LtE: "le", ast.Gt: "gt", ast.GtE: "ge", ast.Eq: "eq", ast.NotEq: "ne"}
_ELEMENT = {"ints": "i64", "reals": "double"}


class TranslationError(Exception):
    """Something that the language does not have."""


class Value(NamedTuple):
    """Text of a value in LLVM's assembly, and its kind: i64, double, i1, ints or reals."""

    text: str
    kind: str


def ir_type(kind: str) -> str:
    """LLVM's type of a kind."""
    return "ptr" if kind in _ELEMENT else kind


def definition(kernel: Kernel) -> ast.FunctionDef:
    """The syntax tree of a function."""
    tree = ast.parse(textwrap.dedent(kernel.source)).body[0]
    assert isinstance(tree, ast.FunctionDef)
    return tree


class Expressions:
    """Instructions of one function, written one after the other.

    Attributes
    ----------
    lines, head, constants : list of str
        Instructions, those at the begin of the function, and tables of numbers.
    places : dict of str to Value
        Where each variable is kept.
    called : list of Kernel
        What the function calls.
    """

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self.called: list[Kernel] = []
        self.lines: list[str] = []
        self.head: list[str] = []
        self.constants: list[str] = []
        self.places: dict[str, Value] = {}
        self._count = 0

    def annotated(self, node: ast.expr | None) -> str:
        """Kind that an annotation means."""
        if node is None or (isinstance(node, ast.Constant) and node.value is None):
            return "void"
        return _KINDS[ast.unparse(node)]

    # -- writing ---------------------------------------------------------------------------

    def fresh(self, word: str = "v") -> str:
        """A name that is not used yet."""
        self._count += 1
        return f"{word}.{self._count}"

    def put(self, expression: str, kind: str) -> Value:
        """Write an instruction; gives its result."""
        symbol = f"%{self.fresh()}"
        self.lines.append(f"  {symbol} = {expression}")
        return Value(symbol, kind)

    def label(self, label: str) -> None:
        """Begin a block."""
        self.lines.append(f"{label}:")

    def jump(self, label: str) -> None:
        """Leave the block."""
        self.lines.append(f"  br label %{label}")
        self.label(self.fresh("after"))  # what follows a jump is never reached

    def enter(self, label: str) -> None:
        """Go on with a new block."""
        self.lines.append(f"  br label %{label}")
        self.label(label)

    def branch(self, node: ast.expr, yes: str, no: str) -> None:
        """Leave the block for one of two."""
        condition = self.as_kind(self.value(node), "i1")
        self.lines.append(f"  br i1 {condition.text}, label %{yes}, label %{no}")

    def _place(self, kind: str) -> str:
        symbol = f"%{self.fresh('place')}"
        self.head.append(f"  {symbol} = alloca {ir_type(kind)}")
        return symbol

    def store(self, name: str, value: Value) -> None:
        """Keep a value in a variable."""
        if name not in self.places:
            self.places[name] = Value(self._place(value.kind), value.kind)
        place = self.places[name]
        value = self.as_kind(value, place.kind)
        self.lines.append(f"  store {ir_type(place.kind)} {value.text}, ptr {place.text}")

    def as_kind(self, value: Value, kind: str) -> Value:
        """The value as another kind."""
        if value.kind == kind:
            return value
        if (value.kind, kind) == ("i1", "i64"):
            return self.put(f"zext i1 {value.text} to i64", kind)
        if (value.kind, kind) == ("i64", "double"):
            return self.put(f"sitofp i64 {value.text} to double", kind)
        if (value.kind, kind) == ("i64", "i1"):
            return self.put(f"icmp ne i64 {value.text}, 0", kind)
        raise TranslationError(f"{self.kernel.name}: a {value.kind} where a {kind} is needed")

    def unknown(self, node: ast.AST) -> TranslationError:
        """Error for what the language does not have."""
        return TranslationError(f"{self.kernel.name}: {ast.unparse(node)}")

    # -- values ----------------------------------------------------------------------------

    def load(self, name: str) -> Value:
        """The value of a variable."""
        place = self.places[name]
        return self.put(f"load {ir_type(place.kind)}, ptr {place.text}", place.kind)

    def element(self, node: ast.Subscript) -> Value:
        """Where an element stands, and of what kind it is."""
        index = self.as_kind(self.value(node.slice), "i64")
        if isinstance(node.value, ast.Name) and node.value.id not in self.places:
            base, kind = self._table(node.value.id), "double"
        else:
            pointer = self.value(node.value)
            base, kind = pointer.text, _ELEMENT[pointer.kind]
        place = self.put(f"getelementptr inbounds {kind}, ptr {base}, i64 {index.text}", kind)
        return Value(place.text, kind)

    def _table(self, name: str) -> str:
        """A tuple of numbers of the module."""
        numbers = self.kernel.space[name]
        symbol = f'@"{self.kernel.name}.{name}"'
        listed = ", ".join(f"double {literal(value)}" for value in numbers)
        text = f"{symbol} = private constant [{len(numbers)} x double] [{listed}]"
        if text not in self.constants:
            self.constants.append(text)
        return symbol

    def value(self, node: ast.expr) -> Value:
        """Write an expression."""
        if isinstance(node, ast.Name) and node.id in self.places:
            return self.load(node.id)
        if isinstance(node, ast.Constant | ast.Name | ast.Attribute):
            return self._constant(node)
        if isinstance(node, ast.Subscript):
            place = self.element(node)
            return self.put(f"load {place.kind}, ptr {place.text}", place.kind)
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
        raise self.unknown(node)

    def _constant(self, node: ast.Constant | ast.Name | ast.Attribute) -> Value:
        value = eval(ast.unparse(node), self.kernel.space)
        if isinstance(value, bool):
            return Value("true" if value else "false", "i1")
        if isinstance(value, int):
            return Value(str(value), "i64")
        if isinstance(value, float):
            return Value(literal(value), "double")
        raise self.unknown(node)

    def _binary(self, node: ast.BinOp) -> Value:
        a, b = self.value(node.left), self.value(node.right)
        op: Any = type(node.op)
        if a.kind == b.kind == "i64" and op in _INTEGER:
            return self.put(f"{_INTEGER[op]} i64 {a.text}, {b.text}", "i64")
        a, b = self.as_kind(a, "double"), self.as_kind(b, "double")
        if op is ast.Pow:
            return self._intrinsic("pow", a, b)
        if op not in _REAL:
            raise self.unknown(node)
        return self.put(f"{_REAL[op]} double {a.text}, {b.text}", "double")

    def _unary(self, node: ast.UnaryOp) -> Value:
        value = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            return self.put(f"xor i1 {self.as_kind(value, 'i1').text}, true", "i1")
        if isinstance(node.operand, ast.Constant):
            number = -eval(ast.unparse(node.operand))
            return Value(literal(number) if value.kind == "double" else str(number), value.kind)
        if value.kind == "double":
            return self.put(f"fneg double {value.text}", "double")
        return self.put(f"sub i64 0, {value.text}", "i64")

    def _comparison(self, node: ast.Compare) -> Value:
        if len(node.ops) > 1:
            raise self.unknown(node)
        a, b = self.value(node.left), self.value(node.comparators[0])
        return self._compared(_ORDER[type(node.ops[0])], a, b)

    def _compared(self, order: str, a: Value, b: Value) -> Value:
        kind = "double" if "double" in (a.kind, b.kind) else "i64"
        kind = "i1" if a.kind == b.kind == "i1" else kind
        a, b = self.as_kind(a, kind), self.as_kind(b, kind)
        if kind == "double":
            word = "une" if order == "ne" else f"o{order}"
            return self.put(f"fcmp {word} double {a.text}, {b.text}", "i1")
        word = order if order in ("eq", "ne") else f"s{order}"
        return self.put(f"icmp {word} {kind} {a.text}, {b.text}", "i1")

    def _logical(self, node: ast.BoolOp) -> Value:
        place, end = self._place("i1"), self.fresh("end")
        for part in node.values:
            value = self.as_kind(self.value(part), "i1")
            self.lines.append(f"  store i1 {value.text}, ptr {place}")
            if part is not node.values[-1]:
                more = self.fresh("more")
                labels = (more, end) if isinstance(node.op, ast.And) else (end, more)
                self.lines.append(f"  br i1 {value.text}, label %{labels[0]}, label %{labels[1]}")
                self.label(more)
        self.enter(end)
        return self.put(f"load i1, ptr {place}", "i1")

    def _choice(self, node: ast.IfExp) -> Value:
        yes, no, end = (self.fresh(w) for w in ("yes", "no", "end"))
        self.branch(node.test, yes, no)
        before, found = self.lines, []
        for part in (node.body, node.orelse):
            self.lines = []
            found.append((self.value(part), self.lines))
        kinds = {value.kind for value, _ in found}
        kind = kinds.pop() if len(kinds) == 1 else "double" if "double" in kinds else "i64"
        place = self._place(kind)
        for label, (value, lines) in zip((yes, no), found, strict=True):
            self.lines = lines
            value = self.as_kind(value, kind)
            before += [f"{label}:", *lines, f"  store {ir_type(kind)} {value.text}, ptr {place}"]
            before.append(f"  br label %{end}")
        self.lines = before
        self.label(end)
        return self.put(f"load {ir_type(kind)}, ptr {place}", kind)

    def _intrinsic(self, name: str, *values: Value) -> Value:
        listed = ", ".join(f"double {self.as_kind(value, 'double').text}" for value in values)
        return self.put(f"call double @llvm.{name}.f64({listed})", "double")

    def _call(self, node: ast.Call) -> Value:
        word = eval(ast.unparse(node.func), self.kernel.space)
        values = [self.value(argument) for argument in node.args]
        if word is words.at:
            kind = values[0].kind
            place = f"getelementptr inbounds {_ELEMENT[kind]}, ptr {values[0].text}"
            return self.put(f"{place}, i64 {values[1].text}", kind)
        if word in (words.doubles, words.integers):
            kind = "reals" if word is words.doubles else "ints"
            return self.put(f"inttoptr i64 {values[0].text} to ptr", kind)
        if word is words.evaluate:
            address = self.put(f"inttoptr i64 {values[0].text} to ptr", "ptr")
            return self._called("void", address.text, values[1:])
        if word is math.sqrt:
            return self._intrinsic("sqrt", values[0])
        if word is abs:
            return self._intrinsic("fabs", values[0])
        if word is float:
            return self.as_kind(values[0], "double")
        if word is int:
            return self.put(f"fptosi double {values[0].text} to i64", "i64")
        if word in (min, max):
            a, b = values
            kind = "double" if "double" in (a.kind, b.kind) else "i64"
            a, b = self.as_kind(a, kind), self.as_kind(b, kind)
            other = self._compared("lt" if word is min else "gt", b, a)
            return self.put(f"select i1 {other.text}, {kind} {b.text}, {kind} {a.text}", kind)
        if isinstance(word, Kernel):
            self.called.append(word)
            tree = definition(word)
            kinds = [self.annotated(argument.annotation) for argument in tree.args.args]
            given = [self.as_kind(v, k) for v, k in zip(values, kinds, strict=True)]
            return self._called(self.annotated(tree.returns), f'@"{word.name}"', given)
        raise self.unknown(node)

    def _called(self, kind: str, function: str, values: list[Value]) -> Value:
        listed = ", ".join(f"{ir_type(value.kind)} {value.text}" for value in values)
        call = f"call {ir_type(kind)} {function}({listed})"
        if kind == "void":
            self.lines.append(f"  {call}")
            return Value("", "void")
        return self.put(call, kind)
