"""What a component declares and is given, under names that models cannot use themselves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from inspect import cleandoc
from typing import Any

from lumped.language.component import Component, Made
from lumped.language.dotted_path import list_members
from lumped.language.port import Port
from lumped.language.quantity import Quantity
from lumped.language.signature import DocumentationSlot


def quantities_of(component: Component | type[Component]) -> Mapping[str, Quantity]:
    """Declared parameters, variables and signals by name."""
    return component._quantities


def ports_of(component: Component | type[Component]) -> Mapping[str, Port]:
    """Declared ports by name."""
    return component._ports


def fields_of(cls: type[Component]) -> Iterable[str]:
    """Names of the settings that are no quantities, such as tables."""
    return cls._fields


def has_parts(cls: type[Component]) -> bool:
    """Whether a class declares parts of its own."""
    return bool(cls._parts)


def text_of(cls: type[Component]) -> str:
    """The docstring written in a class, without the list of its declarations; empty if none."""
    held = vars(cls)["__doc__"]
    return cleandoc((held.written if isinstance(held, DocumentationSlot) else held) or "")


def values_of(component: Component) -> Mapping[str, Any]:
    """What its constructor was given, by name."""
    return component._values


def place_of(component: Component) -> tuple[Component, str] | None:
    """The component that holds it, and its name there; None at the top."""
    return component._place


def parts_of(component: Component) -> Iterator[tuple[str, Component]]:
    """Names of the parts that it holds, and the parts."""
    return component._children()


def origins_of(scope: Component) -> dict[int, str]:
    """Objects that the parts of a component were made from, and their place.

    What a class declared for a part stands for it in the classes that inherit from it, too.
    """
    bases = [base for base in reversed(type(scope).__mro__) if issubclass(base, Component)]
    declared = [item for base in bases for item in base._parts.items()]
    places: dict[int, str] = {}
    for slot, held in (*declared, *((slot, scope._default(slot)) for slot in scope._parts)):
        if slot in scope._parts and not isinstance(held, Made):
            places.update({id(part): place for place, part in list_members(slot, held)})
    return places
