"""Sampled signals of a computer: it reads inputs at instants and holds its outputs in between.

At each instant ``start_time + k T_s`` the outputs first follow the inputs, through all blocks that
sample then, and are held after that. So a value passes through any number of such blocks within one
instant, whatever their order in the model. A ring of such blocks without an integrator is solved as
an algebraic loop.

Source: Astrom and Hagglund, Advanced PID Control, 2006, ch. 13.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from lumped import Component, Equation, Expr, Input, Output, Param, Var, der, param, time, var, when
from lumped.language.expression import Compare, Number
from lumped.language.program import Question
from lumped.language.switch import Item
from lumped.ops import interpolate, where

__all__ = ["SampleHold", "SampledPI"]


_ROUNDING = 1e-9
"""Part of a sample within which a run begins at its instant."""


class _Clocked(Component):
    """What changes at the instants ``start_time + k T_s`` only.

    A run that begins later has its first sample at the next of these instants.
    """

    T_s: Param = param("s", "sampling time", above=0)
    start_time: Param = param("s", "first sample", 0.0)
    count: Var = var("1", "number of the next sample", state="always")

    @property
    def due(self) -> Compare:
        """Whether a sample is due: true at its instant, before anything has changed."""
        due = time > self.start_time + self.count * self.T_s
        return due.called("sampling", "holding")

    def initial_equations(self) -> Iterator[Equation]:
        passed = (time - self.start_time) / self.T_s - _ROUNDING
        begun = passed + interpolate(-passed, [0, 1], [0, 1], period=1)
        yield self.count == where(time > self.start_time, begun, 0)

    def _count_samples(
        self, changes: Mapping[Expr, Number], question: Question | None = None
    ) -> Iterator[Item]:
        """The clock: states that change at each sample, and what a program is asked."""
        yield der(self.count) == 0
        yield when(self.due, {self.count: self.count + 1, **changes}, question=question)


class _Sampled(_Clocked):
    """Output that is computed at instants and held in between."""

    held: Var = var("1", "output since the last sample", state="always")
    y = Output("1", "held signal")

    def _hold_samples(self, value: Expr, changes: Mapping[Expr, Number]) -> Iterator[Item]:
        """Equations of an output that is `value` at the instants, where states change too."""
        yield der(self.held) == 0
        yield self.y == where(self.due, value, self.held)
        yield from self._count_samples({self.held: value, **changes})


class SampleHold(_Sampled):
    """Sample and hold: ``y = u`` at the instants ``start_time + k T_s``, held in between.

    Before the first sample ``y = held``, 0 unless given.
    """

    symbol = "stairs"
    u: Input = Input("1", "signal")

    def equations(self) -> Iterator[Item]:
        yield from self._hold_samples(self.u, {})


class SampledPI(_Sampled):
    """PI controller in a computer: at 0, T_s, 2 T_s, ... ``x += T_s e / T_i``, ``y = k (x + e)``.

    ``e = wanted - measured`` is sampled, and `y` is held until the next sample.
    """

    symbol = "controller"
    wanted: Input = Input("1", "wanted value")
    measured: Input = Input("1", "measured value")
    k: Param = param("1", "gain", above=0)
    T_i: Param = param("s", "integral time", above=0)
    x: Var = var("1", "integral part over the gain", state="always")

    def equations(self) -> Iterator[Item]:
        e = self.wanted - self.measured
        x = self.x + self.T_s / self.T_i * e
        yield der(self.x) == 0
        yield from self._hold_samples(self.k * (x + e), {self.x: x})
