"""Pictures of numbers: histograms, rankings, shares, loads, reliability, accuracy."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lumped.plots.picture import (
    Axis,
    Band,
    Bars,
    Curve,
    Item,
    Level,
    Panel,
    Picture,
    Words,
    label_axis,
)
from lumped.plots.style import COLOURS, GREY, INK, LINES, MARKS, ZERO, Look, look
from lumped.support.ranking import quantiles

Rows = Sequence[tuple[float, float]]
Spread = tuple[
    str, np.ndarray, Sequence[tuple[float, float, float, float]], Sequence[tuple[str, float]]
]
"""Unit, values, quantiles as (q, value, low, high), and parameters with their shares."""

_MOST_BARS = 12
_RANGE = 30.0
"""Ratio of the longest to the shortest bar above which lengths are logarithmic."""
_FELT = 1e-10
"""Of the longest bar: what is shorter is rounding."""
_MOST_SHARE = 3.0
"""Of a permitted value: longer bars are cut."""
_MOST_SHARES = 10
_MOVES = ("rises with the parameter", "falls with the parameter")
_BAR = 0.27  # inch for each


class _Named(NamedTuple):
    """A bar, what stands at its end, and which of two kinds it is of."""

    name: str
    size: float
    text: str
    is_second: bool = False


def _named_bars(
    rows: Sequence[_Named], x: Axis, kinds: Sequence[str] = ("",), each: float = 0.35
) -> Panel:
    """Bars that lie, the first on top, each with its name and a text.

    Parameters
    ----------
    rows : sequence of _Named
        The bars.
    x : Axis
        Their axis.
    kinds : sequence of str
        What both kinds of bars are.
    each : float
        Height for a bar, inch.
    """
    items: list[Item] = []
    for k, (label, colour) in enumerate(zip(kinds, ("blue", "vermilion"), strict=False)):
        places = [i for i, row in enumerate(rows) if row.is_second == bool(k)]
        if places:
            sizes = np.array([rows[i].size for i in places])
            items.append(Bars(np.array(places), sizes, COLOURS[colour], label, lying=True))
    items += [Words(row.size, i, row.text, -1 if row.size < 0 else 1) for i, row in enumerate(rows)]
    names = tuple(row.name for row in rows)
    y = Axis(names=names, down=True, low=-0.6, high=len(rows) - 0.4)
    return Panel(tuple(items), x, y, height=0.4 + each * max(len(rows), 2))


def _histogram(
    values: np.ndarray, bins: int, marked: Iterable[tuple[float, float]], density: bool = False
) -> list[Item]:
    """Bars of values, and lines at three quantiles, given as (q, value)."""
    items: list[Item] = []
    if len(values):
        counts, edges = np.histogram(values, bins=bins, density=density)
        width = float(edges[1] - edges[0])
        items.append(Bars((edges[1:] + edges[:-1]) / 2, counts, COLOURS["sky"], width=width))
    for (q, at), dash in zip(marked, (LINES[2], LINES[0], LINES[1]), strict=False):
        if np.isfinite(at):
            line, told = Look(COLOURS["vermilion"], dash), f"{100 * q:g} %: {at:.4g}"
            items.append(Level(at, upright=True, label=told, look=line))
    return items


def histograms(title: str, results: Mapping[str, tuple[str, np.ndarray]]) -> Picture:
    """How often values occur among many runs, with their median and the quantiles around it.

    Parameters
    ----------
    title : str
        Title of the picture.
    results : mapping of str to (str, ndarray)
        Unit and values of each result; what is not a number is left out.
    """
    panels = []
    for label, (unit, values) in results.items():
        known, every = values[np.isfinite(values)], values[~np.isnan(values)]
        bins = min(80, max(10, len(known) // 50))
        marked = [(q, float(quantiles(every, q))) for q in (0.001, 0.5, 0.999) if len(known)]
        items = _histogram(known, bins, marked)
        panels.append(Panel(tuple(items), Axis(label_axis(label, unit)), Axis("runs", low=0.0)))
    return Picture(title, tuple(panels))


def spreads_picture(title: str, results: Mapping[str, Spread]) -> Picture:
    """Histograms with quantiles and their intervals; beside each the shares of parameters.

    Parameters
    ----------
    title : str
        Title of the picture.
    results : mapping of str to Spread
        By the labels of the functionals.
    """
    panels: list[Panel] = []
    for label, (unit, values, found, ranking) in results.items():
        known = values[np.isfinite(values)]
        items: list[Item] = [
            Band(low, high, COLOURS["orange"])
            for _, _, low, high in found
            if np.isfinite([low, high]).all()
        ]
        marked = [(q, value) for q, value, _, _ in found]
        bins = min(60, max(10, int(np.sqrt(len(known)))))
        items += _histogram(known, bins, marked, density=True)
        panels.append(Panel(tuple(items), Axis(label_axis(label, unit)), Axis("density", low=0.0)))
        shares = [(name, 100 * share) for name, share in ranking if np.isfinite(share)]
        rows = [_Named(name, size, f"{size:.3g} %") for name, size in shares[:_MOST_SHARES]]
        high = 1.3 * max([1.0, *(row.size for row in rows)])
        x = Axis("share of the variance, each alone, %", low=0.0, high=high)
        panels.append(replace(_named_bars(rows, x), height=panels[-1].height))
    return Picture(title, tuple(panels), columns=2)


def torque_speed(
    points: tuple[np.ndarray, np.ndarray],
    thermal: tuple[float, float],
    rated: float | Rows | None,
    maximum: float | Rows | None,
    labels: tuple[str, str],
) -> Picture:
    """Plane of speed and torque: the run, the limits in all four quadrants, the thermal point.

    Parameters
    ----------
    points : tuple of ndarray, each of shape (k,)
        Speed and torque over the run.
    thermal : tuple of float
        Speed and torque of the thermal equivalent.
    rated, maximum : float, rows of (speed, torque) or None
        The limits.
    labels : tuple of str
        Of the speed and of the torque, with their units.
    """
    speed, torque = points
    items: list[Item] = [Curve(speed, torque, "run", look(0))]
    reach = 1.1 * float(np.abs(speed).max())
    limits = ((maximum, "vermilion", "maximum"), (rated, "green", "rated"))
    for limit, colour, label in limits:
        if limit is None:
            continue
        if isinstance(limit, float | int):
            w, bound = np.array([0.0, reach]), np.full(2, float(limit))
        else:  # the first torque holds below the first row, none beyond the last
            rows = np.array([(0.0, limit[0][1]), *limit, (limit[-1][0], 0.0)])
            w, bound = rows.T
        both = np.concatenate([-w[::-1], w])
        line = Look(COLOURS[colour], "dashed" if colour == "green" else "solid")
        for sign in (1, -1):
            values = sign * np.concatenate([bound[::-1], bound])
            items.append(Curve(both, values, label if sign > 0 else "", line))
    mark = Look(COLOURS["green"], "", mark="circle", size=6.0)
    items.append(Curve(np.array([thermal[0]]), np.array([thermal[1]]), "thermal equivalent", mark))
    items += [Level(0.0, look=ZERO), Level(0.0, upright=True, look=ZERO)]
    x, y = (Axis(label) for label in labels)
    return Picture("torque over speed", (Panel(tuple(items), x, y, height=4.2),))


def tornado(ranked: Sequence[tuple[str, float]], title: str, what: str) -> Picture:
    """Change of a number by 1 % of each parameter, the most effective on top.

    If the bars differ by more than a factor of 30, their lengths are logarithmic; their colours
    tell the signs.

    Parameters
    ----------
    ranked : sequence of (str, float)
        Names and relative sensitivities, the largest first.
    title, what : str
        Title, and what changes.
    """
    least = _FELT * max((abs(value) for _, value in ranked), default=0.0)
    felt = [(name, value) for name, value in ranked if abs(value) > least]
    most = felt[:_MOST_BARS]
    values = [value for _, value in most] or [1.0]
    first, last = abs(values[0]), abs(values[-1])
    log = first > _RANGE * last
    if log:
        low, high = last / 2, first * (2 * first / last) ** 0.15
    else:
        low, high = min(0.0, *values), max(0.0, *values)
        room = 0.15 * (high - low)
        low, high = low - room * (low < 0), high + room * (high > 0)
    told = "size of the change" if log else "change"
    x = Axis(f"{told} of {what} by 1 % of the parameter, %", log, low, high)
    rows = [
        _Named(name, abs(value) if log else value, f"{value:+.3g}", value < 0)
        for name, value in most
    ]
    panel = _named_bars(rows, x, _MOVES, _BAR)
    if not log:
        panel = replace(panel, items=(*panel.items, Level(0.0, upright=True, look=ZERO)))
    notes = []
    if len(felt) > len(most):
        notes.append(f"{len(felt) - len(most)} more with less effect")
    if len(ranked) > len(felt):
        notes.append(f"{len(ranked) - len(felt)} without effect")
    return Picture(title, (panel,), below=True, note=", ".join(notes))


def utilisation(title: str, shares: Sequence[tuple[str, float]]) -> Picture:
    """How far limits are used, in %, the largest on top.

    Parameters
    ----------
    title : str
        Title of the picture.
    shares : sequence of (str, float)
        Names and shares, the largest first; bars end at three times what is permitted.
    """
    reach = 100 * min(max(1.0, *(share for _, share in shares)), _MOST_SHARE)
    rows = [
        _Named(
            name,
            min(100 * share, reach),
            f"{share:.1%}" if np.isfinite(share) else "infinite",
            share > 1,
        )
        for name, share in shares
    ]
    x = Axis("share of the permitted value, %", low=0.0, high=1.25 * reach)
    panel = _named_bars(rows, x, ("kept", "exceeded"), 1.3 * _BAR)
    items = (*panel.items, Level(100.0, upright=True, look=ZERO))
    return Picture(title, (replace(panel, items=items),), below=True)


def importance_factors(title: str, factors: Sequence[tuple[str, float]]) -> Picture:
    """Shares of parameters in what leads to a limit, the largest on top.

    Parameters
    ----------
    title : str
        Title of the picture.
    factors : sequence of (str, float)
        Names and shares, the largest first; negative where a smaller value leads to the limit.
    """
    rows = [
        _Named(name, 100 * abs(share), f"{abs(share):.1%}", share < 0)
        for name, share in factors[:_MOST_BARS]
    ]
    x = Axis("importance factor, %", low=0.0, high=1.15 * max(row.size for row in rows))
    left = len(factors) - len(rows)
    note = f"{left} more with less importance" if left else ""
    kinds = ("larger than at the median", "smaller than at the median")
    return Picture(title, (_named_bars(rows, x, kinds),), below=True, note=note)


def exceedance(
    title: str, what: str, levels: tuple[np.ndarray, np.ndarray], limit: float
) -> Picture:
    """Probability over the value that is passed with it, level by level.

    Parameters
    ----------
    title, what : str
        Title of the picture; the quantity with its unit.
    levels : tuple of ndarray, each of shape (k,)
        Values and probabilities.
    limit : float
        Value of the limit.
    """
    wall = Look(COLOURS["vermilion"], "dashed")
    items: list[Item] = [
        Curve(*levels, "levels", Look(COLOURS["blue"], mark=MARKS[3])),
        Level(limit, upright=True, label=f"limit {limit:.4g}", look=wall),
        Level(1.0, look=ZERO),
    ]
    y = Axis("probability", log=True)
    return Picture(title, (Panel(tuple(items), Axis(what), y, height=3.0),))


def duty_picture(
    title: str,
    shares: Sequence[tuple[str, float]],
    spectra: Mapping[str, tuple[np.ndarray, np.ndarray]],
    unit: str,
) -> Picture:
    """Shares of the damage, and cumulative spectra of ranges.

    Parameters
    ----------
    title : str
        Title of the picture.
    shares : sequence of (str, float)
        Names and shares of the damage.
    spectra : mapping of str to (ndarray, ndarray)
        Ranges and numbers of cycles, by name; the first is that of all.
    unit : str
        Of the ranges.
    """
    rows = [_Named(name, 100 * share, f"{100 * share:.1f} %") for name, share in shares]
    high = 1.2 * max(1.0, *(row.size for row in rows))
    damage = _named_bars(rows, Axis("share of the damage, %", low=0.0, high=high))
    curves = []
    for i, (name, (ranges, counts)) in enumerate(spectra.items()):
        line = look(i - 1) if i else Look(INK, width=2.0)
        curves.append(Curve(*_count_exceedances(ranges, counts), name, line))
    exceeded = Axis("cycles of a duty cycle with a larger range", log=True)
    spectrum = Panel(tuple(curves), exceeded, Axis(label_axis("range", unit), low=0.0), height=3.0)
    return Picture(title, (damage, spectrum))


def spectrum_picture(rows: Sequence[tuple[str, float, str]], unit: str) -> Picture:
    """Shares of the time of each level of a load, with its speed.

    Parameters
    ----------
    rows : sequence of (str, float, str)
        Load with its unit, share and speed.
    unit : str
        Of the speed.
    """
    bars = [_Named(load, 100 * share, f"{speed} {unit}") for load, share, speed in rows]
    high = 1.3 * max(row.size for row in bars)
    axis = Axis("share of the time, %", low=0.0, high=high)
    return Picture("load spectrum", (_named_bars(bars, axis, each=_BAR),))


def _count_exceedances(ranges: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Steps of the number of cycles that have at least a range, over which it is drawn."""
    order = np.argsort(-ranges, kind="stable")
    number = np.cumsum(counts[order])
    y = ranges[order]
    first = number[:1] if len(number) else np.zeros(0)
    x = np.repeat(np.concatenate([0.5 * first, number]), 2)[1:-1] if len(number) else first
    return x, np.repeat(y, 2)


def work_precision(title: str, methods: Mapping[str, Rows], least: float) -> Picture:
    """Run time over error, both logarithmic, one line for each method.

    Parameters
    ----------
    title : str
        Title of the picture.
    methods : mapping of str to sequence of (float, float)
        Error and run time, s, of each run.
    least : float
        Error of the reference itself.
    """
    items: list[Item] = [
        Level(least, upright=True, label="error of the reference", look=Look(GREY, "dashed"))
    ]
    for i, (method, rows) in enumerate(methods.items()):
        error = np.array([max(error, least) for error, _ in rows])
        time = np.array([1e3 * seconds for _, seconds in rows])
        line = look(i, mark=MARKS[i % len(MARKS)], hollow=True)
        items.append(Curve(error, time, method, line))
    x = Axis("largest error, relative to the range of the signal", log=True)
    return Picture(title, (Panel(tuple(items), x, Axis("run time, ms", log=True), height=4.0),))
