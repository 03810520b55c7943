"""Pictures of numbers; each function returns a matplotlib Figure that needs no display."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

__all__ = [
    "campbell",
    "curves",
    "frequency_response",
    "histograms",
    "mode_shapes",
    "order_response",
    "phase_diagrams",
    "root_locus",
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
) -> Figure:
    """Curves over time, one panel for each unit; events are thin vertical lines.

    Parameters
    ----------
    title : str
        Title of the figure.
    t : ndarray, shape (k,)
        Times, s.
    quantities : mapping of str to (str, str, ndarray of shape (k,))
        Unit, text and values of each name.
    events : iterable of float
        Their times, s.
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
    axes[-1].set_xlabel("time, s")
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


def mode_shapes(
    title: str, names: Sequence[str], shapes: np.ndarray, captions: Sequence[str]
) -> Figure:
    """Amplitudes along the drive, one panel for each mode.

    Where modes are damped the parts do not pass zero together; dashed lines then show what moves
    a quarter of a period apart.

    Parameters
    ----------
    title : str
        Title of the figure.
    names : sequence of str
        Quantities in their order along the drive.
    shapes : complex ndarray, shape (len(names), modes)
        Their amplitudes.
    captions : sequence of str
        What stands above each panel.
    """
    count = len(captions)
    columns = 1 if count <= 4 else 2
    lines = -(-count // columns)
    figure = Figure((_WIDTH, 1.2 + 1.9 * lines), layout="constrained")
    grid = figure.subplots(lines, columns, sharex=True, sharey=True, squeeze=False)
    place = np.arange(len(names))
    damped = np.abs(shapes.imag).max() > 1e-6
    for i, axis in enumerate(grid.T.ravel()[:count]):
        axis.axhline(0, color="black", linewidth=0.8)
        axis.plot(place, shapes[:, i].real, "o-", markersize=4, label="in phase")
        if damped:
            axis.plot(
                *(place, shapes[:, i].imag, "o--"),
                color="grey",
                markersize=3,
                label="a quarter of a period apart",
            )
        axis.set_title(captions[i], fontsize="medium")
        axis.grid(alpha=0.3)
        axis.set_ylim(-1.15, 1.15)
    for axis in grid.T.ravel()[count:]:
        axis.set_visible(False)
    for axis in grid[-1]:
        angle = 30 if len(names) * columns <= 10 else 90
        axis.set_xticks(place, names, rotation=angle, ha="right", rotation_mode="anchor")
    if damped:
        lines_drawn, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(lines_drawn, labels, loc="outside lower center", ncols=2)
    figure.supylabel("relative amplitude")
    figure.suptitle(title)
    return figure


def frequency_response(
    title: str,
    hertz: np.ndarray,
    outputs: Mapping[str, tuple[str, Mapping[str, tuple[np.ndarray, np.ndarray]]]],
) -> Figure:
    """Magnitude (logarithmic) and phase over the frequency, one pair of panels for each output.

    Parameters
    ----------
    title : str
        Title of the figure.
    hertz : ndarray, shape (k,)
        Frequencies, Hz.
    outputs : mapping of str to (str, mapping of str to two ndarrays of shape (k,))
        Unit of each output, and magnitude and phase (rad) for each input.
    """
    figure = Figure((_WIDTH, 0.6 + 3.6 * len(outputs)), layout="constrained")
    count = 2 * len(outputs)
    axes = figure.subplots(count, sharex=True, height_ratios=[2, 1] * len(outputs))
    for size, angle, (output, (unit, inputs)) in zip(
        axes[::2], axes[1::2], outputs.items(), strict=True
    ):
        for i, (given, (magnitude, phase)) in enumerate(inputs.items()):
            line, colour = _LINES[i // 10 % len(_LINES)], f"C{i % 10}"
            size.plot(hertz, magnitude, line, color=colour, label=given)
            angle.plot(hertz, np.degrees(phase), line, color=colour)
        size.set_yscale("log")
        size.set_title(output, fontsize="medium")
        size.set_ylabel(f"{unit} for each unit")
        size.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
        angle.set_ylabel("phase, deg")
        for axis in (size, angle):
            axis.grid(alpha=0.3)
    axes[-1].set_xlabel("frequency, Hz")
    axes[-1].set_xlim(hertz[0], hertz[-1])
    figure.suptitle(title)
    return figure


def torque_speed(
    points: tuple[np.ndarray, np.ndarray],
    thermal: tuple[float, float],
    rated: float | Rows | None,
    maximum: float | Rows | None,
    units: tuple[str, str],
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
    units : tuple of str
        Units of torque and speed.
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
    torque_unit, speed_unit = units
    turning = torque_unit == "N.m"
    axis.set_xlabel(f"{'angular velocity' if turning else 'speed'}, {speed_unit}")
    axis.set_ylabel(f"{'torque' if turning else 'force'}, {torque_unit}")
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


def campbell(
    title: str, speeds: np.ndarray, hertz: np.ndarray, orders: Sequence[float], critical: Rows
) -> Figure:
    """Natural frequencies over the speed, rays of the orders, and points where they meet.

    Parameters
    ----------
    title : str
        Title of the figure.
    speeds : ndarray, shape (k,)
        Speeds, rad/s.
    hertz : ndarray, shape (k, n)
        Natural frequencies, Hz.
    orders : sequence of float
        Orders of excitation.
    critical : sequence of (float, float)
        Speed, 1/min, and frequency, Hz, of each intersection.
    """
    figure = Figure((_WIDTH, 5.0), layout="constrained")
    axis = figure.subplots()
    rpm = speeds * 30 / np.pi
    axis.plot(rpm, hertz, color="C0")
    for order in orders:
        axis.plot(rpm, order * rpm / 60, color="grey", linewidth=0.8)
        axis.annotate(f"{order:g}", (rpm[-1], order * rpm[-1] / 60), color="grey")
    axis.plot([speed for speed, _ in critical], [f for _, f in critical], "o", color="C3")
    top = np.nanmax(hertz, initial=0.0)
    axis.set_ylim(0, 1.15 * (top or max(orders) * rpm[-1] / 60))
    axis.set_xlim(rpm[0], rpm[-1])
    axis.set_xlabel("speed, 1/min")
    axis.set_ylabel("frequency, Hz")
    axis.grid(alpha=0.3)
    figure.suptitle(title)
    return figure


def root_locus(title: str, eigenvalues: np.ndarray) -> Figure:
    """Eigenvalues in the complex plane, upper half; a circle marks the first value, a dot the last.

    Parameters
    ----------
    title : str
        Title of the figure.
    eigenvalues : complex ndarray, shape (k, n)
        Eigenvalues along the locus, 1/s.
    """
    figure = Figure((_WIDTH, 5.0), layout="constrained")
    axis = figure.subplots()
    hertz = eigenvalues / (2 * np.pi)
    upper = (eigenvalues.imag > 0).any(axis=0)
    for i, column in enumerate(np.flatnonzero(upper).tolist()):
        path = np.where(hertz[:, column].imag >= 0, hertz[:, column], np.nan)
        colour = f"C{i % 10}"
        axis.plot(path.real, path.imag, color=colour)
        axis.plot(path.real[0], path.imag[0], "o", color=colour, fillstyle="none")
        axis.plot(path.real[-1], path.imag[-1], "o", color=colour)
    axis.axvline(0, color="black", linewidth=0.8)
    axis.set_xlabel("real part / (2 pi), 1/s")
    axis.set_ylabel("imaginary part / (2 pi), Hz")
    axis.grid(alpha=0.3)
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


def order_response(
    title: str,
    rpm: np.ndarray,
    outputs: Mapping[str, tuple[str, Mapping[str, np.ndarray]]],
) -> Figure:
    """Amplitudes over the speed, one panel for each output.

    Parameters
    ----------
    title : str
        Title of the figure.
    rpm : ndarray, shape (k,)
        Speeds, 1/min.
    outputs : mapping of str to (str, mapping of str to ndarray of shape (k,))
        Unit of each output, and its curves by their labels; the last one stands out.
    """
    figure = Figure((_WIDTH, 0.6 + 2.6 * len(outputs)), layout="constrained")
    axes = np.atleast_1d(figure.subplots(len(outputs), sharex=True))
    for axis, (output, (unit, curves)) in zip(axes, outputs.items(), strict=True):
        for i, (label, size) in enumerate(curves.items()):
            last = i == len(curves) - 1
            colour = "black" if last else f"C{i % 10}"
            axis.plot(rpm, size, color=colour, linewidth=1.6 if last else 1.1, label=label)
        axis.set_title(output, fontsize="medium")
        axis.set_ylabel(f"amplitude, {unit}")
        axis.set_ylim(bottom=0)
        axis.grid(alpha=0.3)
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    axes[-1].set_xlabel("speed, 1/min")
    axes[-1].set_xlim(rpm[0], rpm[-1])
    figure.suptitle(title)
    return figure


def phase_diagrams(
    title: str, labels: Sequence[str], vectors: np.ndarray, captions: Sequence[str]
) -> Figure:
    """Vectors from one centre and their sum, one polar panel for each row.

    Parameters
    ----------
    title : str
        Title of the figure.
    labels : sequence of str, shape (c,)
        What each vector is.
    vectors : complex ndarray, shape (len(captions), c)
        The vectors.
    captions : sequence of str
        What stands above each panel.
    """
    columns = min(len(captions), 4)
    lines = -(-len(captions) // columns)
    figure = Figure((_WIDTH, 0.8 + 2.3 * lines), layout="constrained")
    grid = figure.subplots(lines, columns, squeeze=False, subplot_kw={"projection": "polar"})
    for axis, row, caption in zip(grid.ravel(), vectors, captions, strict=False):
        reach = max(np.abs(row).max(), abs(row.sum()), 1e-300)
        texts: dict[tuple[float, float], list[str]] = {}
        for label, vector in zip(labels, row, strict=True):
            axis.plot([0, np.angle(vector)], [0, abs(vector)], color="C0", linewidth=1.1)
            end = complex(np.round(vector / reach, 2))
            texts.setdefault((end.real, end.imag), []).append(label)
        for (x, y), names in texts.items():
            place = reach * complex(x, y)
            axis.annotate(", ".join(names), (np.angle(place), abs(place)), fontsize="small")
        axis.plot([0, np.angle(row.sum())], [0, abs(row.sum())], color="black", linewidth=2)
        axis.set_title(f"{caption}: {abs(row.sum()):.3g}", fontsize="medium")
        axis.set_rmax(1.1 * reach)
        axis.set_xticklabels([])
        axis.set_yticklabels([])
    for axis in grid.ravel()[len(captions) :]:
        axis.set_visible(False)
    figure.suptitle(title)
    return figure
