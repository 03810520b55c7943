"""Transistor amplifier of the IVP test set, as published and with its capacitors as they are."""

import numpy as np

import lumped as lp
from benchmarks.published.problem import Problem
from lumped.ops import exp, sin

SUPPLY, R, GAIN = 6.0, 9000.0, 0.99
START = (0.0, 3.0, 3.0, 6.0, 3.0, 3.0, 6.0, 0.0)
JOINED = (1, 2), (3, 0), (4, 5), (6, 0), (7, 8)  # by capacitors of 1 to 5 uF; 0 is the ground


class Circuit(lp.Component):
    """Voltages of eight nodes and of what lies between them."""

    for _i in range(1, 9):
        locals()[f"y{_i}"] = lp.var("V", "")

    def currents(self):
        """Currents that flow out of each node, without the capacitors."""
        y1, y2, y3, y4, y5, y6, y7, y8 = (getattr(self, f"y{i}") for i in range(1, 9))
        one, two = (1e-6 * (exp(u / 0.026) - 1) for u in (y2 - y3, y5 - y6))
        return (
            (y1 - 0.1 * sin(200 * np.pi * lp.time)) / 1000.0,
            (2 * y2 - SUPPLY) / R + (1 - GAIN) * one,
            y3 / R - one,
            (y4 - SUPPLY) / R + GAIN * one,
            (2 * y5 - SUPPLY) / R + (1 - GAIN) * two,
            y6 / R - two,
            (y7 - SUPPLY) / R + GAIN * two,
            y8 / R,
        )


class AsPublished(Circuit):
    """``M y' = f``, where M is singular: two rows for a capacitor between two nodes."""

    def equations(self):
        flows = self.currents()
        for k, (a, b) in enumerate(JOINED, 1):
            rate = lp.der(getattr(self, f"y{a}")) - (lp.der(getattr(self, f"y{b}")) if b else 0.0)
            yield 1e-6 * k * rate == -flows[a - 1]
            if b:
                yield 1e-6 * k * rate == flows[b - 1]


class WithCapacitors(Circuit):
    """Each capacitor has a voltage and a current."""

    for _i in range(1, 6):
        locals()[f"u{_i}"] = lp.var("V", "")
        locals()[f"i{_i}"] = lp.var("A", "")

    def equations(self):
        flows = self.currents()
        for k, (a, b) in enumerate(JOINED, 1):
            voltage, current = getattr(self, f"u{k}"), getattr(self, f"i{k}")
            yield voltage == getattr(self, f"y{a}") - (getattr(self, f"y{b}") if b else 0.0)
            yield current == 1e-6 * k * lp.der(voltage)
            yield current == -flows[a - 1]
            if b:
                yield current == flows[b - 1]


AMPLIFIER = Problem(
    "transistor amplifier",
    "IVP test set, transamp",
    WithCapacitors,
    0.2,
    {
        "y1": -0.5562145012262709e-2,
        "y2": 3.006522471903042,
        "y3": 2.849958788608128,
        "y4": 2.926422536206241,
        "y5": 2.704617865010554,
        "y6": 2.761837778393145,
        "y7": 4.770927631616772,
        "y8": 1.236995868091548,
    },
    start={f"y{i}": value for i, value in enumerate(START, 1)},
)
