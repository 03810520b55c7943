"""Connections between components, and models built without a class."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from lumped.errors import ConnectError, DeclarationError
from lumped.language.component import Component, is_part, path_of
from lumped.language.expression import Equation, Expr, Ref
from lumped.language.port import Connection, Port
from lumped.language.quantity import Input, Output, Quantity
from lumped.support.arguments import checked


def connect(*ends: Port | Expr) -> Connection:
    """Join ports (or signals) of the same kind in one node.

    Parameters
    ----------
    *ends : Port or signal reference
        Two or more.

    Returns
    -------
    Connection

    Raises
    ------
    ConnectError
        If the ends are of different kinds, fewer than two, or not ports.
    """
    found: list[Port | Ref] = []
    for end in ends:
        signal = isinstance(end, Ref) and isinstance(end.quantity, Input | Output)
        if not (isinstance(end, Port) or signal):
            what = repr(end)
            hint = ""
            if isinstance(end, Component):
                what = end._label()
                hint = f" Name one of its ports: {', '.join(end._ports) or 'it has none'}."
            elif isinstance(end, Ref):
                what = f"the quantity '{label(end)}'"
                hint = " Only ports and signals connect; a sensor makes a signal of it."
            raise ConnectError(f"connect: {what} is not a port.{hint}")
        found.append(end)  # type: ignore[arg-type]
    if len(found) < 2:
        raise ConnectError(
            f"connect({', '.join(label(end) for end in found)}): at least two ports are needed."
        )
    if len({(id(end.owner), end.name) for end in found}) < len(found):
        named = ", ".join(label(end) for end in found)
        raise ConnectError(f"connect({named}): one end is named twice.")
    kinds = {_kind(end) for end in found}
    if len(kinds) > 1:
        listed = ", ".join(f"{label(end)} ({_kind(end)})" for end in found)
        raise ConnectError(
            f"connect: ports of different kinds meet: {listed}. Put a component between them "
            "that has both kinds (for rotation and translation a rack and pinion)."
        )
    return Connection(tuple(found))


def _kind(end: Port | Ref) -> str:
    return end.kind if isinstance(end, Port) else "signal"


def label(end: Port | Ref) -> str:
    """Dotted name of a port or signal from the top of its tree."""
    prefix = path_of(end.owner)
    return f"{prefix}.{end.name}" if prefix else end.name


@checked
def chain(*parts: Component | Port) -> Iterator[Connection]:
    """Connect parts one after the other: ``flange_b`` of each to ``flange_a`` of the next.

    A part with a single ``flange`` (a source, a support) may be at either end; a port may be
    named instead of a part.

    Parameters
    ----------
    *parts : Component or Port
        In their order.

    Returns
    -------
    iterator of Connection
        One for each two neighbours.

    Raises
    ------
    ConnectError
        If a part lacks the port needed at its place.
    """
    for before, after in itertools.pairwise(parts):
        yield connect(_end(before, "b"), _end(after, "a"))


def _end(part: Component | Port, side: str) -> Port:
    if isinstance(part, Port):
        return part
    name = f"flange_{side}"
    if name not in part._ports:
        if "flange" not in part._ports:
            raise ConnectError(
                f"chain: {type(part).__name__} {path_of(part)} has no '{name}'; "
                f"name one of its ports instead: {', '.join(part._ports) or 'it has none'}."
            )
        name = "flange"
    port: Port = getattr(part, name)
    return port


@checked
def compose(
    *,
    connections: Iterable[Connection] | Callable[[Any], Iterable[Connection]] = (),
    initial_equations: Callable[[Any], Iterable[Equation]] | None = None,
    name: str = "Model",
    **members: Any,
) -> Component:
    """Build a model without writing a class.

    Parameters
    ----------
    connections : iterable of Connection, or callable
        Connections between the given parts; a callable gets the finished model.
    initial_equations : callable, optional
        Gets the finished model and gives equations that hold at the start only.
    name : str
        Name of the model in texts.
    **members
        Parts (components, lists or dictionaries of them), ports and parameters, by name.

    Returns
    -------
    Component
        An instance of a new class.

    Raises
    ------
    DeclarationError
        If a member is none of these.
    """
    if not name or not name.isprintable():
        raise DeclarationError(f"compose: name = {name!r}: letters are needed.")
    joints = connections if callable(connections) else tuple(connections)

    def join(self: Component) -> Iterable[Connection]:
        return joints(self) if callable(joints) else joints

    for key, value in members.items():
        if not key.isidentifier() or key.startswith("_"):
            raise DeclarationError(
                f"compose: {key!r} is no name: letters, digits and underscores, beginning with a "
                "letter."
            )
        if not (is_part(value) or isinstance(value, Port | Quantity)):
            raise DeclarationError(
                f"compose({key}={value!r}): a component, a list or dictionary of components, "
                "a port or a parameter is needed."
            )
    body = {"__doc__": name, **members, "connections": join}
    if initial_equations is not None:
        body["initial_equations"] = initial_equations
    cls = type(name, (Component,), body)
    model: Component = cls()
    return model
