"""The language of the time loop: what it computes, the same text computes in Python."""

import ctypes
import math

import numpy as np
import pytest

pytest.importorskip("llvmlite")

from lumped.kernel.machine_code import Code, compiled
from lumped.kernel.translate import TranslationError, translated
from lumped.kernel.words import Integers, Kernel, Numbers, at, kernel

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
    total = abs(x[0]) + math.sqrt(abs(x[1])) + x[2] ** 3 - min(x[0], x[1]) * max(x[2], 0.5)
    total += TABLE[n[0] & 3] / OFFSET + (1 if x[0] <= x[1] else -2.5)
    total -= float(n[0] // 2) + int(x[2] * 10) + (1 if x[0] != x[1] else 0) + 1e-3 * (n[0] | 5)
    inside = x[0] < math.inf and (x[1] >= 0.0) == (x[2] >= 0.0)
    return total if inside else -total * 0.1


def evaluated(function, n, x):
    """By machine code."""
    marked = kernel(function)
    code = Code(compiled(translated({"f": marked}), True), ["f"])
    return _CALL(code.addresses["f"])(n.ctypes.data, x.ctypes.data)


@pytest.mark.parametrize("function", [statements, values])
def test_machine_code_computes_what_python_computes(function):
    rng = np.random.default_rng(1)
    for count in range(12):
        x, n = rng.uniform(-2, 2, 5), np.array([count, 0, 0])
        other_x, other_n = x.copy(), n.copy()
        expected = float(function(n, x))
        assert evaluated(function, other_n, other_x) == expected
        np.testing.assert_array_equal(other_x, x)
        np.testing.assert_array_equal(other_n, n)


@kernel
def halved(x: Numbers, n: int) -> None:
    """Called by the next."""
    for i in range(n):
        x[i] = 0.5 * x[i]


def calling(n: Integers, x: Numbers) -> float:
    """Functions and addresses."""
    halved(at(x, 1), n[0])
    return at(x, n[0])[0]


def test_functions_call_each_other_with_addresses():
    x, n = np.arange(6.0), np.array([3])
    assert evaluated(calling, n, x) == 1.5
    np.testing.assert_array_equal(x, [0.0, 0.5, 1.0, 1.5, 4.0, 5.0])


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
    with pytest.raises(TranslationError, match=r"^f: "):
        translated({"f": Kernel("f", source, {})})
