"""Pictures of a report on torsional vibrations; their lines differ in grey, too."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lumped.drawing.torsional_study import MOST_ORDERS, Study
from lumped.support.display_units import Units, display, time_unit
from lumped.timeloop.results.trajectory import Trajectory
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.rules.limits import Measure
from lumped.vibration.rules.verdict import measure_quantity

Real = np.ndarray
Style = tuple[str, str | tuple[int, tuple[int, ...]], float]

_WIDTH = 7.2  # inch, of a page A4 between its margins
_PAIR = 2
"""Responses side by side."""
_PANELS = 4
"""Quantities of a run in a figure."""
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


def _line(axis: Axes, x: Real, y: Real, style: Style, label: str) -> None:
    colour, dashes, width = style
    axis.plot(x, y, color=colour, linestyle=dashes, linewidth=width, label=_plain(label))


def _plain(text: str) -> str:
    """A text that is no formula."""
    return text.replace("$", r"\$")


def _panels(rows: int, columns: int, height: float) -> tuple[Figure, np.ndarray]:
    figure = Figure((_WIDTH, 0.7 + height * rows), layout="constrained")
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    return figure, axes


def _finish(figure: Figure, axes: np.ndarray, used: int, text: str) -> None:
    """Texts, grid and one legend below all panels."""
    shown = axes.ravel()[:used]
    labels: dict[str, Artist] = {}
    for axis in shown:
        axis.grid(alpha=0.4)
        for line, label in zip(*axis.get_legend_handles_labels(), strict=True):
            labels.setdefault(label, line)
    for axis in axes.ravel()[used:]:
        axis.set_visible(False)
        above = axes[-2, -1]
        above.tick_params(labelbottom=True)
        above.set_xlabel(axes[-1, 0].get_xlabel())
    axes[0, 0].set_ylim(bottom=0)  # once all curves have set the common scale
    for row in axes:
        row[0].set_ylabel(text)
    if labels:
        figure.legend(
            list(labels.values()),
            list(labels),
            loc="outside lower center",
            ncols=3,
            frameon=False,
            fontsize="small",
            handlelength=4,
        )


def _over_speed(study: Study, count: int) -> tuple[Figure, np.ndarray]:
    columns = min(count, _PAIR)
    figure, axes = _panels(-(-count // columns), columns, 2.6)
    for axis in axes[-1]:
        axis.set_xlabel(f"speed, {study.speed.unit}")
    for axis in axes.ravel():
        shade(axis, study)
    return figure, axes


def shade(axis: Axes, study: Study) -> None:
    """Shade the speeds of operation."""
    if study.operation is not None:
        low, high = (study.speed.value(w) for w in study.operation)
        axis.axvspan(low, high, color="#d9d9d9", zorder=0, label="operation")


def campbell_figure(study: Study) -> Figure:
    """Orders, and the natural frequencies that these reach; if none, the lowest."""
    found = study.campbell
    rays = np.outer(found.speeds, [max(found.orders) / (2 * np.pi)])
    reached = np.flatnonzero((found.hertz <= rays).any(axis=0))
    shown = reached if len(reached) else [0] * bool(found.hertz.size)
    figure: Figure = replace(found, hertz=found.hertz[:, shown]).plot(
        between=study.operation, units=study.units
    )
    figure.suptitle("")
    return figure


def order_figure(study: Study, output: str) -> Figure:
    """The largest orders of a quantity, a panel for each response, with the same scales."""
    responses = study.having(output)
    shown = study.choose_unit(output)
    largest: dict[float, float] = {}
    for response in responses.values():
        for order, size in zip(response.orders, np.abs(response[output]).max(axis=0), strict=True):
            largest[float(order)] = max(float(size), largest.get(float(order), 0.0))
    chosen = sorted(sorted(largest, key=lambda order: -largest[order])[:MOST_ORDERS])
    figure, axes = _over_speed(study, len(responses))
    for axis, (caption, response) in zip(axes.ravel(), responses.items(), strict=False):
        for order, style in zip(chosen, _STYLES, strict=False):
            if order in response.orders:
                size = shown.value(response.magnitude(output, order))
                speeds = study.speed.value(response.speeds)
                _line(axis, speeds, size, style, f"order {order:g}")
        _frame(axis, caption, response, study)
    _finish(figure, axes, len(responses), f"amplitude, {shown.unit}")
    return figure


def synthesis_figure(study: Study, output: str) -> Figure:
    """All orders together over the speed, against the limits."""
    responses = study.having(output)
    shown = study.choose_unit(output)
    figure, axes = _over_speed(study, len(responses))
    for axis, (caption, response) in zip(axes.ravel(), responses.items(), strict=False):
        limits = study.limits_of(caption, output)
        kinds: list[Measure] = ["maximum", "sum"]
        kinds += [limit.measure for limit in limits]
        for kind, style in zip(dict.fromkeys(kinds), _STYLES, strict=False):
            text = "sum of amplitudes" if kind == "sum" else kind
            size = shown.value(measure_quantity(response, output, kind))
            _line(axis, study.speed.value(response.speeds), size, style, text)
        for i, limit in enumerate(limits):
            speeds = limit.holding(response.speeds)
            permitted = shown.value(limit.at(speeds, study.unit(output)))
            label = f"permitted: {limit.name} ({limit.measure})"
            _line(axis, study.speed.value(speeds), permitted, _LIMIT[i % len(_LIMIT)], label)
        _frame(axis, caption, response, study)
    _finish(figure, axes, len(responses), f"all orders, {shown.unit}")
    return figure


def _frame(axis: Axes, caption: str, response: OrderResponse, study: Study) -> None:
    axis.set_title(_plain(caption), fontsize="medium")
    if len(response.speeds) > 1:
        axis.set_xlim(*(study.speed.value(response.speeds[i]) for i in (0, -1)))


def heat_figure(study: Study) -> Figure:
    """Mean dissipated power over the speed, a panel for each response."""
    figure, axes = _over_speed(study, len(study.heat))
    for axis, (caption, parts) in zip(axes.ravel(), study.heat.items(), strict=False):
        response = study.responses[caption]
        for i, (part, power) in enumerate(parts.items()):
            size, speeds = study.power.value(power), study.speed.value(response.speeds)
            _line(axis, speeds, size, _STYLES[i % len(_STYLES)], part)
        _frame(axis, caption, response, study)
    _finish(figure, axes, len(study.heat), f"dissipated power, {study.power.unit}")
    return figure


def run_figures(run: Trajectory, names: Mapping[str, str], units: Units) -> list[Figure]:
    """Quantities of a run over the time, a panel for each.

    Parameters
    ----------
    run : Trajectory
        The run.
    names : mapping of str to str
        Quantities and their SI units.
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
            _line(axis, time.value(run.t), shown.value(run[name]), _STYLES[0], name)
            axis.set_title(name, fontsize="medium")
            axis.set_ylabel(shown.unit)
            axis.grid(alpha=0.4)
        axes[-1].set_xlabel(f"time, {time.unit}")
        axes[-1].set_xlim(*(time.value(run.t[i]) for i in (0, -1)))
        found.append(figure)
    return found
