"""Figures of the diesel engine and its generator."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

import lumped as lp
from lumped.models.diesel_genset import OUTER, PUBLISHED, scenes
from lumped.models.diesel_genset.drive import RPM, SHAFTS, Genset
from lumped.models.panels import panels

_LARGEST = 6


def draw_shapes() -> Any:
    table = lp.vibration.mass_elastic(scenes.mean_modes(), shaft="flywheel.phi")
    return table.holzer(0).plot()


def draw_phases() -> Any:
    return scenes.vector_sums().plot()


def draw_orders() -> Figure:
    fired = scenes.solve_crankshaft()
    figure, axis = panels(x="speed, 1/min", y=["vibratory torque of shaft 8, kN.m"])
    sizes = {float(order): fired.magnitude(OUTER[8], float(order)) for order in fired.orders}
    largest = sorted(sizes, key=lambda order: -sizes[order].max())[:_LARGEST]
    for order in sorted(largest):
        axis.plot(fired.rpm, sizes[order] / 1e3, label=f"order {order:g}")
    axis.set(xlim=(scenes.SPEEDS[0], scenes.SPEEDS[-1]), ylim=(0, None))
    axis.legend()
    return figure


def draw_synthesis() -> Figure:
    fired = scenes.solve_crankshaft()
    labels = [f"shaft {number}, kN.m" for number in OUTER]
    figure, axes = panels(2, size=(8, 6), x="speed, 1/min", y=labels)
    for axis, (number, name) in zip(axes, OUTER.items(), strict=True):
        both = fired.synthesis(name)
        axis.plot(fired.rpm, both.sum / 1e3, label="sum of the amplitudes")
        axis.plot(fired.rpm, both.maximum / 1e3, label="largest over a cycle")
        torque, rpm = PUBLISHED[number]
        axis.plot(rpm, torque / 1e3, "o", color="black", label="peak of the sum, published")
        axis.set(ylim=(0, None))
    axis.set(xlim=(scenes.SPEEDS[0], scenes.SPEEDS[-1]))
    axes[0].legend()
    return figure


def draw_misfire() -> Figure:
    labels = ("shaft 8, kN.m", "coupling, kN.m")
    figure, (above, below) = panels(2, size=(8, 6), x="speed, 1/min", y=labels, sharex=False)
    for case in scenes.CASES:
        shaft = scenes.solve_crankshaft(case).synthesis(OUTER[8]).maximum
        coupling = scenes.solve_coupling(case).synthesis("coupling.tau").maximum
        above.plot(scenes.SPEEDS, shaft / 1e3, label=case)
        below.plot(scenes.SLOW, coupling / 1e3)
    above.set(xlim=(scenes.SPEEDS[0], scenes.SPEEDS[-1]), ylim=(0, None))
    below.set(xlim=(scenes.SLOW[0], scenes.SLOW[-1]), ylim=(0, None))
    above.legend()
    return figure


def draw_damper() -> Figure:
    fired = scenes.solve_crankshaft()
    damped = scenes.response(model=Genset())
    figure, axis = panels(x="number of the shaft", y=["largest vibratory torque, kN.m"])
    for label, found in (("crankshaft", fired), ("with damper and generator", damped)):
        sizes = [found.synthesis(name).maximum.max() / 1e3 for name in SHAFTS]
        axis.plot(range(1, len(SHAFTS) + 1), sizes, "o-", label=label)
    axis.set(ylim=(0, None))
    axis.legend()
    return figure


def draw_start() -> Figure:
    run = scenes.run_up(grid=4000)
    labels = ("speed, 1/min", "torque of the coupling, kN.m")
    figure, (above, below) = panels(2, size=(8, 5), x="time, s", y=labels)
    above.plot(run.t, run["flywheel.w"] / RPM, label="flywheel")
    above.plot(run.t, run["generator.w"] / RPM, label="generator")
    above.set(ylim=(0, None))
    above.legend()
    below.plot(run.t, -run["coupling.tau"] / 1e3, linewidth=1)
    below.set(xlim=(0, run.t[-1]))
    return figure
