"""Reference files of the eccentric shear, computed independently with numpy and scipy."""

from pathlib import Path

import numpy as np

DEGREES = np.radians(np.arange(361.0))


def data(name: str) -> np.ndarray:
    path = Path(__file__).parents[2] / "data" / "eccentric_shear" / f"{name}.csv"
    return np.genfromtxt(path, delimiter=",", names=True, deletechars="")


def apart(received: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference over the range of what is expected."""
    return float(np.abs(received - expected).max() / (np.ptp(expected) or np.abs(expected).max()))


def nearest(phi: np.ndarray) -> np.ndarray:
    """Rows of a run that stand at the degrees of a turn."""
    rows = np.abs(phi[:, None] - DEGREES).argmin(axis=0)
    assert np.abs(phi[rows] - DEGREES).max() < 1e-9
    return rows
