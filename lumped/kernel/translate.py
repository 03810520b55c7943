"""A small part of Python as LLVM assembly.

Functions take and give integers, numbers, truth values and addresses. There are assignments,
``if``, ``while``, ``for`` over a range, arithmetic, comparisons and calls; integers are not
negative where they are divided. A name that is not assigned to is a constant of its module: a
number, a tuple of numbers or another function of this kind. Operations keep their order and
rounding.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from typing import Any

from lumped.kernel.expressions import Expressions, TranslationError, Value, definition, ir_type
from lumped.kernel.words import Kernel

__all__ = ["TranslationError", "translated"]

_DECLARED = "\n".join(
    f"declare double @llvm.{name}.f64({', '.join(['double'] * count)})"
    for name, count in (("fabs", 1), ("sqrt", 1), ("pow", 2))
)


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


class _Translator(Expressions):
    """One function."""

    def __init__(self, kernel: Kernel) -> None:
        super().__init__(kernel)
        self._tree = definition(kernel)
        self._loops: list[tuple[str, str]] = []

    def text(self, linkage: str) -> str:
        """LLVM assembly of the function."""
        given = []
        for argument in self._tree.args.args:
            kind = self.annotated(argument.annotation)
            given.append(f"{ir_type(kind)} %{argument.arg}")
            self.store(argument.arg, Value(f"%{argument.arg}", kind))
        self._result = self.annotated(self._tree.returns)
        self._block(self._tree.body)
        self.lines.append("  ret void" if self._result == "void" else "  unreachable")
        name, result = self.kernel.name, ir_type(self._result)
        head = f'define {linkage}{result} @"{name}"({", ".join(given)}) {{'
        body = "\n".join(["entry:", *self.head, *self.lines, "}"])
        return "\n".join([*self.constants, head, body])

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
            self._set(node.target, self.value(now))
        elif isinstance(node, ast.If):
            yes, no, end = (self.fresh(w) for w in ("yes", "no", "end"))
            self.branch(node.test, yes, no)
            for label, body in ((yes, node.body), (no, node.orelse)):
                self.label(label)
                self._block(body)
                self.lines.append(f"  br label %{end}")
            self.label(end)
        elif isinstance(node, ast.While):
            self._while(node)
        elif isinstance(node, ast.For):
            self._for(node)
        elif isinstance(node, ast.Return):
            if node.value is None:
                self.lines.append("  ret void")
            else:
                value = self.as_kind(self.value(node.value), self._result)
                self.lines.append(f"  ret {ir_type(self._result)} {value.text}")
            self.label(self.fresh("after"))
        elif isinstance(node, ast.Break | ast.Continue):
            self.jump(self._loops[-1][isinstance(node, ast.Continue)])
        elif isinstance(node, ast.Expr):
            if not isinstance(node.value, ast.Constant):
                self.value(node.value)
        elif not isinstance(node, ast.Pass):
            raise self.unknown(node)

    def _assign(self, node: ast.Assign) -> None:
        first = node.targets[0]
        if isinstance(first, ast.Tuple) and isinstance(node.value, ast.Tuple):
            found = [self.value(part) for part in node.value.elts]
            for target, value in zip(first.elts, found, strict=True):
                self._set(target, value)
            return
        value = self.value(node.value)
        for target in node.targets:
            self._set(target, value)

    def _set(self, target: ast.expr, value: Value) -> None:
        if isinstance(target, ast.Name):
            self.store(target.id, value)
        elif isinstance(target, ast.Subscript):
            place = self.element(target)
            value = self.as_kind(value, place.kind)
            self.lines.append(f"  store {place.kind} {value.text}, ptr {place.text}")
        else:
            raise self.unknown(target)

    def _while(self, node: ast.While) -> None:
        test, body, end = (self.fresh(w) for w in ("test", "body", "end"))
        self.enter(test)
        self.branch(node.test, body, end)
        self.label(body)
        self._loops.append((end, test))
        self._block(node.body)
        self._loops.pop()
        self.lines.append(f"  br label %{test}")
        self.label(end)

    def _for(self, node: ast.For) -> None:
        assert isinstance(node.target, ast.Name)
        assert isinstance(node.iter, ast.Call)
        bounds = [self.value(argument) for argument in node.iter.args]
        begin = bounds[0] if len(bounds) > 1 else Value("0", "i64")
        stop = bounds[min(1, len(bounds) - 1)].text
        step = bounds[2].text if len(bounds) > 2 else "1"
        test, body, following, end = (self.fresh(w) for w in ("test", "body", "next", "end"))
        name = node.target.id
        self.store(name, begin)
        self.enter(test)
        now = self.load(name)
        order = "sgt" if step.startswith("-") else "slt"
        more = self.put(f"icmp {order} i64 {now.text}, {stop}", "i1")
        self.lines.append(f"  br i1 {more.text}, label %{body}, label %{end}")
        self.label(body)
        self._loops.append((end, following))
        self._block(node.body)
        self._loops.pop()
        self.enter(following)
        self.store(name, self.put(f"add nsw i64 {self.load(name).text}, {step}", "i64"))
        self.lines.append(f"  br label %{test}")
        self.label(end)
