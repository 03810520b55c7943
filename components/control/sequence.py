"""Signals that follow how far a motion has come: position switches, sequences, speed profiles."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from lumped import Component, Equation, Expr, Input, Output, Param, Var, der, param, var, when
from lumped.errors import EquationError
from lumped.language.expression import Number
from lumped.language.switch import Item
from lumped.language.value_types import Numbers, Rows
from lumped.ops import maximum, sqrt, where

__all__ = ["Latch", "Minimum", "PositionSequencer", "SpeedProfile", "StepSequencer", "Switch"]


def least(a: Expr, b: Number) -> Expr:
    """The smaller of two expressions; the run stops where they are equal."""
    return where(a < b, a, b)


class Minimum(Component):
    """The smaller of two signals: ``y = min(a, b)``; the run stops where they are equal."""

    symbol = "minimum"
    a: Input = Input("1", "first signal")
    b: Input = Input("1", "second signal")
    y = Output("1", "the smaller one")

    def equations(self) -> Iterator[Equation]:
        yield self.y == least(self.a, self.b)


class Switch(Component):
    """One of two signals: ``y = a`` while `u` is above 0.5, else ``y = b``."""

    symbol = "switch"
    u: Input = Input("1", "command: a above 0.5")
    a: Input = Input("1", "first signal")
    b: Input = Input("1", "second signal")
    y = Output("1", "the chosen one")

    def equations(self) -> Iterator[Equation]:
        yield self.y == where(self.u > 0.5, self.a, self.b)


class Latch(Component):
    """Switch with memory: ``y = 1`` once `u` rises to `on`, ``y = 0`` once it rises to `off`.

    Only rising counts; a signal that falls back changes nothing. The state at the start is ``x``,
    open (0) unless given.
    """

    symbol = "latch"
    u: Input = Input("1", "signal")
    on: Param = param("1", "value of the signal at which it closes")
    off: Param = param("1", "value of the signal at which it opens", 1e30, above=on)
    x: Var = var("1", "1 closed, 0 open", state="always")
    y = Output("1", "1 closed, 0 open")

    def equations(self) -> Iterator[Item]:
        yield der(self.x) == 0
        yield self.y == self.x
        yield when(self.u >= self.on, {self.x: 1.0})
        # only what is closed opens, so a signal that jumps past both closes it first
        opens = self.x * (self.u - self.off) >= 1 - self.x
        yield when(opens.called("u >= off", "u < off"), {self.x: 0.0})


class PositionSequencer(Component):
    """Wanted positions one after the other: ``y = targets[step]``.

    The step rises once `measured` has been within `tolerance` of the wanted position for the time
    `dwell` without a break; `held` counts that time. Arrivals, departures and steps are events. At
    the last target the step stays, and `done` becomes 1 after the dwell there.
    """

    symbol = "sequence"
    targets: Numbers = ()
    measured: Input = Input("1", "measured position")
    tolerance: Param = param("1", "distance from the target that counts as there", above=0)
    dwell: Param = param("s", "time within the tolerance before the next step", above=0)
    step: Var = var("1", "number of the target, from 0", state="always")
    held: Var = var("s", "time within the tolerance", state="always")
    y = Output("1", "wanted position")
    done = Output("1", "1 once the last target was held, else 0")

    def equations(self) -> Iterator[Item]:
        targets = _numbers(self.targets)
        last = len(targets) - 1
        wanted: Number = targets[0]
        for i, target in enumerate(targets[1:], 1):
            wanted = where(self.step >= i, target, wanted)
        away = abs(self.measured - self.y)
        yield self.y == wanted
        yield self.done == where(self.step > last, 1.0, 0.0)
        yield der(self.step) == 0
        counting = where(away <= self.tolerance, 1.0, 0.0)
        yield der(self.held) == where(self.step > last, 0.0, counting)
        is_over = self.held >= self.dwell
        departs = where(is_over, 0.0, away) > self.tolerance  # at the end of the dwell after it
        yield when(departs.called("away", "within tolerance"), {self.held: 0.0})
        yield when(is_over, {self.step: self.step + 1, self.held: 0.0})


def _numbers(targets: Numbers) -> list[float]:
    """Targets that are finite numbers.

    Raises
    ------
    EquationError
        If there is none, or one is no finite number.
    """
    try:
        found = [float(target) for target in targets]
    except (TypeError, ValueError):
        found = []
    if not found or not all(abs(target) < float("inf") for target in found):
        raise EquationError(
            f"targets = {targets!r} must be at least one finite number, such as (0.5, 2.0, 0.0): "
            "the wanted positions in their order."
        )
    return found


class SpeedProfile(Component):
    """Greatest speed over the position: ``y = min(v_i, sqrt(v_j^2 + 2 a (s_j - u)))``.

    `sections` are rows of the position at which a section begins and the speed allowed in it;
    the first speed also applies before the first position. ``v_i`` is the speed of the present
    section; the curves brake with `a` towards each later section j, so that its speed is reached
    where it begins. At the begin of a faster section `y` jumps: connect it to a `RateLimiter`.
    """

    symbol = "table"
    sections: Rows = ()
    u: Input = Input("1", "position")
    a: Param = param("1", "deceleration", above=0)
    y = Output("1", "greatest speed")

    def equations(self) -> Iterator[Equation]:
        rows = _sections(self.sections)
        allowed: Number = rows[-1][1]
        for i, (_, limit) in reversed(list(enumerate(rows[:-1]))):
            here: Number = limit
            for begin, speed in rows[i + 1 :]:
                if speed < limit:
                    way = maximum(begin - self.u, 0.0)
                    here = least(sqrt(speed**2 + 2 * self.a * way), here)
            allowed = where(self.u >= rows[i + 1][0], allowed, here)
        yield self.y == allowed


class StepSequencer(Component):
    """Speeds of steps that follow each other at positions: ``y = v[step]``, or 0 while it waits.

    `sections` are rows of the position at which a step begins and its speed; the run begins in the
    first step. The next one begins where `u` reaches its position, and stays if `u` falls back. In
    the steps numbered in `waits`, from 0, ``y = 0`` while `clear` is not above 0.5, and the next
    one begins only when it is. `y` jumps: connect it to a `RateLimiter`.
    """

    symbol = "sequence"
    sections: Rows = ()
    waits: Numbers = ()
    u: Input = Input("1", "position")
    clear: Input = Input("1", "permission to go on: above 0.5")
    step: Var = var("1", "number of the step, from 0", state="always")
    y = Output("1", "wanted speed")

    def equations(self) -> Iterator[Item]:
        rows = _sections(self.sections)
        if unknown := set(self.waits) - set(range(len(rows))):
            raise EquationError(
                f"waits = {self.waits!r}: there is no step {min(unknown):g}; the steps are 0 to "
                f"{len(rows) - 1}."
            )
        begins = [begin for begin, _ in rows[1:]] + [_NEVER]
        barred = where(self.clear > 0.5, 0.0, 1.0)
        speed: Number = 0.0
        way: Number = 0.0
        waiting = idle = 0.0 * self.step
        for i, (begin, (_, v)) in enumerate(zip(begins, rows, strict=True)):
            speed = where(self.step >= i, v, speed)
            way = where(self.step >= i, begin - self.u, way)
            waiting = where(self.step >= i, barred if i in self.waits else idle, waiting)
        yield self.y == where(waiting > 0.5, 0.0, speed)
        yield der(self.step) == 0
        arrives = where(waiting > 0.5, 1.0, way) <= 0
        yield when(arrives.called("arrived", "under way"), {self.step: self.step + 1})


_NEVER = 1e30
"""Position of the step after the last one."""


def _sections(rows: Rows) -> list[tuple[float, float]]:
    """Sections that make sense.

    Raises
    ------
    EquationError
        If rows are missing, positions do not increase, or a speed is negative.
    """
    try:
        found = [(float(s), float(v)) for s, v in rows]
    except (TypeError, ValueError):
        found = []
    if not found:
        raise EquationError(
            f"sections = {rows!r} has no rows of two numbers. Give rows of the position at which a "
            "section begins and its greatest speed, such as ((0, 0.2), (1.5, 1))."
        )
    for (before, _), (after, _) in pairwise(found):
        if not before < after < float("inf"):
            raise EquationError(
                f"sections: the positions must increase from row to row, but {before:g} -> "
                f"{after:g}."
            )
    for s, v in found:
        if not 0 <= v < float("inf"):
            raise EquationError(
                f"sections: the speed {v:g} from the position {s:g} on must be a finite number "
                "that is not negative; the profile is for one direction."
            )
    return found
