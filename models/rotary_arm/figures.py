"""Figures of the mandrel rotary arm."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import lumped as lp
from lumped.models.panels import panels
from lumped.models.rotary_arm import control, cycle, loads


def draw_cycle() -> Figure:
    full, printed = cycle.run_cycle(), cycle.run_cycle(printed=True)
    figure, (speed, torque) = panels(2, size=(8, 7), height_ratios=(1, 2))
    speed.plot(full.t, full["arm.trays.w"], color="C2")
    for name, angle in cycle.ADOPTED.points.items():
        t = np.interp(angle, full["arm.phi"], full.t)
        speed.axvline(t, color="grey", linewidth=0.5)
        speed.text(t, 1.08, name, ha="left" if name == "E" else "center")
    speed.set(ylabel="speed of the arm, rad/s", ylim=(0, 1.2))
    speed.set_title("One turn in 9 s by prescribed motion; mandrel on the arm from P to R")
    torque.plot(full.t, full[cycle.MOTOR] / 1e3, label="with rotor, loss, g = 9.80665 m/s2")
    torque.plot(printed.t, printed[cycle.REDUCER] / 1e3, "--", label="as the source reckons")
    for limit, name in ((loads.MAXIMUM, "greatest"), (loads.RATED, "rated")):
        torque.axhline(limit / 1e3, color="grey", linestyle=":")
        torque.text(8.95, limit / 1e3, f"{name}, 250 kW", ha="right", va="bottom")
    torque.set(xlabel="time, s", ylabel="motor torque, kN.m", xlim=(0, 9))
    torque.legend()
    return figure


def draw_control() -> Figure:
    run = control.run_controlled(grid=3000)
    figure, (speed, torque, error) = panels(3, size=(8, 8))
    speed.plot(run.t, run["wanted.y"], "--", label="wanted")
    speed.plot(run.t, run["arm.trays.w"], label="arm")
    speed.set_title("Square-root position control of one turn; mandrel on the arm from P to R")
    speed.set(ylabel="speed of the arm, rad/s", ylim=(-0.05, 1.25))
    speed.legend()
    torque.plot(run.t, run["motor.tau"] / 1e3, color="C3")
    torque.axhline(loads.MAXIMUM / 1e3, color="grey", linestyle=":")
    torque.text(10.9, loads.MAXIMUM / 1e3 - 0.3, "greatest, 250 kW", ha="right", va="top")
    torque.set_ylabel("motor torque, kN.m")
    error.semilogy(run.t, np.abs(control.AIM - run["arm.phi"]), color="C4")
    error.axhline(1e-3, color="grey", linestyle=":")
    error.set(ylabel="way to the aim, rad", xlabel="time, s", xlim=(0, 10.98))
    error.text(0.1, 1e-3, "1 mrad", va="bottom")
    for axis in (speed, torque, error):
        for t in control.instants(run)[:2]:
            axis.axvline(t, color="grey", linewidth=0.5)
    for t, name in zip(control.instants(run), ("P", "R"), strict=False):
        speed.text(t, 1.12, name, ha="center", va="bottom")
    return figure


def _show(axes: Sequence[Axes], run: lp.Trajectory, label: str) -> None:
    speed, angle, torque = axes
    speed.plot(run.t, run["arm.trays.w"], label=label)
    angle.plot(run.t, np.degrees(run["arm.phi"]))
    torque.plot(run.t, run["motor.tau"] / 1e3)


def _finish(figure: Figure, axes: Sequence[Axes], limit: float, until: float) -> Figure:
    speed, angle, torque = axes
    speed.set(ylabel="speed of the arm, rad/s")
    angle.axhline(np.degrees(cycle.ADOPTED.pick_up), color="grey", linestyle=":")
    angle.text(0.02 * until, np.degrees(cycle.ADOPTED.pick_up), "mandrel on the table", va="bottom")
    angle.set(ylabel="angle of the arm, deg")
    torque.axhline(limit / 1e3, color="grey", linestyle=":")
    torque.text(0.02 * until, limit / 1e3 - 0.1, "greatest", va="top")
    torque.set(ylabel="motor torque, kN.m", xlabel="time, s", xlim=(0, until))
    speed.legend()
    return figure


def draw_pick_up() -> Figure:
    figure, axes = panels(3, size=(8, 8))
    for bandwidth in (30.0, 20.0, 10.0):
        run = control.run_controlled(until=2.0, parameters={"bandwidth": bandwidth}, grid=2000)
        _show(axes, run, f"speed control of {bandwidth:g} rad/s")
    axes[1].set_ylim(-7, 5)
    axes[0].set_title("Pick-up: a slow speed control lets the mandrel back on the table")
    return _finish(figure, axes, loads.MAXIMUM, 2.0)


def draw_first_motor() -> Figure:
    figure, axes = panels(3, size=(8, 8))
    for eta in (0.86, 0.84, 0.83, 0.80):
        changed = {"motor.tau_max": loads.OVERLOAD * loads.FIRST, "reducer.eta": eta}
        run = control.run_controlled(until=3.0, parameters=changed, grid=2000)
        _show(axes, run, f"efficiency {eta:g}")
    axes[0].set(ylim=(0, 0.2), title="First motor: below 0.832 the loaded arm stalls")
    axes[1].set_ylim(-7, 7)
    return _finish(figure, axes, loads.OVERLOAD * loads.FIRST, 3.0)
