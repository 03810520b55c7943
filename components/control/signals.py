"""Signals that are known functions of the time.

Each has one output `y`. Its unit is written "1", but a signal has the unit of the input that it
drives: `y` in N.m for a torque, in m/s for a velocity. The same is true of parameters such as
`height` and `offset`.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Input, Output, Param, param, time
from lumped.language.value_types import Numbers
from lumped.ops import pi, sin, table, where

__all__ = ["Constant", "Expression", "Ramp", "Sine", "Step", "Table"]


class Constant(Component):
    """Constant signal: ``y = k``, in the unit of the input that it drives."""

    symbol = "constant"
    k: Param = param("1", "value")
    y = Output("1", "signal")

    def equations(self) -> Iterator[Equation]:
        yield self.y == self.k


class Step(Component):
    """Jump: ``y = offset`` before `start_time`, ``y = offset + height`` from then on.

    `y` has the unit of the input that it drives.
    """

    symbol = "step"
    height: Param = param("1", "height of the jump")
    offset: Param = param("1", "value before the jump", 0.0)
    start_time: Param = param("s", "instant of the jump", 0.0)
    y = Output("1", "signal")

    def equations(self) -> Iterator[Equation]:
        yield self.y == self.offset + where(time >= self.start_time, self.height, 0)


class Ramp(Component):
    """Steady rise by `height`: ``y = offset + height (t - start_time) / duration``.

    Constant before and after the rise. `y` has the unit of the input that it drives.
    """

    symbol = "ramp"
    height: Param = param("1", "height of the rise")
    duration: Param = param("s", "duration of the rise", above=0)
    offset: Param = param("1", "value before the rise", 0.0)
    start_time: Param = param("s", "begin of the rise", 0.0)
    y = Output("1", "signal")

    def equations(self) -> Iterator[Equation]:
        elapsed = time - self.start_time
        rising = where(
            time >= self.start_time + self.duration,
            self.height,
            self.height / self.duration * elapsed,
        )
        yield self.y == self.offset + where(time >= self.start_time, rising, 0)


class Sine(Component):
    """Sine: ``y = offset + amplitude sin(2 pi frequency (t - start_time) + phase)``.

    ``y = offset`` before `start_time`. `y` has the unit of the input that it drives.
    """

    symbol = "sine"
    amplitude: Param = param("1", "amplitude")
    frequency: Param = param("Hz", "frequency", min=0)
    phase: Param = param("rad", "phase at the begin", 0.0)
    offset: Param = param("1", "mean value", 0.0)
    start_time: Param = param("s", "begin of the sine", 0.0)
    y = Output("1", "signal")

    def equations(self) -> Iterator[Equation]:
        angle = 2 * pi * self.frequency * (time - self.start_time) + self.phase
        yield self.y == self.offset + where(time >= self.start_time, self.amplitude * sin(angle), 0)


class Table(Component):
    """Straight lines through points: ``y(times[i]) = values[i]``, constant outside them.

    Two points at the same time make a jump. `y` has the unit of the input that it drives.
    """

    symbol = "table"
    times: Numbers = ()
    values: Numbers = ()
    y = Output("1", "signal")

    def equations(self) -> Iterator[Equation]:
        yield self.y == table(self.times, self.values)


class Expression(Component):
    """Signal given as an expression of the time: ``y = value``.

    For example ``Expression(value=3 * lp.ops.sin(lp.time))``. `y` has the unit of the input that
    it drives.
    """

    symbol = "function"
    value: Input = Input("1", "expression of the time")
    y = Output("1", "signal")

    def equations(self) -> Iterator[Equation]:
        yield self.y == self.value
