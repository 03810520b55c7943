"""Panels of the figures of machines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure


def panels(
    rows: int = 1,
    columns: int = 1,
    size: tuple[float, float] = (8, 4),
    *,
    title: str = "",
    x: str = "",
    y: Sequence[str] = (),
    sharex: bool = True,
    **options: Any,
) -> tuple[Figure, Any]:
    """A figure and its axes, each with a grid.

    Parameters
    ----------
    rows, columns : int
        Number of axes; one stands alone, several are an array.
    size : (float, float)
        Width and height, inches.
    title : str
        Above the first of the axes.
    x : str
        Label of the horizontal axes, below the last row.
    y : sequence of str
        Labels of the vertical axes, row by row.
    sharex : bool
        Whether all share their horizontal scale.
    **options
        Of `Figure.subplots`.
    """
    figure = Figure(size, layout="constrained")
    axes = figure.subplots(rows, columns, sharex=sharex, **options)
    every = np.ravel(axes)
    every[0].set_title(title)
    for axis in every:
        axis.grid(alpha=0.3)
    for axis, label in zip(every, y, strict=False):
        axis.set_ylabel(label)
    for axis in every[-columns:]:
        axis.set_xlabel(x)
    return figure, axes
