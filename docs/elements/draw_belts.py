"""Draw belts, differentials and guides under load; the curves are runs of the components.

Run from the top of the project: python docs/elements/draw_belts.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lumped as lp
from lumped.components import (
    Belt,
    BevelDifferential,
    CrankSlider,
    Fixed,
    Inertia,
    Position,
    Torque,
    translation,
)
from lumped.ops import where

FOLDER = Path(__file__).parent


def twisted(pretension: float, d: float = 0.0) -> lp.Trajectory:
    """One pulley held, the other turned to and fro."""
    model = lp.compose(
        turn=Position(phi=0.05 * lp.ops.sin(lp.time)),
        belt=Belt(r_a=0.1, r_b=0.25, distance=0.8, EA=4e5, d=d, F_0=pretension),
        wall=Fixed(),
        connections=lambda m: lp.chain(m.turn, m.belt, m.wall),
    )
    return lp.simulate(lp.assemble(model), until=2 * np.pi, grid=600)


def draw_belt() -> None:
    """Torque and strands over the angle."""
    figure = Figure(figsize=(7.2, 2.9))
    left, right = figure.subplots(1, 2)
    for pretension in (0.0, 500.0, 1500.0):
        run = twisted(pretension)
        left.plot(1e3 * run["turn.phi"], -run["turn.flange.tau"], label=f"{pretension:g} N")
    left.legend(title="pretension", fontsize=8, title_fontsize=8)
    run = twisted(1500.0)
    for name, label in (
        ("T_1", "strand 1"),
        ("T_2", "strand 2"),
        ("F", "force on the shafts"),
    ):
        right.plot(1e3 * run["turn.phi"], 1e-3 * run[f"belt.{name}"], label=label)
    right.legend(fontsize=8, loc="upper center")
    left.set(xlabel="angle of pulley a, mrad", ylabel="torque, N.m", title="pulley b held")
    right.set(xlabel="angle of pulley a, mrad", ylabel="force, kN", title="pretension 1500 N")
    save(figure, "belts")


def draw_differential() -> None:
    """A car whose right wheel stands on ice for a while."""
    model = lp.compose(
        engine=Torque(tau=100.0),
        rotor=Inertia(J=0.5),
        gear=BevelDifferential(ratio=4.0),
        left=Inertia(J=20.0),
        right=Inertia(J=2.0),
        grip=Torque(tau=where(lp.time >= 2.0, where(lp.time >= 3.0, -160.0, 0.0), -160.0)),
        connections=lambda m: (
            *lp.chain(m.engine, m.rotor, m.gear.flange_a),
            lp.connect(m.gear.left, m.left.flange_a),
            lp.connect(m.gear.right, m.right.flange_a, m.grip.flange),
        ),
    )
    run = lp.simulate(lp.assemble(model), until=4.0, grid=800)
    figure = Figure(figsize=(7.2, 2.9))
    left, right = figure.subplots(1, 2)
    for name, label in (("left.w", "left"), ("right.w", "right")):
        left.plot(run.t, run[name], label=label)
    left.plot(run.t, run["rotor.w"] / 4, "--", label="crown gear")
    right.plot(run.t, -run["gear.left.tau"], label="left")
    right.plot(run.t, -run["gear.right.tau"], "--", label="right")
    left.set(xlabel="time, s", ylabel="speed, rad/s", title="right wheel free from 2 s to 3 s")
    right.set(xlabel="time, s", ylabel="torque on the wheel, N.m", title="both outputs alike")
    for axes in (left, right):
        axes.legend(fontsize=8)
    save(figure, "differential")


def draw_guide() -> None:
    """Guide force, friction and crank torque over a turn."""
    figure = Figure(figsize=(7.2, 2.9))
    left, right = figure.subplots(1, 2)
    for mu in (0.0, 0.1, 0.3):
        model = lp.compose(
            turn=Position(phi=10.0 * lp.time),
            crank=CrankSlider(r=0.2, L=0.6, m=5.0, g=9.81),
            guide=translation.GuideFriction(mu=mu),
            connections=lambda m: (
                lp.connect(m.turn.flange, m.crank.flange),
                lp.connect(m.crank.slider, m.guide.flange_a),
                lp.connect(m.crank.guide, m.guide.load),
            ),
        )
        run = lp.simulate(lp.assemble(model), until=0.2 * np.pi, grid=720)
        angle = np.degrees(10.0 * run.t)
        left.plot(angle, run["guide.f"], label=f"mu = {mu:g}")
        right.plot(angle, -run["turn.flange.tau"], label=f"mu = {mu:g}")
    left.set(ylabel="friction, N", title="guide: 10 rad/s, rod 3 r, 5 kg")
    right.set(ylabel="crank torque, N.m", title="crank")
    for axes in (left, right):
        axes.set(xlabel="crank angle, deg", xticks=range(0, 361, 90))
    left.legend(fontsize=8)
    save(figure, "guide_friction")


def save(figure: Figure, name: str) -> None:
    """Grid and file."""
    for axes in figure.axes:
        axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(FOLDER / f"{name}.png", dpi=80, pil_kwargs={"optimize": True})


if __name__ == "__main__":
    draw_belt()
    draw_differential()
    draw_guide()
