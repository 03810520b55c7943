"""Words of the small language in which the time loop is written (see `translate`).

A kernel is a Python function that is also translated into LLVM assembly and into C. Called from
Python it runs as it stands, which is good for a debugger and for tests.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

__all__ = ["Integers", "Kernel", "Library", "Numbers", "call", "kernel", "sqrt", "written"]


Integers = NDArray[np.int64]
"""Integers of 64 bits that stand one after the other; ``n[k:]`` are those from k on."""

Numbers = NDArray[np.float64]
"""Numbers of double precision that stand one after the other."""

Written = TypeVar("Written", bound=Callable[..., object])

_POINTER = ctypes.c_void_p
_CALLED = ctypes.CFUNCTYPE(None, _POINTER, _POINTER, ctypes.c_double, _POINTER, _POINTER)


def call(address: int, x: Numbers, p: Numbers, t: float, m: Numbers, out: Numbers) -> None:
    """Call a function of a plant by its address (see `lumped.kernel.plant`)."""
    arrays: Any = (x, p, m, out)
    x_at, p_at, m_at, out_at = (array.ctypes.data for array in arrays)
    _CALLED(int(address))(x_at, p_at, t, m_at, out_at)


@dataclass(frozen=True)
class Library:
    """A function of the C library, of numbers."""

    c_name: str

    def __call__(self, *values: float) -> float:
        """Call it in Python."""
        found: float = np.float64(getattr(_LIBRARY, self.c_name)(*values))
        return found


def _loaded() -> Any:
    """The C library's functions of numbers."""
    library = ctypes.CDLL(ctypes.util.find_library("m") or ctypes.util.find_library("msvcrt"))
    for name in (*_ONE, *_TWO):
        function = getattr(library, name)
        function.restype = ctypes.c_double
        function.argtypes = [ctypes.c_double] * (2 if name in _TWO else 1)
    return library


_ONE = (
    *("sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh"),
    *("acosh", "atanh", "exp", "expm1", "log", "log1p", "erf", "floor", "ceil"),
)
_TWO = ("atan2", "hypot", "fmod", "remainder", "copysign", "fmin", "fmax", "pow")
_LIBRARY = _loaded()
(sqrt, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, asinh) = map(Library, _ONE[:11])
(acosh, atanh, exp, expm1, log, log1p, erf, floor, ceil) = map(Library, _ONE[11:])
(atan2, hypot, fmod, remainder, copysign, fmin, fmax, power) = map(Library, _TWO)


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
    function : callable
        The same in Python.
    """

    name: str
    source: str
    space: dict[str, Any]
    function: Callable[..., Any]

    def __call__(self, *arguments: Any) -> Any:
        """Call it in Python."""
        return self.function(*arguments)


def kernel(function: Written) -> Written:
    """Mark a function as part of the language; only others that are marked call it."""
    name = f"{function.__module__}.{function.__name__}"
    made: Any = Kernel(name, inspect.getsource(function), function.__globals__, function)
    return made


def written(name: str, source: str, space: dict[str, Any]) -> Any:
    """A kernel from its text."""
    own: dict[str, Any] = {}
    exec("from __future__ import annotations\n" + source, space, own)
    function = own[name]
    return Kernel(f"{space['__name__']}.{name}", source, space, function)
