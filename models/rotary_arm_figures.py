"""Figures of the mandrel rotary arm."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import lumped as lp
from lumped.models.rotary_arm_control import AIM, controlled
from lumped.models.rotary_arm_cycle import ADOPTED, motor_torque, run_cycle
from lumped.models.rotary_arm_loads import FIRST, MAXIMUM, OVERLOAD, RATED

__all__ = ["figures"]


def figures() -> dict[str, Figure]:
    """Figures by name."""
    return {
        "cycle": _draw_cycle(),
        "control": _draw_control(),
        "pick_up": _draw_pick_up(),
        "first_motor": _draw_first_motor(),
    }


def _draw_cycle() -> Figure:
    full, printed = run_cycle(), run_cycle(printed=True)
    figure = Figure((8, 7), layout="constrained")
    speed, torque = figure.subplots(2, sharex=True, height_ratios=(1, 2))
    speed.plot(full.t, full["arm.trays.w"], color="C2")
    for name, angle in ADOPTED.points.items():
        t = np.interp(angle, full["arm.phi"], full.t)
        speed.axvline(t, color="grey", linewidth=0.5)
        speed.text(t, 1.08, name, ha="left" if name == "E" else "center")
    speed.set(ylabel="speed of the arm, rad/s", ylim=(0, 1.2))
    speed.set_title("One turn in 9 s by prescribed motion; mandrel on the arm from P to R")
    torque.plot(full.t, motor_torque(full) / 1e3, label="with rotor, loss, g = 9.80665 m/s2")
    without = motor_torque(printed, rotor=False)
    torque.plot(printed.t, without / 1e3, "--", label="as the source reckons")
    for limit, name in ((MAXIMUM, "greatest"), (RATED, "rated")):
        torque.axhline(limit / 1e3, color="grey", linestyle=":")
        torque.text(9, limit / 1e3, f"{name}, 250 kW", ha="right", va="bottom")
    torque.set(xlabel="time, s", ylabel="motor torque, kN.m", xlim=(0, 9))
    torque.legend()
    for axis in (speed, torque):
        axis.grid(alpha=0.3)
    return figure


def _draw_control() -> Figure:
    run = controlled(grid=3000)
    figure = Figure((8, 8), layout="constrained")
    speed, torque, error = figure.subplots(3, sharex=True)
    speed.plot(run.t, run["wanted.y"], "--", label="wanted")
    speed.plot(run.t, run["arm.trays.w"], label="arm")
    speed.set(title="Square-root position control of one turn", ylabel="speed, rad/s")
    speed.legend()
    torque.plot(run.t, run["motor.tau"] / 1e3, color="C3")
    torque.axhline(MAXIMUM / 1e3, color="grey", linestyle=":")
    torque.text(10.9, MAXIMUM / 1e3 - 0.3, "greatest", ha="right", va="top")
    torque.set_ylabel("motor torque, kN.m")
    error.semilogy(run.t, np.abs(AIM - run["arm.phi"]), color="C4")
    error.axhline(1e-3, color="grey", linestyle=":")
    error.set(ylabel="way to the aim, rad", xlabel="time, s", xlim=(0, 10.98))
    for axis in (speed, torque, error):
        axis.grid(alpha=0.3)
    return figure


def _shown(axes: tuple[Axes, Axes], run: lp.Trajectory, label: str) -> None:
    speed, angle = axes
    speed.plot(run.t, run["arm.trays.w"], label=label)
    angle.plot(run.t, np.degrees(run["arm.phi"]), label=label)


def _finished(figure: Figure, axes: tuple[Axes, Axes], title: str, until: float) -> Figure:
    speed, angle = axes
    speed.set(title=title, ylabel="speed of the arm, rad/s")
    angle.axhline(np.degrees(ADOPTED.pick_up), color="grey", linestyle=":")
    angle.text(until, np.degrees(ADOPTED.pick_up), "table", ha="right", va="bottom")
    angle.set(ylabel="angle of the arm, deg", xlabel="time, s", xlim=(0, until))
    speed.legend()
    for axis in axes:
        axis.grid(alpha=0.3)
    return figure


def _draw_pick_up() -> Figure:
    figure = Figure((8, 6), layout="constrained")
    axes = tuple(figure.subplots(2, sharex=True))
    for bandwidth in (30.0, 20.0, 10.0):
        run = controlled(until=2.0, parameters={"bandwidth": bandwidth}, grid=2000)
        _shown(axes, run, f"speed control of {bandwidth:g} rad/s")
    axes[1].set_ylim(-7, 5)
    title = "Pick-up: a slow speed control lets the mandrel back on the table"
    return _finished(figure, axes, title, 2.0)


def _draw_first_motor() -> Figure:
    figure = Figure((8, 6), layout="constrained")
    axes = tuple(figure.subplots(2, sharex=True))
    for eta in (0.86, 0.84, 0.83, 0.80):
        changed = {"motor.tau_max": OVERLOAD * FIRST, "reducer.eta": eta}
        run = controlled(until=3.0, parameters=changed, grid=2000)
        _shown(axes, run, f"efficiency {eta:g}")
    axes[0].set_ylim(0, 0.2)
    axes[1].set_ylim(-7, 7)
    return _finished(figure, axes, "First motor: below 0.832 the loaded arm stalls", 3.0)
