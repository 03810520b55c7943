"""The Campbell diagram as a picture, with labels of the rays that do not touch each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import scipy

from lumped.plots.picture import Axis, Band, Curve, Item, Panel, Picture, Tag, label_axis
from lumped.plots.style import COLOURS, GREY, LETTER, SMALL, WIDTH, Look
from lumped.support.display_units import Shown

_LINE = 1.3  # height of a line over the size of its letters
_ABOVE = 1.15  # end of the axis over what it shows
_RAYS = ("orange", "purple", "sky", "green")  # blue and vermilion are frequencies and points


def campbell_picture(
    title: str,
    speeds: np.ndarray,
    hertz: np.ndarray,
    orders: Sequence[tuple[str, float]],
    critical: Sequence[tuple[float, float]],
    between: tuple[float, float] | None,
    barred: Sequence[tuple[float, float]],
    shown: tuple[Shown, Shown],
) -> Picture:
    """Natural frequencies over the speed, rays of the orders, and points where they meet.

    Parameters
    ----------
    title : str
        Title of the picture.
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
    shown : (Shown, Shown)
        How speeds and frequencies are shown.
    """
    speed, frequency = shown
    x = speed.value(speeds)
    rays = [
        (label, order, frequency.value(order * speeds / (2 * np.pi))) for label, order in orders
    ]
    curves = frequency.value(hertz)
    top = _find_top(curves, np.max([y for *_, y in rays], axis=0))
    items: list[Item] = []
    for (begin, end), colour, label in [
        *([(between, "green", "range of operation")] if between else []),
        *((each, "vermilion", "barred") for each in barred),
    ]:
        ends = speed.value(begin), speed.value(end)
        items.append(Band(*ends, COLOURS[colour], label, hatched=label == "barred"))
    for i in range(hertz.shape[1]):
        label = "" if i else "natural frequencies"
        items.append(Curve(x, curves[:, i], label, Look(COLOURS["blue"], width=1.5)))
    named = 0
    for label, order, y in rays:
        ray = Look(GREY, width=0.7)
        if label:
            ray = Look(COLOURS[_RAYS[named % len(_RAYS)]], ("solid", "dashed")[named // 4 % 2])
            named += 1
        items.append(Curve(x, y, f"{order:g}: {label}" if label else "", ray))
    places = np.array(critical).reshape(-1, 2)
    mark = Look(COLOURS["vermilion"], "", mark="circle")
    label = "critical speeds" if len(places) else ""
    points = speed.value(places[:, 0]), frequency.value(places[:, 1])
    items.append(Curve(*points, label, mark))
    right = sum(y[-1] <= top for *_, y in rays)
    height = max(3.6, 0.4 + right * _LINE * SMALL / 72)
    shares = {f"{order:g}": (float(y[0]) / top, float(y[-1]) / top) for _, order, y in rays}
    items += _tags(shares, height)
    across = Axis(label_axis("speed", speed.unit), low=float(x[0]), high=float(x[-1]))
    up = Axis(label_axis("frequency", frequency.unit), low=0.0, high=top)
    return Picture(title, (Panel(tuple(items), across, up, height=height),), below=True)


def _find_top(curves: np.ndarray, highest: np.ndarray) -> float:
    """Where the axis of frequencies ends: above the modes that the highest ray nearly reaches.

    Above the lowest mode if it reaches none, and above the ray if there is no mode.
    """
    reached = (curves <= _ABOVE * highest[:, None]).any(axis=0)
    shown = curves[:, reached] if reached.any() else curves[:, :1]
    return _ABOVE * float(np.nanmax(shown, initial=0.0) or highest[-1])


def _tags(ends: Mapping[str, tuple[float, float]], height: float) -> list[Tag]:
    """Orders where their rays leave the panel, to the right or above, moved apart where they meet.

    Rays begin and end at these shares of the height of the panel, which is at least so many inches.
    """
    right, above = [], []
    for text, (begin, end) in ends.items():
        if end <= 1:
            right.append((end, text))
        elif begin < 1:
            above.append(((1 - begin) / (end - begin), text))
    upright = max((len(text) for _, text in above), default=0) > 4
    found = []
    for labels, length, aside in ((right, height, True), (above, WIDTH - 2.0, False)):
        labels.sort()
        lines = [_LINE if aside or upright else LETTER * len(t) + 0.8 for _, t in labels]
        room = length * 72 / SMALL
        small = min(1.0, room / max(sum(lines), 1.0))
        moved = _apart([place for place, _ in labels], [small * each / room for each in lines])
        for (place, text), there in zip(labels, moved.tolist(), strict=True):
            found.append(Tag(text, not aside, place, there, small, upright and not aside))
    return found


def _apart(wanted: Sequence[float], gaps: Sequence[float]) -> np.ndarray:
    """Ascending places nearest to the wanted ones, within 0 and 1, without touching.

    Least squares under a least distance between neighbours, which is isotonic regression.
    """
    width = np.asarray(gaps)
    offset = np.cumsum(width) - width / 2
    level = np.asarray(wanted) - offset
    if len(level):
        level = scipy.optimize.isotonic_regression(level).x
    return np.clip(level, 0.0, max(1.0 - width.sum(), 0.0)) + offset
