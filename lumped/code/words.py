"""Words of the small language in which the time loop is written (see `translate`).

A kernel is a Python function that is also translated into LLVM assembly and into C. Called from
Python it runs unchanged, for a debugger and for tests.
"""

from __future__ import annotations

import ast
import ctypes
import ctypes.util
import textwrap
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

Integers = NDArray[np.int64]
"""Array of 64-bit integers; ``n[k:]`` is the array from k on."""

Numbers = NDArray[np.float64]
"""Array of double-precision numbers."""


if TYPE_CHECKING:
    # all that numbers can do, wide ones can
    Wide: TypeAlias = Any
    Wides: TypeAlias = Any
else:

    class Wide:
        """A number for each of several lanes, side by side; only machine code has them."""

    class Wides:
        """Array of wide numbers, as a field of a record or an argument."""


def flat(wides: Any) -> Numbers:
    """The numbers of wide ones: all lanes of the first, then of the second."""
    raise NotImplementedError


def any_lane(truths: Any) -> bool:
    """Whether something holds in one of the lanes; of a single number, whether it holds."""
    return bool(truths)


def record_at(kind: Any, address: int) -> Any:
    """The record at an address."""
    raise NotImplementedError


def enter(address: int, record: Any) -> int:
    """Call an entry of the time loop by its address."""
    raise NotImplementedError


def call_wide(address: int, x: Any, p: Any, t: Any, m: Any, out: Any) -> None:
    """Call a function of a plant for all lanes."""
    raise NotImplementedError


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
    """A mathematical function of the C library."""

    c_name: str

    def __call__(self, *values: float) -> float:
        """Call it in Python."""
        found: float = np.float64(getattr(_LIBRARY, self.c_name)(*values))
        return found


def _load_library() -> Any:
    """The mathematical functions of the C library."""
    library = ctypes.CDLL(ctypes.util.find_library("m") or ctypes.util.find_library("msvcrt"))
    for name in (*ONE, *TWO):
        function = getattr(library, name)
        function.restype = ctypes.c_double
        function.argtypes = [ctypes.c_double] * (2 if name in TWO else 1)
    return library


ONE = (
    *("sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh"),
    *("acosh", "atanh", "exp", "expm1", "log", "log1p", "erf", "floor", "ceil"),
)
TWO = ("atan2", "hypot", "fmod", "remainder", "copysign", "fmin", "fmax", "pow")
"""Functions of the C library with one argument, and with two."""
_LIBRARY = _load_library()
(sqrt, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, asinh) = map(Library, ONE[:11])
(acosh, atanh, exp, expm1, log, log1p, erf, floor, ceil) = map(Library, ONE[11:])
(atan2, hypot, fmod, remainder, copysign, fmin, fmax, power) = map(Library, TWO)


@dataclass(frozen=True, eq=False)
class Kernel:
    """A function written in the language.

    Attributes
    ----------
    name : str
        Its symbol.
    space : dict
        Values of the names in it.
    function : callable
        The same in Python.
    text : str
        Its text, if no file has it.
    is_wide : bool
        Whether its numbers are wide. A function that never branches on a number can be.
    """

    name: str
    space: dict[str, Any]
    function: Callable[..., Any]
    text: str = ""
    is_wide: bool = False

    @property
    def tree(self) -> ast.FunctionDef:
        """Its text, parsed."""
        if self.text:
            return _parse_function(self.text)
        code = self.function.__code__
        return _parse_function(_sources(code.co_filename)[code.co_firstlineno])

    @property
    def widened(self) -> Kernel:
        """The same for wide numbers."""
        return replace(self, name=f"{self.name}.wide", is_wide=True)

    def __call__(self, *arguments: Any) -> Any:
        """Call it in Python."""
        return self.function(*arguments)


def kernel(function: Written) -> Written:
    """Mark a function as part of the language; only other kernels may call it."""
    name = f"{function.__module__}.{function.__name__}"
    made: Any = Kernel(name, function.__globals__, function)
    return made


@cache
def _parse_function(source: str) -> ast.FunctionDef:
    tree = ast.parse(textwrap.dedent(source)).body[0]
    assert isinstance(tree, ast.FunctionDef)
    return tree


@cache
def _sources(file: str) -> dict[int, str]:
    """Texts of the functions of a module by their first lines.

    `inspect.getsource` goes through the module once for each function.
    """
    text = Path(file).read_text(encoding="utf-8")
    lines = text.splitlines(keepends=True)
    found = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)]
    begins = [min([node.lineno, *(d.lineno for d in node.decorator_list)]) for node in found]
    return {
        begin: "".join(lines[begin - 1 : node.end_lineno])
        for begin, node in zip(begins, found, strict=True)
    }


def make_kernel(name: str, text: str, space: dict[str, Any]) -> Any:
    """A kernel from its text."""
    own: dict[str, Any] = {}
    exec("from __future__ import annotations\n" + text, space, own)
    return Kernel(f"{space['__name__']}.{name}", space, own[name], text)


@kernel
def copy_numbers(count: int, given: Numbers, out: Numbers) -> None:
    """Copy so many numbers."""
    for i in range(count):
        out[i] = given[i]


@kernel
def least_of(given: Numbers, top: int) -> float:
    """The least of the first number and so many after it."""
    found = given[0]
    for j in range(1, top + 1):
        found = min(found, given[j])
    return found


@kernel
def greatest_of(given: Numbers, top: int) -> float:
    """The greatest of the first number and so many after it."""
    found = given[0]
    for j in range(1, top + 1):
        found = max(found, given[j])
    return found


@kernel
def largest_of(count: int, given: Numbers) -> float:
    """The largest size of so many numbers."""
    found = 0.0
    for i in range(count):
        found = max(found, abs(given[i]))
    return found


@kernel
def last_up_to(given: Numbers, stride: int, low: int, high: int, most: float) -> int:
    """Number of the last of ascending numbers, each a stride apart, that is no greater.

    It is sought from `low`, which needs not be one, up to but without `high`.
    """
    while high - low > 1:
        middle = (low + high) // 2
        if given[middle * stride] <= most:
            low = middle
        else:
            high = middle
    return low
