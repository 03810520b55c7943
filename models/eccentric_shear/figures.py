"""Figures of the eccentric shear."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lumped.models.eccentric_shear import scenes, stand
from lumped.models.panels import panels


def _label_crank(axis: Axes, degrees: int = 360) -> None:
    """Axis of the crank angle, with the changes of carriage."""
    axis.set(xlabel="crank angle, deg", xlim=(0, degrees), xticks=range(0, degrees + 1, 45))
    for begin in range(0, degrees, 360):
        for change in (stand.MEETS, 2 * np.pi - stand.MEETS):
            axis.axvline(np.degrees(change) + begin, color="black", linewidth=0.6)


def draw_inertia() -> Figure:
    title = "Inertia of shaft and supports, reduced to the crank"
    figure, axis = panels(title=title, y=["reduced inertia, t.m²"])
    lines = (
        (stand.PrintedShear, "-", "as printed"),
        (stand.GuidedShear, "--", "in the guides of the frame"),
    )
    for shear, line, label in lines:
        run = scenes.inertia(shear)
        reduced = (scenes.motions(run, shear) ** 2).sum(axis=1) / 1e3
        axis.plot(np.degrees(stand.SPEED * run.t), reduced, line, label=f"supports {label}")
    for angle, text in ((46, "upper support moves"), (180, "lower support moves")):
        axis.text(angle, 1.2, text, ha="center")
    axis.set(ylim=(0, None))
    axis.legend()
    _label_crank(axis)
    return figure


def draw_ellipses() -> Figure:
    title = "Elliptical gears, slowest crank in the middle of the cut"
    labels = ("motor speed / crank speed", "motor's inertia at the crank, t.m²")
    figure, (ratio, felt) = panels(2, size=(8, 6), title=title, y=labels)
    for e in (0.0, 0.2, 0.4, 0.5, 0.6):
        demand = scenes.turn(scenes.CrankTurned, e, grid=720)
        phi, u = np.degrees(demand.phi), demand.ratio
        ratio.plot(phi, u, label=f"e = {e:g}")
        felt.plot(phi, u**2 * stand.J_MOTOR / 1e3)
    for axis in (ratio, felt):
        axis.axvspan(
            *np.degrees([stand.CUT_BEGINS, stand.CUT_ENDS]), color="C7", alpha=0.2, label="cut"
        )
        _label_crank(axis)
    ratio.set(xlabel="")
    ratio.legend(fontsize="small")
    return figure


def draw_torque() -> Figure:
    figure, axes = panels(2, size=(8, 6), y=["torque / Mmax"] * 2)
    for axis, pulse in zip(axes, ("half-sine", "rectangle"), strict=True):
        for e in (0.0, 0.2, 0.4, 0.5, 0.6):
            demand = scenes.turn(scenes.CrankTurned, e, pulse)
            axis.plot(np.degrees(demand.phi), demand.tau / stand.GREATEST, label=f"e = {e:g}")
        axis.set(title=f"Motor torque at constant crank speed, {pulse}")
        axis.axhline(0, color="black", linewidth=0.8)
        _label_crank(axis)
    axes[0].set_xlabel("")
    axes[0].legend(fontsize="small")
    return figure


def draw_ratios() -> Figure:
    eccentricity, share = "eccentricity e of the ellipses", "torque / torque of circles"
    figure, grid = panels(2, 2, size=(8, 7), x=eccentricity, y=(share, "", share), sharey=True)
    ellipses = np.linspace(0, 0.6, 17)
    sizes = (("peak", 2.5, 3.0, "peak"), ("rms", 1.6, 1.7, "RMS"))
    for column, pulse in enumerate(("half-sine", "rectangle")):
        for speed, line, label in (
            (stand.SPEED, "-", "1: variable inertia"),
            (scenes.SLOW * stand.SPEED, "--", "2: constant inertia"),
        ):
            demands = [
                scenes.turn(scenes.CrankTurned, e, pulse, speed=speed, grid=500) for e in ellipses
            ]
            for axis, (name, *_) in zip(grid[:, column], sizes, strict=True):
                size = np.array([getattr(demand, name) for demand in demands])
                axis.plot(ellipses, size / size[0], line, label=label)
        for axis, (_, low, high, text) in zip(grid[:, column], sizes, strict=True):
            claim = f"published: 1/{high:g} to 1/{low:g}"
            axis.fill_between([0.4, 0.5], 1 / high, 1 / low, color="C2", alpha=0.4, label=claim)
            axis.set(title=f"{text} of the motor torque, {pulse}", xlim=(0, 0.6), ylim=(0.2, 1))
            axis.legend(fontsize="small")
    return figure


def draw_free_run() -> Figure:
    title = "Controlled motor, free speed; the carriage changes at the thin lines"
    labels = ("crank speed, rad/s", "motor speed, rad/s", "motor torque / Mmax")
    figure, axes = panels(3, size=(8, 8), title=title, y=labels)
    cases = (
        (0.0, stand.PrintedShear, "C0-", "e = 0"),
        (0.5, stand.PrintedShear, "C1-", "e = 0.5"),
        (0.5, stand.GuidedShear, "C3:", "e = 0.5, guided supports"),
    )
    for e, shear, line, label in cases:
        run = scenes.free_run(e, shear=shear, grid=2000)
        phi = np.degrees(run["loaded.shear.crank.phi"])
        signals = (
            run["loaded.shear.shaft.body.w"],
            run["motor.w"],
            run["motor.tau"] / stand.GREATEST,
        )
        for axis, signal in zip(axes, signals, strict=True):
            axis.plot(phi, signal, line, label=label)
    for axis in axes:
        for begin in (0, 360):
            cut = np.degrees([stand.CUT_BEGINS, stand.CUT_ENDS]) + begin
            axis.axvspan(*cut, color="C7", alpha=0.2, label="cut" if begin == 0 else None)
        _label_crank(axis, 720)
        axis.set(xlabel="", xticks=range(0, 721, 90))
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    axes[2].set_xlabel("crank angle, deg")
    return figure
