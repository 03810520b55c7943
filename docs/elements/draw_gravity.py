"""Draw masses that swing in gravity and a speed profile; the curves are runs of the components.

Run from the top of the project: python docs/elements/draw_gravity.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lumped as lp
from lumped.components import (
    JournalFriction,
    Latch,
    Minimum,
    RateLimiter,
    Speed,
    SpeedProfile,
    SquareRootController,
    SwingingMass,
)
from lumped.components.control.sensors import AngleSensor

FOLDER = Path(__file__).parent


def torque_over_angle(**body: float) -> tuple[np.ndarray, np.ndarray]:
    """Angle in degrees and torque of an arm that turns slowly once around."""
    model = lp.compose(
        turn=Speed(w=2 * np.pi),
        body=SwingingMass(**body),
        connections=lambda m: [lp.connect(m.turn.flange, m.body.flange)],
    )
    run = lp.simulate(lp.assemble(model, keep=["body.phi"]), until=1.0, grid=360)
    return np.degrees(run["body.phi"]), -run["turn.flange.tau"]


def draw_swinging_mass() -> Figure:
    """Torques over a turn, and a pendulum that a journal stops."""
    figure = Figure((6.8, 2.7), layout="constrained")
    turn, swing = figure.subplots(1, 2)
    for label, body in (("arm", {"m": 10.0, "R": 0.5}), ("counterweight", {"m": 8.0, "R": -0.4})):
        turn.plot(*torque_over_angle(**body), label=f"{label}, R = {body['R']:g} m")
    turn.set(title="Torque at even speed", xlabel="angle, deg", ylabel="torque, N.m")
    turn.set_xticks(range(0, 361, 90))
    turn.legend(fontsize=8)
    for load in (100.0, 400.0):
        model = lp.compose(
            bob=SwingingMass(m=10.0, R=0.5),
            journal=JournalFriction(mu=0.15, d=0.1, f_n=load),
            connections=lambda m: [lp.connect(m.bob.flange, m.journal.flange_a)],
        )
        run = lp.simulate(lp.assemble(model), until=6.0, grid=600, start={"bob.phi": -0.8})
        swing.plot(run.t, np.degrees(run["bob.phi"]), label=f"f_n = {load:g} N")
    swing.set(title="Pendulum in a journal", xlabel="time, s", ylabel="angle, deg")
    swing.legend(fontsize=8)
    return figure


def draw_speed_profile() -> Figure:
    """A move that a profile and the square-root law limit."""
    model = lp.compose(
        profile=SpeedProfile(sections=((0.0, 0.2), (0.3, 1.0), (2.0, 0.2), (2.3, 0.8)), a=1.0),
        aim=SquareRootController(wanted=4.0, K=6.0, a=1.0),
        wanted=Minimum(),
        ramp=RateLimiter(rate=1.4, T=0.02),
        turn=Speed(),
        angle=AngleSensor(),
        carried=Latch(on=0.15, off=2.15),
        connections=lambda m: [
            lp.connect(m.angle.phi, m.profile.u, m.aim.measured, m.carried.u),
            lp.connect(m.profile.y, m.wanted.a),
            lp.connect(m.aim.y, m.wanted.b),
            lp.connect(m.wanted.y, m.ramp.u),
            lp.connect(m.ramp.y, m.turn.w),
            lp.connect(m.turn.flange, m.angle.flange),
        ],
    )
    run = lp.simulate(lp.assemble(model, keep=["angle.phi"]), until=14.0, grid=3000)
    figure = Figure((8.0, 4.2), layout="constrained")
    speed, latch = figure.subplots(2, sharex=True, height_ratios=(3, 1))
    phi = run["angle.phi"]
    speed.plot(phi, run["profile.y"], "--", label="SpeedProfile")
    speed.plot(phi, run["aim.y"], ":", label="SquareRootController")
    speed.plot(phi, run["ramp.y"], label="after Minimum and RateLimiter")
    speed.set(title="Move by 4 rad, slow about 0.15 and 2.15 rad", ylim=(0, 1.2))
    speed.set_ylabel("speed, rad/s")
    speed.legend(fontsize=8, loc=(0.33, 0.03))
    latch.plot(phi, run["carried.y"], color="C3")
    latch.set(ylabel="Latch", xlabel="angle, rad", yticks=(0, 1), xlim=(0, 4.05))
    for axis in (speed, latch):
        axis.grid(alpha=0.3)
    return figure


if __name__ == "__main__":
    draw_swinging_mass().savefig(FOLDER / "swinging_mass.png", dpi=80)
    draw_speed_profile().savefig(FOLDER / "speed_profile.png", dpi=80)
