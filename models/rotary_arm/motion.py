"""Rotary arm: the motion of one turn that heats the motor least.

Slow zones, speeds and duration are those of the adopted cycle (`lumped.models.rotary_arm.cycle`);
its ramps of 1.38 rad/s2 are free. The turn is divided where the mandrel is taken and put down and
where slow zones end, so that each phase is smooth: mass and friction are constant in it. The
reducer is lossless, as its loss depends on the direction of the power.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lumped as lp
from lumped.components import IdealGear, Inertia, Speed, SwingingMass, Torque
from lumped.models.rotary_arm import parts
from lumped.models.rotary_arm.cycle import ADOPTED, Cycle
from lumped.models.rotary_arm.loads import MAXIMUM

NOTHING = 1e-3  # kg  an arm without mandrel; a mass is positive


class Carrying(lp.Component):
    """Arm on a lossless reducer, with the mandrel or without; the source's numbers."""

    g: lp.Param = lp.param("m/s2", "gravity", parts.PRINTED["arm.g"])
    m_x: lp.Param = lp.param("kg", "mandrel", parts.M_MANDREL, above=0)
    friction: lp.Param = lp.param("N.m", "friction in the journals while it turns", 0.0, min=0)
    motor: Torque = Torque(tau=0.0)
    reducer: IdealGear = IdealGear(ratio=parts.RATIO)
    trays: SwingingMass = SwingingMass(m=parts.M_TRAYS, R=parts.R_H, g=g)
    arms: SwingingMass = SwingingMass(
        m=parts.M_ARMS, R=parts.R_H / 2, J=parts.M_ARMS * parts.R_H**2 / 12, g=g
    )
    weights: SwingingMass = SwingingMass(m=parts.M_WEIGHTS, R=-parts.R_WEIGHTS, g=g)
    mandrel: SwingingMass = SwingingMass(m=m_x, R=parts.R_H, J=m_x * parts.R_X**2 / 2, g=g)
    body: Inertia = Inertia(J=parts.M_SHAFT * parts.D_SHAFT**2 / 8 + parts.J_REDUCER)
    journal: Torque = Torque(tau=-friction)

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(self.motor.flange, self.reducer.flange_a)
        swinging = (self.trays, self.arms, self.weights, self.mandrel)
        shaft = (part.flange for part in swinging)
        yield lp.connect(self.reducer.flange_b, self.body.flange_a, self.journal.flange, *shaft)


def best_motion(cycle: Cycle = ADOPTED, intervals: int = 20) -> lp.optimisation.Motion:
    """Motion of least root mean square torque through the stations of a cycle.

    Parameters
    ----------
    cycle : Cycle
        Stations, speeds and duration.
    intervals : int
        As for `lumped.optimisation.motion`.

    Returns
    -------
    Motion
    """
    system = lp.assemble(Carrying(), keep=["trays.phi"])
    lever = parts.PRINTED["arm.g"] * parts.MU * parts.K_JOURNAL * parts.D_SHAFT / 2
    weight = parts.M_TRAYS + parts.M_ARMS + parts.M_SHAFT + parts.M_WEIGHTS
    empty, full = (
        lp.start_point(system, parameters={"m_x": m, "friction": lever * (weight + m)})
        for m in (NOTHING, parts.M_MANDREL)
    )
    at, braking = cycle.points, (parts.FAST**2 - parts.SLOW**2) / (2 * cycle.ramp)
    angles = (at["S"], at["P"], at["A"], at["E"] + braking, at["R"], at["F"], at["S"] + 2 * np.pi)
    speeds = (parts.SLOW, parts.SLOW, parts.FAST, parts.SLOW, parts.SLOW, parts.FAST)
    torque = {"motor.tau": (-MAXIMUM, MAXIMUM)}
    return lp.optimisation.motion(
        [empty, full, full, full, empty, empty],
        drive="motor.tau",
        stations={"trays.phi": angles},
        duration=cycle.duration,
        minimise=lp.functionals.rms("motor.tau"),
        limits=[{"trays.w": (0.0, w)} | torque for w in speeds],
        intervals=intervals,
    )


def run_motion(
    found: lp.optimisation.Motion, cycle: Cycle = ADOPTED, grid: int = 3600
) -> lp.Trajectory:
    """The arm with latches, table, rollers and sticking friction, turned by an optimal motion.

    Parameters
    ----------
    found : Motion
        From `best_motion`.
    cycle : Cycle
        Angles of pick-up and release, and the duration.
    grid : int
        Output intervals.

    Returns
    -------
    Trajectory
    """
    profile = parts.RATIO * found.profile("trays.w")
    model = parts.Driven(drive=Speed(w=profile)).with_(
        {"arm.pick_up": cycle.pick_up, "arm.release": cycle.release}
    )
    return lp.simulate(
        lp.assemble(model, keep=["arm.angle.phi"]),
        until=cycle.duration,
        grid=grid,
        start={
            "arm.phi": cycle.points["S"],
            "arm.mandrel.phi": cycle.pick_up,
            "arm.table.gap": 0.0,
        },
        parameters=parts.PRINTED,
    )
