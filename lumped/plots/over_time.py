"""Curves over time: which stand together in a panel, and what happened meanwhile."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lumped.plots.picture import Axis, Curve, Instants, Panel, Picture, Real, labelled
from lumped.plots.style import CURVES, MARKS, look

__all__ = ["over_time"]

_RANGE = 30.0
"""Times its own range that a curve may stand in."""
_PANELS = 6
"""Unless quantities are named."""
_NEAR = 1 / 150
"""Share of the time within which events of one kind are one mark."""
_CONSTANT = 1e-9
"""Of its size: a curve with less range than that is constant."""

Quantity = tuple[str, str, Real]
Happening = tuple[float, str, str]


def over_time(
    title: str,
    t: Real,
    quantities: Mapping[str, Quantity],
    events: Sequence[Happening],
    *,
    all_of_them: bool,
) -> Picture:
    """Curves over time; quantities of one unit and of similar range share a panel.

    Parameters
    ----------
    title : str
        Title of the picture.
    t : ndarray, shape (k,)
        Times, s.
    quantities : mapping of str to (str, str, ndarray of shape (k,))
        Unit, text and values of each name.
    events : sequence of (float, str, str)
        Their times, s, what happened, and where, or of what sort it is.
    all_of_them : bool
        Whether all are drawn, however many; else as many as can be read.
    """
    groups = _groups(quantities)
    most = len(quantities) if all_of_them else _PANELS
    kept = groups[:most] if all_of_them else [group[:CURVES] for group in groups[:most]]
    if all_of_them:
        kept = [group[i : i + CURVES] for group in kept for i in range(0, len(group), CURVES)]
    left = len(quantities) - sum(map(len, kept))
    marks = _marks(events, float(t[-1] - t[0]))
    panels = tuple(_panel(t, group, quantities, marks) for group in kept)
    note = f"{left} more: choose with names" if left else ""
    return Picture(title, panels, shared=True, note=note)


def _panel(
    t: Real, group: list[str], quantities: Mapping[str, Quantity], marks: tuple[Instants, ...]
) -> Panel:
    unit = quantities[group[0]][0]
    texts = {quantities[name][1] for name in group}
    curves = [Curve(t, quantities[name][2], name, look(i)) for i, name in enumerate(group)]
    label = labelled(texts.pop() if len(texts) == 1 else "", unit)
    spans = [_span(quantities[name][2]) for name in group]
    low, high = min(s[0] for s in spans), max(s[1] for s in spans)
    flat = high - low <= _CONSTANT * max(abs(low), abs(high))
    room = 0.05 * max(abs(low), abs(high)) or 1.0
    y = Axis(label, low=low - room, high=high + room) if flat else Axis(label)
    ends = (float(t[0]), float(t[-1])) if t[-1] > t[0] else (None, None)
    return Panel((*curves, *marks), Axis("time, s", low=ends[0], high=ends[1]), y)


def _span(values: Real) -> tuple[float, float]:
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if len(known) else (0.0, 0.0)


def _groups(quantities: Mapping[str, Quantity]) -> list[list[str]]:
    """Names that share a panel: one unit, and no range below a thirtieth of the panel's.

    What is constant counts with its value, zero with nothing. The widest come first, so that each
    joins those that are most like it; panels and curves keep the order in which they are named.
    """
    spans = {name: _span(values) for name, (_, _, values) in quantities.items()}

    def least(name: str) -> float:
        low, high = spans[name]
        size = max(abs(low), abs(high))
        if not size:
            return np.inf
        return high - low if high - low > _CONSTANT * size else size

    found: list[list[str]] = []
    for name in sorted(quantities, key=lambda n: -min(least(n), 1e300)):
        for group in found:
            members = [*group, name]
            whole = max(spans[m][1] for m in members) - min(spans[m][0] for m in members)
            alike = quantities[name][0] == quantities[group[0]][0]
            if alike and whole <= _RANGE * min(map(least, members)):
                group.append(name)
                break
        else:
            found.append([name])
    place = {name: i for i, name in enumerate(quantities)}
    return sorted((sorted(g, key=place.__getitem__) for g in found), key=lambda g: place[g[0]])


def _marks(events: Sequence[Happening], length: float) -> tuple[Instants, ...]:
    """A mark for each kind of event if these are few, else for each sort; near ones are one."""
    by_text: dict[str, list[Happening]] = {}
    by_sort: dict[str, list[Happening]] = {}
    for event in events:
        by_text.setdefault(event[1], []).append(event)
        by_sort.setdefault(event[2], []).append(event)
    found = []
    few = len(by_text) <= len(MARKS)
    for i, (label, members) in enumerate((by_text if few else by_sort).items()):
        kept: list[Happening] = []
        for event in sorted(members):
            if not kept or event[0] - kept[-1][0] > _NEAR * length:
                kept.append(event)
        count = f" ({len(members)}, {len(kept)} marked)" if len(kept) < len(members) else ""
        times = np.array([time for time, _, _ in kept])
        told = tuple(text for _, text, _ in kept)
        found.append(Instants(times, told, label + count, MARKS[i % len(MARKS)]))
    return tuple(found)
