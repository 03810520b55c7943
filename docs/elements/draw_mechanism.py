"""Draw the pictures of gears of varying ratio, linkages and cams."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import lumped as lp
from lumped.components import (
    Bar,
    Eccentric,
    EllipticalGear,
    GuidedRod,
    Inertia,
    NonCircularGear,
    PlaneSpring,
    PulseTorque,
    Speed,
    translation,
)

FOLDER = Path(__file__).parent


def turned(gear):
    """Angles and speed of flange b of a gear that is turned at a with 1 rad/s for two turns."""
    model = lp.compose(
        turn=Speed(w=1.0),
        gear=gear,
        body=Inertia(J=1.0),
        connections=lambda m: lp.chain(m.turn, m.gear, m.body),
    )
    run = lp.simulate(lp.assemble(model, keep=["body.phi"]), until=4 * np.pi, grid=800)
    return np.degrees(run.t), run["body.phi"], run["body.w"]


def draw_noncircular():
    """Angle and ratio over two turns."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 2.9))
    gears = {f"ellipses, e = {e:g}": EllipticalGear(e=e) for e in (0.5, 0.8)}
    gears["x + sin(2 x) / 4"] = NonCircularGear(transmission=lambda x: -(x + lp.ops.sin(2 * x) / 4))
    # half a turn at half, half a turn at one and a half times the speed, with ramps between
    places, ratios = (0, 0.6, 2.5, 3.8, 5.7, 2 * np.pi), (-1, -0.5, -0.5, -1.5, -1.5, -1)
    closing = (2 * np.pi) / -np.trapezoid(ratios, places)
    gears["ratio of straight lines"] = NonCircularGear(
        transmission=lp.transmissions.from_ratio(
            lambda x: closing * lp.ops.interpolate(x, places, ratios), turns=-1
        )
    )
    for name, gear in gears.items():
        phi, angle, w = turned(gear)
        left.plot(phi, -np.degrees(angle), label=name)
        right.plot(phi, -w, label=name)
    left.set(xlabel="angle of flange a, deg", ylabel="angle of flange b, reversed, deg")
    right.set(xlabel="angle of flange a, deg", ylabel="ratio -w_b / w_a")
    finish(figure, "noncircular")


def draw_linkages():
    """Foot of a guided rod on an eccentric, and its speed."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 2.9))
    for length in (0.3, 0.5, 3.4):
        model = lp.compose(
            turn=Speed(w=1.0),
            crank=Eccentric(radius=0.25, phase=np.pi / 2),
            hub=translation.Fixed(),
            rod=GuidedRod(length=length),
            ram=translation.Mass(m=1.0),
            connections=lambda m: [
                lp.connect(m.turn.flange, m.crank.flange),
                lp.connect(m.hub.flange, m.crank.hub_x, m.crank.hub_y),
                lp.connect(m.crank.pin_x, m.rod.pin_x),
                lp.connect(m.crank.pin_y, m.rod.pin_y),
                lp.connect(m.rod.foot_y, m.ram.flange_a),
            ],
        )
        run = lp.simulate(lp.assemble(model, keep=["ram.s"]), until=2 * np.pi, grid=400)
        phi = np.degrees(run.t)
        left.plot(phi, run["ram.s"] + length, label=f"rod {length:g} m")
        right.plot(phi, run["ram.v"], label=f"rod {length:g} m")
    left.set(xlabel="crank angle, deg", ylabel="foot + length, m", title="radius 0.25 m")
    right.set(xlabel="crank angle, deg", ylabel="speed of the foot, m/s", title="at 1 rad/s")
    finish(figure, "linkages")


def draw_plane():
    """Path of a mass on a spring, and a double pendulum of two bars."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.4))
    for d in (0.0, 3.0):
        model = lp.compose(
            centre=translation.Fixed(),
            spring=PlaneSpring(c=300.0, d=d, length0=0.8),
            x=translation.Mass(m=2.0, s=1.0, v=0.0),
            y=translation.Mass(m=2.0, s=0.0, v=3.0),
            connections=lambda m: [
                lp.connect(m.centre.flange, m.spring.a_x, m.spring.a_y),
                lp.connect(m.spring.b_x, m.x.flange_a),
                lp.connect(m.spring.b_y, m.y.flange_a),
            ],
        )
        run = lp.simulate(lp.assemble(model, keep=["x.s", "y.s"]), until=3.0, grid=1500)
        left.plot(run["x.s"], run["y.s"], lw=1, label=f"d = {d:g} N.s/m")
    left.set(xlabel="x, m", ylabel="y, m", title="mass of 2 kg on a PlaneSpring", aspect="equal")
    bar = Bar(length=0.5, m=1.0, J=1 / 48, g=9.81)
    model = lp.compose(
        nail=translation.Fixed(),
        upper=bar.with_({"phi": 0.3, "w": 0.0}),
        lower=bar.with_({"phi": 1.0, "w": 0.0}),
        connections=lambda m: [
            lp.connect(m.nail.flange, m.upper.a_x, m.upper.a_y),
            lp.connect(m.upper.b_x, m.lower.a_x),
            lp.connect(m.upper.b_y, m.lower.a_y),
        ],
    )
    names = [f"{bar}.b_{axis}.s" for bar in ("upper", "lower") for axis in "xy"]
    run = lp.simulate(lp.assemble(model, keep=names), until=2.0, grid=1000)
    for bar in ("upper", "lower"):
        right.plot(run[f"{bar}.b_x.s"], run[f"{bar}.b_y.s"], lw=1, label=f"end of the {bar} bar")
    for i in range(0, 1000, 90):
        x, y = (
            [0.0, *(run[f"{bar}.b_{axis}.s"][i] for bar in ("upper", "lower"))] for axis in "xy"
        )
        right.plot(x, y, color="0.75", lw=0.8, zorder=0)
    right.set(xlabel="x, m", title="double pendulum of two Bars", aspect="equal")
    right.set(xlim=(-1.1, 1.1), ylim=(-1.1, 1.1))
    right.legend(fontsize=7, loc="upper left")
    finish(figure, "plane")


def draw_cams():
    """Torque pulses over two turns."""
    figure, axes = plt.subplots(figsize=(5.5, 3.1))
    for shape in ("half-sine", "rectangle"):
        model = lp.compose(
            turn=Speed(w=1.0),
            pulse=PulseTorque(shape=shape, tau_max=-10.0, centre=2.0, width=1.2),
            connections=lambda m: lp.chain(m.turn.flange, m.pulse.flange),
        )
        run = lp.simulate(lp.assemble(model), until=4 * np.pi, grid=800)
        axes.plot(np.degrees(run.t), run["pulse.tau"], label=shape)
    axes.set(xlabel="angle, deg", ylabel="torque, N.m", title="centre 2 rad, width 1.2 rad")
    finish(figure, "cams")


def finish(figure, name):
    """Grid, legend, file."""
    for axes in figure.axes:
        axes.grid(alpha=0.3)
    figure.axes[0].legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(FOLDER / f"{name}.png", dpi=72)
    plt.close(figure)


if __name__ == "__main__":
    draw_noncircular()
    draw_linkages()
    draw_plane()
    draw_cams()
