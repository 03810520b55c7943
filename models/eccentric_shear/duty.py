"""Idle and working time of the shear, and its start and stop: the conclusions of the source.

At constant speed of the motor its angle q divides a turn. With the ellipses matched to the cut,
``tan(q / 2) = (1 + e) / (1 - e) tan(y / 2)`` for the crank angle y from the middle of the cut; a
cut over the angle a takes ``2 / pi arctan((1 + e) / (1 - e) tan(a / 4))`` of a turn. Working and
idle time are those of circles times the mean of the ratio over the cut and over the rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import lumped as lp
from lumped.components import PController, PointToPoint, SignTorque, Sum
from lumped.functionals import integral, peak
from lumped.models.eccentric_shear import scenes, stand
from lumped.models.eccentric_shear.stand import IDLE, SPEED, Loaded, PrintedShear
from lumped.models.sources import Given

RAMP = Given(0.5, "s", "A", "duration of a start or a stop")
TURN = 2 * np.pi / SPEED
NEAR = 0.01
"""Deviation over the speed at which this counts as reached."""
SETTLING = 0.05  # s  of a run after its stop


def working_share(eps: float) -> float:
    """Share of a turn that the cut takes at constant motor speed."""
    demand = scenes.turn(scenes.MotorTurned, eps, grid=4000)
    t, phi = demand.run.t, demand.phi
    begin, end = np.interp([stand.CUT_BEGINS, stand.CUT_ENDS], phi, t)
    return float((end - begin) / t[-1])


def idle_peak(eps: float) -> float:
    """Greatest motor torque outside the cut at constant crank speed, N.m."""
    demand = scenes.turn(scenes.CrankTurned, eps)
    cutting = np.abs(demand.phi - stand.CENTRE_SINE) <= stand.CUT / 2
    return float(demand.tau[~cutting].max())


class StartStop(scenes.FreeShear):
    """One turn from rest to rest in the upper position; the idle torque is friction [A]."""

    way: PointToPoint = PointToPoint(
        distance=2 * np.pi, v_max=scenes.FreeShear.w, a_max=scenes.FreeShear.w / RAMP
    )
    loaded: Loaded = Loaded(eps=scenes.FreeShear.eps, idle=SignTorque(tau_nominal=-IDLE))
    control: PController = PController(wanted=way.s, k=scenes.GAIN)
    voltage: Sum = Sum(b=scenes.FreeShear.motor.k * way.v)


@dataclass(frozen=True)
class Transient:
    """A start or a stop.

    Attributes
    ----------
    time : float
        Until the motor is within `NEAR` of its speed, or of standstill, s.
    peak : float
        Greatest amount of the motor torque, N.m.
    work, heat : float
        Of the motor at its shaft, and in its armature, J.
    """

    time: float
    peak: float
    work: float
    heat: float


def start_stop(eps: float, idle: float = IDLE, **options: Any) -> lp.Trajectory:
    """One turn from rest to rest in the upper position.

    Parameters
    ----------
    eps : float
        Eccentricity of the ellipses.
    idle : float
        Idle torque, N.m.
    **options
        Passed to `lumped.simulate`.
    """
    start = scenes.upright(PrintedShear) | {"motor.w": 0.0}
    changes = {"eps": eps, "loaded.idle.tau_nominal": -idle}
    options = {"until": TURN + RAMP + SETTLING, "grid": 8000} | options
    return lp.simulate(lp.assemble(StartStop()), parameters=changes, start=start, **options)


def split_turn(run: lp.Trajectory) -> tuple[Transient, Transient]:
    """Start and stop of a run of `start_stop`."""
    t, w = run.t, run["motor.w"]
    ends = t >= TURN
    up = _reach(t, w - (1 - NEAR) * SPEED)
    down = _reach(t[ends], NEAR * SPEED - w[ends]) - TURN
    return _measure(run, (0.0, RAMP), up), _measure(run, (TURN, TURN + RAMP), down)


def _reach(t: np.ndarray, above: np.ndarray) -> float:
    """Instant from which a quantity is not negative."""
    i = int(np.argmax(above >= 0))
    return float(np.interp(0.0, above[i - 1 : i + 1], t[i - 1 : i + 1]))


def _measure(run: lp.Trajectory, between: tuple[float, float], time: float) -> Transient:
    current = integral("motor.i", "motor.i", between=between)
    return Transient(
        time,
        run.value(peak("motor.tau", between=between)),
        run.value(integral("motor.tau", "motor.w", between=between)),
        scenes.RESISTANCE * run.value(current),
    )
