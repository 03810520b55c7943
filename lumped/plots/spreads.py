"""Pictures of results that scatter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lumped.plots.picture import Axis, Band, Bars, Item, Level, Panel, Picture, Words, label_axis
from lumped.plots.style import COLOURS, LINES, Look

Row = tuple[
    str, np.ndarray, Sequence[tuple[float, float, float, float]], Sequence[tuple[str, float]]
]
"""Unit, values, quantiles as (q, value, low, high), and parameters with their shares."""

_MOST = 10


def spreads_picture(title: str, results: Mapping[str, Row]) -> Picture:
    """Histograms with quantiles and their intervals; beside each the shares of parameters.

    Parameters
    ----------
    title : str
        Title of the picture.
    results : mapping of str to Row
        By the labels of the functionals.
    """
    panels: list[Panel] = []
    for label, (unit, values, quantiles, ranking) in results.items():
        items: list[Item] = []
        known = values[np.isfinite(values)]
        if len(known):
            bins = min(60, max(10, int(np.sqrt(len(known)))))
            counts, edges = np.histogram(known, bins=bins, density=True)
            width = float(edges[1] - edges[0])
            items.append(Bars((edges[1:] + edges[:-1]) / 2, counts, COLOURS["sky"], width=width))
        for (q, value, low, high), dash in zip(
            quantiles, (LINES[2], LINES[0], LINES[1]), strict=False
        ):
            if np.isfinite([low, high]).all():
                items.append(Band(low, high, COLOURS["orange"]))
            told = f"{100 * q:g} %: {value:.4g}"
            look = Look(COLOURS["vermilion"], dash)
            if np.isfinite(value):
                items.append(Level(value, upright=True, label=told, look=look))
        panels.append(Panel(tuple(items), Axis(label_axis(label, unit)), Axis("density", low=0.0)))
        panels.append(_shares(ranking))
    return Picture(title, tuple(panels), columns=2)


def _shares(ranking: Sequence[tuple[str, float]]) -> Panel:
    most = [(name, share) for name, share in ranking if np.isfinite(share)][:_MOST]
    sizes = np.array([100 * share for _, share in most])
    items: list[Item] = [Bars(np.arange(len(most)), sizes, COLOURS["blue"], lying=True)]
    items += [Words(size, i, f"{size:.3g} %", 1) for i, size in enumerate(sizes.tolist())]
    high = 1.3 * float(sizes.max(initial=1.0))
    x = Axis("share of the variance, each alone, %", low=0.0, high=high)
    names = tuple(name for name, _ in most)
    return Panel(tuple(items), x, Axis(names=names, down=True, low=-0.6, high=len(most) - 0.4))
