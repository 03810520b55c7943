"""The cycle of the rotary arm: one turn in 9 s as a prescribed motion, and its torque.

Twelve points, speeds and the ramp are printed; the angles of the points are drawn in a figure that
is missing in the copy used. Model [A]: from rest at S to the slow speed, over P, where the mandrel
is taken, to A; there to the fast speed; at E down to the slow speed, over R, where it is put down,
to F; fast; from I to rest at S + 360 deg. The nine seconds then fix the sum of the slow angles. B,
C, D, G and H do not enter the torque [A]: B, D, G and H clear one mandrel diameter, C lies a
stopping angle and 0.1 s before D.

With pick-up and release exactly horizontal and equal slow zones the RMS torque is 4064 N.m with
nothing fitted; with both 1.469 deg lower it is the printed 4100 N.m, and this is adopted. Other
assumptions give the printed value as well, so the RMS does not determine P, R, the zones and single
accelerations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import lumped as lp
from lumped.components import Torque
from lumped.errors import ParameterError
from lumped.models.rotary_arm import parts
from lumped.models.rotary_arm.loads import MAXIMUM, RATED


@dataclass(frozen=True)
class Cycle:
    """One turn by ramps and constant speeds.

    Parameters
    ----------
    pick_up, release : float
        Angles of P and R, rad.
    ramp : float
        Angular acceleration of all ramps, rad/s2.
    duration : float
        Of the whole turn, s.
    zones : tuple of float
        Slow angles before P, from P to A, before R and from R to F, relative to each other; those
        at the ends of ramps do not count the ramps.
    """

    pick_up: float = parts.PICK_UP
    release: float = parts.RELEASE
    ramp: float = parts.EPS
    duration: float = 9.0
    zones: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        """Refuse a cycle whose ramps leave no time or no angle.

        Raises
        ------
        ParameterError
            If the ramps, zones and speeds do not fit into the turn and its duration.
        """
        t, _ = self.speed() if self.ramp > 0 and min(self.zones) > 0 else ([1.0, 0.0], [])
        if not (np.isfinite(t).all() and np.diff(t).min() > 0 and self.slow > 0):
            raise ParameterError(
                f"Cycle: ramps of {self.ramp:g} rad/s2 and slow zones {self.zones} between "
                f"{parts.SLOW:g} and {parts.FAST:g} rad/s do not make one turn in "
                f"{self.duration:g} s. Give positive ramps and zones, and enough, but not too "
                "much time."
            )

    @property
    def slow(self) -> float:
        """Sum of the slow angles, rad, which follows from the remaining time."""
        ramps = (parts.SLOW**2 + 3 * (parts.FAST**2 - parts.SLOW**2) + parts.FAST**2) / (
            2 * self.ramp
        )
        time = (parts.SLOW + 3 * (parts.FAST - parts.SLOW) + parts.FAST) / self.ramp
        fast = 2 * np.pi - ramps
        return (self.duration - time - fast / parts.FAST) / (1 / parts.SLOW - 1 / parts.FAST)

    @property
    def points(self) -> dict[str, float]:
        """Angles of the twelve points, rad."""
        sp, pa, er, rf = self.slow * np.array(self.zones) / sum(self.zones)
        change = (parts.FAST**2 - parts.SLOW**2) / (2 * self.ramp)
        s = self.pick_up - sp - parts.SLOW**2 / (2 * self.ramp)
        a, f = self.pick_up + pa, self.release + rf
        clear = np.arcsin(2 * parts.R_X / parts.R_H)
        stopping = parts.FAST**2 / (2 * self.ramp)
        d = self.release - clear
        return {
            "S": s,
            "P": self.pick_up,
            "A": a,
            "B": self.pick_up + clear,
            "C": d - stopping - 0.1 * parts.FAST,
            "D": d,
            "E": self.release - er - change,
            "R": self.release,
            "F": f,
            "G": self.release + clear,
            "H": self.release + 2 * clear,
            "I": s + 2 * np.pi - stopping,
        }

    def speed(self) -> tuple[list[float], list[float]]:
        """Times in s and speeds in rad/s where ramps begin and end."""
        at = self.points
        change = (parts.FAST**2 - parts.SLOW**2) / (2 * self.ramp)
        begin = at["S"] + parts.SLOW**2 / (2 * self.ramp)
        t, w = [0.0], [0.0]
        for wanted, way in (
            (parts.SLOW, at["A"] - begin),
            (parts.FAST, at["E"] - at["A"] - change),
            (parts.SLOW, at["F"] - at["E"] - change),
            (parts.FAST, at["I"] - at["F"] - change),
            (0.0, 0.0),
        ):
            t.append(float(t[-1] + abs(wanted - w[-1]) / self.ramp))
            w.append(wanted)
            if way:
                t.append(float(t[-1] + way / wanted))
                w.append(wanted)
        t[-1] = self.duration  # equal but for rounding
        return t, w


ADOPTED = Cycle()
OTHERS = {
    "both horizontal, nothing fitted": Cycle(0.0, np.pi),
    "both horizontal, loaded zones 1.1725 times": Cycle(
        0.0, np.pi, zones=(1.0, 1.1725, 1.1725, 1.0)
    ),
    "both horizontal, ramps 2.061 rad/s2": Cycle(0.0, np.pi, ramp=2.061),
    "release 3.23 deg lower": Cycle(0.0, np.pi + np.radians(3.23)),
}
"""Other readings of the nine seconds, by their assumptions."""


def run_cycle(
    cycle: Cycle = ADOPTED,
    printed: bool = False,
    grid: int | Sequence[float] = 1800,
    rtol: float = 1e-6,
    parameters: Mapping[str, Any] | None = None,
    model: parts.Driven | None = None,
) -> lp.Trajectory:
    """Inverse dynamics of a cycle: the torque of the motor, `MOTOR`, follows from the motion.

    Parameters
    ----------
    cycle : Cycle
        Motion.
    printed : bool
        With the parameters of the source (`PRINTED`).
    grid : int or sequence of float
        Number of intervals, or instants, s.
    rtol : float
        Tolerance of `lumped.inverse`.
    parameters : mapping of name to value, optional
        Changed parameters.
    model : Driven, optional
        Arm, reducer and rotor, on which a torque acts; those of the source unless given.
    """
    t, w = cycle.speed()
    places = {"arm.pick_up": cycle.pick_up, "arm.release": cycle.release}
    model = (parts.Driven() if model is None else model).with_({"drive": Torque(tau=0.0)} | places)
    system = lp.assemble(model, keep=["arm.angle.phi"])
    changed = (parts.PRINTED if printed else {}) | dict(parameters or {})
    found = system.parameter_values(changed)
    still = {"arm.mandrel.phi": found["arm.pick_up"], "arm.table.gap": 0.0}
    return lp.inverse(
        system,
        motion={"rotor.w": found["reducer.ratio"] * lp.ops.table(t, w)},
        drive="drive.tau",
        until=cycle.duration,
        grid=grid,
        start={"arm.phi": cycle.points["S"]} | still,
        parameters=changed,
        rtol=rtol,
    )


MOTOR = "drive.tau"
REDUCER = "reducer.flange_a.tau"
"""Torque of the motor, and that without its rotor, as the source computes it."""


def demand(run: lp.Trajectory, torque: str = MOTOR) -> lp.simulation.Sizing:
    """Demand of a cycle on the chosen motor."""
    return lp.simulation.sizing(run, of=(torque, "rotor.w"), rated=RATED, maximum=MAXIMUM)


def carrying(seconds: float) -> Cycle:
    """Cycle with horizontal pick-up and release that has the mandrel on the arm for some seconds.

    The two slow zones of the loaded half turn then fill the time that ramps and fast motion leave.
    """
    time = 2 * (parts.FAST - parts.SLOW) / parts.EPS
    fast = np.pi - (parts.FAST**2 - parts.SLOW**2) / parts.EPS
    loaded = (seconds - time - fast / parts.FAST) / (1 / parts.SLOW - 1 / parts.FAST)
    short = Cycle(0.0, np.pi)
    return Cycle(
        0.0,
        np.pi,
        duration=short.duration + (2 * loaded - short.slow) * (1 / parts.SLOW - 1 / parts.FAST),
    )


def measure_loaded_rms(run: lp.Trajectory) -> float:
    """RMS of the torque without the rotor while the mandrel is on the arm, N.m."""
    on = run["arm.carried.y"] == 1
    t, torque = run.t[on], run[REDUCER][on]
    return float(np.sqrt(np.trapezoid(torque**2, t) / (t[-1] - t[0])))
