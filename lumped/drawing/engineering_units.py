"""Units in which engineers read the results of a torsional vibration calculation."""

from __future__ import annotations

import numpy as np

__all__ = ["engineering"]

_SHOWN = {
    "N.m": ("kN.m", 1e-3),
    "N.m/rad": ("kN.m/rad", 1e-3),
    "Pa": ("MPa", 1e-6),
    "W": ("kW", 1e-3),
    "rad": ("deg", 180 / np.pi),
    "rad/s": ("1/min", 30 / np.pi),
}


def engineering(unit: str) -> tuple[str, float]:
    """The unit in which a quantity is shown, and by what its value in SI units is multiplied."""
    return _SHOWN.get(unit, (unit, 1.0))
