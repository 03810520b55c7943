"""Values of parts that are alike or differ one by one."""

from __future__ import annotations

from typing import Any

from lumped import Component
from lumped.errors import DeclarationError, shown

__all__: list[str] = []


def one_for_each(component: Component, name: str, count: int) -> list[Any]:
    """A value for each of some parts, from a field that holds one for all or one for each.

    Raises
    ------
    DeclarationError
        If the field holds another number of values.
    """
    given = getattr(component, name)
    if not isinstance(given, tuple):
        return [given] * count
    if len(given) != count:
        raise DeclarationError(
            f"{component._label()}: {name} = {shown(given)}: one number for all, or {count} of "
            f"them are needed, {len(given)} were given."
        )
    return list(given)
