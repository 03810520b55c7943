"""Figures of the diesel engine and its generator."""

from __future__ import annotations

from matplotlib.figure import Figure

import lumped as lp
from lumped.models.diesel_genset import OUTER, PUBLISHED
from lumped.models.diesel_genset.drive import RPM, SHAFTS, Genset
from lumped.models.diesel_genset.scenes import (
    CASES,
    SLOW,
    SPEEDS,
    coupled,
    mean_modes,
    published,
    response,
    run_up,
    vector_sums,
)

__all__ = ["figures"]

_LARGEST = 6


def figures() -> dict[str, Figure]:
    """Figures by name."""
    table = lp.vibration.mass_elastic(mean_modes(), over="flywheel.phi")
    fired = published()
    return {
        "shapes": table.holzer(0).plot(),
        "phases": vector_sums().plot(),
        "orders": _draw_orders(fired),
        "synthesis": _draw_synthesis(fired),
        "misfire": _draw_misfire(),
        "damper": _draw_damper(fired),
        "start": _draw_start(),
    }


def _draw_orders(fired: lp.vibration.OrderResponse) -> Figure:
    figure = Figure((8, 4), layout="constrained")
    axis = figure.subplots()
    sizes = {float(order): fired.magnitude(OUTER[8], float(order)) for order in fired.orders}
    largest = sorted(sizes, key=lambda order: -sizes[order].max())[:_LARGEST]
    for order in sorted(largest):
        axis.plot(fired.rpm, sizes[order] / 1e3, label=f"order {order:g}")
    axis.set(xlabel="speed, 1/min", ylabel="vibratory torque of shaft 8, kN.m")
    axis.set(xlim=(SPEEDS[0], SPEEDS[-1]), ylim=(0, None))
    axis.grid(alpha=0.3)
    axis.legend()
    return figure


def _draw_synthesis(fired: lp.vibration.OrderResponse) -> Figure:
    figure = Figure((8, 6), layout="constrained")
    for axis, (number, name) in zip(figure.subplots(2, 1, sharex=True), OUTER.items(), strict=True):
        both = fired.synthesis(name)
        axis.plot(fired.rpm, both.sum / 1e3, label="sum of the amplitudes")
        axis.plot(fired.rpm, both.maximum / 1e3, label="largest over a cycle")
        torque, rpm = PUBLISHED[number]
        axis.plot(rpm, torque / 1e3, "o", color="black", label="peak of the sum, published")
        axis.set(ylabel=f"shaft {number}, kN.m", ylim=(0, None))
        axis.grid(alpha=0.3)
    axis.set(xlabel="speed, 1/min", xlim=(SPEEDS[0], SPEEDS[-1]))
    figure.axes[0].legend()
    return figure


def _draw_misfire() -> Figure:
    figure = Figure((8, 6), layout="constrained")
    above, below = figure.subplots(2, 1)
    for case in CASES:
        above.plot(SPEEDS, published(case).synthesis(OUTER[8]).maximum / 1e3, label=case)
        below.plot(SLOW, coupled(case).synthesis("coupling.tau").maximum / 1e3)
    above.set(ylabel="shaft 8, kN.m", xlim=(SPEEDS[0], SPEEDS[-1]), ylim=(0, None))
    below.set(
        ylabel="coupling, kN.m", xlabel="speed, 1/min", xlim=(SLOW[0], SLOW[-1]), ylim=(0, None)
    )
    for axis in (above, below):
        axis.grid(alpha=0.3)
    above.legend()
    return figure


def _draw_damper(fired: lp.vibration.OrderResponse) -> Figure:
    damped = response(model=Genset())
    figure = Figure((8, 4), layout="constrained")
    axis = figure.subplots()
    for label, found in (("crankshaft", fired), ("with damper and generator", damped)):
        sizes = [found.synthesis(name).maximum.max() / 1e3 for name in SHAFTS]
        axis.plot(range(1, len(SHAFTS) + 1), sizes, "o-", label=label)
    axis.set(xlabel="number of the shaft", ylabel="largest vibratory torque, kN.m", ylim=(0, None))
    axis.grid(alpha=0.3)
    axis.legend()
    return figure


def _draw_start() -> Figure:
    run = run_up(grid=4000)
    figure = Figure((8, 5), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    above.plot(run.t, run["flywheel.w"] / RPM, label="flywheel")
    above.plot(run.t, run["generator.w"] / RPM, label="generator")
    above.set(ylabel="speed, 1/min", ylim=(0, None))
    above.legend()
    below.plot(run.t, -run["coupling.tau"] / 1e3, linewidth=1)
    below.set(xlabel="time, s", ylabel="torque of the coupling, kN.m", xlim=(0, run.t[-1]))
    for axis in (above, below):
        axis.grid(alpha=0.3)
    return figure
