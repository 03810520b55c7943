"""Pictures of a reliability: what makes a limit exceeded, and how likely values are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lumped.plots.picture import Axis, Bars, Curve, Item, Level, Panel, Picture, Words
from lumped.plots.style import COLOURS, MARKS, ZERO, Look

_MOST_BARS = 12
_BAR = 0.35  # inch for each


def importance_factors(title: str, factors: Sequence[tuple[str, float]]) -> Picture:
    """Shares of parameters in what leads to a limit, the largest on top.

    Parameters
    ----------
    title : str
        Title of the picture.
    factors : sequence of (str, float)
        Names and shares, the largest first; negative where a smaller value leads to the limit.
    """
    most = factors[:_MOST_BARS]
    items: list[Item] = []
    for sign, colour, label in ((1, "blue", "larger"), (-1, "vermilion", "smaller")):
        rows = [i for i, (_, share) in enumerate(most) if share * sign > 0]
        if rows:
            sizes = 100 * np.abs([most[i][1] for i in rows])
            text = f"{label} than at the median"
            items.append(Bars(np.array(rows), sizes, COLOURS[colour], text, lying=True))
    items += [
        Words(100 * abs(share), i, f"{abs(share):.1%}", 1) for i, (_, share) in enumerate(most)
    ]
    reach = 100 * max(abs(share) for _, share in most)
    x = Axis("importance factor, %", low=0.0, high=1.15 * reach)
    y = Axis(names=tuple(name for name, _ in most), down=True, low=-0.6, high=len(most) - 0.4)
    left = len(factors) - len(most)
    note = f"{left} more with less importance" if left else ""
    panel = Panel(tuple(items), x, y, height=0.4 + _BAR * max(len(most), 2))
    return Picture(title, (panel,), below=True, note=note)


def exceedance(
    title: str, what: str, levels: tuple[np.ndarray, np.ndarray], limit: float
) -> Picture:
    """Probability over the value that is passed with it, level by level.

    Parameters
    ----------
    title, what : str
        Title of the picture; the quantity with its unit.
    levels : tuple of ndarray, each of shape (k,)
        Values and probabilities.
    limit : float
        Value of the limit.
    """
    line = Look(COLOURS["blue"], mark=MARKS[3])
    wall = Look(COLOURS["vermilion"], "dashed")
    items: list[Item] = [
        Curve(*levels, "levels", line),
        Level(limit, upright=True, label=f"limit {limit:.4g}", look=wall),
        Level(1.0, look=ZERO),
    ]
    y = Axis("probability", log=True)
    return Picture(title, (Panel(tuple(items), Axis(what), y, height=3.0),))
