"""Draw the pictures of cranks and their motor: ``python docs/elements/draw_crank.py``."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import lumped as lp
from lumped.components import (
    CrankSlider,
    InverterInductionMotor,
    Position,
    Speed,
    StrokeLoad,
    translation,
)

FOLDER = Path(__file__).parent
W = 10.0  # rad/s
RODS = {
    "rod 4 r": {"L": 0.8},
    "rod 4 r, offset r": {"L": 0.8, "e": 0.2},
    "rod 4 r, two masses": {"L": 0.8, "two_mass": True},
}


def revolution(crank):
    """One turn at constant speed on a fixed foundation."""
    model = lp.compose(
        turn=Position(phi=W * lp.time),
        crank=crank,
        base=translation.Fixed(),
        connections=lambda m: [
            lp.connect(m.turn.flange, m.crank.flange),
            lp.connect(m.crank.frame_x, m.base.flange),
        ],
    )
    return lp.simulate(lp.assemble(model), until=2 * np.pi / W, grid=360)


def draw_crank():
    """Position of the slider, torque and force on the foundation."""
    figure, axes = plt.subplots(1, 3, figsize=(8.5, 2.9))
    for (label, shape), line in zip(RODS.items(), ("-", "-", "--"), strict=True):
        rod = {"r": 0.2, "m": 5.0, "m_rod": 4.0, "J_rod": 4.0 * shape["L"] ** 2 / 12}
        run = revolution(CrankSlider(**rod, **shape))
        angle = np.degrees(W * run.t)
        for axis, name, sign in zip(
            axes, ("crank.s", "turn.flange.tau", "base.flange.f"), (1, -1, 1), strict=True
        ):
            axis.plot(angle, sign * run[name], line, label=label)
    for axis, label in zip(
        axes, ("slider, m", "crank torque, N.m", "force on foundation, N"), strict=True
    ):
        axis.set(xlabel="crank angle, deg", title=label, xticks=range(0, 361, 90))
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("r = 0.2 m, 10 rad/s")
    axes[0].set_ylim(0, 1.6)
    axes[0].legend(fontsize=7, loc="upper center")
    save(figure, "crank")


def draw_stroke_load():
    """Force over a stroke, to and fro."""
    figure, axes = plt.subplots(figsize=(5.5, 3.4))
    for p, q in ((1.0, 1.0), (2.2, 0.66)):
        model = lp.compose(
            move=translation.Position(s=0.6 - 0.6 * lp.ops.cos(lp.time)),
            load=StrokeLoad(forward=100.0, backward=60.0, s_0=0.0, s_1=1.2, p=p, q=q),
            connections=lambda m: [lp.connect(m.move.flange, m.load.flange)],
        )
        run = lp.simulate(lp.assemble(model), until=2 * np.pi, grid=600)
        axes.plot(run["move.s"], run["load.f"], label=f"p = {p:g}, q = {q:g}")
    axes.set(xlabel="position, m", ylabel="force, N", title="forward 100 N, backward 60 N")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    save(figure, "stroke_load")


def draw_inverter_motor():
    """Torque over speed at four synchronous speeds."""
    figure, axes = plt.subplots(figsize=(5.5, 3.4))
    for w_s in (25.0, 50.0, 75.0, 100.0):
        model = lp.compose(
            turn=Speed(w=120.0 * lp.time),
            motor=InverterInductionMotor(w_s=w_s, J=1.0, tau_k=130.0, d_k=5.0, T=1e-4),
            connections=lambda m: [lp.connect(m.turn.flange, m.motor.flange)],
        )
        run = lp.simulate(lp.assemble(model), until=1.0, grid=600)
        settled = run.t > 0.005
        axes.plot(run["motor.w"][settled], run["motor.tau"][settled], label=f"{w_s:g} rad/s")
    axes.set(xlabel="speed, rad/s", ylabel="torque, N.m", title="d_k = 5 rad/s")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, title="synchronous")
    save(figure, "inverter_induction_motor")


def save(figure, name):
    """Write the file."""
    figure.tight_layout()
    figure.savefig(FOLDER / f"{name}.png", dpi=66, pil_kwargs={"optimize": True})
    plt.close(figure)


if __name__ == "__main__":
    draw_crank()
    draw_stroke_load()
    draw_inverter_motor()
