"""The cycle of the rotary arm: one turn in 9 s as a prescribed motion, and the torque it takes.

Twelve points, speeds and the ramp are printed, the angles of the points are lost. Model [A]: from
rest at S to the slow speed, over P, where the mandrel is taken, to A; there to the fast speed; at E
down to the slow speed, over R, where it is put down, to F; fast; from I to rest at S + 360 deg.
The nine seconds then fix the sum of the slow angles. B, C, D, G and H do not enter the torque [A]:
B, D, G and H clear one mandrel diameter, C lies a stopping angle and 0.1 s before D.

With pick-up and release exactly horizontal and equal slow zones the RMS torque is 4064 N.m with
nothing fitted; the printed 4100 N.m comes with both 1.469 deg lower, which is adopted. Other
assumptions reach it as well, so that P, R, the zones and single accelerations cannot be told from
the RMS.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import lumped as lp
from lumped.components import Speed
from lumped.errors import ParameterError
from lumped.models.rotary_arm_parts import (
    EPS,
    FAST,
    PICK_UP,
    PRINTED,
    R_H,
    R_X,
    RATIO,
    RELEASE,
    SLOW,
    Driven,
)


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

    pick_up: float = PICK_UP
    release: float = RELEASE
    ramp: float = EPS
    duration: float = 9.0
    zones: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        """Refuse what leaves no time or no way.

        Raises
        ------
        ParameterError
            If the ramps, zones and speeds do not fit into the turn and its duration.
        """
        t, _ = self.speed() if self.ramp > 0 and min(self.zones) > 0 else ([1.0, 0.0], [])
        if not (np.isfinite(t).all() and np.diff(t).min() > 0 and self.slow > 0):
            raise ParameterError(
                f"Cycle: ramps of {self.ramp:g} rad/s2 and slow zones {self.zones} between "
                f"{SLOW:g} and {FAST:g} rad/s do not make one turn in {self.duration:g} s. Give "
                "positive ramps and zones, and enough, but not too much time."
            )

    @property
    def slow(self) -> float:
        """Sum of the slow angles, rad: what is left of the time decides."""
        ramps = (SLOW**2 + 3 * (FAST**2 - SLOW**2) + FAST**2) / (2 * self.ramp)
        time = (SLOW + 3 * (FAST - SLOW) + FAST) / self.ramp
        fast = 2 * np.pi - ramps
        return (self.duration - time - fast / FAST) / (1 / SLOW - 1 / FAST)

    @property
    def points(self) -> dict[str, float]:
        """Angles of the twelve points, rad."""
        sp, pa, er, rf = self.slow * np.array(self.zones) / sum(self.zones)
        change = (FAST**2 - SLOW**2) / (2 * self.ramp)
        s = self.pick_up - sp - SLOW**2 / (2 * self.ramp)
        a, f = self.pick_up + pa, self.release + rf
        clear = np.arcsin(2 * R_X / R_H)
        stopping = FAST**2 / (2 * self.ramp)
        d = self.release - clear
        return {
            "S": s,
            "P": self.pick_up,
            "A": a,
            "B": self.pick_up + clear,
            "C": d - stopping - 0.1 * FAST,
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
        change = (FAST**2 - SLOW**2) / (2 * self.ramp)
        begin = at["S"] + SLOW**2 / (2 * self.ramp)
        t, w = [0.0], [0.0]
        for wanted, way in (
            (SLOW, at["A"] - begin),
            (FAST, at["E"] - at["A"] - change),
            (SLOW, at["F"] - at["E"] - change),
            (FAST, at["I"] - at["F"] - change),
            (0.0, 0.0),
        ):
            t.append(float(t[-1] + abs(wanted - w[-1]) / self.ramp))
            w.append(wanted)
            if way:
                t.append(float(t[-1] + way / wanted))
                w.append(wanted)
        t[-1] = self.duration  # but for rounding it is
        return t, w


ADOPTED = Cycle()


def run_cycle(
    cycle: Cycle = ADOPTED, printed: bool = False, grid: int = 1800, **options: Any
) -> lp.Trajectory:
    """Torque that a cycle takes.

    Parameters
    ----------
    cycle : Cycle
        Motion.
    printed : bool
        With the parameters of the source (`PRINTED`).
    grid : int
        Number of intervals.
    **options
        Passed to `lumped.simulate`.
    """
    t, w = cycle.speed()
    model = Driven(drive=Speed(w=RATIO * lp.ops.table(t, w))).with_(
        {"arm.pick_up": cycle.pick_up, "arm.release": cycle.release}
    )
    system = lp.assemble(model, keep=["arm.angle.phi"])
    start = {"arm.phi": cycle.points["S"], "arm.mandrel.phi": cycle.pick_up, "arm.table.gap": 0.0}
    return lp.simulate(
        system,
        until=cycle.duration,
        grid=grid,
        start=start,
        parameters=(PRINTED if printed else {}) | options.pop("parameters", {}),
        **options,
    )


def motor_torque(run: lp.Trajectory, rotor: bool = True) -> np.ndarray:
    """Torque of the motor over time, N.m; without `rotor` that between rotor and reducer."""
    return -run["drive.flange.tau"] if rotor else run["reducer.flange_a.tau"]


def rms(run: lp.Trajectory, torque: np.ndarray) -> float:
    """Root of the mean square over a run; jumps are met exactly, as the run notes both sides."""
    return float(np.sqrt(np.trapezoid(torque**2, run.t) / (run.t[-1] - run.t[0])))
