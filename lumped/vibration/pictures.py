"""Pictures of vibrations, described as data; the Campbell diagram has a module of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lumped.plots.picture import (
    Axis,
    Bars,
    Curve,
    HeatMap,
    Item,
    Level,
    Panel,
    Picture,
    Words,
    label_axis,
)
from lumped.plots.style import COLOURS, GREY, INK, LETTER, SMALL, ZERO, Look, look
from lumped.support.display_units import Shown

_LINKS = Look(GREY, "dotted")
_ROUND = 1.9
"""Height of a phase diagram, inch; its radius is 1 / 2.4 of it."""
_WIDE, _HIGH = (2.4 * points / (72 * _ROUND) for points in (LETTER * SMALL, 1.2 * SMALL))
"""A small letter, relative to that radius."""
_STEPS = (15.0, 30.0, 45.0, 90.0, 180.0, 360.0, 720.0)


def mode_shapes_picture(
    title: str, names: Sequence[str], shapes: np.ndarray, captions: Sequence[str], note: str
) -> Picture:
    """Amplitudes along the drive, one panel for each mode.

    Where modes are damped the parts do not pass zero together; dashed lines then show what moves
    a quarter of a period apart.

    Parameters
    ----------
    title : str
        Title of the picture.
    names : sequence of str
        Quantities in their order along the drive.
    shapes : complex ndarray, shape (len(names), modes)
        Their amplitudes.
    captions : sequence of str
        What stands above each panel.
    note : str
        Which modes are left out.
    """
    place = np.arange(len(names))
    damped = np.abs(shapes.imag).max() > 1e-6
    drawn = []
    for caption, shape in zip(captions, shapes.T, strict=True):
        items: list[Item] = [Level(0.0, look=ZERO)]
        label = "in phase" if damped else ""
        items.append(Curve(place, shape.real, label, Look(mark="circle")))
        if damped:
            apart = Look(COLOURS["vermilion"], "dashed", 1.0, "square", 3.0)
            items.append(Curve(place, shape.imag, "a quarter of a period apart", apart))
        x, y = Axis(names=tuple(names)), Axis("relative amplitude", low=-1.15, high=1.15)
        drawn.append(Panel(tuple(items), x, y, caption, height=1.6))
    columns = 1 if len(captions) <= 4 else 2
    return Picture(title, tuple(drawn), columns, shared=True, below=True, note=note)


def frequency_response_picture(
    title: str,
    hertz: np.ndarray,
    outputs: Mapping[tuple[str, str], Mapping[str, tuple[np.ndarray, np.ndarray]]],
    frequency: Shown,
    *,
    decibels: bool,
) -> Picture:
    """Magnitude and phase over the frequency, one pair of panels for each output and unit.

    Frequencies of more than a decade stand on a logarithmic axis. Phases go on without jumps from
    where they begin, within -180 and 180 deg.

    Parameters
    ----------
    title : str
        Title of the picture.
    hertz : ndarray, shape (k,)
        Frequencies, Hz.
    outputs : mapping of (str, str) to mapping of str to two ndarrays of shape (k,)
        For each output and unit of its responses: magnitude and phase (rad) by the inputs.
    frequency : Shown
        How frequencies are shown.
    decibels : bool
        Whether magnitudes are in dB, else as they are on a logarithmic axis.
    """
    f = frequency.value(hertz)
    low, high = float(f[0]), float(f[-1])
    log = high > 10 * max(low, f[min(1, len(f) - 1)]) > 0
    first = low if low > 0 or not log else float(f[1])
    ends = (first, high) if high > first else (None, None)
    x = Axis(label_axis("frequency", frequency.unit), log, *ends)
    panels = []
    for (output, unit), inputs in outputs.items():
        sizes: list[Item] = []
        angles: list[Item] = []
        span = 0.0
        for i, (given, (magnitude, phase)) in enumerate(inputs.items()):
            size = np.where(magnitude > 0, magnitude, np.nan)
            sizes.append(Curve(f, 20 * np.log10(size) if decibels else size, given, look(i)))
            degrees = _phase(phase)
            angles.append(Curve(f, degrees, "", look(i)))
            span = max(span, float(np.ptp(degrees)))
        told = label_axis("magnitude", unit)
        label = (f"magnitude, dB of {unit}" if unit else "magnitude, dB") if decibels else told
        y = Axis(label, log=not decibels)
        step = next((step for step in _STEPS if span <= 4.5 * step), None)
        panels.append(Panel(tuple(sizes), x, y, output, height=2.2))
        panels.append(Panel(tuple(angles), x, Axis("phase, deg", step=step), height=1.3))
    return Picture(title, tuple(panels), shared=True)


def _phase(phase: np.ndarray) -> np.ndarray:
    """Degrees without jumps that begin between -180, included but for rounding, and 180."""
    degrees = np.degrees(np.unwrap(phase))
    degrees -= 360 * np.floor((degrees[0] + 180 + 1e-6) / 360)
    return np.asarray(degrees)


def root_locus_picture(title: str, eigenvalues: np.ndarray, frequency: Shown) -> Picture:
    """Eigenvalues in the complex plane, upper half; a circle marks the first value, a dot the last.

    Parameters
    ----------
    title : str
        Title of the picture.
    eigenvalues : complex ndarray, shape (k, n)
        Eigenvalues along the locus, 1/s.
    frequency : Shown
        How frequencies are shown.
    """
    items: list[Item] = [Level(0.0, upright=True, look=ZERO)]
    hertz = frequency.factor * eigenvalues / (2 * np.pi)
    upper = (eigenvalues.imag > 0).any(axis=0)
    for i, column in enumerate(np.flatnonzero(upper).tolist()):
        path = np.where(hertz[:, column].imag >= 0, hertz[:, column], np.nan)
        items.append(Curve(path.real, path.imag, look=look(i)))
        for k, hollow in ((0, True), (-1, False)):
            end = look(i, dash="", mark="circle", hollow=hollow)
            items.append(Curve(path.real[[k]], path.imag[[k]], look=end))
    x, y = (Axis(label_axis(f"{of} part / (2 pi)", frequency.unit)) for of in ("real", "imaginary"))
    return Picture(title, (Panel(tuple(items), x, y, height=4.0),))


def order_response_picture(
    title: str,
    speeds: np.ndarray,
    outputs: Mapping[str, tuple[str, Mapping[str, np.ndarray]]],
    speed: Shown,
    note: str,
) -> Picture:
    """Amplitudes over the speed, one panel for each output.

    Parameters
    ----------
    title : str
        Title of the picture.
    speeds : ndarray, shape (k,)
        Speeds, rad/s.
    outputs : mapping of str to (str, mapping of str to ndarray of shape (k,))
        Unit of each output, and its curves by their labels; the last one stands out.
    speed : Shown
        How speeds are shown.
    note : str
        Which orders are left out.
    """
    across, x = speed.value(speeds), _over_speed(speeds, speed)
    panels = []
    for output, (unit, curves) in outputs.items():
        last = len(curves) - 1
        items = [
            Curve(across, size, label, Look(INK, width=1.8) if 0 < i == last else look(i))
            for i, (label, size) in enumerate(curves.items())
        ]
        panels.append(Panel(tuple(items), x, Axis(label_axis("amplitude", unit), low=0.0), output))
    return Picture(title, tuple(panels), shared=True, note=note)


def _over_speed(speeds: np.ndarray, speed: Shown) -> Axis:
    values = speed.value(speeds)
    ends = (float(values.min()), float(values.max())) if len(values) > 1 else (None, None)
    return Axis(label_axis("speed", speed.unit), low=ends[0], high=ends[1])


def holzer_picture(
    title: str,
    inertias: Sequence[tuple[str, int, float]],
    shafts: Sequence[tuple[str, tuple[int, int], float]],
    ends: Mapping[int, float],
    unit: str,
) -> Picture:
    """Angles of the inertias, joined by the shafts, above the torques in the shafts.

    Parameters
    ----------
    title : str
        Title of the picture.
    inertias : sequence of (str, int, float)
        Name, station and relative angle of one at each station.
    shafts : sequence of (str, (int, int), float)
        Name, stations and torque of each; station -1 is the ground.
    ends : mapping of int to float
        Relative angle of each station, in the order along the drive.
    unit : str
        Unit of the torques.
    """
    place = {station: i for i, station in enumerate(ends)}
    angles: list[Item] = [Level(0.0, look=ZERO)]
    for _, (a, b), _ in shafts:
        free = a if a >= 0 else b
        x, y, line = (a, b), (ends.get(a), ends.get(b)), Look()
        if min(a, b) < 0:
            x, y, line = (free, free), (ends[free], 0.0), _LINKS
        angles.append(Curve(np.array([place[s] for s in x]), np.array(y, dtype=float), look=line))
    at = np.array([place[station] for _, station, _ in inertias])
    sizes = np.array([angle for *_, angle in inertias])
    angles.append(Curve(at, sizes, look=Look(dash="", mark="circle")))
    names = {station: name for name, station, _ in inertias}
    told = tuple(names.get(station, "-") for station in ends)
    torque = np.array([torque for *_, torque in shafts])
    bars = Bars(np.arange(len(shafts)), torque, COLOURS["orange"], width=0.6)
    return Picture(
        title,
        (
            Panel(tuple(angles), Axis(names=told), Axis("relative angle", low=-1.15, high=1.15)),
            Panel(
                (bars, Level(0.0, look=ZERO)),
                Axis(names=tuple(name for name, *_ in shafts), low=-0.6, high=len(shafts) - 0.4),
                Axis(label_axis("torque in the shafts", unit)),
            ),
        ),
    )


def order_tracks_picture(
    title: str,
    speeds: np.ndarray,
    orders: np.ndarray,
    size: np.ndarray,
    tracks: Mapping[str, np.ndarray],
    unit: str,
    speed: Shown,
) -> Picture:
    """Amplitudes over speed and order as a colour map, above those of some orders as curves.

    Parameters
    ----------
    title : str
        Title of the picture.
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
    label = label_axis("amplitude", unit)
    across, x = speed.value(speeds), _over_speed(speeds, speed)
    curves = [Curve(across, y, name, look(i)) for i, (name, y) in enumerate(tracks.items())]
    plane = Panel((HeatMap(across, orders, size, label),), x, Axis("order"), height=3.0)
    below = Panel(tuple(curves), x, Axis(label, low=0.0))
    return Picture(title, (plane, below), shared=True, below=True)


