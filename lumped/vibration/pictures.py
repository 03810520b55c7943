"""Pictures of vibrations; each function returns a matplotlib Figure that needs no display."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lumped.support.display_units import Shown

__all__ = [
    "campbell",
    "frequency_response",
    "holzer",
    "mode_shapes",
    "order_response",
    "order_tracks",
    "phase_diagrams",
    "root_locus",
]

_WIDTH = 8.0  # inch
_LINES = ("-", "--", ":", "-.")  # after ten colours
_FONT, _LINE, _LETTER = 8.0, 1.3, 0.62  # points; height of a line and width of a letter over it
_AWAY = 0.03  # of the axes
_RAYS = ("C1", "C2", "C4", "C5", "C6", "C8", "C9")  # red and blue are points and frequencies


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
    frequency: Shown,
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
    frequency : Shown
        How frequencies are shown.
    """
    x = frequency.value(hertz)
    figure = Figure((_WIDTH, 0.6 + 3.6 * len(outputs)), layout="constrained")
    count = 2 * len(outputs)
    axes = figure.subplots(count, sharex=True, height_ratios=[2, 1] * len(outputs))
    for size, angle, (output, (unit, inputs)) in zip(
        axes[::2], axes[1::2], outputs.items(), strict=True
    ):
        for i, (given, (magnitude, phase)) in enumerate(inputs.items()):
            line, colour = _LINES[i // 10 % len(_LINES)], f"C{i % 10}"
            size.plot(x, magnitude, line, color=colour, label=given)
            angle.plot(x, np.degrees(phase), line, color=colour)
        size.set_yscale("log")
        size.set_title(output, fontsize="medium")
        size.set_ylabel(f"{unit} for each unit")
        size.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
        angle.set_ylabel("phase, deg")
        for axis in (size, angle):
            axis.grid(alpha=0.3)
    axes[-1].set_xlabel(f"frequency, {frequency.unit}")
    axes[-1].set_xlim(x[0], x[-1])
    figure.suptitle(title)
    return figure


def campbell(
    title: str,
    speeds: np.ndarray,
    hertz: np.ndarray,
    orders: Sequence[tuple[str, float]],
    critical: Sequence[tuple[float, float]],
    between: tuple[float, float] | None,
    barred: Sequence[tuple[float, float]],
    units: tuple[Shown, Shown],
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
    orders : sequence of (str, float)
        Labels, empty where there is none, and orders of excitation.
    critical : sequence of (float, float)
        Speed, rad/s, and frequency, Hz, of each intersection.
    between : (float, float) or None
        Range of operation, rad/s.
    barred : sequence of (float, float)
        Ranges of speeds that are barred, rad/s.
    units : (Shown, Shown)
        How speeds and frequencies are shown.
    """
    speed, frequency = units
    x, y = speed.value(speeds), frequency.value(hertz)
    rays = [
        (label, order, frequency.value(order * speeds / (2 * np.pi))) for label, order in orders
    ]
    top = 1.15 * (np.nanmax(y, initial=0.0) or max(ray[-1] for *_, ray in rays))
    right = sum(ray[-1] <= top for *_, ray in rays)
    figure = Figure((_WIDTH, max(5.0, 2.0 + right * _LINE * _FONT / 72)), layout="constrained")
    axis = figure.subplots()
    axis.plot(x, y, color="C0")
    named = 0
    for label, order, ray in rays:
        look: dict[str, Any] = {"color": "grey", "linewidth": 0.8}
        if label:
            look = {"color": _RAYS[named % len(_RAYS)], "label": f"{order:g}: {label}"}
            named += 1
        axis.plot(x, ray, **look)
    places = np.array(critical).reshape(-1, 2)
    axis.plot(speed.value(places[:, 0]), frequency.value(places[:, 1]), "o", color="C3")
    plain: dict[str, Any] = {"color": "C2", "alpha": 0.15}
    shaded = {"facecolor": "none", "edgecolor": "C3", "hatch": "///", "alpha": 0.5}
    ranges = [(between, "range of operation", plain)] if between else []
    ranges += [(each, "barred", shaded) for each in barred]
    for (begin, end), label, look in ranges:
        told = label in axis.get_legend_handles_labels()[1]
        axis.axvspan(
            speed.value(begin), speed.value(end), zorder=0, label=None if told else label, **look
        )
    if ranges or named:
        figure.legend(loc="outside lower center", ncols=2, frameon=False)
    axis.set_ylim(0, top)
    axis.set_xlim(x[0], x[-1])
    _label_rays(
        axis, [(order, *ray[[0, -1]]) for _, order, ray in rays], figure.get_figheight() - 1.8
    )
    axis.set_xlabel(f"speed, {speed.unit}")
    axis.set_ylabel(f"frequency, {frequency.unit}")
    axis.grid(alpha=0.3)
    figure.suptitle(title)
    return figure


def _label_rays(axis: Axes, rays: Sequence[tuple[float, float, float]], height: float) -> None:
    """Orders where their rays leave the axes, to the right or above, moved apart where they meet.

    A ray is its order and its heights at both ends. The axes are at least so many inches high.
    """
    _, top = axis.get_ylim()
    right, above = [], []
    for text, (begin, end) in {f"{order:g}": ends for order, *ends in rays}.items():
        if end <= top:
            right.append((end / top, text))
        elif begin < top:
            above.append(((top - begin) / (end - begin), text))
    upright = max((len(text) for _, text in above), default=0) > 4
    for labels, length, aside in ((right, height, True), (above, _WIDTH - 2.0, False)):
        labels.sort()
        lines = [_LINE if aside or upright else _LETTER * len(t) + 0.8 for _, t in labels]
        room = length * 72 / _FONT
        small = min(1.0, room / max(sum(lines), 1.0))
        places = _apart([place for place, _ in labels], [small * each / room for each in lines])
        for (place, text), moved in zip(labels, places.tolist(), strict=True):
            axis.annotate(
                text,
                xy=(1, place) if aside else (place, 1),
                xytext=(1 + _AWAY, moved) if aside else (moved, 1 + 1.6 * _AWAY),
                xycoords="axes fraction",
                color="dimgrey",
                fontsize=small * _FONT,
                rotation=90 if upright and not aside else 0,
                ha="left" if aside else "center",
                va="center" if aside else "bottom",
                arrowprops={"arrowstyle": "-", "color": "grey", "lw": 0.5, "shrinkA": 0},
                annotation_clip=False,
            )


def _apart(wanted: Sequence[float], gaps: Sequence[float]) -> np.ndarray:
    """Ascending places nearest to the wanted ones, within 0 and 1, without touching.

    Least squares under a least distance between neighbours: isotonic regression, by pooling.
    """
    width = np.asarray(gaps)
    offset = np.cumsum(width) - width / 2
    pools: list[tuple[float, int]] = []
    for value in (np.asarray(wanted) - offset).tolist():
        mean, count = value, 1
        while pools and pools[-1][0] > mean:
            other, members = pools.pop()
            mean, count = (mean * count + other * members) / (count + members), count + members
        pools.append((mean, count))
    level = np.repeat([mean for mean, _ in pools], [count for _, count in pools])
    found: np.ndarray = np.clip(level, 0.0, max(1.0 - width.sum(), 0.0)) + offset
    return found


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


def order_response(
    title: str,
    speeds: np.ndarray,
    outputs: Mapping[str, tuple[str, Mapping[str, np.ndarray]]],
    speed: Shown,
) -> Figure:
    """Amplitudes over the speed, one panel for each output.

    Parameters
    ----------
    title : str
        Title of the figure.
    speeds : ndarray, shape (k,)
        Speeds, rad/s.
    outputs : mapping of str to (str, mapping of str to ndarray of shape (k,))
        Unit of each output, and its curves by their labels; the last one stands out.
    speed : Shown
        How speeds are shown.
    """
    x = speed.value(speeds)
    figure = Figure((_WIDTH, 0.6 + 2.6 * len(outputs)), layout="constrained")
    axes = np.atleast_1d(figure.subplots(len(outputs), sharex=True))
    for axis, (output, (unit, curves)) in zip(axes, outputs.items(), strict=True):
        for i, (label, size) in enumerate(curves.items()):
            last = i == len(curves) - 1
            colour = "black" if last else f"C{i % 10}"
            axis.plot(x, size, color=colour, linewidth=1.6 if last else 1.1, label=label)
        axis.set_title(output, fontsize="medium")
        axis.set_ylabel(f"amplitude, {unit}")
        axis.set_ylim(bottom=0)
        axis.grid(alpha=0.3)
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    axes[-1].set_xlabel(f"speed, {speed.unit}")
    axes[-1].set_xlim(x[0], x[-1])
    figure.suptitle(title)
    return figure


def holzer(
    title: str,
    inertias: Sequence[tuple[str, int, float]],
    shafts: Sequence[tuple[str, tuple[int, int], float]],
    ends: Mapping[int, float],
    unit: str,
) -> Figure:
    """Angles of the inertias, joined by the shafts, above the torques in the shafts.

    Parameters
    ----------
    title : str
        Title of the figure.
    inertias : sequence of (str, int, float)
        Name, station and angle, rad, of one at each station.
    shafts : sequence of (str, (int, int), float)
        Name, stations and torque of each; station -1 is the ground.
    ends : mapping of int to float
        Angle of each station, in the order along the drive.
    unit : str
        Unit of the torques.
    """
    figure = Figure((_WIDTH, 6.4), layout="constrained")
    angles, torques = figure.subplots(2)
    place = {station: i for i, station in enumerate(ends)}
    angles.axhline(0, color="black", linewidth=0.8)
    for _, (a, b), _ in shafts:
        free = a if a >= 0 else b
        if min(a, b) < 0:
            angles.plot([place[free]] * 2, [ends[free], 0], ":", color="grey")
        else:
            angles.plot([place[a], place[b]], [ends[a], ends[b]], color="C0")
    angles.plot([place[s] for _, s, _ in inertias], [q for *_, q in inertias], "o", color="C0")
    names = {station: name for name, station, _ in inertias}
    _name_parts(angles, [names.get(station, "-") for station in ends])
    angles.set(ylabel="relative angle", ylim=(-1.15, 1.15))
    torques.bar(range(len(shafts)), [torque for *_, torque in shafts], color="C1", width=0.6)
    torques.axhline(0, color="black", linewidth=0.8)
    _name_parts(torques, [name for name, *_ in shafts])
    torques.set(ylabel=f"torque in the shafts, {unit}", xlim=(-0.6, len(shafts) - 0.4))
    figure.suptitle(title)
    return figure


def _name_parts(axis: Axes, names: Sequence[str]) -> None:
    axis.set_xticks(range(len(names)), names)
    steep = len(names) * max(map(len, names)) > 60
    axis.tick_params(axis="x", labelrotation=30 if steep and len(names) <= 10 else 90 * steep)
    if steep:
        for label in axis.get_xticklabels():
            label.set(ha="right", rotation_mode="anchor")
    axis.grid(alpha=0.3)


def order_tracks(
    title: str,
    speeds: np.ndarray,
    orders: np.ndarray,
    size: np.ndarray,
    tracks: Mapping[str, np.ndarray],
    unit: str,
    speed: Shown,
) -> Figure:
    """Amplitudes over speed and order as a colour map, above those of some orders as curves.

    Parameters
    ----------
    title : str
        Title of the figure.
    speeds : ndarray, shape (k,)
        Speed of each window, rad/s.
    orders : ndarray, shape (o,)
        Periods for each turn.
    size : ndarray, shape (k, o)
        Amplitudes.
    tracks : mapping of str to ndarray of shape (k,)
        Amplitudes of single orders by their labels.
    unit : str
        Unit of the amplitudes.
    speed : Shown
        How speeds are shown.
    """
    x = speed.value(speeds)
    figure = Figure((_WIDTH, 6.4), layout="constrained")
    plane, curves = figure.subplots(2, sharex=True, height_ratios=[3, 2])
    mesh = plane.pcolormesh(x, orders, size.T, shading="nearest", cmap="viridis")
    figure.colorbar(mesh, ax=plane, label=f"amplitude, {unit}")
    plane.set_ylabel("order")
    for i, (label, values) in enumerate(tracks.items()):
        curves.plot(x, values, _LINES[i // 10 % len(_LINES)], color=f"C{i % 10}", label=label)
    curves.set(xlabel=f"speed, {speed.unit}", ylabel=f"amplitude, {unit}", xlim=(x[0], x[-1]))
    curves.set_ylim(bottom=0)
    curves.grid(alpha=0.3)
    figure.legend(loc="outside lower center", ncols=5, frameon=False)
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
