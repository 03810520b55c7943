"""Figures of the mandrel rotary arm."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lumped.models.panels import panels
from lumped.models.rotary_arm import control, cycle, loads, steps


def draw_cycle() -> Figure:
    full, printed = cycle.run_cycle(), cycle.run_cycle(printed=True)
    title = "One turn in 9 s by prescribed motion; mandrel on the arm from P to R"
    labels = ("speed of the arm, rad/s", "motor torque, kN.m")
    figure, (speed, torque) = panels(
        2, size=(8, 7), title=title, x="time, s", y=labels, height_ratios=(1, 2)
    )
    speed.plot(full.t, full["arm.trays.w"], color="C2")
    for name, angle in cycle.ADOPTED.points.items():
        t = np.interp(angle, full["arm.phi"], full.t)
        speed.axvline(t, color="grey", linewidth=0.5)
        speed.text(t, 1.08, name, ha="left" if name == "E" else "center")
    speed.set(ylim=(0, 1.2))
    torque.plot(full.t, full[cycle.MOTOR] / 1e3, label="with rotor, loss, g = 9.80665 m/s2")
    torque.plot(printed.t, printed[cycle.REDUCER] / 1e3, "--", label="as the source reckons")
    for limit, name in ((loads.MAXIMUM, "greatest"), (loads.RATED, "rated")):
        torque.axhline(limit / 1e3, color="grey", linestyle=":")
        torque.text(8.95, limit / 1e3, f"{name}, 250 kW", ha="right", va="bottom")
    torque.set(xlim=(0, 9))
    torque.legend()
    return figure


def draw_control() -> Figure:
    run = control.run_controlled(grid=3000)
    title = "Square-root position control of one turn; mandrel on the arm from P to R"
    labels = ("speed of the arm, rad/s", "motor torque, kN.m", "way to the aim, rad")
    figure, (speed, torque, error) = panels(3, size=(8, 8), title=title, x="time, s", y=labels)
    speed.plot(run.t, run["wanted.y"], "--", label="wanted")
    speed.plot(run.t, run["arm.trays.w"], label="arm")
    speed.set(ylim=(-0.05, 1.25))
    speed.legend()
    torque.plot(run.t, run["motor.tau"] / 1e3, color="C3")
    torque.axhline(loads.MAXIMUM / 1e3, color="grey", linestyle=":")
    torque.text(10.9, loads.MAXIMUM / 1e3 - 0.3, "greatest, 250 kW", ha="right", va="top")
    error.semilogy(run.t, np.abs(control.AIM - run["arm.phi"]), color="C4")
    error.axhline(1e-3, color="grey", linestyle=":")
    error.set(xlim=(0, 10.98))
    error.text(0.1, 1e-3, "1 mrad", va="bottom")
    for axis in (speed, torque, error):
        for t in control.instants(run)[:2]:
            axis.axvline(t, color="grey", linewidth=0.5)
    for t, name in zip(control.instants(run), ("P", "R"), strict=False):
        speed.text(t, 1.12, name, ha="center", va="bottom")
    return figure


def _draw_lifts(
    title: str, cases: Mapping[str, Mapping[str, float]], until: float, limit: float
) -> tuple[Figure, Any]:
    """Speed, angle and torque of runs with changed parameters, by their labels."""
    labels = ("speed of the arm, rad/s", "angle of the arm, deg", "motor torque, kN.m")
    figure, axes = panels(3, size=(8, 8), title=title, x="time, s", y=labels)
    speed, angle, torque = axes
    for label, parameters in cases.items():
        run = control.run_controlled(until=until, parameters=parameters, grid=2000)
        speed.plot(run.t, run["arm.trays.w"], label=label)
        angle.plot(run.t, np.degrees(run["arm.phi"]))
        torque.plot(run.t, run["motor.tau"] / 1e3)
    table = np.degrees(cycle.ADOPTED.pick_up)
    angle.axhline(table, color="grey", linestyle=":")
    angle.text(0.02 * until, table, "mandrel on the table", va="bottom")
    torque.axhline(limit / 1e3, color="grey", linestyle=":")
    torque.text(0.02 * until, limit / 1e3 - 0.1, "greatest", va="top")
    torque.set(xlim=(0, until))
    speed.legend()
    return figure, axes


def draw_pick_up() -> Figure:
    title = "Pick-up: a slow speed control lets the mandrel back on the table"
    cases = {f"speed control of {x:g} rad/s": {"bandwidth": x} for x in (30.0, 20.0, 10.0)}
    figure, axes = _draw_lifts(title, cases, 2.0, loads.MAXIMUM)
    axes[1].set_ylim(-7, 5)
    return figure


def draw_first_motor() -> Figure:
    greatest = loads.OVERLOAD * loads.FIRST
    cases = {
        f"efficiency {eta:g}": {"motor.tau_max": greatest, "reducer.eta": eta}
        for eta in (0.86, 0.84, 0.83, 0.80)
    }
    title = "First motor: below 0.832 the loaded arm stalls"
    figure, axes = _draw_lifts(title, cases, 3.0, greatest)
    axes[0].set(ylim=(0, 0.2))
    axes[1].set_ylim(-7, 7)
    return figure


def draw_steps() -> Figure:
    title = "Cycle by twelve steps; solid: nothing in the way, dashed: it waits at C until 6 s"
    labels = ("speed of the arm, rad/s", "angle of the arm, deg", "motor torque, kN.m")
    figure, (speed, angle, torque) = panels(3, size=(8, 9), title=title, x="time, s", y=labels)
    for i, (free, line) in enumerate(((0.0, "-"), (6.0, "--"))):
        run = steps.run_steps(free, until=13.0, grid=3000)
        speed.plot(run.t, run["arm.trays.w"], line, color=f"C{i}")
        angle.plot(run.t, np.degrees(run["arm.phi"]), line, color=f"C{i}")
        torque.plot(run.t, run["motor.tau"] / 1e3, line, color=f"C{i}")
    for x, name, zone in ((0.1, "line", "PB"), (0.4, "rack", "DG"), (0.9, "kick-out arm", "DH")):
        ends = np.degrees([steps.AT[end] for end in zone])
        angle.plot([x, x], ends, linewidth=4, alpha=0.5, label=f"way of the {name}")
    for name in "ACEFI":
        angle.axhline(np.degrees(steps.AT[name]), color="grey", linewidth=0.3)
        angle.text(13.05, np.degrees(steps.AT[name]), name, fontsize="small", va="center")
    angle.legend(loc="lower right", fontsize="small")
    torque.set(xlim=(0, 13))
    return figure


def draw_chatter() -> Figure:
    title = "Square root with its linear zone, and nearly without: no friction, no loss"
    labels = ("way to the aim, rad", "speed of the arm, rad/s")
    figure, (way, speed) = panels(2, size=(8, 6), title=title, x="time, s", y=labels)
    for K, label in ((6.0, "K = 6 1/s"), (1000.0, "K = 1000 1/s")):
        free = {"arm.mu": 0.0, "reducer.eta": 1.0, "aim.K": K}
        run = control.run_controlled(until=12.0, parameters=free, grid=6000)
        way.plot(run.t, control.AIM - run["arm.phi"], label=label)
        speed.plot(run.t, run["arm.trays.w"])
    way.set(xlim=(9, 12), ylim=(-0.02, 0.1))
    speed.set(ylim=(-0.05, 0.1))
    way.legend()
    return figure
