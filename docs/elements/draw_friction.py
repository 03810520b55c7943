"""Draw the pictures of friction elements: ``python docs/elements/draw_friction.py``."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import lumped as lp
from lumped.components import (
    BearingFriction,
    Brake,
    Clutch,
    Fixed,
    Inertia,
    OneWayClutch,
    Speed,
    SpringDamper,
    Stribeck,
    Torque,
)
from lumped.components.translation import Force, MassWithStopAndFriction
from lumped.components.translation import Speed as Slide
from lumped.components.translation import SpringDamper as Coil

FOLDER = Path(__file__).parent
FALLING = ((0.0, 0.5), (5.0, 0.42), (15.0, 0.36))


def swept(part, w, torque="tau"):
    """Sliding speed and torque of an element that a source turns through standstill.

    The speed rises evenly from -w to w. A stiff shaft stands between source and element, so that
    the element may stick.
    """
    joined = [part] if "support" in part._ports else [part, Fixed()]
    model = lp.compose(
        turn=Speed(w=w * (lp.time / 10 - 1)),
        shaft=SpringDamper(c=2e3, d=4.0),
        body=Inertia(J=1e-3, w=-w),
        part=joined,
        connections=lambda m: lp.chain(m.turn, m.shaft, m.body, *m.part),
    )
    run = lp.simulate(lp.assemble(model), until=20.0, grid=None, start={"shaft.phi_rel": 0.0})
    return -run["body.w"] if len(joined) > 1 else run["body.w"], run[f"part[0].{torque}"]


def finish(figure, name):
    """Write a picture."""
    for axes in figure.axes:
        axes.grid(alpha=0.3)
        axes.axhline(0, color="0.6", lw=0.8)
        axes.axvline(0, color="0.6", lw=0.8)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(FOLDER / f"{name}.png", dpi=80)
    plt.close(figure)


def draw_bearing_friction():
    """Torque over speed for three characteristics."""
    figure, axes = plt.subplots(figsize=(5.4, 3.6))
    for label, part in (
        ("((0, 1), (20, 1.5))", BearingFriction(characteristic=((0, 1), (20, 1.5)))),
        ("((0, 3),), peak = 1.5", BearingFriction(characteristic=((0, 3),), peak=1.5)),
        (
            "Stribeck(2, 5.5, 0.4, 0.05)",
            BearingFriction(characteristic=Stribeck(2.0, 5.5, 0.4, 0.05)),
        ),
    ):
        axes.plot(*swept(part, 20.0), label=label)
    axes.set(xlabel="speed, rad/s", ylabel="friction torque, N.m", title="Bearing friction")
    finish(figure, "bearing_friction")


def draw_brake():
    """Torque over speed for several normal forces."""
    figure, axes = plt.subplots(figsize=(5.4, 3.6))
    for u in (0.0, 0.25, 0.5, 1.0):
        part = Brake(characteristic=FALLING, c_geo=0.1, f_max=400.0, u=u, peak=1.1)
        axes.plot(*swept(part, 15.0), label=f"u = {u:g}")
    axes.set(xlabel="speed, rad/s", ylabel="friction torque, N.m", title="Brake")
    finish(figure, "brake")


def draw_clutch():
    """Torque over sliding speed, and two bodies that a clutch brings together."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.1))
    for u in (0.25, 0.5, 1.0):
        part = Clutch(characteristic=FALLING, c_geo=0.1, f_max=400.0, u=u, peak=1.1)
        w, tau = swept(part, 15.0)
        left.plot(w, tau, label=f"u = {u:g}")
    left.set(xlabel="speed of b relative to a, rad/s", ylabel="torque on flange b, N.m")
    left.set(title="sliding and sticking")
    pressed = lp.ops.table([0.2, 0.5, 1.4, 1.5], [0.0, 1.0, 1.0, 0.0])
    model = lp.compose(
        drive=Torque(tau=5.0),
        a=Inertia(J=0.2, w=15.0),
        clutch=Clutch(characteristic=FALLING, c_geo=0.1, f_max=200.0, u=pressed),
        b=Inertia(J=0.4, w=0.0),
        connections=lambda m: lp.chain(m.drive, m.a, m.clutch, m.b),
    )
    run = lp.simulate(lp.assemble(model), until=2.0)
    right.plot(run.t, run["a.w"], label="a, rad/s")
    right.plot(run.t, run["b.w"], label="b, rad/s")
    right.plot(run.t, -run["clutch.tau"], "--", label="torque from a to b, N.m")
    right.set(xlabel="time, s", title="pressed from 0.2 s to 1.5 s")
    finish(figure, "clutch")


