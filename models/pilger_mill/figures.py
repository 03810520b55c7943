"""Figures of the cold pilger mill LG90."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import lumped as lp
from lumped.models.panels import panels
from lumped.models.pilger_mill import stand
from lumped.models.pilger_mill.balance import balance
from lumped.models.pilger_mill.drive import running, start_up

DEGREES = np.arange(361.0)
LINES = {"before": "--", "after": "-"}


def _turn(
    name: str,
    design: str,
    kind: type[stand.Mill] = stand.Mill,
    g: float = 0.0,
    changes: Mapping[str, float] | None = None,
) -> lp.Trajectory:
    w = stand.SPEED[name]
    part = stand.mill(name, design, kind, g=g, **(changes or {}))
    return stand.revolution(stand.turn_mill(part, w * lp.time), w, DEGREES)


def _label_angle(axis: Axes) -> None:
    axis.set(xlabel="crank angle, deg", xlim=(0, 360), xticks=range(0, 361, 45))


def draw_kinematics() -> Figure:
    run = _turn("P", "after")
    labels = ("position\nless its mean, m", "velocity, m/s", "acceleration, m/s²")
    figure, axes = panels(3, size=(8, 8), title="Set P, 64 revolutions a minute", y=labels)
    for part, label in (("stand", "stand, along x"), ("weight", "counterweight, along y")):
        s, v = run[f"mill.{part}.s"], run[f"mill.{part}.v"]
        axes[0].plot(DEGREES, s - s.mean(), label=label)
        axes[1].plot(DEGREES, v)
        axes[2].plot(DEGREES, run[f"mill.{part}.a"])
    axes[0].legend()
    _label_angle(axes[2])
    return figure


def draw_inertia_force() -> Figure:
    labels = ["along y, kN"] * 2 + ["amount, kN"] * 2
    figure, axes = panels(2, 2, size=(8, 8), y=labels, sharex=False)
    for column, name in enumerate("PF"):
        for design, line in LINES.items():
            force = stand.shaking_force(_turn(name, design)) / 1e3
            axes[0, column].plot(*force.T, line, label=f"{design} optimisation")
            axes[1, column].plot(DEGREES, np.hypot(*force.T), line)
        axes[0, column].set(title=f"Force on the foundation, set {name}", aspect="equal")
        axes[0, column].set_xlabel("along x, kN")
        axes[1, column].set(ylim=(0, None))
        _label_angle(axes[1, column])
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


CASES = (
    ("as printed", stand.AsPrinted, 0.0, ":"),
    ("exact", stand.Mill, 0.0, "-"),
    ("exact, with gravity", stand.Mill, 9.80665, "--"),
)


def draw_inertia_torque() -> Figure:
    torque = "torque, kN.m"
    figure, axes = panels(2, 2, size=(10, 7), y=(torque, "", torque), sharey="row")
    for row, name in enumerate("PF"):
        for axis, design in zip(axes[row], LINES, strict=True):
            for label, kind, g, line in CASES:
                run = _turn(name, design, kind, g, {"T_f": 0.0, "M0": 0.0})
                axis.plot(DEGREES, stand.crank_torque(run) / 1e3, line, label=label)
            axis.axhline(0, color="black", linewidth=0.8)
            axis.set(title=f"Inertia torque at the crank, set {name}, {design}")
    for axis in axes[1]:
        _label_angle(axis)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def draw_motor_torque() -> Figure:
    labels = [f"torque at the {shaft} shaft, kN.m" for shaft in ("crank", "motor")]
    figure, axes = panels(2, 2, size=(10, 7), y=labels + ["motor power, kW"] * 2)
    for column, name in enumerate("PF"):
        torque, power = axes[:, column]
        for color, (design, line) in zip(("C0", "C1"), LINES.items(), strict=True):
            for kind, width, label in (
                (stand.AsPrinted, 1.6, "as printed"),
                (stand.Mill, 0.7, "exact"),
            ):
                found = stand.crank_torque(_turn(name, design, kind), stand.IDLE) / 1e3
                style = {"linewidth": width, "label": f"{design}, {label}", "color": color}
                torque.plot(DEGREES, found / stand.RATIO[name], line, **style)
                power.plot(DEGREES, found * stand.SPEED[name], line, **style)
        torque.set_title(f"Set {name}")
        power.axhline(510, color="C3", linewidth=0.8, linestyle="-.", label="published, before")
        _label_angle(power)
        for axis in (torque, power):
            axis.axhline(0, color="black", linewidth=0.8)
    figure.legend(*axes[1, 0].get_legend_handles_labels(), loc="outside lower center", ncols=5)
    return figure


def draw_optimum() -> Figure:
    figure, axes = panels(2, size=(8, 8), sharex=False)
    for axis, name in zip(axes, "PF", strict=True):
        found = balance(name)
        front, goals = found.front(), found.goals()
        axis.plot(front[:, 2] / goals[0], front[:, 3] / goals[1], ".-", label="Pareto front")
        points = {design: np.array(list(u.values())) for design, u in stand.DESIGNS.items()}
        points |= {"best by the weights of the source": found.optimum()}
        for (label, u), mark in zip(points.items(), "so*", strict=True):
            goal = found.forces(u).max() / goals[0], found.fluctuation(u) / goals[1]
            text = f"{label}: $m_2$ = {u[0]:.0f} kg, $m_sR_s$ = {u[1]:.0f} kg m"
            if label == "before":
                text += f", beyond the right edge at {goal[0]:.3f}, {goal[1]:.4f}"
                axis.plot([], [], mark, markersize=9, label=text)
            else:
                axis.plot(*goal, mark, markersize=9, label=text)
        axis.set(title=f"Set {name}", xlabel="$F_1 / F_{10}$", ylabel="$F_2 / F_{20}$")
        axis.xaxis.set_major_formatter("{x:.3f}")
        axis.yaxis.set_major_formatter("{x:.4f}")
        axis.legend(loc="upper left", bbox_to_anchor=(0, -0.2))
    return figure


def draw_running() -> Figure:
    return _draw_run(running(until=3.75, grid=2000), "Steady running, set P")


def draw_start_up() -> Figure:
    return _draw_run(start_up(grid=2000), "Start from rest, set P")


def _draw_run(run: lp.Trajectory, title: str) -> Figure:
    labels = ("speed of the motor, rad/s", "motor torque, kN.m")
    figure, (speed, torque) = panels(2, size=(8, 6), title=title, x="time, s", y=labels)
    speed.plot(run.t, run["motor.w"])
    torque.plot(run.t, run["motor.tau"] / 1e3)
    torque.set(xlim=(0, run.t[-1]))
    return figure
