"""Figures of the eccentric shear."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from lumped.models.eccentric_shear_scenes import SLOW, CrankTurned, free_run, turn
from lumped.models.eccentric_shear_stand import (
    CUT_BEGINS,
    CUT_ENDS,
    GREATEST,
    MEETS,
    SPEED,
    GuidedShear,
    PrintedShear,
)

__all__ = ["figures"]


def figures() -> dict[str, Figure]:
    """Figures by name."""
    return {"torque": _draw_torque(), "reduction": _draw_reduction(), "free_run": _draw_free()}


def _draw_torque() -> Figure:
    figure = Figure((8, 6), layout="constrained")
    axes = figure.subplots(2, sharex=True)
    for axis, pulse in zip(axes, ("half-sine", "rectangle"), strict=True):
        for e in (0.0, 0.2, 0.4, 0.5, 0.6):
            demand = turn(CrankTurned, e, pulse, grid=2000)
            axis.plot(np.degrees(demand.phi), demand.tau / GREATEST, label=f"e = {e:g}")
        axis.set(title=f"Motor torque at constant crank speed, {pulse}", ylabel="torque / Mmax")
        axis.axhline(0, color="black", linewidth=0.8)
        axis.grid(alpha=0.3)
    axes[0].legend(fontsize="small")
    axes[1].set(xlabel="crank angle, deg", xlim=(0, 360), xticks=range(0, 361, 45))
    return figure


def _draw_reduction() -> Figure:
    figure = Figure((8, 4), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    ellipses = np.linspace(0, 0.6, 13)
    for axis, pulse in zip(axes, ("half-sine", "rectangle"), strict=True):
        for speed, line, label in ((SPEED, "-", "with inertia"), (SLOW * SPEED, "--", "without")):
            demands = [turn(CrankTurned, e, pulse, speed=speed, grid=1000) for e in ellipses]
            for color, name in (("C0", "peak"), ("C1", "rms")):
                sizes = np.array([getattr(demand, name) for demand in demands])
                axis.plot(ellipses, sizes[0] / sizes, line, color=color, label=f"{name}, {label}")
        axis.set(title=pulse, xlabel="eccentricity of the ellipses")
        axis.grid(alpha=0.3)
    for names, low, high in (("C0", 2.5, 3.0), ("C1", 1.6, 1.7)):
        for axis in axes:
            axis.fill_between([0.4, 0.5], low, high, color=names, alpha=0.25)
    axes[0].set_ylabel("reduction of the motor torque (boxes: published)")
    axes[0].legend(fontsize="small")
    return figure


def _draw_free() -> Figure:
    figure = Figure((8, 8), layout="constrained")
    axes = figure.subplots(3, sharex=True)
    cases = (
        (0.0, PrintedShear, "C0-", "e = 0"),
        (0.5, PrintedShear, "C1-", "e = 0.5"),
        (0.5, GuidedShear, "C3:", "e = 0.5, guided supports"),
    )
    for e, shear, line, label in cases:
        run = free_run(e, shear=shear, grid=4000)
        phi = np.degrees(run["loaded.shear.crank.phi"])
        signals = (run["loaded.shear.shaft.body.w"], run["motor.w"], run["motor.tau"] / GREATEST)
        for axis, signal in zip(axes, signals, strict=True):
            axis.plot(phi, signal, line, label=label)
    titles = ("crank speed, rad/s", "motor speed, rad/s", "motor torque / Mmax")
    for axis, title in zip(axes, titles, strict=True):
        axis.set_ylabel(title)
        axis.grid(alpha=0.3)
        for turn_begin in (0, 360):
            cut = np.degrees([CUT_BEGINS, CUT_ENDS]) + turn_begin
            axis.axvspan(*cut, color="C7", alpha=0.2, label="cut" if turn_begin == 0 else None)
            for change in (MEETS, 2 * np.pi - MEETS):
                axis.axvline(np.degrees(change) + turn_begin, color="black", linewidth=0.6)
    axes[0].set_title("Controlled motor, free speed; the carriage changes at the thin lines")
    axes[0].legend(fontsize="small")
    axes[2].set(xlabel="crank angle, deg", xlim=(0, 720), xticks=range(0, 721, 90))
    return figure
