"""Draw tyres and synchronisers: ``python docs/elements/draw_tyre.py``."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import lumped as lp
from lumped.components import Brake, Inertia, Speed, Synchroniser, Torque, Tyre, translation

FOLDER = Path(__file__).parent
TYRE = {"R": 0.3, "mu": 1.0, "B": 10.0, "C": 1.6, "E": -0.2, "sigma": 0.3}


def finish(figure, name):
    """Grid, legends, file."""
    for axes in figure.axes:
        axes.grid(alpha=0.3)
        axes.spines[["top", "right"]].set_visible(False)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize=8, frameon=False)
    figure.tight_layout()
    figure.savefig(FOLDER / f"{name}.png", dpi=80)
    plt.close(figure)


def draw_tyre():
    """Force over slip at 20 m/s, and a wheel that is braked until it locks and the car stands."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.2))
    for load in (2000.0, 4000.0, 6000.0):
        model = lp.compose(
            turn=Speed(w=20.0 / 0.3 * (1 + 0.5 * lp.ops.sin(np.pi * (lp.time / 100 - 0.5)))),
            tyre=Tyre(**TYRE, f_n=load),
            slide=translation.Speed(v=20.0),
            connections=lambda m: [
                lp.connect(m.turn.flange, m.tyre.wheel),
                lp.connect(m.tyre.hub, m.slide.flange),
            ],
        )
        run = lp.simulate(lp.assemble(model), until=100.0, grid=800)
        seen = run.t > 1
        left.plot(run["tyre.k"][seen], run["tyre.f"][seen] / 1e3, label=f"load {load:g} N")
    left.set(title="rolling steadily", xlabel="slip k", ylabel="driving force, kN")
    pressed = lp.ops.table([0.0, 0.3, 0.5], [0.0, 0.0, 1.0])
    model = lp.compose(
        wheel=Inertia(J=1.2, w=20.0 / 0.3),
        brake=Brake(characteristic=((0.0, 0.4),), c_geo=0.2, f_max=2e4, u=pressed),
        tyre=Tyre(**TYRE, f_n=4000.0),
        car=translation.Mass(m=400.0, v=20.0),
        connections=lambda m: [
            *lp.chain(m.wheel, m.brake, m.tyre.wheel),
            lp.connect(m.tyre.hub, m.car.flange_a),
        ],
    )
    run = lp.simulate(lp.assemble(model), until=4.0, grid=1500)
    right.plot(run.t, run["car.v"], label="car, m/s")
    right.plot(run.t, 0.3 * run["wheel.w"], label="tread, m/s")
    right.plot(run.t, run["tyre.f"] / 200, "--", label="force, 200 N")
    right.set(title="braked until it locks", xlabel="time, s")
    finish(figure, "tyre")


def draw_synchroniser():
    """Speeds and torque of a change of gear."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.1))
    pressed = lp.ops.table([0.05, 0.1, 0.6, 0.61], [0.0, 1.0, 1.0, 0.0])
    model = lp.compose(
        wheel=Inertia(J=0.02, w=300.0),
        shift=Synchroniser(f_max=600.0, mu=0.1, R=0.035, alpha=0.113, u=pressed),
        shaft=Inertia(J=0.5, w=120.0),
        load=Torque(tau=lp.ops.where(lp.time >= 0.4, -800.0, 0.0)),
        connections=lambda m: lp.chain(m.wheel, m.shift, m.shaft, m.load),
    )
    run = lp.simulate(lp.assemble(model), until=0.7, grid=2000)
    left.plot(run.t, run["wheel.w"], label="wheel")
    left.plot(run.t, run["shaft.w"], label="shaft")
    left.set(title="pressed from 0.05 to 0.6 s", xlabel="time, s", ylabel="speed, rad/s")
    right.plot(run.t, run["shift.tau_cones"], label="cones")
    right.plot(run.t, run["shift.tau_dogs"], label="dogs")
    right.set(title="the shaft is braked from 0.4 s", xlabel="time, s", ylabel="torque, N.m")
    finish(figure, "synchroniser")


if __name__ == "__main__":
    draw_tyre()
    draw_synchroniser()
