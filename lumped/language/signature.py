"""What `help` and `inspect.signature` say of a component class, made from it when asked."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from lumped.errors import shown
from lumped.language.expression import Expr
from lumped.language.port import Port
from lumped.language.quantity import Input, Output, Param, Quantity, Var

_Entry = tuple[str, str, str]
"""A name, what sort of thing it is, and its meaning."""


class SignatureSlot:
    """Attribute ``__signature__`` of component classes: what their constructors take.

    Parameters
    ----------
    init : callable
        Constructor of all components; a class that has another is described by that.
    """

    def __init__(self, init: Callable[..., None]) -> None:
        self._init = init

    def __get__(self, obj: object, owner: Any) -> inspect.Signature:
        if obj is not None or owner.__init__ is not self._init:
            raise AttributeError("__signature__")
        return inspect.Signature([*_arguments(owner)])


class DocumentationSlot:
    """Attribute ``__doc__`` of a component class: what is written there, and its declarations.

    Attributes
    ----------
    written : str or None
        The docstring in the class.
    """

    def __init__(self, written: str | None) -> None:
        self.written = written

    def __get__(self, obj: object, owner: Any) -> str:
        quantities, ports = owner._quantities, owner._ports
        given = {n: q for n, q in quantities.items() if isinstance(q, Param | Input)}
        lists = {
            "Parameters": [
                *((n, f"{kind}, default {shown(v)}", "") for n, kind, v in _fields(owner)),
                *((name, _quantity(q), q.text) for name, q in given.items()),
                *((name, kind, "") for name, kind in _parts(owner)),
            ],
            "Variables": _of_kind(quantities, Var),
            "Outputs": _of_kind(quantities, Output),
            "Ports": [(name, _port(port), "") for name, port in ports.items()],
        }
        sections = [_section(title, entries) for title, entries in lists.items() if entries]
        written = inspect.cleandoc(self.written or "")
        return "\n\n".join(text for text in (written, *sections) if text)


class _NotGiven:
    """Default of an argument that may be left out without a value taking its place."""

    def __repr__(self) -> str:
        return "..."


def _arguments(cls: Any) -> Iterator[inspect.Parameter]:
    def argument(name: str, kind: str, default: Any) -> inspect.Parameter:
        return inspect.Parameter(name, _BY_NAME, default=default, annotation=kind)

    quantities: Mapping[str, Quantity] = cls._quantities
    for name, kind, value in _fields(cls):
        yield argument(name, kind, value)
    for name, quantity in quantities.items():
        if isinstance(quantity, Param):
            default = quantity.default
            number = isinstance(default, float | int)
            empty = inspect.Parameter.empty if default is None else _NOT_GIVEN
            yield argument(name, quantity.unit, default if number else empty)
        elif isinstance(quantity, Input):
            yield argument(name, quantity.unit, _NOT_GIVEN)
    for name, kind in _parts(cls):
        yield argument(name, kind, _NOT_GIVEN)
    for name, quantity in quantities.items():
        if isinstance(quantity, Var):
            yield argument(name, quantity.unit, _NOT_GIVEN)


_BY_NAME = inspect.Parameter.KEYWORD_ONLY
_NOT_GIVEN = _NotGiven()


def _fields(cls: Any) -> Iterator[tuple[str, str, Any]]:
    """Structural choices, their annotations and defaults."""
    written: dict[str, Any] = {}
    for base in reversed(cls.__mro__):
        written.update(vars(base).get("__annotations__", {}))
    for name, value in cls._fields.items():
        kind = written[name]
        yield name, kind if isinstance(kind, str) else inspect.formatannotation(kind), value


def _parts(cls: Any) -> Iterator[tuple[str, str]]:
    """Parts, and what they are."""
    for name, held in cls._parts.items():
        if isinstance(held, Mapping):
            kind = f"parts {', '.join(map(repr, held))}"
        elif isinstance(held, list | tuple):
            kind = f"{len(held)} parts"
        else:
            kind = type(held).__name__ if hasattr(held, "_quantities") else "made parts"
        yield name, kind


def _of_kind(quantities: Mapping[str, Quantity], kind: type[Quantity]) -> list[_Entry]:
    return [(n, _quantity(q), q.text) for n, q in quantities.items() if isinstance(q, kind)]


def _quantity(quantity: Quantity) -> str:
    """Unit, range and default of a quantity."""
    if isinstance(quantity, Param):
        return ", ".join([quantity.unit, *_range(quantity), *_default(quantity)])
    if isinstance(quantity, Input):
        return f"{quantity.unit}, input"
    unsaid = isinstance(quantity.start, float | int) and quantity.start == 0
    return quantity.unit if unsaid else f"{quantity.unit}, start {shown(quantity.start)}"


def _range(parameter: Param) -> Iterator[str]:
    if parameter.exceeds is not None:
        other = parameter.exceeds
        low = repr(other) if isinstance(other, Expr) else "a value that follows from others"
        yield f"{parameter.lower.words} {low}"
    for bound in parameter.bounds:
        yield f"{bound.words} {bound.limit:g}"


def _default(parameter: Param) -> Iterator[str]:
    if callable(parameter.default):
        yield "default follows from others"
    elif parameter.default is not None:
        yield f"default {shown(parameter.default)}"


def _port(port: Port) -> str:
    rest = ", free if open" if port.free else ", at rest if open" if port.grounded else ""
    return f"{port.kind}{rest}"


def _section(title: str, entries: list[_Entry]) -> str:
    lines = [title, "-" * len(title)]
    for name, kind, text in entries:
        lines += [f"{name} : {kind}", *([f"    {text}"] if text else [])]
    return "\n".join(lines)
