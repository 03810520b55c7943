"""Words of the small language in which the time loop is written (see `translate`).

The functions here are never called from Python; they tell the type checker what the words mean.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

__all__ = ["Integers", "Kernel", "Numbers", "at", "doubles", "evaluate", "integers", "kernel"]


class Integers(Protocol):
    """Address of integers of 64 bits."""

    def __getitem__(self, place: int) -> int: ...
    def __setitem__(self, place: int, value: int) -> None: ...


class Numbers(Protocol):
    """Address of numbers of double precision."""

    def __getitem__(self, place: int) -> float: ...
    def __setitem__(self, place: int, value: float) -> None: ...


Pointer = TypeVar("Pointer", Integers, Numbers)
Written = TypeVar("Written", bound=Callable[..., object])


def at(pointer: Pointer, offset: int) -> Pointer:
    """The address some places further on."""
    raise NotImplementedError


def doubles(address: int) -> Numbers:
    """Numbers at an address that is given as an integer."""
    raise NotImplementedError


def integers(address: int) -> Integers:
    """Integers at an address that is given as an integer."""
    raise NotImplementedError


def evaluate(address: int, x: Numbers, p: Numbers, t: float, m: Numbers, out: Numbers) -> None:
    """Call a function of a system (see `emit`)."""
    raise NotImplementedError


@dataclass(frozen=True)
class Kernel:
    """A function written in the language.

    Attributes
    ----------
    name : str
        Its symbol.
    source : str
        Its text.
    space : dict
        What the names in it mean.
    """

    name: str
    source: str
    space: dict[str, Any]


def kernel(function: Written) -> Written:
    """Mark a function as part of the language; only others that are marked call it."""
    name = f"{function.__module__}.{function.__name__}"
    made: Any = Kernel(name, inspect.getsource(function), function.__globals__)
    return made  # type: ignore[no-any-return]
