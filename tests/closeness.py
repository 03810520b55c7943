"""How far a received curve is from an expected one."""

import numpy as np


def apart(received, expected):
    """Largest difference over the range of what is expected."""
    return float(np.abs(received - expected).max() / (np.ptp(expected) or np.abs(expected).max()))


def assert_close(received, expected, rtol, what):
    error = np.abs(received - expected).max() / np.abs(expected).max()
    print(f"{what}: largest error {error:.1e} of the largest value")
    assert error <= rtol
