"""Curves over time: which stand together in a panel, and what happened meanwhile."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from lumped.plots.picture import Axis, Curve, Instants, Panel, Picture, label_axis
from lumped.plots.style import CURVES, MARKS, look
from lumped.support.arrays import Real

_RANGE = 30.0
"""Times its own range that a curve may stand in."""
_PANELS, _LOOKED_AT = 6, 200
"""Unless quantities are named: panels, and quantities among which they are chosen."""
_NEAR = 1 / 150
"""Share of the time within which events under one label are one mark."""
_CONSTANT = 1e-9
"""Of its size: a curve with less range than that is constant."""
_ZERO = 1e-12
"""Of the largest of its unit: what is smaller shares any panel."""
_SIZES = (7.5, 6.0, 4.7, 3.5, 2.5)
"""Of marks, points: those of several labels at one instant are all seen."""

Quantity = tuple[str, str, Real]
Happening = tuple[float, str, str]


def draw_over_time(
    title: str,
    time: tuple[Real, str],
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
    time : (ndarray of shape (k,), str)
        Times, and their unit.
    quantities : mapping of str to (str, str, ndarray of shape (k,))
        Unit, text and values of each name.
    events : sequence of (float, str, str)
        Their times, what happened, and of what sort it is.
    all_of_them : bool
        Whether all are drawn, however many; else as many as can be read.
    """
    if all_of_them:
        groups = _groups(quantities)
        kept = [group[i : i + CURVES] for group in groups for i in range(0, len(group), CURVES)]
    else:
        groups = _groups(dict(itertools.islice(quantities.items(), _LOOKED_AT)))
        kept = [group[:CURVES] for group in _each_unit_first(groups, quantities)[:_PANELS]]
    left = len(quantities) - sum(map(len, kept))
    marks = _marks(events, float(time[0][-1] - time[0][0]))
    panels = tuple(_panel(time, group, quantities, marks) for group in kept)
    note = f"{left} more: choose with names" if left else ""
    return Picture(title, panels, shared=True, note=note)


def _panel(
    time: tuple[Real, str],
    group: list[str],
    quantities: Mapping[str, Quantity],
    marks: tuple[Instants, ...],
) -> Panel:
    t, t_unit = time
    unit = quantities[group[0]][0]
    texts = {quantities[name][1] for name in group}
    curves = [Curve(t, quantities[name][2], name, look(i)) for i, name in enumerate(group)]
    label = label_axis(texts.pop() if len(texts) == 1 else "", unit)
    spans = [_span(quantities[name][2]) for name in group]
    low, high = min(s[0] for s in spans), max(s[1] for s in spans)
    flat = high - low <= _CONSTANT * max(abs(low), abs(high))
    room = 0.05 * max(abs(low), abs(high)) or 1.0
    y = Axis(label, low=low - room, high=high + room) if flat else Axis(label)
    ends = (float(t[0]), float(t[-1])) if t[-1] > t[0] else (None, None)
    return Panel((*curves, *marks), Axis(label_axis("time", t_unit), low=ends[0], high=ends[1]), y)


def _span(values: Real) -> tuple[float, float]:
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if len(known) else (0.0, 0.0)


def _groups(quantities: Mapping[str, Quantity]) -> list[list[str]]:
    """Names that share a panel: one unit, and no range below a thirtieth of the panel's.

    What is constant counts with its value, zero with nothing. The two groups in which the least
    range is the greatest share of the common one are joined, as long as there are such. Panels and
    curves keep the order in which they are named.
    """
    by_unit: dict[str, list[str]] = {}
    for name, (unit, _, _) in quantities.items():
        by_unit.setdefault(unit, []).append(name)
    place = {name: i for i, name in enumerate(quantities)}
    found = []
    for names in by_unit.values():
        low, high = np.array([_span(quantities[name][2]) for name in names]).T
        size = np.maximum(np.abs(low), np.abs(high))
        least = np.where(high - low > _CONSTANT * size, high - low, size)
        least[size <= _ZERO * size.max()] = np.inf
        groups: list[list[str]] = [[name] for name in names]
        while len(groups) > 1:
            whole = np.maximum.outer(high, high) - np.minimum.outer(low, low)
            ratio = whole / np.minimum.outer(least, least)
            np.fill_diagonal(ratio, np.inf)
            a, b = sorted(np.unravel_index(int(ratio.argmin()), ratio.shape))
            if not ratio[a, b] <= _RANGE:
                break
            groups[a] += groups.pop(b)
            low[a], high[a] = min(low[a], low[b]), max(high[a], high[b])
            least[a] = min(least[a], least[b])
            low, high, least = (np.delete(each, b) for each in (low, high, least))
        found += [sorted(group, key=place.__getitem__) for group in groups]
    return sorted(found, key=lambda group: place[group[0]])


def _each_unit_first(
    groups: list[list[str]], quantities: Mapping[str, Quantity]
) -> list[list[str]]:
    """Groups, the first of each unit before the second of any."""
    seen: dict[str, int] = {}
    rank = []
    for i, group in enumerate(groups):
        unit = quantities[group[0]][0]
        seen[unit] = seen.get(unit, 0) + 1
        rank.append((seen[unit], i))
    return [groups[i] for _, i in sorted(rank)]


def _marks(events: Sequence[Happening], length: float) -> tuple[Instants, ...]:
    """A mark for each text of an event if these are few, else for each sort; near ones are one."""
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
        found.append(Instants(times, told, label + count, MARKS[i], _SIZES[i]))
    return tuple(found)
