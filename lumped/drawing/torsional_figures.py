"""Pictures of a report on torsional vibrations; their lines differ in grey, too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lumped.drawing.torsional_study import MOST_ORDERS, Study
from lumped.plots.matplotlib_figure import plain_text
from lumped.support.display_units import Units, display, time_unit
from lumped.timeloop.results.trajectory import Trajectory
from lumped.vibration.rules.limits import Limit, Measure
from lumped.vibration.rules.measures import measure_quantity

Real = np.ndarray
Style = tuple[str, str | tuple[int, tuple[int, ...]], float]
Line = tuple[Real, Real, Style, str]
"""Speeds, rad/s, values as they are shown, look and label."""

_WIDTH = 7.2  # inch, of a page A4 between its margins
_PAIR = 2
"""Responses side by side."""
_PANELS = 4
"""Quantities of a run in a figure."""
_THIN: Style = ("black", "-", 0.6)
_LEGEND = 108
"""Letters of a row of a legend."""
_STYLES: tuple[Style, ...] = (
    ("black", "-", 1.3),
    ("#1f4fd8", "--", 1.3),
    ("#c4261d", "-.", 1.3),
    ("#8a8a8a", "-", 1.3),
    ("#2b7a3d", ":", 1.6),
    ("#8a4b08", (0, (6, 1, 1, 1, 1, 1)), 1.1),
)
"""Colour, dashes and width in points."""
_LIMIT: tuple[Style, ...] = (
    ("#c4261d", (0, (8, 2)), 2.0),
    ("#c4261d", (0, (2, 2)), 2.0),
    ("#c4261d", (0, (8, 2, 2, 2)), 2.0),
)


def _over_speed(study: Study, panels: Mapping[str, Sequence[Line]], text: str) -> Figure:
    """A panel for the lines of each response, with the same scales, and one legend below all."""
    columns = min(len(panels), _PAIR)
    rows = -(-len(panels) // columns)
    figure = Figure((_WIDTH, 0.7 + 2.6 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    speed, labels = f"speed, {study.speed.unit}", dict[str, Artist]()
    for axis in axes[-1]:
        axis.set_xlabel(speed)
    for axis in axes.ravel()[len(panels) :]:
        axis.set_visible(False)
        axes[-2, -1].tick_params(labelbottom=True)
        axes[-2, -1].set_xlabel(speed)
    for axis, (caption, lines) in zip(axes.ravel(), panels.items(), strict=False):
        if study.operation is not None:
            low, high = (study.speed.value(w) for w in study.operation)
            axis.axvspan(low, high, color="#d9d9d9", zorder=0, label="operation")
        for speeds, values, style, label in lines:
            _draw(axis, study.speed.value(speeds), values, style, label)
        axis.set_title(plain_text(caption), fontsize="medium")
        axis.grid(alpha=0.4)
        reached = study.speed.value(study.responses[caption].speeds)
        if len(reached) > 1:
            axis.set_xlim(reached[0], reached[-1])
        for line, label in zip(*axis.get_legend_handles_labels(), strict=True):
            labels.setdefault(label, line)
    axes[0, 0].set_ylim(bottom=0)  # once all curves have set the common scale
    for row in axes:
        row[0].set_ylabel(text)
    if labels:
        figure.legend(
            list(labels.values()),
            list(labels),
            loc="outside lower center",
            ncols=max(1, min(3, _LEGEND // max(map(len, labels)))),
            frameon=False,
            fontsize="small",
            handlelength=4,
        )
    return figure


def _draw(axis: Axes, x: Real, y: Real, style: Style, label: str) -> None:
    colour, dashes, width = style
    axis.plot(x, y, color=colour, linestyle=dashes, linewidth=width, label=plain_text(label))


def campbell_figure(study: Study) -> Figure:
    """Orders, and the natural frequencies that these reach; if none, the lowest."""
    figure: Figure = study.campbell.plot(between=study.operation, units=study.units)
    figure.suptitle("")
    return figure


def order_figure(study: Study, output: str) -> Figure:
    """The largest orders of a quantity, a panel for each response, with the same scales."""
    shown = study.choose_unit(output)
    largest: dict[float, float] = {}
    for own in study.measure_orders(output).values():
        for order, (size, _) in own.items():
            largest[order] = max(size, largest.get(order, 0.0))
    chosen = sorted(sorted(largest, key=lambda order: -largest[order])[:MOST_ORDERS])
    lines = {
        caption: [
            (response.speeds, shown.value(response.magnitude(output, x)), style, f"order {x:g}")
            for x, style in zip(chosen, _STYLES, strict=False)
            if x in response.orders
        ]
        for caption, response in study.having(output).items()
    }
    return _over_speed(study, lines, f"amplitude, {shown.unit}")


def synthesis_figure(study: Study, output: str) -> Figure:
    """All orders together over the speed, against the limits."""
    shown = study.choose_unit(output)
    lines: dict[str, list[Line]] = {}
    for caption, response in study.having(output).items():
        limits = study.limits_of(caption, output)
        kinds: list[Measure] = ["maximum", "sum", *(limit.measure for limit in limits)]
        own = lines[caption] = []
        for kind, style in zip(dict.fromkeys(kinds), _STYLES, strict=False):
            size = shown.value(measure_quantity(response, output, kind))
            text = "sum of amplitudes" if kind == "sum" else kind
            own.append((response.speeds, size, style, text))
        for limit, style in zip(limits, cycle(_LIMIT), strict=False):
            speeds = limit.holding(response.speeds)
            permitted = shown.value(limit.at(speeds, study.unit(output)))
            own.append((speeds, permitted, style, f"permitted: {limit.name} ({limit.measure})"))
    return _over_speed(study, lines, f"all orders, {shown.unit}")


def heat_figure(study: Study) -> Figure:
    """Mean dissipated power over the speed, a panel for each response."""
    lines: dict[str, list[Line]] = {}
    for caption, parts in study.heat.items():
        speeds, styles = study.responses[caption].speeds, cycle(_STYLES)
        lines[caption] = [
            (speeds, study.power.value(power), style, part)
            for (part, power), style in zip(parts.items(), styles, strict=False)
        ]
    return _over_speed(study, lines, f"dissipated power, {study.power.unit}")


def run_figures(
    run: Trajectory, names: Mapping[str, str], limits: Sequence[Limit], units: Units
) -> list[Figure]:
    """Quantities of a run over the time, a panel for each, with what is permitted.

    Parameters
    ----------
    run : Trajectory
        The run.
    names : mapping of str to str
        Quantities and their SI units.
    limits : sequence of Limit
        Of the run; those of its mean power are not drawn.
    units : mapping of str to str
        Units to show.
    """
    time = time_unit(units)
    found, every = [], list(names.items())
    for first in range(0, len(every), _PANELS):
        members = every[first : first + _PANELS]
        figure = Figure((_WIDTH, 0.7 + 1.8 * len(members)), layout="constrained")
        axes = figure.subplots(len(members), sharex=True, squeeze=False)[:, 0]
        for axis, (name, unit) in zip(axes, members, strict=True):
            shown = display(name, unit, units)
            _draw(axis, time.value(run.t), shown.value(run[name]), _THIN, name)
            for limit in limits:
                if run.system.key(limit.quantity) == name and limit.measure != "mean power":
                    permitted = shown.value(limit.at(run.t[:1], unit)[0])
                    for side in (permitted, -permitted):
                        axis.axhline(side, color="#c4261d", linestyle="--", linewidth=1.0)
            axis.set_title(name, fontsize="medium")
            axis.set_ylabel(shown.unit)
            axis.grid(alpha=0.4)
        axes[-1].set_xlabel(f"time, {time.unit}")
        axes[-1].set_xlim(*(time.value(run.t[i]) for i in (0, -1)))
        found.append(figure)
    return found
