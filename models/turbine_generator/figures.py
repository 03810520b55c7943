"""Figures of the turbine generator."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

import lumped as lp
from lumped.models.panels import panels
from lumped.models.turbine_generator import drive, scenes

SHAFT = drive.SHAFTS["LPB-GEN"]
BODIES = {
    "HP": "turbine.hp",
    "IP": "turbine.ip",
    "LPA": "turbine.lpa",
    "LPB": "turbine.lpb",
    "GEN": "gen",
    "EXC": "turbine.exciter",
}


def draw_shapes() -> Figure:
    table = lp.vibration.mass_elastic(lp.modes(lp.assemble(drive.Train())), shaft="gen.phi")
    figure, axes = panels(len(table.hertz), size=(8, 7), sharey=True)
    for mode, axis in enumerate(axes):
        holzer = table.holzer(mode)
        angles = np.array([holzer.angle(name) for name in BODIES.values()])
        axis.plot(angles / np.abs(angles).max(), "o-")
        axis.axhline(0, color="black", linewidth=0.6)
        axis.set(ylim=(-1.15, 1.15), ylabel=f"{table.hertz[mode]:.2f} Hz")
    axes[-1].set_xticks(range(len(BODIES)), list(BODIES))
    return figure


def draw_fault() -> Figure:
    labels = ("air gap, rated torques", "LPB-GEN, rated torques")
    figure, (top, bottom) = panels(2, size=(8, 5.5), x="time from the fault, ms", y=labels)
    for phases, text in (("abc", "three phases"), ("bc", "line to line")):
        run = scenes.run_short_circuit(0.32, phases, grid=6000)
        time = 1e3 * (run.t - drive.BEGIN)
        top.plot(time, scenes.per_unit(run, "gen.tau"), linewidth=1, label=text)
        bottom.plot(time, scenes.per_unit(run, SHAFT), linewidth=1, label=text)
    top.set(xlim=(-20, 300))
    top.legend(loc="upper right")
    return figure


def draw_cleared() -> Figure:
    durations = np.arange(0.03, 0.2001, 0.0005)
    found = scenes.clear_faults(durations)
    figure, axis = panels(x="duration of the fault, ms", y=["largest torque, rated torques"])
    for text in drive.SHAFTS:
        axis.plot(1e3 * durations, found[text] / drive.BASE.tau, label=text)
    axis.set(xlim=(30, 200), ylim=(0, None))
    axis.legend(ncols=5, loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False)
    return figure


def draw_reclosed() -> Figure:
    run = scenes.run_reclosing(grid=8000)
    figure, axis = panels(x="time, s", y=["torque, rated torques"])
    axis.plot(run.t, scenes.per_unit(run, "gen.tau"), linewidth=0.8, label="air gap")
    axis.plot(run.t, scenes.per_unit(run, SHAFT), linewidth=1.2, label="LPB-GEN")
    instants = {
        "fault": drive.BEGIN,
        "cleared": drive.CLEARED,
        "opened": drive.OPENS,
        "closed": drive.CLOSES,
    }
    for text, time in instants.items():
        axis.axvline(time, color="black", linewidth=0.6)
        axis.annotate(text, (time, 0.97), xycoords=("data", "axes fraction"), rotation=90,
                      ha="right", va="top")  # fmt: skip
    axis.set(xlim=(0, 0.6))
    axis.legend(loc="lower right")
    return figure


def draw_resonance() -> Figure:
    reactances = np.linspace(0.05, 0.6, 551)
    figure, axis = panels(x="reactance of the series capacitor, pu", y=["growth, 1/s"])
    for mode, growth in enumerate(scenes.find_growth(reactances).T[:4], 1):
        axis.plot(reactances, growth, label=f"mode {mode}")
    axis.set(xlim=(0.05, 0.6), ylim=(-1, 5))
    axis.legend(loc="upper left")
    return figure
