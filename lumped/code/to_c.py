"""The language of the time loop as C99 (see `translate`)."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from lumped.code.records import Field, Record
from lumped.code.translate import (
    TranslationError,
    Value,
    Writer,
    find_common_kind,
    write_all,
)
from lumped.code.words import Kernel

_TYPES = {"int": "int64_t ", "float": "double ", "bool": "bool ", "void": "void "}
_TYPES |= {"ints": "int64_t *", "numbers": "double *"}
_ELEMENT = {"ints": "int", "numbers": "float"}
_HEAD = """#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#if defined(_MSC_VER)
#pragma fp_contract(off)
#elif defined(__clang__) || !defined(__GNUC__)
#pragma STDC FP_CONTRACT OFF
#endif

/* an address that takes 64 bits, on machines with shorter ones too */
#if UINTPTR_MAX < UINT64_MAX
#define AT(declared, name) declared; int32_t name##_rest
#else
#define AT(declared, name) declared
#endif

typedef void (*Called)(const double *x, const double *p, double t, const double *m, double *out);

static inline double number_least(double a, double b) { return b < a ? b : a; }
static inline double number_greatest(double a, double b) { return b > a ? b : a; }
static inline int64_t integer_least(int64_t a, int64_t b) { return b < a ? b : a; }
static inline int64_t integer_greatest(int64_t a, int64_t b) { return b > a ? b : a; }
"""


def number(value: float) -> str:
    """A number in C, to the last digit."""
    if value != value or value in (float("inf"), -float("inf")):
        return "NAN" if value != value else "INFINITY" if value > 0 else "-INFINITY"
    return float(value).hex() if value != int(value) else repr(float(value))


def as_c(functions: Mapping[str, Callable[..., object]]) -> str:
    """C of functions and all that they call; they are visible under these symbols."""
    kernels: Any = list(functions.values())
    names = {kernel.name: symbol for symbol, kernel in zip(functions, kernels, strict=True)}
    found: list[_CFunction] = write_all(kernels, lambda k: _CFunction(k, names))
    records = declare_records(kind for f in found for kind in f.variables.values())
    heads = [f"{f.head};" for f in found]
    return "\n".join([_HEAD, records, *heads, "", *(f.text for f in found)])


def write_result(kernel: Kernel, own: Mapping[str, Any]) -> str:
    """What a function of one line returns; `own` are functions that it calls, by their symbols."""
    function = _CFunction(kernel, {called.name: symbol for symbol, called in own.items()})
    function.read()
    return function.lines[0].removeprefix("    return ").removesuffix(";")


def header(functions: Mapping[str, Callable[..., object]]) -> str:
    """Declarations of such functions and of the records that they take."""
    kernels: Any = list(functions.values())
    names = {kernel.name: symbol for symbol, kernel in zip(functions, kernels, strict=True)}
    found = [_CFunction(kernel, names) for kernel in kernels]
    records = declare_records(kind for f in found for _, kind in f.arguments)
    return "\n".join([_HEAD, records, *(f"{f.head};" for f in found), ""])


def declare_records(kinds: Iterable[Any]) -> str:
    """Types of records, with those that they point to."""
    waiting: list[type[Record]] = [kind for kind in kinds if isinstance(kind, type)]
    found: dict[str, str] = {}
    while waiting:
        kind = waiting.pop()
        if kind.__name__ not in found:
            found[kind.__name__] = _record(kind)
            waiting += [f.kind for f in kind.fields.values() if isinstance(f.kind, type)]
    names = [f"typedef struct {name} {name};" for name in sorted(found)]
    return "\n".join([*names, "", *(found[name] for name in sorted(found))])


def _record(kind: type[Record]) -> str:
    rows = []
    for field in kind.fields.values():
        text = f"{_type(field.kind)}{field.name}"
        if field.kind not in ("int", "float"):
            text = f"AT({text}, {field.name})"
        rows.append(f"    {text};")
    return f"struct {kind.__name__} {{\n" + "\n".join(rows) + "\n};"


def _type(kind: Any) -> str:
    return _TYPES[kind] if isinstance(kind, str) else f"{kind.__name__} *"


class _CFunction(Writer):
    """One function."""

    def __init__(self, kernel: Kernel, names: Mapping[str, str] | None = None) -> None:
        super().__init__(kernel)
        self._names = names or {}
        self.lines: list[str] = []
        self._tables: dict[str, str] = {}
        self._depth, self._count = 1, 0

    def _symbol(self, kernel: Kernel) -> str:
        if kernel.name in self._names:
            return self._names[kernel.name]
        return re.sub(r"\W+_*", "_", kernel.name.partition("kernel.")[2] or kernel.name)

    @property
    def head(self) -> str:
        """Its declaration."""
        given = ", ".join(f"{_type(kind)}{name}" for name, kind in self.arguments) or "void"
        linkage = "" if self.kernel.name in self._names else "static "
        return f"{linkage}{_type(self.result)}{self._symbol(self.kernel)}({given})"

    @property
    def text(self) -> str:
        """The function in C."""
        given = dict(self.arguments)
        own = [(n, k) for n, k in self.variables.items() if n not in given]
        declared = [f"    {_type(kind)}{name};" for name, kind in own]
        used = set(re.findall(r"\w+", "\n".join(self.lines)))
        declared += [f"    (void){name};" for name in given if name not in used]
        body = [*declared, *self.lines]
        return "\n".join([*self._tables.values(), self.head, "{", *body, "}\n"])

    def _line(self, text: str) -> None:
        self.lines.append("    " * self._depth + text)

    def _inner(self, body: list[ast.stmt]) -> None:
        self._depth += 1
        self.block(body)
        self._depth -= 1
        self._line("}")

    # -- statements --------------------------------------------------------------------------

    def write_if(self, test: ast.expr, yes: list[ast.stmt], no: list[ast.stmt]) -> None:
        self._line(f"if ({_bare(self.convert(self.value(test), 'bool'))}) {{")
        self._inner(yes)
        if no:
            self._line("else {")
            self._inner(no)

    def write_while(self, test: ast.expr, body: list[ast.stmt]) -> None:
        self._line(f"while ({_bare(self.convert(self.value(test), 'bool'))}) {{")
        self._inner(body)

    def write_for(
        self, name: str, bounds: tuple[Value, Value, Value], down: bool, body: list[ast.stmt]
    ) -> None:
        begin, end, step = (value.text for value in bounds)
        last = self.keep(Value(end, "int")).text
        order = ">" if down else "<"
        self._line(f"for ({name} = {begin}; {name} {order} {last}; {name} += {step}) {{")
        self._inner(body)

    def write_return(self, value: Value | None) -> None:
        self._line("return;" if value is None else f"return {_bare(value)};")

    def write_break(self) -> None:
        self._line("break;")

    def write_continue(self) -> None:
        self._line("continue;")

    def write_expression(self, value: Value) -> None:
        self._line(f"{value.text};")

    def write_variable(self, name: str, value: Value) -> None:
        self._line(f"{name} = {_bare(value)};")

    def write_element(self, base: Value, index: Value, value: Value) -> None:
        self._line(f"{self.element(base, index).text} = {_bare(value)};")

    def write_field(self, record: Value, field: Field, value: Value) -> None:
        self._line(f"{record.text}->{field.name} = {_bare(value)};")

    # -- values ------------------------------------------------------------------------------

    def number(self, value: float) -> Value:
        if isinstance(value, bool):
            return Value("true" if value else "false", "bool")
        if isinstance(value, int):
            return Value(f"INT64_C({value})" if abs(value) > 2**31 - 1 else str(value), "int")
        text = number(value)
        return Value(f"({text})" if text.startswith("-") else text, "float")

    def table(self, name: str, numbers: tuple[float, ...]) -> Value:
        symbol = f"{self._symbol(self.kernel)}_{name.strip('_')}"
        listed = ", ".join(number(value) for value in numbers)
        self._tables[name] = f"static const double {symbol}[] = {{{listed}}};"
        return Value(symbol, "numbers")

    def variable(self, name: str) -> Value:
        return Value(name, self.variables[name])

    def keep(self, value: Value) -> Value:
        self._count += 1
        name = f"kept_{self._count}"
        self.variables[name] = value.kind
        self.write_variable(name, value)
        return Value(name, value.kind)

    def field(self, record: Value, field: Field) -> Value:
        return Value(f"{record.text}->{field.name}", field.kind)

    def element(self, base: Value, index: Value) -> Value:
        return Value(f"{base.text}[{_bare(index)}]", _ELEMENT[base.kind])

    def move(self, base: Value, offset: Value) -> Value:
        return Value(f"({base.text} + {offset.text})", base.kind)

    def convert(self, value: Value, kind: Any) -> Value:
        if value.kind == kind:
            return value
        if (value.kind, kind) in (("bool", "int"), ("int", "float")):
            return Value(f"({_type(kind).strip()}){value.text}", kind)
        if (value.kind, kind) == ("int", "bool"):
            return Value(f"({value.text} != 0)", kind)
        raise TranslationError(f"{self.kernel.name}: a {value.kind} where a {kind} is needed")

    def truncate(self, value: Value) -> Value:
        return Value(f"(int64_t){value.text}", "int")

    def arithmetic(self, sign: str, a: Value, b: Value) -> Value:
        return Value(f"({a.text} {sign} {b.text})", a.kind)

    def minus(self, value: Value) -> Value:
        return Value(f"(-{value.text})", value.kind)

    def logical_not(self, value: Value) -> Value:
        return Value(f"!{value.text}" if value.text[0] == "(" else f"!({value.text})", "bool")

    def compare(self, order: str, a: Value, b: Value) -> Value:
        return Value(f"({a.text} {order} {b.text})", "bool")

    def logical(self, both: bool, parts: list[ast.expr]) -> Value:
        texts = [self.convert(self.value(part), "bool").text for part in parts]
        return Value(f"({(' && ' if both else ' || ').join(texts)})", "bool")

    def choice(self, test: ast.expr, yes: ast.expr, no: ast.expr) -> Value:
        condition = self.convert(self.value(test), "bool")
        found = [self.value(part) for part in (yes, no)]
        kind = find_common_kind(found)
        a, b = (self.convert(value, kind).text for value in found)
        return Value(f"({condition.text} ? {a} : {b})", kind)

    def extreme(self, least: bool, a: Value, b: Value) -> Value:
        kind = "integer" if a.kind == "int" else "number"
        name = f"{kind}_{'least' if least else 'greatest'}"
        return Value(f"{name}({_bare(a)}, {_bare(b)})", a.kind)

    def library(self, name: str, values: list[Value]) -> Value:
        return Value(f"{name}({', '.join(_bare(value) for value in values)})", "float")

    def call_kernel(self, kernel: Kernel, values: list[Value], result: Any) -> Value:
        listed = ", ".join(_bare(value) for value in values)
        return Value(f"{self._symbol(kernel)}({listed})", result)

    def cast(self, address: Value, kind: Any) -> Value:
        raise TranslationError(f"{self.kernel.name}: records by address")

    def any_of(self, truths: Value) -> Value:
        if truths.kind != "bool":
            raise TranslationError(f"{self.kernel.name}: wide numbers")
        return truths

    def call_by_address(self, result: Any, values: list[Value]) -> Value:
        listed = ", ".join(_bare(value) for value in values[1:])
        return Value(f"((Called)(intptr_t){values[0].text})({listed})", "void")


def _bare(value: Value) -> str:
    """Text of a value without the parentheses around it."""
    text = value.text
    if not (text.startswith("(") and text.endswith(")")):
        return text
    depth = 0
    for k, sign in enumerate(text):
        depth += (sign == "(") - (sign == ")")
        if depth == 0 and k < len(text) - 1:
            return text
    return text[1:-1]
