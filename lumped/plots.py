"""Pictures of numbers; each function returns a matplotlib Figure that needs no display."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

__all__ = [
    "curves",
    "histograms",
    "tornado",
    "torque_speed",
    "work_precision",
]

Rows = Sequence[tuple[float, float]]

_WIDTH = 8.0  # inch
_MOST_BARS = 12
_LINES = ("-", "--", ":", "-.")  # after ten colours


def curves(
    title: str,
    t: np.ndarray,
    quantities: Mapping[str, tuple[str, str, np.ndarray]],
    events: Iterable[float],
    time_unit: str = "s",
) -> Figure:
    """Curves over time, one panel for each unit; events are thin vertical lines.

    Parameters
    ----------
    title : str
        Title of the figure.
    t : ndarray, shape (k,)
        Times.
    quantities : mapping of str to (str, str, ndarray of shape (k,))
        Unit, text and values of each name.
    events : iterable of float
        Their times.
    time_unit : str
        Unit of all times.
    """
    panels: dict[str, list[str]] = {}
    texts: dict[str, set[str]] = {}
    for name, (unit, text, _) in quantities.items():
        panels.setdefault(unit, []).append(name)
        texts.setdefault(unit, set()).add(text)
    times = list(events)
    figure = Figure((_WIDTH, 0.6 + 2.4 * len(panels)), layout="constrained")
    axes = figure.subplots(len(panels), sharex=True, squeeze=False).ravel()
    for axis, (unit, members) in zip(axes, panels.items(), strict=True):
        for i, name in enumerate(members):
            line = _LINES[i // 10 % len(_LINES)]
            axis.plot(t, quantities[name][2], line, color=f"C{i % 10}", label=name)
        for time in times:
            axis.axvline(time, color="grey", linewidth=0.6)
        (text,) = texts[unit] if len(texts[unit]) == 1 else ("",)
        axis.set_ylabel(f"{text}, {unit}" if text else unit)
        axis.grid(alpha=0.3)
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    axes[-1].set_xlabel(f"time, {time_unit}")
    axes[-1].set_xlim(t[0], t[-1])
    figure.suptitle(title)
    return figure


def histograms(title: str, results: Mapping[str, tuple[str, np.ndarray]]) -> Figure:
    """How often values occur among many runs, with their median and the quantiles around it.

    Parameters
    ----------
    title : str
        Title of the figure.
    results : mapping of str to (str, ndarray)
        Unit and values of each result; what is not a number is left out.
    """
    count = len(results)
    figure = Figure((_WIDTH, 2.0 + 1.8 * count), layout="constrained")
    panels = figure.subplots(count, 1, squeeze=False)[:, 0]
    for axis, (label, (unit, values)) in zip(panels, results.items(), strict=True):
        known = values[np.isfinite(values)]
        axis.set_xlabel(f"{label}, {unit}" if unit not in ("", "1") else label)
        axis.set_ylabel("runs")
        axis.grid(alpha=0.3)
        if not len(known):
            continue
        axis.hist(known, bins=min(80, max(10, len(known) // 50)), color="C0")
        for q, line in ((0.001, ":"), (0.5, "-"), (0.999, ":")):
            at = float(np.quantile(known, q))
            axis.axvline(at, color="C3", linestyle=line, label=f"{100 * q:g} %: {at:.4g}")
        axis.legend()
    figure.suptitle(title)
    return figure


def torque_speed(
    points: tuple[np.ndarray, np.ndarray],
    thermal: tuple[float, float],
    rated: float | Rows | None,
    maximum: float | Rows | None,
    labels: tuple[str, str],
) -> Figure:
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
    figure = Figure((_WIDTH, 5.0), layout="constrained")
    axis = figure.subplots()
    axis.plot(speed, torque, color="C0", label="run")
    reach = 1.1 * np.abs(speed).max()
    limits = ((maximum, "C3", "maximum"), (rated, "C2", "rated"))
    for limit, colour, label in limits:
        if limit is None:
            continue
        if isinstance(limit, float | int):
            w, bound = np.array([0.0, reach]), np.full(2, limit)
        else:  # the first torque holds below the first row, none beyond the last
            rows = np.array([(0.0, limit[0][1]), *limit, (limit[-1][0], 0.0)])
            w, bound = rows.T
        for sign in (1, -1):
            both = np.concatenate([-w[::-1], w])
            axis.plot(
                *(both, sign * np.concatenate([bound[::-1], bound])),
                color=colour,
                label=label if sign > 0 else None,
            )
    axis.plot(*thermal, "o", color="C2", label="thermal equivalent")
    for line in (axis.axhline, axis.axvline):
        line(0, color="black", linewidth=0.8)
    axis.set_xlabel(labels[0])
    axis.set_ylabel(labels[1])
    axis.grid(alpha=0.3)
    axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    return figure


def tornado(ranked: Sequence[tuple[str, float]], title: str, what: str) -> Figure:
    """Change of a number by 1 % of each parameter, the most effective on top.

    Parameters
    ----------
    ranked : sequence of (str, float)
        Names and relative sensitivities, the largest first.
    title, what : str
        Title, and what changes.
    """
    most = ranked[:_MOST_BARS]
    figure = Figure((_WIDTH, 1.2 + 0.3 * len(most)), layout="constrained")
    axis = figure.subplots()
    place = np.arange(len(most))
    percent = [value for _, value in most]
    axis.barh(place, percent, color=["C0" if value >= 0 else "C3" for value in percent])
    axis.set_yticks(place, [name for name, _ in most])
    axis.invert_yaxis()
    axis.axvline(0, color="black", linewidth=0.8)
    axis.grid(alpha=0.3, axis="x")
    axis.set_xlabel(f"change of {what} by 1 % of the parameter, %")
    figure.suptitle(title)
    return figure


def work_precision(title: str, methods: Mapping[str, Rows], least: float) -> Figure:
    """Run time over error, both logarithmic, one line for each method.

    Parameters
    ----------
    title : str
        Title of the figure.
    methods : mapping of str to sequence of (float, float)
        Error and run time, s, of each run.
    least : float
        Error of the reference itself.
    """
    figure = Figure((_WIDTH, 5.0), layout="constrained")
    axis = figure.subplots()
    marks = "os^Dv"
    for i, (method, rows) in enumerate(methods.items()):
        error = [max(error, least) for error, _ in rows]
        mark = f"-{marks[i % len(marks)]}"
        axis.plot(
            error, [1e3 * seconds for _, seconds in rows], mark, label=method, fillstyle="none"
        )
    axis.axvline(least, color="grey", linewidth=0.8, linestyle="--")
    axis.annotate(
        "error of the reference",
        (least, 0.98),
        xycoords=("data", "axes fraction"),
        rotation=90,
        va="top",
        ha="right",
        color="grey",
    )
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlabel("largest error, relative to the range of the signal")
    axis.set_ylabel("run time, ms")
    axis.grid(alpha=0.3, which="both")
    axis.legend(frameon=False)
    figure.suptitle(title)
    return figure
