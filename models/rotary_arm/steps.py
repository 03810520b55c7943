"""The rotary arm's cycle as a sequence of steps, with its interlocks.

The source names twelve positions on the turn, each the condition of a step: S start, P the mandrel
is taken, A acceleration with it, B interference with the lubrication line, taken as its end [I], C
check of interference, D interference with the rack that restrains the mandrel, taken as its begin
[I], E deceleration, R the mandrel is put down, F acceleration without it, G end of the interference
with the rack, H end of that with the kick-out arm, I deceleration. The arm is interlocked with the
rack and the kick-out arm; their signals are not described. Model [I]: at C the sequence asks
whether both are out of the way; unless they are, the arm brakes with its ramp, stands between C and
D, and goes on when they are. It occupies the way of the line from P to B, that of the rack from D
to G and that of the kick-out arm from D to H, and says so by the signals `line`, `rack` and
`kick_out`.

The angles are those of the adopted cycle [A].
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.components import Latch, StepSequencer
from lumped.models.rotary_arm import control, parts
from lumped.models.rotary_arm.cycle import ADOPTED
from lumped.ops import where

AT = ADOPTED.points
SLOWLY = "SPER"
STEPS = tuple((angle, parts.SLOW if name in SLOWLY else parts.FAST) for name, angle in AT.items())
"""Angle at which each of the twelve steps begins, and its speed."""
CHECK = list(AT).index("C")


class Sequenced(control.Controlled):
    """Arm led by the sequence of steps; the machines in its way leave it at the instant `free`."""

    free: lp.Param = lp.param("s", "instant from which rack and kick-out arm are out of the way", 0)
    profile: StepSequencer = StepSequencer(
        sections=STEPS, waits=(CHECK,), clear=where(lp.time >= free, 1.0, 0.0)
    )
    line: Latch = Latch(on=AT["P"], off=AT["B"])
    rack: Latch = Latch(on=AT["D"], off=AT["G"])
    kick_out: Latch = Latch(on=AT["D"], off=AT["H"])

    def connections(self) -> Iterator[lp.Connection]:
        yield from super().connections()
        yield lp.connect(self.arm.phi, self.line.u, self.rack.u, self.kick_out.u)


def run_steps(
    free: float = 0.0,
    until: float = 10.98,
    parameters: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """The cycle by steps, from rest at S.

    Parameters
    ----------
    free : float
        Instant from which rack and kick-out arm are out of the way, s.
    until : float
        End, s.
    parameters : mapping of name to value, optional
        Parameters to change besides.
    **options
        Of `control.run_controlled`.
    """
    changed = {"free": free} | dict(parameters or {})
    return control.run_controlled(until, changed, model=Sequenced(), **options)


def arrivals(run: lp.Trajectory) -> dict[str, float]:
    """Instants at which the steps after S begin, s, by the names of their positions."""
    rises = np.flatnonzero(np.diff(run["profile.step"]) > 0)
    return {list(AT)[int(run["profile.step"][i + 1])]: float(run.t[i + 1]) for i in rises}


def standing(run: lp.Trajectory) -> tuple[float, float]:
    """Angle, rad, at which an arm that waits stands, and for how long, s; NaN and 0 if it does not.

    Parameters
    ----------
    run : Trajectory
        From `run_steps`.
    """
    still = (run["profile.step"] == CHECK) & (np.abs(run["arm.trays.w"]) < 1e-6)
    if not still.any():
        return float("nan"), 0.0
    return float(run["arm.phi"][still][-1]), float(np.ptp(run.t[still]))
