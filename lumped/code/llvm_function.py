"""One function in LLVM assembly, instruction after instruction."""

from __future__ import annotations

import ast
from typing import Any

from lumped.code.llvm_words import INTEGER, INTRINSIC, NUMBER, ORDER, TYPES, literal
from lumped.code.records import Field
from lumped.code.translate import TranslationError, Value, Writer, find_common_kind
from lumped.code.words import Kernel

_ELEMENT = {"ints": ("i64", "int"), "numbers": ("double", "float"), "wides": ("", "wide")}
_LARGE = 40
"""Lines above which a function is marked noinline, unless `inline`."""
_MUCH = 12
"""Operations from which on a loop may get a vector form."""


def _is_worth_a_vector_form(body: list[ast.stmt]) -> bool:
    """Whether a loop sets numbers by arithmetic alone, and by much of it."""
    parts = [part for statement in body for part in ast.walk(statement)]
    return (
        all(isinstance(statement, ast.Assign | ast.AugAssign) for statement in body)
        and not any(isinstance(part, ast.IfExp) for part in parts)
        and all(_is_vector_word(part) for part in parts if isinstance(part, ast.Call))
        and sum(isinstance(part, ast.BinOp) for part in parts) >= _MUCH
    )


def _is_vector_word(call: ast.Call) -> bool:
    return isinstance(call.func, ast.Name) and call.func.id in ("abs", "fmax", "fmin")


