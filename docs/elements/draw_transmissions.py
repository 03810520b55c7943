"""Draw Cardan joints, screws, harmonic drives, Geneva wheels, sprockets and cams by their runs.

Run from the top of the project: python docs/elements/draw_transmissions.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lumped as lp
from lumped.components import (
    Cam,
    CamFollower,
    CardanJoint,
    CardanShaft,
    Damper,
    Fixed,
    Geneva,
    HarmonicDrive,
    Inertia,
    LeadScrew,
    Position,
    Speed,
    Sprocket,
    cam_motion,
    translation,
)

HERE = Path(__file__).parent


def turned(part: lp.Component, turns: float = 1.0) -> lp.Trajectory:
    """A part turned at flange a with 1 rad/s, a body at flange b."""
    model = lp.compose(
        turn=Speed(w=1.0),
        part=part,
        body=Inertia(J=1.0),
        connections=lambda m: lp.chain(m.turn, m.part, m.body),
    )
    system = lp.assemble(model, keep=["body.phi"])
    return lp.simulate(system, until=2 * np.pi * turns, grid=800)


def draw_cardan() -> Figure:
    """Ratio of a joint over a turn, and a drive behind a joint that runs up."""
    figure = Figure((7.5, 3.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    for bend in (10, 20, 30):
        run = turned(CardanJoint(beta=np.radians(bend)))
        left.plot(np.degrees(run.t), run["body.w"], label=f"{bend} deg")
    left.set(
        xlabel="angle of the fork at a, deg", ylabel="ratio w_b / w_a", xticks=range(0, 361, 90)
    )
    model = lp.compose(
        turn=Speed(w=5.0 * lp.time),
        shaft=CardanShaft(beta_a=0.35, beta_b=0.0, c=900.0),
        drum=Inertia(J=0.4),
        brake=Damper(d=1.5),
        wall=Fixed(),
        connections=lambda m: lp.chain(m.turn, m.shaft, m.drum, m.brake, m.wall),
    )
    run = lp.simulate(lp.assemble(model), until=10.0, grid=4000)
    right.plot(run["turn.w"], run["drum.w"] - run["turn.w"], lw=0.6)
    right.set(xlabel="speed of the drive, rad/s", ylabel="drum less drive, rad/s")
    right.set(title="bend 20 deg, w_n = 47.4 rad/s")
    left.legend(fontsize=8)
    return figure


def draw_screws() -> Figure:
    """Torque to raise and to lower over the friction, of runs in which it grows."""
    figure = Figure((5.5, 3.1), layout="constrained")
    axes = figure.subplots()
    for w, label in ((1.0, "raise 6.4 kN"), (-1.0, "lower 6.4 kN")):
        found = []
        rubs = np.linspace(0.0, 0.2, 41)
        for mu in rubs:
            model = lp.compose(
                turn=Speed(w=w),
                screw=LeadScrew(lead=0.008, d=0.03, mu=mu),
                weight=translation.Force(f=-6400.0),
                connections=lambda m: lp.chain(m.turn, m.screw, m.weight),
            )
            found.append(lp.start_point(lp.assemble(model))["screw.flange_a.tau"])
        axes.plot(rubs, found, label=label)
    axes.axvline(0.008 / np.pi / 0.03, color="0.5", lw=0.8, ls="--", label="holds itself from here")
    axes.set(xlabel="coefficient of friction", ylabel="torque on the screw, N.m")
    axes.set(title="lead 8 mm, mean diameter 30 mm")
    axes.legend(fontsize=8)
    return figure


def draw_harmonic_drive() -> Figure:
    """Torque over twist, and vibration by the kinematic error while the drive runs up."""
    figure = Figure((7.5, 3.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    drive = HarmonicDrive(ratio=100.0, K1=1.6e4, K2=2.5e4, K3=2.9e4, T1=14.0, T2=48.0)
    wound = lp.compose(
        wall=Fixed(),
        drive=drive,
        turn=Position(phi=4e-3 * (2 * lp.time - 1)),
        connections=lambda m: [
            lp.connect(m.wall.flange, m.drive.wave_generator),
            lp.connect(m.turn.flange, m.drive.flexspline),
        ],
    )
    run = lp.simulate(lp.assemble(wound), until=1.0, grid=200)
    left.plot(1e3 * run["drive.phi_rel"], run["drive.tau"])
    left.set(xlabel="twist, mrad", ylabel="torque, N.m", title="K1, K2, K3")
    model = lp.compose(
        turn=Speed(w=40.0 * lp.time),
        drive=drive.with_({"errors": ((2, 1e-4, 0.0),)}),
        arm=Inertia(J=2.0),
        brake=Damper(d=8.0),
        wall=Fixed(),
        connections=lambda m: [
            lp.connect(m.turn.flange, m.drive.wave_generator),
            *lp.chain(m.drive.flexspline, m.arm, m.brake, m.wall),
        ],
    )
    run = lp.simulate(lp.assemble(model), until=3.0, grid=4000)
    right.plot(run["turn.w"], run["drive.tau"], lw=0.6)
    right.set(xlabel="speed of the wave generator, rad/s", ylabel="torque, N.m")
    right.set(title="error 0.1 mrad, order 2")
    return figure


def draw_geneva() -> Figure:
    """Angle and speed of the wheel over two turns."""
    figure = Figure((7.5, 3.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    for slots in (3, 4, 6):
        run = turned(Geneva(slots=slots, phase=-np.pi), turns=2.0)
        left.plot(np.degrees(run.t), -np.degrees(run["body.phi"]), label=f"{slots} slots")
        right.plot(np.degrees(run.t), -run["body.w"], label=f"{slots} slots")
    left.set(ylabel="angle of the wheel, reversed, deg")
    right.set(ylabel="ratio -w_b / w_a")
    for axes in (left, right):
        axes.set(xlabel="angle of the driver, deg", xticks=range(0, 721, 180))
    left.legend(fontsize=8)
    return figure


def draw_chains() -> Figure:
    """Speed of a chain over its mean one, over the angle."""
    figure = Figure((5.5, 3.0), layout="constrained")
    axes = figure.subplots()
    for z in (7, 11, 17):
        model = lp.compose(
            turn=Speed(w=1.0),
            sprocket=Sprocket(z=z, pitch=2 * np.pi / z),
            chain=translation.Mass(m=1.0),
            connections=lambda m: lp.chain(m.turn, m.sprocket, m.chain),
        )
        run = lp.simulate(lp.assemble(model), until=np.pi, grid=800)
        axes.plot(np.degrees(run.t), run["chain.v"], label=f"{z} teeth")
    axes.set(xlabel="angle, deg", ylabel="speed of the chain over its mean")
    axes.set(xticks=range(0, 181, 45))
    axes.legend(fontsize=8)
    return figure


def draw_cam_follower() -> Figure:
    """Lift of a follower that lifts off, and the force of the cam below the limit and above."""
    figure = Figure((7.5, 3.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    for w in (120.0, 200.0):
        model = lp.compose(
            turn=Speed(w=w),
            valve=CamFollower(
                cam=Cam(profile=cam_motion(((0, 0), (1.2, 0.01), (2.4, 0)))),
                m=0.3,
                c=3e4,
                F_0=150.0,
            ),
            connections=lambda m: lp.chain(m.turn.flange, m.valve.flange),
        )
        system = lp.assemble(model, keep=["valve.mass.s"])
        run = lp.simulate(system, until=2 * np.pi / w, grid=1500)
        angle = np.degrees(w * run.t)
        left.plot(angle, 1e3 * run["valve.mass.s"], label=f"{w:g} rad/s")
        right.plot(angle, -1e-3 * run["valve.contact.f"], label=f"{w:g} rad/s")
    left.set(ylabel="lift, mm", title="rise and return by cycloids")
    right.set(ylabel="force of the cam, kN")
    for axes in (left, right):
        axes.set(xlabel="angle of the cam, deg", xticks=range(0, 361, 90))
    left.legend(fontsize=8)
    return figure


def save(figure: Figure, name: str) -> None:
    """Grid and file."""
    for axes in figure.axes:
        axes.grid(alpha=0.3)
    figure.savefig(HERE / f"{name}.png", dpi=80, pil_kwargs={"optimize": True})


if __name__ == "__main__":
    save(draw_cardan(), "cardan")
    save(draw_screws(), "screws")
    save(draw_harmonic_drive(), "harmonic_drive")
    save(draw_geneva(), "geneva")
    save(draw_chains(), "chains")
    save(draw_cam_follower(), "cam_follower")
