"""Reader for a small part of Python, which is then written in another language.

Functions take and give integers, numbers, truth values, addresses and records (see `records`).
There are assignments, ``if``, ``while``, ``for`` over a range, arithmetic, comparisons and calls;
integers must not be negative in divisions. A name without assignment is a constant of the module: a
number, a tuple of numbers or another function of this kind. Operations keep their order and
rounding. `to_llvm` and `to_c` write the result.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable
from typing import Any, ClassVar, NamedTuple, Protocol, TypeVar

from lumped.code import words
from lumped.code.records import Field, Record
from lumped.code.words import Kernel

_KINDS = {"int": "int", "float": "float", "bool": "bool", "Integers": "ints", "Numbers": "numbers"}
_KINDS |= {"Wide": "wide", "Wides": "wides"}
_INTEGER = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.FloorDiv: "/", ast.Mod: "%"}
_NUMBER = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
_ORDER = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
_ELEMENT = {"ints": "int", "numbers": "float", "wides": "wide"}
_WIDE = {"float": "wide", "numbers": "wides", "bool": "truths"}
"""Kinds in a function whose numbers are wide."""
_BY_ADDRESS = {words.call: "void", words.call_wide: "void", words.enter: "int"}
"""Words that call machine code at an address, and what it gives."""

Written = TypeVar("Written", bound="Writer")


class TranslationError(Exception):
    """A construct that the language does not have."""


class Value(NamedTuple):
    """Text of a value, and its kind.

    The kind is "int", "float", "bool", "ints", "numbers", "void" or a class of records; or "wide",
    "wides" or "truths" for what each lane has of its own.
    """

    text: str
    kind: Any


def write_all(kernels: Iterable[Kernel], write: Callable[[Kernel], Written]) -> list[Written]:
    """Written forms of functions and of all that they call."""
    found: dict[str, Written] = {}
    waiting = list(kernels)
    while waiting:
        now = waiting.pop()
        if now.name not in found:
            made = found[now.name] = write(now)
            made.read()
            waiting += made.called
    return list(found.values())


def find_common_kind(values: Iterable[Value]) -> Any:
    """The kind that can hold all of some values."""
    kinds = {value.kind for value in values}
    if len(kinds) == 1:
        return kinds.pop()
    return next((kind for kind in ("truths", "wide", "float", "int") if kind in kinds), "")


class Language(Protocol):
    """What a language writes for each construct."""

    def write_if(self, test: ast.expr, yes: list[ast.stmt], no: list[ast.stmt]) -> None: ...
    def write_while(self, test: ast.expr, body: list[ast.stmt]) -> None: ...
    def write_for(
        self, name: str, bounds: tuple[Value, Value, Value], down: bool, body: list[ast.stmt]
    ) -> None: ...
    def write_return(self, value: Value | None) -> None: ...
    def write_break(self) -> None: ...
    def write_continue(self) -> None: ...
    def write_expression(self, value: Value) -> None: ...
    def write_variable(self, name: str, value: Value) -> None: ...
    def write_element(self, base: Value, index: Value, value: Value) -> None: ...
    def write_field(self, record: Value, field: Field, value: Value) -> None: ...
    def number(self, value: float) -> Value: ...
    def table(self, name: str, numbers: tuple[float, ...]) -> Value: ...
    def variable(self, name: str) -> Value: ...
    def keep(self, value: Value) -> Value: ...
    def field(self, record: Value, field: Field) -> Value: ...
    def element(self, base: Value, index: Value) -> Value: ...
    def move(self, base: Value, offset: Value) -> Value: ...
    def convert(self, value: Value, kind: Any) -> Value: ...
    def truncate(self, value: Value) -> Value: ...
    def arithmetic(self, sign: str, a: Value, b: Value) -> Value: ...
    def minus(self, value: Value) -> Value: ...
    def logical_not(self, value: Value) -> Value: ...
    def compare(self, order: str, a: Value, b: Value) -> Value: ...
    def logical(self, both: bool, parts: list[ast.expr]) -> Value: ...
    def choice(self, test: ast.expr, yes: ast.expr, no: ast.expr) -> Value: ...
    def extreme(self, least: bool, a: Value, b: Value) -> Value: ...
    def library(self, name: str, values: list[Value]) -> Value: ...
    def call_kernel(self, kernel: Kernel, values: list[Value], result: Any) -> Value: ...
    def call_by_address(self, result: Any, values: list[Value]) -> Value: ...
    def cast(self, address: Value, kind: Any) -> Value: ...
    def any_of(self, truths: Value) -> Value: ...


class Writer(Language, ast.NodeVisitor):
    """Reads one function, statement by statement, and writes it in a language.

    Attributes
    ----------
    kernel : Kernel
        The function that is read.
    called : list of Kernel
        Functions that it calls.
    variables : dict of str to kind
        Its variables.
    counterparts : dict
        What stands for a class of records or a function where numbers are wide.
    """

    counterparts: ClassVar[dict[Any, Any]] = {}

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self.called: list[Kernel] = []
        self.variables: dict[str, Any] = {}
        self._tree = kernel.tree
        self.arguments = [(a.arg, self.read_annotation(a.annotation)) for a in self._tree.args.args]
        self.result = self.read_annotation(self._tree.returns)

    def read(self) -> None:
        """Go through all statements."""
        self.variables |= dict(self.arguments)
        self.block(self._tree.body)

    def read_annotation(self, node: ast.expr | None) -> Any:
        """Kind that an annotation means."""
        if node is None or (isinstance(node, ast.Constant) and node.value is None):
            return "void"
        text = ast.unparse(node)
        kind = _KINDS.get(text) or self.kernel.space[text]
        if not self.kernel.is_wide:
            return kind
        return _WIDE.get(kind) or self.counterparts.get(kind, kind)

    def unknown(self, node: ast.AST) -> TranslationError:
        """Error for a construct that the language does not have."""
        return TranslationError(f"{self.kernel.name}: {ast.unparse(node)}")

    # -- statements ------------------------------------------------------------------------

    def block(self, body: list[ast.stmt]) -> None:
        """Statements one after the other."""
        for node in body:
            self.visit(node)

    def generic_visit(self, node: ast.AST) -> Any:
        """Refuse what has no method."""
        raise self.unknown(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        old = ast.parse(ast.unparse(node.target), mode="eval").body
        self._set(node.target, self.value(ast.BinOp(old, node.op, node.value)))

    def visit_If(self, node: ast.If) -> None:
        self.write_if(node.test, node.body, node.orelse)

    def visit_While(self, node: ast.While) -> None:
        self.write_while(node.test, node.body)

    def visit_Return(self, node: ast.Return) -> None:
        given = None if node.value is None else self.value(node.value)
        self.write_return(None if given is None else self.convert(given, self.result))

    def visit_Break(self, _: ast.Break) -> None:
        self.write_break()

    def visit_Continue(self, _: ast.Continue) -> None:
        self.write_continue()

    def visit_Expr(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Constant):
            self.write_expression(self.value(node.value))

    def visit_Pass(self, _: ast.Pass) -> None:
        """Nothing is to be written."""

    def visit_Assign(self, node: ast.Assign) -> None:
        first = node.targets[0]
        if isinstance(first, ast.Tuple) and isinstance(node.value, ast.Tuple):
            found = [self.keep(self.value(part)) for part in node.value.elts]
            for target, value in zip(first.elts, found, strict=True):
                self._set(target, value)
            return
        value = self.value(node.value)
        if len(node.targets) > 1:
            value = self.keep(value)
        for target in node.targets:
            self._set(target, value)

    def _set(self, target: ast.expr, value: Value) -> None:
        if isinstance(target, ast.Name):
            kind = _WIDE.get(value.kind, value.kind) if self.kernel.is_wide else value.kind
            kind = self.variables.setdefault(target.id, kind)
            self.write_variable(target.id, self.convert(value, kind))
        elif isinstance(target, ast.Subscript) and not isinstance(target.slice, ast.Slice):
            base, index = self._element(target)
            self.write_element(base, index, self.convert(value, _ELEMENT[base.kind]))
        elif isinstance(target, ast.Attribute):
            record, field = self._field(target)
            self.write_field(record, field, self.convert(value, field.kind))
        else:
            raise self.unknown(target)

    def visit_For(self, node: ast.For) -> None:
        if not (isinstance(node.target, ast.Name) and isinstance(node.iter, ast.Call)):
            raise self.unknown(node)
        bounds = [self.convert(self.value(a), "int") for a in node.iter.args]
        begin = bounds[0] if len(bounds) > 1 else self.number(0)
        end = bounds[min(1, len(bounds) - 1)]
        down = len(bounds) > 2 and ast.unparse(node.iter.args[2]).startswith("-")
        step = bounds[2] if len(bounds) > 2 else self.number(1)
        self.variables.setdefault(node.target.id, "int")
        self.write_for(node.target.id, (begin, end, step), down, node.body)

    # -- values ----------------------------------------------------------------------------

    def value(self, node: ast.expr) -> Value:
        """An expression."""
        found: Value = self.visit(node)
        return found

    def visit_Name(self, node: ast.Name) -> Value:
        return self.variable(node.id) if node.id in self.variables else self.visit_Constant(node)

    def visit_Attribute(self, node: ast.Attribute) -> Value:
        return self.field(*self._field(node)) if self._is_field(node) else self.visit_Constant(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> Value:
        return self.logical(isinstance(node.op, ast.And), node.values)

    def visit_IfExp(self, node: ast.IfExp) -> Value:
        return self.choice(node.test, node.body, node.orelse)

    def _is_field(self, node: ast.expr) -> bool:
        while isinstance(node, ast.Attribute):
            node = node.value
        return isinstance(node, ast.Name) and node.id in self.variables

    def _field(self, node: ast.Attribute) -> tuple[Value, Field]:
        record = self.value(node.value)
        known = isinstance(record.kind, type) and issubclass(record.kind, Record)
        if not known or node.attr not in record.kind.fields:
            raise self.unknown(node)
        return record, record.kind.fields[node.attr]

    def visit_Constant(self, node: ast.expr) -> Value:
        try:
            value = eval(ast.unparse(node), self.kernel.space)
        except (NameError, AttributeError):
            raise self.unknown(node) from None
        if isinstance(value, bool | int | float):
            return self.number(value)
        raise self.unknown(node)

    def _element(self, node: ast.Subscript) -> tuple[Value, Value]:
        index = self.convert(self.value(node.slice), "int")
        base = node.value
        if isinstance(base, ast.Name) and base.id not in self.variables:
            numbers = self.kernel.space.get(base.id)
            if not isinstance(numbers, tuple):
                raise self.unknown(node)
            return self.table(base.id, numbers), index
        pointer = self.value(base)
        if pointer.kind not in _ELEMENT:
            raise self.unknown(node)
        return pointer, index

    def visit_Subscript(self, node: ast.Subscript) -> Value:
        if isinstance(node.slice, ast.Slice):
            if node.slice.lower is None or node.slice.upper or node.slice.step:
                raise self.unknown(node)
            base, begin = self.value(node.value), self.value(node.slice.lower)
            return self.move(base, self.convert(begin, "int"))
        return self.element(*self._element(node))

    def visit_BinOp(self, node: ast.BinOp) -> Value:
        a, b = self.value(node.left), self.value(node.right)
        op: Any = type(node.op)
        if a.kind == b.kind == "int" and op in _INTEGER:
            return self.arithmetic(_INTEGER[op], a, b)
        kind = "wide" if "wide" in (a.kind, b.kind) else "float"
        a, b = self.convert(a, kind), self.convert(b, kind)
        if op is ast.Pow:
            return self.library("pow", [a, b])
        if op not in _NUMBER:
            raise self.unknown(node)
        return self.arithmetic(_NUMBER[op], a, b)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant):
            return self.number(-eval(ast.unparse(node.operand)))
        value = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            is_wide = value.kind in ("wide", "truths")
            return self.logical_not(self.convert(value, "truths" if is_wide else "bool"))
        if isinstance(node.op, ast.USub):
            return self.minus(value)
        raise self.unknown(node)

    def visit_Compare(self, node: ast.Compare) -> Value:
        if len(node.ops) > 1:
            raise self.unknown(node)
        a, b = self.value(node.left), self.value(node.comparators[0])
        kind = find_common_kind((a, b))
        order = _ORDER[type(node.ops[0])]
        return self.compare(order, self.convert(a, kind), self.convert(b, kind))

    def _are_wide(self, kinds: Iterable[Any]) -> bool:
        """Whether a function with arguments of these kinds is one for wide numbers."""
        return any(k in ("wide", "wides", "truths", *self.counterparts.values()) for k in kinds)

    def _flat(self, node: ast.expr) -> Value:
        """Address of wide numbers."""
        if isinstance(node, ast.Attribute) and self._is_field(node):
            record, field = self._field(node)
            return Value(self.field(record, field._replace(kind="wides")).text, "numbers")
        found = self.value(node)
        if found.kind != "wides":
            raise self.unknown(node)
        return Value(found.text, "numbers")

    def visit_Call(self, node: ast.Call) -> Value:
        word = eval(ast.unparse(node.func), self.kernel.space)
        if word is words.flat:
            return self._flat(node.args[0])
        if word is words.record_at:
            kind = self.kernel.space[ast.unparse(node.args[0])]
            return self.cast(self.value(node.args[1]), kind)
        values = [self.value(argument) for argument in node.args]
        if word in _BY_ADDRESS:
            return self.call_by_address(_BY_ADDRESS[word], values)
        if word is words.any_lane:
            return self.any_of(values[0])
        if isinstance(word, Kernel):
            own = type(self)(word)
            if self._are_wide(value.kind for value in values) and not self._are_wide(
                kind for _, kind in own.arguments
            ):
                word = self.counterparts.get(word) or word.widened
                own = type(self)(word)
            self.called.append(word)
            kinds = [kind for _, kind in own.arguments]
            if len(kinds) != len(values):
                raise self.unknown(node)
            given = [self.convert(v, k) for v, k in zip(values, kinds, strict=True)]
            return self.call_kernel(word, given, own.result)
        if word is float:
            return self.convert(values[0], "float")
        if word is int:
            return self.truncate(values[0])
        if word in (min, max):
            kind = find_common_kind(values)
            return self.extreme(word is min, *(self.convert(v, kind) for v in values))
        name = "fabs" if word is abs else getattr(word, "c_name", None)
        if name is None:
            raise self.unknown(node)
        kind = "wide" if any(v.kind == "wide" for v in values) else "float"
        return self.library(name, [self.convert(v, kind) for v in values])
