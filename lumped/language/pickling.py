"""Copies of components, and how they are pickled."""

from __future__ import annotations

import sys
from contextvars import ContextVar
from typing import Any, TypeVar

from lumped.support.optional_packages import extra

_C = TypeVar("_C")

_whole: ContextVar[bool] = ContextVar("whole", default=False)
"""Whether a model is being pickled with its classes, so that its parts need not add theirs."""


def rebuild(cls: type[_C], values: dict[str, Any], place: Any) -> _C:
    """An instance from values already checked."""
    made = object.__new__(cls)
    object.__setattr__(made, "_values", values)
    object.__setattr__(made, "_place", place)
    object.__setattr__(made, "_bound", {})
    return made


def reduce_component(component: object, values: dict[str, Any], place: Any) -> tuple[Any, ...]:
    """What pickle makes a component from; with its class if that cannot be imported."""
    if _whole.get() or _importable(type(component)):
        return rebuild, (type(component), values, place)
    cloudpickle = extra(
        "cloudpickle", "cluster", f"To pickle {type(component).__name__}, which cannot be imported,"
    )
    token = _whole.set(True)
    try:
        return cloudpickle.loads, (cloudpickle.dumps(component),)
    finally:
        _whole.reset(token)


def _importable(cls: type) -> bool:
    """Whether another process finds a class by its name."""
    found: Any = None if cls.__module__ == "__main__" else sys.modules.get(cls.__module__)
    for name in cls.__qualname__.split("."):
        found = getattr(found, name, None)
    return found is cls
