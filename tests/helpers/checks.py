"""What many tests compare with, and how."""

import numpy as np
import pytest

from lumped.kernel import engine

STEP = 1e-30j


def worst(received, expected):
    """Largest difference, relative to the largest expected value."""
    error = np.abs(np.asarray(received) - expected).max() / max(np.abs(expected).max(), 1e-300)
    print(f"error over range {error:.2e}")
    return error


def apart(received, expected):
    """Largest difference over the range of what is expected."""
    return float(np.abs(received - expected).max() / (np.ptp(expected) or np.abs(expected).max()))


def assert_close(received, expected, rtol, what):
    error = np.abs(received - expected).max() / np.abs(expected).max()
    print(f"{what}: largest error {error:.1e} of the largest value")
    assert error <= rtol


def by_complex_step(function, point):
    """Derivatives of all numbers that a function gives, shape (numbers, len(point))."""
    columns = [
        np.imag(function(*moved)) / STEP.imag for moved in point + STEP * np.identity(len(point))
    ]
    return np.array(columns).T


def refused(kind, action, *words):
    """The text of the error with which an action ends; it has these words."""
    with pytest.raises(kind) as caught:
        action()
    text = str(caught.value)
    print(f"\n{kind.__name__}: {text}")
    for word in words:
        assert word in text
    return text


def in_all_engines(action):
    """What an action gives in machine code, in C and in Python."""
    found = []
    for name in ("llvm", "c", "python"):
        with engine.using(name):
            found.append(action())
    return found