def draw_one_way_clutch():
    """Torque over sliding speed, and a body that is driven, overruns and is caught again."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.1))
    pull = 12 * (1 - lp.time / 2)
    for u in (0.0, 1.0):
        model = lp.compose(
            ground=Fixed(),
            wheel=OneWayClutch(characteristic=((0, 0.5),), c_geo=0.1, f_max=80.0, u=u, peak=1.2),
            body=Inertia(J=0.2),
            drive=Torque(tau=-pull),
            connections=lambda m: lp.chain(m.ground, m.wheel, m.body, m.drive),
        )
        run = lp.simulate(lp.assemble(model), until=3.5, grid=2000)
        left.plot(run["wheel.w_rel"], run["wheel.tau"], label=f"u = {u:g}")
    left.set(xlabel="speed of b relative to a, rad/s", ylabel="torque on flange b, N.m")
    left.set(title="locked and sliding", xlim=(-1, 10))
    model = lp.compose(
        drive=Torque(tau=4 * lp.ops.sin(2 * np.pi * lp.time)),
        a=Inertia(J=0.1),
        wheel=OneWayClutch(u=0.0),
        b=Inertia(J=0.2),
        bearing=BearingFriction(characteristic=lambda w: 0.1 + 0.05 * w),
        connections=lambda m: lp.chain(m.drive, m.a, m.wheel, m.b, m.bearing),
    )
    run = lp.simulate(lp.assemble(model), until=2.5)
    right.plot(run.t, run["a.w"], label="a, driven by a sine")
    right.plot(run.t, run["b.w"], label="b")
    right.set(xlabel="time, s", ylabel="speed, rad/s", title="a freewheel at work, u = 0")
    finish(figure, "one_way_clutch")


def draw_mass_with_stop_and_friction():
    """Friction force over velocity, and a mass pushed to and fro between its stops."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.1))
    curve = Stribeck(coulomb=5.0, static=15.0, decay=2.0, viscous=1.0)
    slide = MassWithStopAndFriction(
        m=1.0, length=0.2, s_min=-0.6, s_max=0.6, characteristic=curve, peak=1.2
    )
    model = lp.compose(
        pull=Slide(v=6 * (lp.time / 10 - 1)),
        rod=Coil(c=2e4, d=200.0),
        slide=slide.with_({"s_min": -100.0, "s_max": 100.0, "v": -6.0}),
        connections=lambda m: lp.chain(m.pull, m.rod, m.slide),
    )
    run = lp.simulate(lp.assemble(model), until=20.0, grid=None)
    left.plot(run["slide.v"], run["slide.f"])
    left.set(xlabel="velocity, m/s", ylabel="friction force, N", title="Stribeck friction")
    model = lp.compose(
        push=Force(f=25 * lp.ops.sin(2 * np.pi * lp.time)),
        slide=slide,
        connections=lambda m: lp.chain(m.push, m.slide),
    )
    run = lp.simulate(lp.assemble(model), until=2.0)
    right.plot(run.t, run["slide.s"], label="position, m")
    right.plot(run.t, run["slide.v"] / 10, label="velocity, 10 m/s")
    right.plot(run.t, run["slide.f_stop"] / 25, ":", label="force of the stops, 25 N")
    right.set(xlabel="time, s", title="pushed by a sine of 25 N")
    finish(figure, "mass_with_stop_and_friction")


if __name__ == "__main__":
    draw_bearing_friction()
    draw_brake()
    draw_clutch()
    draw_one_way_clutch()
    draw_mass_with_stop_and_friction()
