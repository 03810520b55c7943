"""Draw sources, springs and samplers: ``python docs/elements/draw_sources.py``."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import lumped as lp
from lumped.components import (
    FilteredPosition,
    FilteredSpeed,
    Fixed,
    Inertia,
    NonlinearSpring,
    SampleHold,
    Speed,
)

FOLDER = Path(__file__).parent


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


def draw_sources():
    """A body that follows steps of an angle and of a speed."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.1))
    steps = lp.ops.table([0.0, 0.05, 0.05, 0.3, 0.3, 0.5], [0.0, 0.0, 1.0, 1.0, -0.5, -0.5])
    for axes, kind, quantity, state, title, unit in (
        (left, FilteredPosition, "phi_ref", "body.phi", "FilteredPosition", "angle, rad"),
        (right, FilteredSpeed, "w_ref", "body.w", "FilteredSpeed", "speed, rad/s"),
    ):
        for f_crit in (2.0, 5.0, 20.0):
            model = lp.compose(
                source=kind(f_crit=f_crit, **{quantity: steps}),
                body=Inertia(J=1.0),
                connections=lambda m: lp.chain(m.source, m.body),
            )
            run = lp.simulate(lp.assemble(model, keep=[state]), until=0.5, grid=800)
            axes.plot(run.t, run[state], label=f"f_crit = {f_crit:g} Hz")
        axes.plot([0, 0.05, 0.05, 0.3, 0.3, 0.5], [0, 0, 1, 1, -0.5, -0.5], "k:", lw=1)
        axes.set(title=title, xlabel="time, s", ylabel=unit)
    finish(figure, "sources")


def draw_springs():
    """Torque over twist, and free vibrations of different amplitude."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.1))
    rows = ((0.0, 0.0), (0.05, 20.0), (0.1, 90.0))
    laws = {
        "rows ((0, 0), (0.05, 20), (0.1, 90))": rows,
        "400 x + 5e4 x**3": lambda x: 400 * x + 5e4 * x**3,
    }
    for name, law in laws.items():
        model = lp.compose(
            wall=Fixed(),
            spring=NonlinearSpring(characteristic=law, phi_rel=-0.12),
            turn=Speed(w=0.24),
            connections=lambda m: lp.chain(m.wall, m.spring, m.turn),
        )
        run = lp.simulate(lp.assemble(model), until=1.0, grid=600)
        left.plot(run["spring.phi_rel"], run["spring.tau"], label=name)
    left.set(title="characteristic", xlabel="twist, rad", ylabel="torque on flange b, N.m")
    for w in (1.0, 2.0, 4.0):
        model = lp.compose(
            wall=Fixed(),
            spring=NonlinearSpring(characteristic=rows),
            body=Inertia(J=0.5, w=w, phi=0.0),
            connections=lambda m: lp.chain(m.wall, m.spring, m.body),
        )
        run = lp.simulate(lp.assemble(model), until=0.5, grid=800)
        right.plot(run.t, run["spring.phi_rel"], label=f"begun with {w:g} rad/s")
    right.set(title="swings on the rows, 0.5 kg.m2", xlabel="time, s", ylabel="twist, rad")
    right.set_ylim(-0.12, 0.19)
    finish(figure, "springs")


def draw_sampled():
    """A signal, held by a fast sampler, and taken from that by a slow one."""
    figure, axes = plt.subplots(figsize=(6, 3.1))
    signal = lp.ops.sin(2 * lp.time) + 0.2 * lp.ops.sin(9 * lp.time)
    model = lp.compose(
        fast=SampleHold(T_s=0.1, u=signal),
        slow=SampleHold(T_s=0.4),
        connections=lambda m: [lp.connect(m.fast.y, m.slow.u)],
    )
    run = lp.simulate(lp.assemble(model), until=3.0, grid=1500)
    axes.plot(run.t, np.sin(2 * run.t) + 0.2 * np.sin(9 * run.t), "k:", lw=1, label="signal")
    axes.plot(run.t, run["fast.y"], label="T_s = 0.1 s")
    axes.plot(run.t, run["slow.y"], label="T_s = 0.4 s, behind it")
    axes.set(title="Two samplers in a row", xlabel="time, s", ylabel="signal")
    finish(figure, "sampled")


if __name__ == "__main__":
    draw_sources()
    draw_springs()
    draw_sampled()
