"""SI units as powers of base units."""

from __future__ import annotations

import re

__all__ = ["DISPLAYED", "base_powers"]

DISPLAYED = {"rad": ("deg", 57.29577951308232), "rad/s": ("rpm", 9.549296585513721)}
"""Units that people read, and how many of them one SI unit is."""

_UNITS = {
    "A": {"A": 1},
    "C": {"A": 1, "s": 1},
    "F": {"kg": -1, "m": -2, "s": 4, "A": 2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "Hz": {"s": -1},
    "J": {"kg": 1, "m": 2, "s": -2},
    "K": {"K": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "T": {"kg": 1, "s": -2, "A": -1},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Wb": {"kg": 1, "m": 2, "s": -2, "A": -1},
    "kg": {"kg": 1},
    "m": {"m": 1},
    "rad": {"rad": 1},
    "s": {"s": 1},
}
_FACTOR = re.compile(r"([A-Za-z]+)(-?\d*)$")


def base_powers(unit: str) -> dict[str, int] | None:
    """Powers of kg, m, s, A, K and rad in a unit such as ``N.m.s/rad2``; None if unknown."""
    above, _, below = unit.partition("/")
    powers: dict[str, int] = {}
    for part, sign in ((above, 1), (below.strip("()"), -1)):
        for factor in part.split(".") if part not in ("", "1") else ():
            found = _FACTOR.match(factor)
            if found is None or found.group(1) not in _UNITS:
                return None
            for base, power in _UNITS[found.group(1)].items():
                powers[base] = powers.get(base, 0) + sign * int(found.group(2) or 1) * power
    return {base: power for base, power in powers.items() if power}