def phase_diagrams_picture(
    title: str, labels: Sequence[str], vectors: np.ndarray, captions: Sequence[str]
) -> Picture:
    """Vectors from one centre and their sum, one panel for each row.

    Parameters
    ----------
    title : str
        Title of the picture.
    labels : sequence of str, shape (c,)
        What each vector is.
    vectors : complex ndarray, shape (len(captions), c)
        The vectors.
    captions : sequence of str
        What stands above each panel.
    """
    circle = np.exp(2j * np.pi * np.linspace(0.0, 1.0, 91))
    panels = []
    for row, caption in zip(vectors, captions, strict=True):
        whole = complex(row.sum())
        reach = max(float(np.abs(row).max()), abs(whole), 1e-300)
        items: list[Item] = [
            Curve(
                share * reach * circle.real,
                share * reach * circle.imag,
                look=Look(GREY, "dotted", 0.6),
            )
            for share in (0.5, 1.0)
        ]
        for i, vector in enumerate(row):
            told = "" if i else "vectors"
            items.append(Curve(np.array([0, vector.real]), np.array([0, vector.imag]), told))
        bold = Look(INK, width=2.2)
        items.append(Curve(np.array([0, whole.real]), np.array([0, whole.imag]), "sum", bold))
        for end, text in _merge_labels(row / reach, labels):
            items.append(Words(reach * end.real, reach * end.imag, text))
        bare = Axis(low=-1.2 * reach, high=1.2 * reach, bare=True)
        text = f"{caption}: {abs(whole):.3g}"
        panels.append(Panel(tuple(items), bare, bare, text, height=_ROUND, square=True))
    return Picture(title, tuple(panels), min(len(captions), 4), below=True)


def _merge_labels(ends: np.ndarray, labels: Sequence[str]) -> list[tuple[complex, str]]:
    """Where labels stand at the ends of vectors; those that would touch become one text."""
    found: list[tuple[complex, str]] = []
    for end, label in zip(ends.tolist(), labels, strict=True):
        here, text = end, label
        touching = True
        while touching:
            touching = False
            for k, (there, other) in enumerate(found):
                apart = here - there
                wide = _WIDE * (len(text) + len(other) + 1) / 2
                if abs(apart.real) < wide and abs(apart.imag) < _HIGH:
                    here, text, touching = there, f"{other}, {text}", True
                    del found[k]
                    break
        found.append((here, text))
    return found
