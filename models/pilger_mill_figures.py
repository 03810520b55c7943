"""Figures of the cold pilger mill LG90."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

import lumped as lp
from lumped.models.pilger_mill_balance import balance
from lumped.models.pilger_mill_drive import running, start_up
from lumped.models.pilger_mill_stand import (
    DESIGNS,
    IDLE,
    SPEED,
    AsPrinted,
    Mill,
    crank_torque,
    mill,
    revolution,
    shaking_force,
    turned,
)

__all__ = ["figures"]

DEGREES = np.arange(361.0)
LINES = {"before": "--", "after": "-"}


def figures() -> dict[str, Figure]:
    """Figures by name."""
    return {
        "kinematics": _draw_kinematics(),
        "inertia_force": _draw_force(),
        "crank_torque": _draw_torque(),
        "optimum": _draw_front(),
        "running": _draw_run(running(until=3.75, grid=2000), "Steady running, set P"),
        "start_up": _draw_run(start_up(grid=2000), "Start from rest, set P"),
    }


def _turn(name: str, design: str, kind: type[Mill] = Mill, g: float = 0.0) -> lp.Trajectory:
    w = SPEED[name]
    return revolution(turned(mill(name, design, kind, g=g), w * lp.time), w, DEGREES)


def _label_angle(axis: object) -> None:
    axis.set(xlabel="crank angle, deg", xlim=(0, 360), xticks=range(0, 361, 45))  # type: ignore[attr-defined]


def _draw_kinematics() -> Figure:
    run = _turn("P", "after")
    figure = Figure((8, 8), layout="constrained")
    axes = figure.subplots(3, sharex=True)
    parts: Mapping[str, str] = {"stand": "stand, along x", "weight": "counterweight, along y"}
    for part, label in parts.items():
        s, v = run[f"mill.{part}.s"], run[f"mill.{part}.v"]
        axes[0].plot(DEGREES, s - s.mean(), label=label)
        axes[1].plot(DEGREES, v)
        axes[2].plot(DEGREES, run[f"mill.{part}.a"])
    axes[0].set(title="Set P, 64 revolutions a minute", ylabel="position\nless its mean, m")
    axes[1].set(ylabel="velocity, m/s")
    axes[2].set(ylabel="acceleration, m/s²")
    axes[0].legend()
    for axis in axes:
        axis.grid(alpha=0.3)
    _label_angle(axes[2])
    return figure


def _draw_force() -> Figure:
    figure = Figure((8, 8), layout="constrained")
    axes = figure.subplots(2, 2)
    for column, name in enumerate("PF"):
        for design, line in LINES.items():
            force = shaking_force(_turn(name, design)) / 1e3
            axes[0, column].plot(*force.T, line, label=f"{design} optimisation")
            axes[1, column].plot(DEGREES, np.hypot(*force.T), line)
        axes[0, column].set(title=f"Force on the foundation, set {name}", aspect="equal")
        axes[0, column].set(xlabel="along x, kN", ylabel="along y, kN")
        axes[1, column].set(ylabel="amount, kN", ylim=(0, None))
        _label_angle(axes[1, column])
    for axis in axes.flat:
        axis.grid(alpha=0.3)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _draw_torque() -> Figure:
    figure = Figure((8, 8), layout="constrained")
    axes = figure.subplots(2, sharex=True)
    cases = (
        ("as printed", AsPrinted, 0.0, ":"),
        ("exact", Mill, 0.0, "-"),
        ("exact, with gravity", Mill, 9.80665, "--"),
    )
    for axis, name in zip(axes, "PF", strict=True):
        for label, kind, g, line in cases:
            torque = crank_torque(_turn(name, "after", kind, g), IDLE)
            axis.plot(DEGREES, torque / 1e3, line, label=label)
        axis.axhline(0, color="black", linewidth=0.8)
        axis.set(title=f"Torque at the crank, set {name}, after", ylabel="torque, kN.m")
        axis.grid(alpha=0.3)
        axis.legend()
    _label_angle(axes[1])
    return figure


def _draw_front() -> Figure:
    figure = Figure((8, 8), layout="constrained")
    axes = figure.subplots(2)
    for axis, name in zip(axes, "PF", strict=True):
        found = balance(name)
        front, goals = found.front(), found.goals()
        axis.plot(front[:, 2] / goals[0], front[:, 3] / goals[1], label="Pareto front")
        points = {design: np.array(list(u.values())) for design, u in DESIGNS.items()}
        points |= {"best by the weights of the source": found.optimum()}
        for (label, u), mark in zip(points.items(), "so*", strict=True):
            goal = found.forces(u).max() / goals[0], found.fluctuation(u) / goals[1]
            text = f"{label}: $m_2$ = {u[0]:.0f} kg, $m_sR_s$ = {u[1]:.0f} kg m"
            axis.plot(*goal, mark, markersize=9, label=text)
        axis.set(title=f"Set {name}", xlabel="$F_1 / F_{10}$", ylabel="$F_2 / F_{20}$")
        axis.grid(alpha=0.3)
        axis.legend()
    return figure


def _draw_run(run: lp.Trajectory, title: str) -> Figure:
    figure = Figure((8, 6), layout="constrained")
    speed, torque = figure.subplots(2, sharex=True)
    speed.plot(run.t, run["motor.w"])
    speed.set(title=title, ylabel="speed of the motor, rad/s")
    torque.plot(run.t, run["motor.tau"] / 1e3)
    torque.set(xlabel="time, s", ylabel="motor torque, kN.m", xlim=(0, run.t[-1]))
    for axis in (speed, torque):
        axis.grid(alpha=0.3)
    return figure
