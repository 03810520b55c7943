"""Electrical parts that feed a motor, and sensors.

Pins have a potential `v` in V and a current `i` in A into the part. A part with the pins `p` and
`n` has the voltage ``v = v_p - v_n`` and the current `i` from p to n. Every circuit needs a
`Ground`, which sets the potential zero.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from lumped import Component, Equation, Expr, Input, Output, Param, Pin, Var, der, param, var
from lumped.components.rows import check_rows
from lumped.errors import EquationError
from lumped.language.validity import Range
from lumped.language.value_types import Rows
from lumped.ops import interpolate, maximum, minimum, smooth

__all__ = [
    "Battery",
    "Capacitor",
    "CurrentSensor",
    "CurrentSource",
    "Ground",
    "Inductor",
    "Inverter",
    "Resistor",
    "VariableResistor",
    "VoltageSensor",
    "VoltageSource",
]


class Ground(Component):
    """Potential zero: ``v = 0``. One for each circuit that nothing else grounds."""

    symbol = "earth"
    pin = Pin()

    def equations(self) -> Iterator[Equation]:
        yield self.pin.v == 0


class _TwoPin(Component):
    """Voltage and current between two pins."""

    p = Pin()
    n = Pin()
    v: Var = var("V", "voltage from p to n")
    i: Var = var("A", "current from p to n")

    def equations(self) -> Iterator[Equation]:
        yield self.v == self.p.v - self.n.v
        yield self.p.i == self.i
        yield self.n.i == -self.i


class Resistor(_TwoPin):
    """Resistor: ``v = R i``; its heat is ``v i``."""

    symbol = "resistor"
    R: Param = param("Ohm", "resistance", min=0)

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self.v == self.R * self.i


class VariableResistor(_TwoPin):
    """Resistor that is changed, such as a starter: ``v = R i`` with `R` as a signal."""

    symbol = "resistor"
    R: Input = Input("Ohm", "resistance")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self.v == self.R * self.i


class Inductor(_TwoPin):
    """Inductor: ``v = L der(i)``."""

    symbol = "inductor"
    L: Param = param("H", "inductance; for none, leave the inductor out", above=0)
    i: Var = var("A", "current from p to n", state="prefer")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self.v == self.L * der(self.i)


class Capacitor(_TwoPin):
    """Capacitor: ``i = C der(v)``."""

    symbol = "capacitor"
    C: Param = param("F", "capacitance; for none, leave the capacitor out", above=0)
    v: Var = var("V", "voltage from p to n", state="prefer")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self.i == self.C * der(self.v)


class VoltageSource(Component):
    """Ideal source of voltage: ``v_p - v_n = v``, whatever current that takes.

    `i` is the current that it delivers at p.
    """

    symbol = "voltage"
    p = Pin()
    n = Pin()
    v: Input = Input("V", "voltage")
    i: Var = var("A", "current delivered at p")

    def equations(self) -> Iterator[Equation]:
        yield self.p.v - self.n.v == self.v
        yield self.p.i == -self.i
        yield self.n.i == self.i


class CurrentSource(Component):
    """Ideal source of current: delivers ``i_p = -i`` at p, whatever voltage that takes."""

    symbol = "current"
    p = Pin()
    n = Pin()
    i: Input = Input("A", "current delivered at p")
    v: Var = var("V", "voltage from p to n")

    def equations(self) -> Iterator[Equation]:
        yield self.v == self.p.v - self.n.v
        yield self.p.i == -self.i
        yield self.n.i == self.i


class VoltageSensor(Component):
    """Ideal sensor of a voltage: ``v = v_p - v_n``; takes no current."""

    symbol = "meter_v"
    p = Pin()
    n = Pin()
    v = Output("V", "voltage from p to n")

    def equations(self) -> Iterator[Equation]:
        yield self.p.i == 0
        yield self.n.i == 0
        yield self.v == self.p.v - self.n.v


class CurrentSensor(Component):
    """Ideal sensor in a wire: ``i = i_p``, the current from p to n; no voltage across it."""

    symbol = "meter_a"
    p = Pin()
    n = Pin()
    i = Output("A", "current from p to n")

    def equations(self) -> Iterator[Equation]:
        yield self.p.v == self.n.v
        yield self.p.i + self.n.i == 0
        yield self.i == self.p.i


class Battery(Component):
    """Battery: ``v = ocv(soc) - R i - R_1 i_1``, ``Q der(soc) = -i``, ``T_1 der(i_1) = i - i_1``.

    `ocv` are rows of the state of charge and the voltage without current, joined by straight lines;
    a run that leaves them ends with an error. `R_1` with the time constant `T_1` is a resistance
    beside a capacitance in series with `R`; without it the voltage follows at once. `i` is the
    current delivered at p, negative while it is charged. Source: Plett, Battery Management Systems
    1 (2015), ch. 2.
    """

    symbol = "battery"
    p = Pin()
    n = Pin()
    ocv: Rows = ()
    Q: Param = param("A.s", "capacity", above=0)
    R: Param = param("Ohm", "inner resistance", min=0)
    R_1: Param = param("Ohm", "resistance beside a capacitance; 0: none", 0.0, min=0)
    T_1: Param = param("s", "time constant of this resistance", 1.0, above=0)
    soc: Var = var("1", "state of charge", 1.0, state="always")
    i_1: Var = var("A", "current in the resistance R_1", state="always")
    v: Var = var("V", "voltage from p to n")
    i: Var = var("A", "current delivered at p")

    def equations(self) -> Iterator[Equation]:
        yield self.v == self.p.v - self.n.v
        yield self.p.i == -self.i
        yield self.n.i == self.i
        places, voltages = self._rows()
        open_circuit = interpolate(self.soc, places, voltages)
        yield self.v == open_circuit - self.R * self.i - self.R_1 * self.i_1
        yield self.Q * der(self.soc) == -self.i
        yield self.T_1 * der(self.i_1) == self.i - self.i_1

    def _rows(self) -> tuple[list[float], list[float]]:
        """States of charge and voltages that make sense.

        Raises
        ------
        EquationError
            If there are fewer than two rows of two numbers, states of charge do not increase within
            0 and 1, or voltages are not positive or fall.
        """
        what, example = "state of charge and voltage (V)", "((0, 300), (0.5, 350), (1, 400))"
        found = check_rows("ocv", self.ocv, what, example, least=2)
        for (soc, v), (next_soc, next_v) in pairwise(found):
            if not 0 <= soc < next_soc <= 1:
                raise EquationError(
                    f"ocv: states of charge must increase from 0 to 1, but {soc:g} -> {next_soc:g}."
                )
            if not 0 < v <= next_v < float("inf"):
                raise EquationError(
                    f"ocv: voltages must be positive and not fall with the charge, but {v:g} V at "
                    f"{soc:g} -> {next_v:g} V at {next_soc:g}."
                )
        places, voltages = zip(*found, strict=True)
        return list(places), list(voltages)

    def loss(self) -> Expr:
        """Heat in the resistances, W."""
        return self.R * self.i**2 + self.R_1 * self.i_1**2

    def valid(self) -> Iterator[Range]:
        """States of charge of the rows."""
        places, _ = self._rows()
        advice = "Take less charge, or give rows up to there"
        yield Range(self.soc, places[0], places[-1], "1", "state of charge", advice)


class Inverter(Component):
    """Four-quadrant converter, averaged over its switching: ``v_dc i_dc = v_out i`` (no loss).

    ``T_d der(v_out) = v - v_out`` with `v` limited to the direct voltage on either side, which it
    measures through a filter: ``T_f der(v_f) = v_dc - v_f``. `i` is the current delivered at p.

    ``psi der(i_dc) = v_out i - v_dc i_dc`` reaches this balance within ``psi / v_dc`` (some
    nanoseconds). Of the two currents that a source with an inner resistance allows, this finds the
    stable one.
    """

    symbol = "inverter"
    dc_p = Pin()
    dc_n = Pin()
    p = Pin()
    n = Pin()
    v: Input = Input("V", "wanted voltage")
    T_d: Param = param("s", "dead time of the switching", above=0)
    T_f: Param = param("s", "time constant of the measured direct voltage", above=0)
    psi: Param = param("V.s", "direct voltage times time to the power balance", 1e-6, above=0)
    i_dc: Var = var("A", "current taken at dc_p", state="prefer")
    i: Var = var("A", "current delivered at p")
    v_out: Var = var("V", "voltage from p to n", state="prefer")
    v_f: Var = var("V", "measured direct voltage", state="prefer")
    v_dc = Output("V", "measured direct voltage")

    def equations(self) -> Iterator[Equation]:
        direct = self.dc_p.v - self.dc_n.v
        yield self.dc_p.i == self.i_dc
        yield self.dc_n.i == -self.i_dc
        yield self.p.i == -self.i
        yield self.n.i == self.i
        yield self.p.v - self.n.v == self.v_out
        yield self.psi * der(self.i_dc) == self.v_out * self.i - direct * self.i_dc
        limited = smooth(minimum(maximum(self.v, -self.v_f), self.v_f))
        yield self.T_d * der(self.v_out) == limited - self.v_out
        yield self.T_f * der(self.v_f) == direct - self.v_f
        yield self.v_dc == self.v_f
