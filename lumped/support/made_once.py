"""Results made once for an object that threads share, and kept in it."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Generic, TypeVar, TypeVarTuple

from lumped.support.process_lock import process_lock

T = TypeVar("T")
S = TypeVar("S", bound="Shared")
Arguments = TypeVarTuple("Arguments")


class Shared:
    """An object that threads share; one thread at a time makes missing results.

    Attributes
    ----------
    made : dict
        Results of the functions marked `made_once` for this object.
    """

    def __init__(self) -> None:
        self.made: dict[object, Any] = {}


def made_once(function: Callable[[S, *Arguments], T]) -> Callable[[S, *Arguments], T]:
    """Call a function once for an object and further arguments, and keep the result."""

    @wraps(function)
    def call_once(owner: S, *arguments: *Arguments) -> T:
        key, found = (function, arguments) if arguments else function, owner.made
        if key not in found:
            with process_lock:
                if key not in found:
                    found[key] = function(owner, *arguments)
        made: T = found[key]
        return made

    return call_once


class Recent(Generic[T]):
    """Results for the keys that were made last.

    Parameters
    ----------
    most : int
        How many are kept.
    """

    def __init__(self, most: int) -> None:
        self._most, self._known = most, dict[object, T]()

    def of(self, key: object, make: Callable[[], T]) -> T:
        """The result for a key, made now if needed; threads may make it at the same time."""
        known = self._known  # never changed in place, as others may read it
        if key in known:
            return known[key]
        found = make()
        self._known = dict([*self._known.items(), (key, found)][-self._most :])
        return found
