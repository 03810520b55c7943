"""Components: declarations as class attributes, equations and connections as generators."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self, dataclass_transform

import numpy as np

from lumped.errors import DeclarationError, UnknownNameError, nearest, shown, told_by
from lumped.language.declaration_checks import refuse_shared, refuse_slips
from lumped.language.dotted_path import find_member, list_members, replace_member, split_key, steps
from lumped.language.expression import Equation, Expr
from lumped.language.pickling import rebuild, reduce_component
from lumped.language.port import Connection, Port
from lumped.language.quantity import Input, Output, Quantity, Var
from lumped.language.signature import DocumentationSlot, SignatureSlot
from lumped.language.switch import Item
from lumped.support.arguments import checked
from lumped.support.rich_html import RichHtml
from lumped.support.units import plain

Outline = tuple[str, Sequence[tuple[Expr | float, Expr | float]]]
"""A name, and points in a plane."""


_SIGNAL = (
    ", or an expression of lumped.time such as 5 * lumped.ops.sin(lumped.time) or "
    "lumped.ops.table(times, values), or a connection to a signal"
)
"""Types that an input may have besides numbers."""


class _Slot:
    """Class attribute that is read from an instance; of the class it is what was declared."""

    def __init__(self, name: str, default: Any, read: Callable[[Component, str], Any]) -> None:
        self._name, self._default, self._read = name, default, read

    def __get__(self, obj: Component | None, owner: type) -> Any:
        return self._default if obj is None else self._read(obj, self._name)


class Made:
    """Parts that a function makes of a component, as many as its structural choices need.

    Written as a class attribute, ``pieces = Made(function)``. Parameters of the parts may be bound
    to expressions of the component's own, or of what is beside it.

    Parameters
    ----------
    function : callable
        Gets the component and gives a list or dictionary of parts.
    """

    def __init__(self, function: Callable[[Any], Any]) -> None:
        self._function = function

    def parts(self, component: Component, name: str) -> Any:
        """The parts of a component.

        Raises
        ------
        DeclarationError
            If the function gives anything else.
        """
        with told_by(component._label(), f"the parts '{name}'"):
            made = self._function(component)
        if made != [] and not is_part(made):
            raise DeclarationError(
                f"{component._label()}: '{name}' is made as {shown(made)}; a component (or list or "
                "dictionary of components) is needed."
            )
        return made


@dataclass_transform(eq_default=False, kw_only_default=True)
class Component(RichHtml):
    """Base of all components and models.

    A subclass declares quantities (`param`, `var`, `Input`, `Output`), ports and parts as class
    attributes, yields its equations from `equations` and its connections from `connections`.
    It yields equations that hold at the start only, such as ``der(self.w) == 0``, from
    `initial_equations`. Plain annotated class attributes are structural choices, fixed at
    flattening.

    Parameters
    ----------
    **values
        For a parameter a number (or, inside a class body, an expression of the enclosing
        component's parameters); for a variable its start value, which then holds exactly;
        for an input a number (a parameter from then on) or an expression of the time and of the
        enclosing component's parameters; for a part a replacement; for a structural field its
        value.

    Raises
    ------
    UnknownNameError
        If a name is not declared.
    DeclarationError
        If a value is of the wrong sort.
    """

    _quantities: ClassVar[dict[str, Quantity]] = {}
    _ports: ClassVar[dict[str, Port]] = {}
    _parts: ClassVar[dict[str, Any]] = {}
    _fields: ClassVar[dict[str, Any]] = {}

    symbol: ClassVar[str] = "box"
    """Name of the symbol in schematics; a subclass writes ``symbol = "inertia"``."""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        tables: tuple[dict[str, Any], ...] = ({}, {}, {}, {})
        for base in reversed(cls.__mro__[1:]):
            if issubclass(base, Component):
                inherited: list[dict[str, Any]]
                inherited = [base._quantities, base._ports, base._parts, base._fields]
                for table, own in zip(tables, inherited, strict=True):
                    table.update(own)
        cls._quantities, cls._ports, cls._parts, cls._fields = tables
        refuse_slips(cls, Component)
        for name, value in list(vars(cls).items()):
            if name.startswith("_"):
                continue
            home = _table_of(tables, name, value, vars(cls).get("__annotations__", {}))
            if home is None:
                continue
            for table in tables:
                table.pop(name, None)
            home[name] = value
            if home is cls._parts:
                setattr(cls, name, _Slot(name, value, Component._part))
            elif home is cls._fields:
                setattr(cls, name, _Slot(name, value, Component._field))
        refuse_shared(cls.__name__, _select_given(cls._parts))
        cls.__doc__ = DocumentationSlot(cls.__doc__)  # type: ignore[assignment]

    def __init__(self, *positional: Any, **values: Any) -> None:
        if positional:
            kind = type(self).__name__
            first = next(iter([*self._quantities, *self._parts, *self._fields]), "name")
            raise DeclarationError(
                f"{kind}({shown(positional[0])}): give values by their names, such as "
                f"{kind}({first}=...)."
            )
        given = {name: self._check_value(name, value) for name, value in values.items()}
        object.__setattr__(self, "_values", given)
        object.__setattr__(self, "_place", None)
        object.__setattr__(self, "_bound", {})
        if any(name in self._parts for name in given):
            held = {name: given.get(name, default) for name, default in self._parts.items()}
            refuse_shared(type(self).__name__, _select_given(held))

    __signature__ = SignatureSlot(__init__)

    _values: dict[str, Any]
    _place: tuple[Component, str] | None
    _bound: dict[str | Made, Any]

    def equations(self) -> Iterable[Item]:
        """Equations of the component, and its `hold` and `when` items; yielded one by one."""
        return ()

    def initial_equations(self) -> Iterable[Equation | tuple[Equation, ...]]:
        """Equations that hold at the start of a run only; yielded one by one."""
        return ()

    def connections(self) -> Iterable[Connection]:
        """Connections between the component's parts; yielded one by one."""
        return ()

    def valid(self) -> Iterable[tuple[Expr, float, float, str, str, str]]:
        """Where the equations hold; yielded one by one.

        Runs, equilibria and responses that leave a range are errors. A range is an expression of
        the component's own quantities, the least and the largest value, their unit, what the
        expression is, and what to do where a value lies outside, a sentence without its full stop.
        """
        return ()

    def stored(self) -> Expr | None:
        """Energy that the component stores, J, of its own quantities; None if it does not say."""
        return None

    def loss(self) -> Expr | None:
        """Power that it dissipates, W, of its own quantities; None if it does not say."""
        return None

    def rating(self) -> tuple[str, Expr] | None:
        """Unit and value of what schematics tell of it, of its own parameters.

        None for the first parameter that is not zero.
        """
        return None

    def outline(self) -> Iterable[Outline]:
        """Moving shapes in a plane, for pictures: a name, and the points of a line, or one point.

        Points are horizontal and vertical positions in m, expressions of the component's
        quantities.
        """
        return ()

    @checked
    def with_(self, changes: Mapping[str, Any]) -> Self:
        """A copy with other values.

        Parameters
        ----------
        changes : mapping of str to value
            Dotted names (``"shaft.c"``, ``"mass[3].J"``) and their new values.

        Raises
        ------
        UnknownNameError
            If a name is not declared.
        """
        values = dict(self._values)
        below: dict[str, dict[str, Any]] = {}
        for path, value in changes.items():
            head, *others = steps(path) or [""]
            rest = ".".join(others)
            if rest:
                below.setdefault(head, {})[rest] = value
            elif "[" in head:
                slot, key = split_key(head)
                held = self._find_parts(slot, values)
                if not isinstance(held, Mapping):
                    find_member(held, key, slot)
                values[slot] = replace_member(held, key, value)
            else:
                values[head] = value
        for head, inner in below.items():
            slot, key = split_key(head)
            held = self._find_parts(slot, values)
            values[slot] = replace_member(held, key, find_member(held, key, slot).with_(inner))
        return type(self)(**values)

    def _find_parts(self, slot: str, values: Mapping[str, Any]) -> Any:
        if slot not in self._parts:
            raise UnknownNameError(
                f"{type(self).__name__} has no part '{slot}'. {nearest(slot, self._parts)}"
            )
        held = values.get(slot, self._parts[slot])
        if isinstance(held, Made):
            raise DeclarationError(
                f"{type(self).__name__}: its parts '{slot}' follow from its own values. Change "
                "those."
            )
        return held

    if not TYPE_CHECKING:  # type checkers shall go on finding misspelt names

        def __getattr__(self, name: str) -> Any:
            if name.startswith("_"):
                raise AttributeError(name)
            known = [*self._quantities, *self._ports, *self._parts, *self._fields]
            raise UnknownNameError(f"{self._label()} has no '{name}'. {nearest(name, known)}")

    def __setattr__(self, name: str, value: object) -> None:
        if "_values" not in vars(self):
            raise DeclarationError(
                f"{type(self).__name__}.__init__ assigns {name}. Leave __init__ out and declare "
                f"{name} in the class, such as {name}: Param = param(unit, text); values are then "
                f"given as {type(self).__name__}({name}=...)."
            )
        raise DeclarationError(
            f"{name} of {self._label()} cannot be assigned: components are values. "
            f"Use .with_({{'{name}': ...}}), which gives a changed copy."
        )

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    def __reduce_ex__(self, protocol: Any) -> tuple[Any, ...]:
        return reduce_component(self, self._values, self._place)

    def __repr__(self) -> str:
        inner = ", ".join(f"{k}={v!r}" for k, v in self._values.items())
        return f"{type(self).__name__}({inner})"

    def _label(self) -> str:
        path, kind = path_of(self), type(self).__name__
        return f"{path} ({kind})" if path else kind

    def _default(self, name: str) -> Any:
        held = self._values.get(name, self._parts.get(name))
        if not isinstance(held, Made):
            return held
        if held not in self._bound:
            self._bound[held] = held.parts(self, name)
        return self._bound[held]

    def _check_value(self, name: str, value: Any) -> Any:
        kind = type(self).__name__
        if name in self._quantities:
            quantity = self._quantities[name]
            if isinstance(quantity, Output):
                raise DeclarationError(
                    f"{kind}({name}=...): '{name}' is an output; the component determines it."
                )
            if isinstance(value, Expr):
                return value
            more = f" ({quantity.text})" + (_SIGNAL if isinstance(quantity, Input) else "")
            return plain(value, quantity.unit, f"{kind}({name}=...):", DeclarationError, more)
        if name in self._parts:
            if not is_part(value):
                raise DeclarationError(
                    f"{kind}({name}={value!r}): a component (or list or dictionary of "
                    "components) is needed."
                )
            return value
        if name in self._fields:
            if isinstance(self._fields[name], bool) and not isinstance(value, bool | np.bool_):
                raise DeclarationError(f"{kind}({name}={shown(value)}): True or False is needed.")
            return _freeze(value)
        given = [n for n, q in self._quantities.items() if not isinstance(q, Output)]
        start = [n for n in given if isinstance(self._quantities[n], Var)]
        known = [*self._fields, *(n for n in given if n not in start), *self._parts, *start]
        raise UnknownNameError(f"{kind} has no '{name}'. {nearest(name, known)}")

    def _copy_at(self, parent: Component, name: str) -> Self:
        return rebuild(type(self), self._values, (parent, name))

    def _part(self, name: str) -> Any:
        bound = self._bound.get(name)
        if bound is None:
            held = self._default(name)
            if isinstance(held, Component):
                bound = held._copy_at(self, name)
            elif isinstance(held, Mapping):
                bound = {k: c._copy_at(self, f'{name}["{k}"]') for k, c in held.items()}
            else:
                bound = tuple(c._copy_at(self, f"{name}[{i}]") for i, c in enumerate(held))
            self._bound[name] = bound
        return bound

    def _field(self, name: str) -> Any:
        return self._values.get(name, self._fields[name])

    def _children(self) -> Iterator[tuple[str, Component]]:
        for name in self._parts:
            yield from list_members(name, self._part(name))


def _table_of(
    tables: tuple[dict[str, Any], ...], name: str, value: Any, annotations: Mapping[str, Any]
) -> dict[str, Any] | None:
    if isinstance(value, Quantity):
        return tables[0]
    if isinstance(value, Port):
        return tables[1]
    if isinstance(value, Made) or is_part(value):
        return tables[2]
    if inspect.isroutine(value) or isinstance(value, property | classmethod | staticmethod):
        return None
    return tables[3] if name in annotations or name in tables[3] else None


def _select_given(parts: Mapping[str, Any]) -> dict[str, Any]:
    """Parts that no function makes."""
    return {name: held for name, held in parts.items() if not isinstance(held, Made)}


def _freeze(value: Any) -> Any:
    """Arrays and lists as tuples, so that equal choices compare equal."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    return tuple(_freeze(v) for v in value) if isinstance(value, list | tuple) else value


def is_part(value: object) -> bool:
    """Whether a value is a component, or a list or dictionary of components."""
    if isinstance(value, Component):
        return True
    if isinstance(value, Mapping) and all(isinstance(key, str) for key in value):
        value = list(value.values())
    return (
        isinstance(value, list | tuple)
        and bool(value)
        and all(isinstance(v, Component) for v in value)
    )


def path_of(component: Component) -> str:
    """Dotted path of a component from the top of its tree."""
    names: list[str] = []
    while component._place is not None:
        component, name = component._place
        names.append(name)
    return ".".join(reversed(names))
