"""Pictures of loads that vary: damage by case, and how many cycles exceed a range."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lumped.plots.picture import Axis, Bars, Curve, Item, Panel, Picture, Words, label_axis
from lumped.plots.style import COLOURS, INK, Look, look

_BAR = 0.35  # inch for each


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
    sizes = np.array([100 * share for _, share in shares])
    items: list[Item] = [Bars(np.arange(len(sizes)), sizes, COLOURS["blue"], lying=True)]
    items += [Words(size, i, f"{size:.1f} %", 1) for i, size in enumerate(sizes.tolist())]
    names = tuple(name for name, _ in shares)
    x = Axis("share of the damage, %", low=0.0, high=1.2 * max(float(sizes.max()), 1.0))
    y = Axis(names=names, down=True, low=-0.6, high=len(names) - 0.4)
    damage = Panel(tuple(items), x, y, height=0.4 + _BAR * max(len(names), 2))
    curves = []
    for i, (name, (ranges, counts)) in enumerate(spectra.items()):
        line = look(i - 1) if i else Look(INK, width=2.0)
        curves.append(Curve(*_count_exceedances(ranges, counts), name, line))
    exceeded = Axis("cycles of a duty cycle with a larger range", log=True)
    spectrum = Panel(tuple(curves), exceeded, Axis(label_axis("range", unit), low=0.0), height=3.0)
    return Picture(title, (damage, spectrum))


def _count_exceedances(ranges: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Steps of the number of cycles that have at least a range, over which it is drawn."""
    order = np.argsort(-ranges, kind="stable")
    number = np.cumsum(counts[order])
    y = ranges[order]
    first = number[:1] if len(number) else np.zeros(0)
    x = np.repeat(np.concatenate([0.5 * first, number]), 2)[1:-1] if len(number) else first
    return x, np.repeat(y, 2)
