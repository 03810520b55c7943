"""Figures of the reversing cold rolling mill 400."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import lumped as lp
from lumped.models.panels import panels
from lumped.models.reversing_mill import drives, incoming, scenes
from lumped.models.reversing_mill import stand as mill
from lumped.models.reversing_mill.stand import RATED, SHAFT_LABELS, SHAFTS

SHARE, EQUALIZING = "torque / rated torque", "equalizing torque\n/ rated torque"


def draw_modes_upper() -> Any:
    return lp.modes(lp.assemble(mill.UpperBranch())).plot()


def draw_modes_lower() -> Any:
    return lp.modes(lp.assemble(mill.LowerBranch())).plot()


def draw_modes_closed() -> Any:
    return lp.modes(lp.assemble(mill.ClosedGap())).plot()


def _draw_torques(runs: Mapping[str, lp.Trajectory], height: float, until: float) -> Figure:
    """Shaft torques of some runs up to an instant in ms, one below the other, by their titles."""
    count = len(runs)
    figure, axes = panels(count, size=(8, height), x="time, ms", y=[SHARE] * count, sharey=True)
    for axis, (title, run) in zip(axes, runs.items(), strict=True):
        axis.plot(1e3 * run.t, run.table(SHAFTS) / RATED, label=SHAFT_LABELS)
        axis.axhline(0, color="black", linewidth=0.8)
        axis.set_title(title)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    axes[-1].set(xlim=(0, until))
    return figure


def draw_strip_entry() -> Figure:
    runs = {
        f"Strip entry, motors {what}": mill.strip_entry(mill.ClosedGap(), torque, grid=1000)
        for what, torque in (("unchanged", 0.0), ("stepping to rated torque", RATED))
    }
    return _draw_torques(runs, 6, 200)


def draw_eccentricity() -> Figure:
    title = "Eccentricity, order 1: torque on the joined rolls, or on each pair if open"
    labels = ("torque / exciting torque", "frequency, Hz")
    figure, (gains, orders) = panels(2, size=(8, 8), title=title, x="strip speed, m/s", y=labels)
    speeds = np.linspace(0.05, 22.5, 2000)
    cases = ((mill.ClosedGap(), 0.5, "-", "closed gap"), (mill.OpenGap(), 1.0, "--", "open gap"))
    for gap, torque, line, label in cases:
        torques = np.abs(mill.eccentricity_gains(gap, speeds, torque))
        for i, name in enumerate(SHAFT_LABELS):
            gains.semilogy(speeds, torques[:, i], line, color=f"C{i}", label=f"{name}, {label}")
        hertz = lp.modes(lp.assemble(gap)).hertz
        orders.hlines(hertz, 0, speeds[-1], linestyle=line, color="black", label=label)
        if label == "closed gap":
            critical = mill.critical_strip_speeds(gap)
            heights = np.broadcast_to(hertz[:, None], critical.shape)
            dots = orders.plot(critical, heights, "oC3", zorder=3)
            dots[0].set_label("critical, closed gap")
    for n in range(1, 5):
        orders.plot(speeds, n * mill.eccentricity_hertz(1) * speeds, color="C0", linewidth=1)
        speed = min(21.5, 43 / n / mill.eccentricity_hertz(1))
        orders.text(
            speed, n * mill.eccentricity_hertz(speed) + 1, f"order {n}", color="C0", ha="right"
        )
    gains.legend(fontsize="small", loc="lower right")
    orders.set(title="Critical speeds", xlim=(0, speeds[-1]), ylim=(0, 47))
    orders.legend(loc="lower right", fontsize="small")
    return figure


def draw_incoming() -> Figure:
    title = "Waves of the incoming strip, as long as a circumference of the backup rolls"
    labels = ("torque / exciting torque", SHARE)
    figure, (gain, torque) = panels(2, size=(8, 8), title=title, y=labels, sharex=False)
    speeds = np.linspace(0.05, 22.5, 2000)
    gaps = ((mill.ClosedGap(), "-", "no slip"), (mill.CreepingGap(), "--", "creeping"))
    for gap, line, label in gaps:
        gains = np.abs(incoming.thickness_gains(gap, speeds, 1.0))
        for i, name in enumerate(SHAFT_LABELS):
            gain.semilogy(speeds, gains[:, i], line, color=f"C{i}", label=f"{name}, {label}")
    gain.axvspan(10, 15, color="grey", alpha=0.2, label="speeds in print")
    gain.set(xlim=(0, speeds[-1]), xlabel="strip speed, m/s")
    gain.legend(fontsize="small")
    run = incoming.rolling_waves(15.0, until=1.0, grid=2000)
    torque.plot(run.t, run.table(SHAFTS) / RATED, linewidth=1.2)
    text = f"15 m/s, thickness +-{100 * incoming.THICKNESS:g} %, creeping"
    torque.set(xlim=(0, 1), xlabel="time, s", title=text)
    return figure


def draw_creep() -> Figure:
    system = lp.assemble(mill.CreepingGap())
    points = [
        (K_s, damping, hertz)
        for K_s in np.geomspace(1, 1e4, 400)
        for found in [lp.modes(system, parameters={"K_s": K_s * mill.KGF})]
        for damping, hertz in zip(found.damping, found.hertz, strict=True)
    ]
    creep, title = "creep coefficient $K_s$, kgf m s", "Damping by creep in the gap"
    figure, axis = panels(size=(8, 5), title=title, x=creep, y=["damping ratio"])
    axis.axvspan(210, 420, color="grey", alpha=0.2, label="plausible $K_s$ (assumed)")
    K_s, damping, hertz = np.transpose(points)
    dots = axis.scatter(K_s, damping, s=6, c=hertz, cmap="turbo")
    figure.colorbar(dots, label="natural frequency, Hz")
    axis.loglog()
    axis.set(xlim=(1, 1e4))
    axis.legend()
    return figure


def draw_skidding() -> Figure:
    run = scenes.skidding(grid=2000)
    title = "Skidding gap: motors at 1.6 and 0.4 rated torque for 120 ms"
    labels = (SHARE, EQUALIZING, "slip of the rolls, rad/s")
    figure, (shafts, gap, slip) = panels(3, size=(8, 8), title=title, x="time, ms", y=labels)
    t = 1e3 * run.t
    shafts.plot(t, run.table(SHAFTS) / RATED, label=SHAFT_LABELS)
    gap.plot(t, run["gap.tau"] / RATED, color="C3")
    for name, value in (("$M_s$", scenes.STATIC), ("$M_k$", scenes.KINETIC)):
        gap.axhline(value / RATED, color="grey", linestyle="--", linewidth=0.8)
        gap.text(396, value / RATED - 0.01, name, ha="right", va="top")
    slip.plot(t, run["gap.w_rel"], color="C4")
    slip.set(xlim=(0, 400))
    for axis in (shafts, gap, slip):
        lines = [axis.axvline(1e3 * t, color="black", linestyle=":") for t in scenes.SKIDS]
    lines[0].set_label("skids and sticks, by modal sums")
    slip.legend()
    figure.legend(*shafts.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def draw_strip_break() -> Figure:
    loose = f"motors at rated torque, spindles with {scenes.PLAY:g} rad of play"
    cases: dict[str, dict[str, Any]] = {
        "motors at rated torque": {},
        "motors at 1.1 and 0.9 rated torque": {"share": 0.1},
        loose: {"play": scenes.PLAY},
    }
    runs = {
        f"Strip break, {title}": scenes.strip_break(**case, grid=2000)
        for title, case in cases.items()
    }
    return _draw_torques(runs, 8, 220)


def draw_strip_entry_unequal_speeds() -> Figure:
    title, rolls = (
        "Strip enters at 20 ms, the upper branch 2 rad/s faster",
        "speed of the rolls, rad/s",
    )
    figure, axes = panels(3, size=(8, 8), title=title, y=(SHARE, rolls, rolls), sharex=False)
    torque, speeds, near = axes
    for stand, line in ((scenes.JoinedGap(), "-"), (scenes.StripGap(), ":")):
        run = scenes.entry_at_speed(stand, lead=2.0, grid=20_000)
        t = 1e3 * run.t
        for i, (shaft, name) in enumerate(zip(SHAFTS, SHAFT_LABELS, strict=True)):
            torque.plot(t, run[shaft] / RATED, line, color=f"C{i}", label=name)
        for i, side in enumerate(("upper", "lower"), 3):
            speeds.plot(t, run[f"{side}.rolls.w"], line, color=f"C{i}", label=f"{side} rolls")
            near.plot(t, run[f"{side}.rolls.w"], line, color=f"C{i}")
    torque.set(xlim=(0, 200))
    speeds.set(title="Solid: joined at once; dotted: joined by friction up to $M_s$", xlim=(0, 200))
    near.set(xlim=(19.5, 21.5), ylim=(-2.5, 2.5))
    for axis in axes:
        axis.set_xlabel("time, ms")
    shown = [axis.get_legend_handles_labels() for axis in (torque, speeds)]
    handles, labels = shown[0][0][:3] + shown[1][0][:2], shown[0][1][:3] + shown[1][1][:2]
    figure.legend(handles, labels, loc="outside lower center", ncols=5, fontsize="small")
    return figure


def draw_unequal_rolls() -> Figure:
    cases = (
        ("two PI controllers", scenes.unequal_rolls(scenes.ControlledStand(), 4.0, grid=4000)),
        ("with load-share trim", scenes.unequal_rolls(scenes.TrimmedStand(), 4.0, grid=4000)),
    )
    title = f"Diameters of the rolls differ by {100 * scenes.DIFFERENCE:g} %"
    labels = ("equalizing torque / rated torque", "slip of the rolls, rad/s")
    figure, (torque, slip) = panels(2, size=(8, 6), title=title, x="time, s", y=labels)
    for name, run in cases:
        torque.plot(run.t, run["gap.tau"] / RATED, linewidth=1, label=name)
        slip.plot(run.t, run["gap.w_rel"], linewidth=1, label=name)
    for i, s in enumerate((0.03, 0.01), 2):
        expected = scenes.DIFFERENCE / (2 * s)
        label = f"droop {100 * s:g} %: eps / (2 s)"
        torque.axhline(expected, color=f"C{i}", linestyle="--", label=label)
    slip.set(xlim=(0, 4))
    torque.legend(fontsize="small")
    return figure


def draw_motors() -> Figure:
    title = "Motors on converters: strip enters at 0.5 s between unequal rolls"
    motors = "motor torque / rated torque\nsolid upper, dotted lower"
    labels = (EQUALIZING, motors, "speed of the upper motor, rad/s")
    figure, (gap, torque, speed) = panels(3, size=(8, 8), title=title, x="time, s", y=labels)
    cases: tuple[tuple[str, drives.MotorStand | drives.SharingStand, float], ...] = (
        ("droop 3 %", drives.MotorStand(s=0.03), 1.03 * scenes.SPEED),
        ("without droop", drives.MotorStand(), scenes.SPEED),
        ("load-share trim", drives.SharingStand(), scenes.SPEED),
    )
    for i, (name, stand, idle) in enumerate(cases):
        run = drives.motors_at_entry(stand, idle, grid=4000)
        gap.plot(run.t, run["gap.tau"] / RATED, color=f"C{i}", linewidth=0.8, label=name)
        for side, line in (("upper", "-"), ("lower", ":")):
            style = {"color": f"C{i}", "linestyle": line, "linewidth": 1.2}
            torque.plot(run.t, run[f"{side}.motor.tau"] / RATED, **style)
        speed.plot(run.t, run["upper.motor.w"], color=f"C{i}", linewidth=1.2)
    speed.set(xlim=(0, 4))
    figure.legend(*gap.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure
