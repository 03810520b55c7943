"""Draw periodic loads and a rolling pass: ``python docs/elements/draw_periodic.py``."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import lumped as lp
from lumped.components import (
    HarmonicTorque,
    Inertia,
    PeriodicTorque,
    RollingTorque,
    Speed,
    SpringDamper,
    StripPass,
    Torque,
)

FOLDER = Path(__file__).parent
POINTS = (
    (0.0, 0.0),
    (0.4, 420.0),
    (1.0, 260.0),
    (2.2, 40.0),
    (3.1, 0.0),
    (4.2, -50.0),
    (5.3, -60.0),
)
HARMONICS = ((1.0, 180.0, 0.3), (2.0, 140.0, 0.2), (3.0, 75.0, 0.1))


def torque(part):
    """Angle in degrees and torque over two turns."""
    model = lp.compose(
        turn=Speed(w=1.0), part=part, connections=lambda m: lp.chain(m.turn.flange, m.part.flange)
    )
    run = lp.simulate(lp.assemble(model, keep=["part.tau"]), until=4 * np.pi, grid=800)
    return np.degrees(run.t), run["part.tau"]


def finish(figure, name):
    """Write a picture beside this file."""
    for axes in figure.axes:
        axes.grid(color="0.9")
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize="small")
    figure.savefig(FOLDER / f"{name}.png", dpi=80)
    plt.close(figure)


def periodic_torque():
    """Torque over two turns."""
    figure, axes = plt.subplots(figsize=(6.4, 3.2), layout="constrained")
    for shape in ("smooth", "lines"):
        axes.plot(*torque(PeriodicTorque(points=POINTS, shape=shape)), label=f"points, {shape}")
    axes.plot(*torque(HarmonicTorque(harmonics=HARMONICS, mean=80.0)), "--", label="harmonics")
    places, values = np.transpose(POINTS)
    axes.plot(np.degrees(places), values, "o", color="0.4", markersize=4)
    axes.set(title="Periodic torque over two turns", xlabel="angle, deg", ylabel="torque, N.m")
    finish(figure, "periodic_torque")


def rolling():
    """Speed and torques of rolls that reverse."""
    figure, (above, below) = plt.subplots(2, figsize=(6, 4), sharex=True, layout="constrained")
    model = lp.compose(
        drive=Torque(tau=1.1e5 * lp.ops.sin(2 * lp.time)),
        body=Inertia(J=4e3),
        gap=RollingTorque(F=2e6, a=0.012, R=0.4, T_back=4e4, T_front=1.2e5),
        connections=lambda m: lp.chain(m.drive, m.body, m.gap.flange),
    )
    run = lp.simulate(lp.assemble(model), until=6.0, grid=1500)
    above.plot(run.t, run["body.w"], label="rolls")
    below.plot(run.t, run["drive.tau"] / 1e3, label="drive")
    below.plot(run.t, run["gap.tau_f"] / 1e3, label="forming")
    below.plot(run.t, run["gap.tau"] / 1e3, "--", label="forming and tensions")
    above.set(title="Rolls that reverse", ylabel="speed, rad/s")
    below.set(xlabel="time, s", ylabel="torque, kN.m")
    finish(figure, "rolling")


def strip_entry():
    """Torque of a spindle while strips of several entry times come."""
    figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
    for w in (32.0, 8.0, 2.0):
        model = lp.compose(
            motor=Speed(w=w),
            spindle=SpringDamper(c=2e7, d=2e3, phi_rel=0.0),
            rolls=Inertia(J=1600.0, w=w),
            gap=StripPass(
                F=2e5, a=0.04, R=0.4, dh=0.02, l=6.0, phi_in=0.02 * w, T_back=0.0, T_front=0.0
            ),
            connections=lambda m: lp.chain(m.motor, m.spindle, m.rolls, m.gap),
        )
        run = lp.simulate(lp.assemble(model), until=0.3, grid=1000)
        axes.plot(run.t, -run["spindle.tau"] / 1.6e4, label=f"{w:g} rad/s")
    axes.set(title="Entry of a strip", xlabel="time, s", ylabel="spindle torque over steady one")
    finish(figure, "strip_entry")


if __name__ == "__main__":
    periodic_torque()
    rolling()
    strip_entry()
