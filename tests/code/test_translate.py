"""The language of the time loop: Python, LLVM and C compute the same."""

import ctypes
import math
from typing import Annotated

import numpy as np
import pytest
from compiled_c import compile_c

from lumped.code.machine_code import Code, compile_module
from lumped.code.records import Record, address
from lumped.code.to_c import as_c
from lumped.code.to_llvm import as_llvm
from lumped.code.translate import TranslationError
from lumped.code.words import Integers, Kernel, Numbers, kernel, sqrt

TABLE = (0.5, -1.25, 3e-7, 1e300)
OFFSET = 3
_CALL = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p)


def statements(n: Integers, x: Numbers) -> float:
    """Loops, choices and assignments of every kind."""
    total, count = 0.0, 0
    for i in range(n[0]):
        if i % 3 == 1:
            continue
        if total > 50.0:
            break
        for j in range(i, 0, -2):
            total += x[j % 4] * j
        count += 1
    k = 10
    while k > 0:
        k -= 3
        if k == 4:
            n[1] = k
    a = b = total + count // 2
    a, b = b - 1, a + 1.5
    if (count > 2 and total > 0.0) or not k < 0:
        a = -a
    elif count == 1:
        a = 7.0
    else:
        b = 8.0
    n[2], x[4] = count, a
    return a + b * (2 if count > 3 else 0.25)


def values(n: Integers, x: Numbers) -> float:
    """Operations of every kind."""
    total = abs(x[0]) + sqrt(abs(x[1])) + x[2] ** 3 - min(x[0], x[1]) * max(x[2], 0.5)
    total += TABLE[n[0] % 4] / OFFSET + (1 if x[0] <= x[1] else -2.5)
    total -= float(n[0] // 2) + int(x[2] * 10) + (1 if x[0] != x[1] else 0) + 1e-3 * (n[0] % 5)
    inside = x[0] < math.inf and (x[1] >= 0.0) == (x[2] >= 0.0)
    return total if inside else -total * 0.1


CODES = []


def by_llvm(functions):
    code = Code(compile_module(True, as_llvm(functions)))
    CODES.append(code)  # machine code lives as long as this
    return {name: _CALL(code.address(name)) for name in functions}


def by_c(functions, folder):
    library = compile_c(functions, folder)
    for name in functions:
        function = getattr(library, name)
        function.restype, function.argtypes = ctypes.c_double, [ctypes.c_void_p] * 2
    return {name: getattr(library, name) for name in functions}


def same_in_all(function, tmp_path, given):
    """What a function gives and writes, in Python, by LLVM and by C."""
    marked = {"f": kernel(function)}
    engines = [by_llvm(marked)["f"], by_c(marked, tmp_path)["f"]]
    for n, x in given:
        other_n, other_x = n.copy(), x.copy()
        expected = float(function(n, x))
        for made in engines:
            own_n, own_x = other_n.copy(), other_x.copy()
            assert made(own_n.ctypes.data, own_x.ctypes.data) == expected
            np.testing.assert_array_equal(own_x, x)
            np.testing.assert_array_equal(own_n, n)


@pytest.mark.parametrize("function", [statements, values])
def test_machine_code_and_c_compute_what_python_computes(function, tmp_path):
    rng = np.random.default_rng(1)
    given = [(np.array([count, 0, 0]), rng.uniform(-2, 2, 5)) for count in range(12)]
    same_in_all(function, tmp_path, given)


@kernel
def halved(x: Numbers, n: int) -> None:
    """Called by the next."""
    for i in range(n):
        x[i] = 0.5 * x[i]


def calling(n: Integers, x: Numbers) -> float:
    """Functions and addresses."""
    halved(x[1:], n[0])
    return x[n[0] :][0]


def test_functions_call_each_other_with_addresses(tmp_path):
    x, n = np.arange(6.0), np.array([3])
    same_in_all(calling, tmp_path, [(n, x)])
    np.testing.assert_array_equal(x, [0.0, 0.5, 1.0, 1.5, 4.0, 5.0])


class Inner(Record):
    """A record inside another."""

    count: int
    sums: Annotated[Numbers, "parts"]


class Outer(Record):
    """A record with all kinds of fields."""

    size: int
    total: float
    values: Annotated[Numbers, "parts"]
    flags: Annotated[Integers, "parts + 1"]
    given: Numbers
    inner: Inner


@kernel
def sums(outer: Outer, unused: Numbers) -> float:
    """Writes fields of two records."""
    inner = outer.inner
    for i in range(outer.size):
        outer.total += outer.values[i] * outer.given[i]
        inner.sums[i] = outer.total
        outer.flags[i] = outer.total > 1.0
        inner.count += outer.flags[i]
    outer.flags[outer.size] = inner.count
    return outer.total


@pytest.mark.parametrize("engine", ["python", "llvm", "c"])
def test_records_are_the_same_to_all(engine, tmp_path):
    given = np.array([0.5, 2.0, -1.0])
    outer = Outer({"parts": 3}, size=3, given=given, inner=Inner({"parts": 3}))
    outer.values[:] = [1.0, 2.0, 3.0]
    if engine == "python":
        found = sums(outer, given)
    else:
        made = by_llvm({"f": sums}) if engine == "llvm" else by_c({"f": sums}, tmp_path)
        found = made["f"](address(outer), given.ctypes.data)
    assert (found, outer.total, outer.inner.count) == (1.5, 1.5, 2)
    np.testing.assert_array_equal(outer.inner.sums, [0.5, 4.5, 1.5])
    np.testing.assert_array_equal(outer.flags, [0, 1, 1, 2])


def test_a_field_that_a_record_does_not_have_is_an_error():
    with pytest.raises(AttributeError, match="'Inner' object has no attribute 'counts'"):
        Inner({"parts": 1}).counts = 3


@pytest.mark.parametrize(
    "line",
    [
        "return [n[0]][0]",
        "return 1.0 < x[0] < 2.0",
        "n[0] = 1.5\n    return 0.0",
        "with x:\n        return 0.0",
        "return print(x[0])",
        "return x[0] @ x[1]",
    ],
)
def test_what_the_language_does_not_have_is_an_error(line):
    source = f"def f(n: Integers, x: Numbers) -> float:\n    {line}\n"
    for language in (as_llvm, as_c):
        with pytest.raises(TranslationError, match=r"^f: "):
            language({"f": Kernel("f", {}, print, source)})
