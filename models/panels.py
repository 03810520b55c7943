"""Panels of the figures of machines."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

__all__ = ["panels"]


def panels(
    rows: int = 1,
    columns: int = 1,
    size: tuple[float, float] = (8, 4),
    *,
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
    sharex : bool
        Whether all share their horizontal scale.
    **options
        Of `Figure.subplots`.
    """
    figure = Figure(size, layout="constrained")
    axes = figure.subplots(rows, columns, sharex=sharex, **options)
    for axis in np.ravel(axes):
        axis.grid(alpha=0.3)
    return figure, axes
