"""Units that are read without pint: SI and those of the trade, as powers of base units."""

from __future__ import annotations

import re
from functools import cache
from math import pi
from typing import NamedTuple


class Measure(NamedTuple):
    """A unit in base units: one of it is `factor` of them, and its zero is at `zero`.

    Parameters
    ----------
    powers : dict of str to int
        Powers of kg, m, s, A, K and rad; those that are zero are left out.
    factor, zero : float
        In base units.
    """

    powers: dict[str, int]
    factor: float = 1.0
    zero: float = 0.0

    @property
    def is_si(self) -> bool:
        """Whether values in it are those in base units."""
        return self.factor == 1.0 and not self.zero


_ONE: dict[str, int] = {}
_WORK = {"kg": 1, "m": 2, "s": -2}
_SI = {
    "A": {"A": 1},
    "C": {"A": 1, "s": 1},
    "F": {"kg": -1, "m": -2, "s": 4, "A": 2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "Hz": {"s": -1},
    "J": _WORK,
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
_PREFIXES = {"u": 1e-6, "m": 1e-3, "k": 1e3, "M": 1e6, "G": 1e9}
_PREFIXED = ("A", "F", "H", "Hz", "J", "N", "Ohm", "Pa", "V", "W", "m", "rad", "s")
_UNITS = {
    **{name: Measure(powers) for name, powers in _SI.items()},
    **{p + name: Measure(_SI[name], size) for p, size in _PREFIXES.items() for name in _PREFIXED},
    "%": Measure(_ONE, 0.01),
    "bar": Measure(_SI["Pa"], 1e5),
    "cm": Measure(_SI["m"], 1e-2),
    "deg": Measure(_SI["rad"], pi / 180),
    "degC": Measure(_SI["K"], 1.0, 273.15),
    "g": Measure(_SI["kg"], 1e-3),
    "h": Measure(_SI["s"], 3600.0),
    "kWh": Measure(_WORK, 3.6e6),
    "min": Measure(_SI["s"], 60.0),
    "rpm": Measure({"rad": 1, "s": -1}, 2 * pi / 60),
    "t": Measure(_SI["kg"], 1e3),
    "turn": Measure(_SI["rad"], 2 * pi),
}
_FACTOR = re.compile(r"([A-Za-z%]+)(-?\d*)$")


@cache
def measure(unit: str) -> Measure | None:
    """A unit such as ``kN.m``, ``N.m.s/rad2`` or ``rad/(s.N.m)``; None if it is not known here."""
    if unit in _UNITS:
        return _UNITS[unit]
    above, slash, below = unit.partition("/")
    if below.startswith("(") and below.endswith(")"):
        below = below[1:-1]
    elif "." in below:
        return None
    if slash and not (above and below):
        return None
    powers: dict[str, int] = {}
    size = 1.0
    for part, sign in ((above, 1), (below, -1)):
        for factor in part.split(".") if part not in ("", "1") else ():
            found = _FACTOR.match(factor)
            one = None if found is None else _UNITS.get(found.group(1))
            if found is None or one is None or one.zero:
                return None
            power = sign * int(found.group(2) or 1)
            size *= one.factor**power
            for base, own in one.powers.items():
                powers[base] = powers.get(base, 0) + own * power
    return Measure({base: power for base, power in powers.items() if power}, size)
