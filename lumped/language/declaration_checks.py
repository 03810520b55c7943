"""Declarations of components that are refused."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Any

from lumped.errors import DeclarationError
from lumped.language.dotted_path import list_members
from lumped.language.port import Port
from lumped.language.quantity import Quantity

_METHODS = ("connections", "equations", "initial_equations")
_FREE = ("loss", "stored")
"""Optional methods whose names quantities and ports may have; then nothing is told by them."""
_ALIKE = 0.88
"""Likeness of names above which one counts as the other misspelt."""


def refuse_slips(cls: type, base: type) -> None:
    """Refuse declarations that Python accepts but that must be mistakes; `base` is `Component`."""
    own, kinds = vars(cls), (base, Port, Quantity)
    for name in own.get("__annotations__", {}):
        if name not in own and not name.startswith("_"):
            raise DeclarationError(
                f"{cls.__name__}.{name} is annotated but has no value; write for example "
                f"{name}: Param = param(unit, text), or give a structural field its default."
            )
    for name in own:
        meant = get_close_matches(name, _METHODS, 1, _ALIKE)
        if meant and name not in _METHODS and inspect.isroutine(own[name]):
            raise DeclarationError(
                f"{cls.__name__}.{name}: is the method '{meant[0]}' meant? Write it so, or choose "
                "a name less alike."
            )
    declared = {id(value) for kind in cls.__mro__ for value in vars(kind).values()}
    for name, value in own.items():
        if isinstance(value, type) and issubclass(value, kinds):
            raise DeclarationError(
                f"{cls.__name__}.{name} is the class {value.__name__} itself; "
                f"write {value.__name__}(...), with parentheses."
            )
        if isinstance(value, kinds) and name.startswith("_"):
            raise DeclarationError(
                f"{cls.__name__}.{name}: names that begin with an underscore are not seen as parts "
                "of a component; choose another."
            )
        held = list(value.values()) if isinstance(value, Mapping) else value
        if isinstance(held, list | tuple) and any(
            isinstance(v, Port | Quantity) and id(v) not in declared for v in held
        ):
            raise DeclarationError(
                f"{cls.__name__}.{name}: quantities and ports in a list or dictionary are no "
                "declarations. Declare each by its own name, or declare one in a component, such "
                f"as Piece, and hold these in a list: {name} = [Piece() for _ in "
                f"range({len(held)})]."
            )
        if isinstance(value, kinds) and hasattr(base, name) and name not in _FREE:
            raise DeclarationError(
                f"{cls.__name__}.{name}: '{name}' is a name that components use themselves; "
                "choose another."
            )


def refuse_shared(kind: str, parts: Mapping[str, Any]) -> None:
    """Refuse a part that is in two places."""
    seen: dict[int, str] = {}
    for name, held in parts.items():
        if isinstance(held, Mapping):
            _refuse_keys(kind, name, held)
        for place, part in list_members(name, held):
            if id(part) in seen:
                raise DeclarationError(
                    f"{kind}: '{seen[id(part)]}' and '{place}' are the same "
                    f"{type(part).__name__} object. A component stands in one place of a "
                    f"parent; write {type(part).__name__}(...) once for each."
                )
            seen[id(part)] = place


def _refuse_keys(kind: str, name: str, held: Iterable[str]) -> None:
    """Refuse keys that cannot be in the name of a quantity, in a file or in a program."""
    for key in held:
        if not key or not key.isprintable() or set(key) & set("\"'[]\\"):
            raise DeclarationError(
                f"{kind}: a part of '{name}' is called {key!r}. A key needs at least one letter, "
                "and no quotation mark, square bracket, backslash, line break or other control "
                "character."
            )
