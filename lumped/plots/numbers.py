"""Pictures of numbers: histograms, rankings, shares of limits, torque over speed, accuracy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lumped.plots.picture import Axis, Bars, Curve, Item, Level, Panel, Picture, Words, label_axis
from lumped.plots.style import COLOURS, GREY, LINES, MARKS, ZERO, Look, look
from lumped.support.ranking import quantiles

Rows = Sequence[tuple[float, float]]

_MOST_BARS = 12
_RANGE = 30.0
"""Ratio of the longest to the shortest bar above which lengths are logarithmic."""
_FELT = 1e-10
"""Of the longest bar: what is shorter is rounding."""
_MOST_SHARE = 3.0
"""Of a permitted value: longer bars are cut."""
_BAR = 0.27  # inch for each


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
        items: list[Item] = []
        if len(known):
            counts, edges = np.histogram(known, bins=min(80, max(10, len(known) // 50)))
            width = float(edges[1] - edges[0])
            items.append(Bars((edges[1:] + edges[:-1]) / 2, counts, COLOURS["sky"], width=width))
            for q, dash in ((0.001, LINES[2]), (0.5, LINES[0]), (0.999, LINES[1])):
                at = float(quantiles(every, q))
                if np.isfinite(at):
                    line, told = Look(COLOURS["vermilion"], dash), f"{100 * q:g} %: {at:.4g}"
                    items.append(Level(at, upright=True, label=told, look=line))
        axis = Axis(label_axis(label, unit))
        panels.append(Panel(tuple(items), axis, Axis("runs", low=0.0)))
    return Picture(title, tuple(panels))


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
    sizes = np.abs([value for _, value in most])
    log = len(most) > 0 and sizes[0] > _RANGE * sizes[-1]
    floor = sizes[-1] / 2 if log else 0.0
    items: list[Item] = []
    for sign, colour, label in ((1, "blue", "rises"), (-1, "vermilion", "falls")):
        rows = [i for i, (_, value) in enumerate(most) if value * sign > 0]
        if rows:
            lengths = np.array([most[i][1] for i in rows])
            lengths = np.abs(lengths) if log else lengths
            text = f"{label} with the parameter"
            items.append(Bars(np.array(rows), lengths, COLOURS[colour], text, lying=True))
    for i, (_, value) in enumerate(most):
        end = abs(value) if log else value
        items.append(Words(end, i, f"{value:+.3g}", -1 if end < 0 else 1))
    if not log:
        items.append(Level(0.0, upright=True, look=ZERO))
    reach = float(sizes[0]) if len(most) else 1.0
    values = [value for _, value in most]
    if log:
        low, high = floor, reach * (reach / floor) ** 0.15
    else:
        low, high = min(values, default=0.0), max(values, default=reach)
        room = 0.15 * (max(high, 0.0) - min(low, 0.0))
        low, high = (low - room if low < 0 else 0.0), (high + room if high > 0 else 0.0)
    told = "size of the change" if log else "change"
    x = Axis(f"{told} of {what} by 1 % of the parameter, %", log, low, high)
    names = tuple(name for name, _ in most)
    y = Axis(names=names, down=True, low=-0.6, high=len(most) - 0.4)
    notes = []
    if len(felt) > len(most):
        notes.append(f"{len(felt) - len(most)} more with less effect")
    if len(ranked) > len(felt):
        notes.append(f"{len(ranked) - len(felt)} without effect")
    panel = Panel(tuple(items), x, y, height=0.4 + _BAR * max(len(most), 2))
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
    items: list[Item] = []
    for is_kept, colour, label in ((True, "blue", "kept"), (False, "vermilion", "exceeded")):
        rows = [i for i, (_, share) in enumerate(shares) if (share <= 1) == is_kept]
        if rows:
            sizes = np.array([min(100 * shares[i][1], reach) for i in rows])
            items.append(Bars(np.array(rows), sizes, COLOURS[colour], label, lying=True))
    for i, (_, share) in enumerate(shares):
        told = f"{share:.1%}" if np.isfinite(share) else "infinite"
        items.append(Words(min(100 * share, reach), i, told, 1))
    items.append(Level(100.0, upright=True, look=ZERO))
    x = Axis("share of the permitted value, %", low=0.0, high=1.25 * reach)
    names = tuple(name for name, _ in shares)
    y = Axis(names=names, down=True, low=-0.6, high=len(shares) - 0.4)
    panel = Panel(tuple(items), x, y, height=0.4 + _BAR * 1.3 * max(len(shares), 2))
    return Picture(title, (panel,), below=True)


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