class LlvmFunction(Writer):
    """One function, instruction after instruction."""

    lanes, inline = 1, False

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
        given = ", ".join(f"{self._type(kind)} %{name}" for name, kind in self.arguments)
        # inlining a large function gains nothing and takes long to compile
        apart = " noinline" if len(self._lines) > _LARGE else ""
        apart = " alwaysinline" if self.inline else apart
        head = f'define {linkage}{self._type(self.result)} @"{self.kernel.name}"({given}){apart} {{'
        return "\n".join([*self._tables, head, "entry:", *self._head, *self._lines, "}"])

    def read(self) -> None:
        """Write all instructions."""
        for name, kind in self.arguments:
            self.variables[name] = kind
            self.write_variable(name, Value(f"%{name}", kind))
        super().read()
        self._lines.append("  ret void" if self.result == "void" else "  unreachable")

    def _type(self, kind: Any) -> str:
        wide = {"wide": f"<{self.lanes} x double>", "truths": f"<{self.lanes} x i1>"}
        return (wide | TYPES).get(kind, "ptr") if isinstance(kind, str) else "ptr"

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
        condition = self.convert(self.value(test), "bool").text
        self._lines.append(f"  br i1 {condition}, label %{yes}, label %{no}")

    def _room(self, kind: Any) -> str:
        symbol = f"%{self._fresh('place')}"
        self._head.append(f"  {symbol} = alloca {self._type(kind)}")
        return symbol

    def _store(self, value: Value, place: str) -> None:
        self._lines.append(f"  store {self._type(value.kind)} {value.text}, ptr {place}, align 8")

    def _load(self, place: str, kind: Any) -> Value:
        return self._put(f"load {self._type(kind)}, ptr {place}, align 8", kind)

    # -- statements --------------------------------------------------------------------------

    def write_if(self, test: ast.expr, yes: list[ast.stmt], no: list[ast.stmt]) -> None:
        labels = [self._fresh(word) for word in ("yes", "no", "end")]
        self._branch(test, *labels[:2])
        for label, body in zip(labels[:2], (yes, no), strict=True):
            self._lines.append(f"{label}:")
            self.block(body)
            self._lines.append(f"  br label %{labels[2]}")
        self._lines.append(f"{labels[2]}:")

    def write_while(self, test: ast.expr, body: list[ast.stmt]) -> None:
        again, inside, end = (self._fresh(word) for word in ("test", "body", "end"))
        self._enter(again)
        self._branch(test, inside, end)
        self._lines.append(f"{inside}:")
        self._write_loop_body(end, again, body)
        self._lines += [f"  br label %{again}", f"{end}:"]

    def write_for(
        self, name: str, bounds: tuple[Value, Value, Value], down: bool, body: list[ast.stmt]
    ) -> None:
        begin, end, step = bounds
        again, inside, following, after = map(self._fresh, ("test", "body", "next", "end"))
        self.write_variable(name, begin)
        self._enter(again)
        more = self.compare(">" if down else "<", self.variable(name), end)
        self._lines.append(f"  br i1 {more.text}, label %{inside}, label %{after}")
        self._lines.append(f"{inside}:")
        self._write_loop_body(after, following, body)
        self._enter(following)
        self.write_variable(name, self.arithmetic("+", self.variable(name), step))
        hint = "" if _is_worth_a_vector_form(body) else self._forbid_vectors()
        self._lines += [f"  br label %{again}{hint}", f"{after}:"]

    def _forbid_vectors(self) -> str:
        """Hint to leave a loop as it is: a vector form takes long to make, and gains nothing."""
        self.declared |= {
            "!0 = distinct !{!0, !1}",
            '!1 = !{!"llvm.loop.vectorize.enable", i1 false}',
        }
        return ", !llvm.loop !0"

    def _write_loop_body(self, end: str, following: str, body: list[ast.stmt]) -> None:
        self._loops.append((end, following))
        self.block(body)
        self._loops.pop()

    def _leave(self, instruction: str) -> None:
        # a block ends at its jump: what follows needs a label
        self._lines += [f"  {instruction}", f"{self._fresh('after')}:"]

    def write_return(self, value: Value | None) -> None:
        self._leave("ret void" if value is None else f"ret {self._type(value.kind)} {value.text}")

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
        self._store(value, self.move(base, index).text)

    def write_field(self, record: Value, field: Field, value: Value) -> None:
        self._store(value, self._place_of(record, field))

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

    def keep(self, value: Value) -> Value:
        return value

    def _word(self, record: Value, field: Field) -> str:
        place = f"getelementptr inbounds i64, ptr {record.text}, i64 {field.place}"
        return self._put(place, "").text

    def _place_of(self, record: Value, field: Field) -> str:
        """Address of a field; a wide number is where its word points to."""
        word = self._word(record, field)
        return self._load(word, "wides").text if field.kind == "wide" else word

    def field(self, record: Value, field: Field) -> Value:
        return self._load(self._place_of(record, field), field.kind)

    def element(self, base: Value, index: Value) -> Value:
        return self._load(self.move(base, index).text, _ELEMENT[base.kind][1])

    def move(self, base: Value, offset: Value) -> Value:
        kind = self._type("wide") if base.kind == "wides" else _ELEMENT[base.kind][0]
        place = f"getelementptr inbounds {kind}, ptr {base.text}, i64 {offset.text}"
        return self._put(place, base.kind)

    def convert(self, value: Value, kind: Any) -> Value:
        if value.kind == kind:
            return value
        if (value.kind, kind) == ("bool", "int"):
            return self._put(f"zext i1 {value.text} to i64", kind)
        if (value.kind, kind) == ("int", "float"):
            return self._put(f"sitofp i64 {value.text} to double", kind)
        if (value.kind, kind) == ("int", "bool"):
            return self._put(f"icmp ne i64 {value.text}, 0", kind)
        if kind == "wide" and value.kind in ("int", "float"):
            return self._spread(self.convert(value, "float"), kind)
        if (value.kind, kind) == ("bool", "truths"):
            return self._spread(value, kind)
        if (value.kind, kind) == ("wide", "truths"):
            zero = self.convert(self.number(0.0), "wide")
            return self._put(f"fcmp une {self._type('wide')} {value.text}, {zero.text}", kind)
        if (value.kind, kind) == ("truths", "wide"):
            text = f"uitofp {self._type('truths')} {value.text} to {self._type('wide')}"
            return self._put(text, kind)
        raise TranslationError(f"{self.kernel.name}: a {value.kind} where a {kind} is needed")

    def _spread(self, value: Value, kind: Any) -> Value:
        """The same in all lanes."""
        whole, one = self._type(kind), self._type(value.kind)
        first = self._put(f"insertelement {whole} undef, {one} {value.text}, i32 0", kind)
        mask = f"<{self.lanes} x i32> zeroinitializer"
        return self._put(f"shufflevector {whole} {first.text}, {whole} undef, {mask}", kind)

    def any_of(self, truths: Value) -> Value:
        if truths.kind == "bool":
            return truths
        kind, suffix = self._type("truths"), f"v{self.lanes}i1"
        self.declared.add(f"declare i1 @llvm.vector.reduce.or.{suffix}({kind})")
        return self._put(f"call i1 @llvm.vector.reduce.or.{suffix}({kind} {truths.text})", "bool")

    def cast(self, address: Value, kind: Any) -> Value:
        return self._put(f"inttoptr i64 {address.text} to ptr", kind)

    def truncate(self, value: Value) -> Value:
        return self._put(f"fptosi double {value.text} to i64", "int")

    def arithmetic(self, sign: str, a: Value, b: Value) -> Value:
        word = (INTEGER if a.kind == "int" else NUMBER)[sign]
        return self._put(f"{word} {self._type(a.kind)} {a.text}, {b.text}", a.kind)

    def minus(self, value: Value) -> Value:
        if value.kind in ("float", "wide"):
            return self._put(f"fneg {self._type(value.kind)} {value.text}", value.kind)
        return self._put(f"sub i64 0, {value.text}", "int")

    def logical_not(self, value: Value) -> Value:
        true = "true" if value.kind == "bool" else f"<{', '.join(['i1 true'] * self.lanes)}>"
        return self._put(f"xor {self._type(value.kind)} {value.text}, {true}", value.kind)

    def compare(self, order: str, a: Value, b: Value) -> Value:
        word = ORDER[order]
        if a.kind in ("float", "wide"):
            word = "une" if word == "ne" else f"o{word}"
            kind = "bool" if a.kind == "float" else "truths"
            return self._put(f"fcmp {word} {self._type(a.kind)} {a.text}, {b.text}", kind)
        word = word if word in ("eq", "ne") else f"s{word}"
        return self._put(f"icmp {word} {self._type(a.kind)} {a.text}, {b.text}", "bool")

    def _is_wide(self, node: ast.expr) -> bool:
        """Whether a condition differs between lanes; writes nothing."""
        if self.lanes == 1:
            return False
        kept = self._lines, self._head, self._tables, self.called, self._count
        self._lines, self._head, self._tables, self.called = [], [], [], []
        kind = self.value(node).kind
        self._lines, self._head, self._tables, self.called, self._count = kept
        return kind in ("truths", "wide")

    def _join_conditions(self, both: bool, parts: list[ast.expr]) -> Value:
        """Conditions of lanes, all of which are evaluated."""
        values = [self.convert(self.value(part), "truths") for part in parts]
        found = values[0]
        for value in values[1:]:
            word = "and" if both else "or"
            text = f"{word} {self._type('truths')} {found.text}, {value.text}"
            found = self._put(text, "truths")
        return found

    def logical(self, both: bool, parts: list[ast.expr]) -> Value:
        if any(self._is_wide(part) for part in parts):
            return self._join_conditions(both, parts)
        place, end = self._room("bool"), self._fresh("end")
        for part in parts:
            value = self.convert(self.value(part), "bool")
            self._store(value, place)
            if part is not parts[-1]:
                more = self._fresh("more")
                yes, no = (more, end) if both else (end, more)
                self._lines.append(f"  br i1 {value.text}, label %{yes}, label %{no}")
                self._lines.append(f"{more}:")
        self._enter(end)
        return self._load(place, "bool")

    def choice(self, test: ast.expr, yes: ast.expr, no: ast.expr) -> Value:
        if self._is_wide(test):
            truths = self.convert(self.value(test), "truths")
            values = [self.value(part) for part in (yes, no)]
            are_truths = "truths" in [value.kind for value in values]
            kind = "truths" if are_truths else "wide"
            a, b = (self.convert(value, kind) for value in values)
            whole = self._type(kind)
            text = f"{self._type('truths')} {truths.text}, {whole} {a.text}, {whole} {b.text}"
            return self._put(f"select {text}", kind)
        labels = [self._fresh(word) for word in ("yes", "no", "end")]
        self._branch(test, *labels[:2])
        before, found = self._lines, []
        for part in (yes, no):
            self._lines = []
            found.append((self.value(part), self._lines))
        kind = find_common_kind(value for value, _ in found)
        place = self._room(kind)
        for label, (value, lines) in zip(labels[:2], found, strict=True):
            self._lines = lines
            self._store(self.convert(value, kind), place)
            before += [f"{label}:", *self._lines, f"  br label %{labels[2]}"]
        self._lines = before
        self._lines.append(f"{labels[2]}:")
        return self._load(place, kind)

    def extreme(self, least: bool, a: Value, b: Value) -> Value:
        other = self.compare("<" if least else ">", b, a)
        kind, condition = self._type(a.kind), self._type(other.kind)
        text = f"select {condition} {other.text}, {kind} {b.text}, {kind} {a.text}"
        return self._put(text, a.kind)

    def library(self, name: str, values: list[Value]) -> Value:
        if values[0].kind == "wide":
            if name not in ("sqrt", "fabs", "fmin", "fmax"):
                return self._call_in_lanes(name, values)
            whole, symbol = self._type("wide"), f"llvm.{INTRINSIC[name]}.v{self.lanes}f64"
            self.declared.add(f"declare {whole} @{symbol}({', '.join([whole] * len(values))})")
            given = ", ".join(f"{whole} {self.convert(v, 'wide').text}" for v in values)
            return self._put(f"call {whole} @{symbol}({given})", "wide")
        symbol = f"llvm.{INTRINSIC[name]}.f64" if name in INTRINSIC else name
        self.declared.add(f"declare double @{symbol}({', '.join(['double'] * len(values))})")
        listed = ", ".join(f"double {value.text}" for value in values)
        return self._put(f"call double @{symbol}({listed})", "float")

    def _call_in_lanes(self, name: str, values: list[Value]) -> Value:
        """A function of the C library, for one lane after the other."""
        whole, found = self._type("wide"), Value("undef", "wide")
        for lane in range(self.lanes):
            own = [
                self._put(f"extractelement {whole} {v.text}, i32 {lane}", "float") for v in values
            ]
            one = self.library(name, own)
            text = f"insertelement {whole} {found.text}, double {one.text}, i32 {lane}"
            found = self._put(text, "wide")
        return found

    def call_kernel(self, kernel: Kernel, values: list[Value], result: Any) -> Value:
        return self._write_call(f'@"{kernel.name}"', values, result)

    def call_by_address(self, result: Any, values: list[Value]) -> Value:
        address = self._put(f"inttoptr i64 {values[0].text} to ptr", "")
        given = [self._store_wide(value) for value in values[1:]]
        return self._write_call(address.text, given, result)

    def _store_wide(self, value: Value) -> Value:
        """A wide number in memory: it travels by its address."""
        if value.kind != "wide":
            return value
        place = self._room("wide")
        self._store(value, place)
        return Value(place, "wides")

    def _write_call(self, function: str, values: list[Value], result: Any) -> Value:
        listed = ", ".join(f"{self._type(value.kind)} {value.text}" for value in values)
        text = f"call {self._type(result)} {function}({listed})"
        if result == "void":
            self._lines.append(f"  {text}")
            return Value("", "void")
        return self._put(text, result)
