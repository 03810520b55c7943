"""Figures of the turbine generator."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

import lumped as lp
from lumped.models.turbine_generator.drive import (
    BASE,
    BEGIN,
    CLEARED,
    CLOSES,
    OPENS,
    SHAFTS,
    Train,
)
from lumped.models.turbine_generator.scenes import cleared, faulted, per_unit, reclosed

__all__ = ["figures"]

SHAFT = SHAFTS["LPB-GEN"]
BODIES = {
    "HP": "turbine.hp",
    "IP": "turbine.ip",
    "LPA": "turbine.lpa",
    "LPB": "turbine.lpb",
    "GEN": "gen",
    "EXC": "turbine.exciter",
}


def figures() -> dict[str, Figure]:
    """Figures by name."""
    return {
        "shapes": _draw_shapes(),
        "fault": _draw_fault(),
        "cleared": _draw_cleared(),
        "reclosed": _draw_reclosed(),
    }


def _draw_shapes() -> Figure:
    table = lp.vibration.mass_elastic(lp.modes(lp.assemble(Train())), over="gen.phi")
    figure = Figure((8, 7), layout="constrained")
    axes = figure.subplots(len(table.hertz), 1, sharex=True, sharey=True)
    for mode, axis in enumerate(axes):
        holzer = table.holzer(mode)
        angles = np.array([holzer.angle(name) for name in BODIES.values()])
        axis.plot(angles / np.abs(angles).max(), "o-")
        axis.axhline(0, color="black", linewidth=0.6)
        axis.set(ylim=(-1.15, 1.15), ylabel=f"{table.hertz[mode]:.2f} Hz")
        axis.grid(alpha=0.3)
    axes[-1].set_xticks(range(len(BODIES)), list(BODIES))
    return figure


def _draw_fault() -> Figure:
    figure = Figure((8, 5.5), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True)
    for phases, text in (("abc", "three phases"), ("bc", "line to line")):
        run = faulted(0.32, phases, grid=6000)
        time = 1e3 * (run.t - BEGIN)
        top.plot(time, per_unit(run, "gen.tau"), linewidth=1, label=text)
        bottom.plot(time, per_unit(run, SHAFT), linewidth=1, label=text)
    top.set(ylabel="air gap, rated torques", xlim=(-20, 300))
    bottom.set(ylabel="LPB-GEN, rated torques", xlabel="time from the fault, ms")
    for axis in (top, bottom):
        axis.grid(alpha=0.3)
    top.legend(loc="upper right")
    return figure


def _draw_cleared() -> Figure:
    durations = np.arange(0.03, 0.2001, 0.0005)
    found = cleared(durations)
    figure = Figure((8, 4), layout="constrained")
    axis = figure.subplots()
    for text in SHAFTS:
        axis.plot(1e3 * durations, found[text] / BASE.tau, label=text)
    axis.set(xlabel="duration of the fault, ms", ylabel="largest torque, rated torques")
    axis.set(xlim=(30, 200), ylim=(0, None))
    axis.grid(alpha=0.3)
    axis.legend(ncols=5, loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
    return figure


def _draw_reclosed() -> Figure:
    run = reclosed(grid=8000)
    figure = Figure((8, 4), layout="constrained")
    axis = figure.subplots()
    axis.plot(run.t, per_unit(run, "gen.tau"), linewidth=0.8, label="air gap")
    axis.plot(run.t, per_unit(run, SHAFT), linewidth=1.2, label="LPB-GEN")
    instants = {"fault": BEGIN, "cleared": CLEARED, "opened": OPENS, "closed": CLOSES}
    for text, time in instants.items():
        axis.axvline(time, color="black", linewidth=0.6)
        axis.annotate(text, (time, 0.97), xycoords=("data", "axes fraction"), rotation=90,
                      ha="right", va="top")  # fmt: skip
    axis.set(xlabel="time, s", ylabel="torque, rated torques", xlim=(0, 0.6))
    axis.grid(alpha=0.3)
    axis.legend(loc="lower right")
    return figure
