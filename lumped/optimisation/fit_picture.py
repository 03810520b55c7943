"""Picture of measured and fitted curves; it returns a matplotlib Figure that needs no display."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from lumped.support.display_units import Shown

__all__ = ["fit_picture"]

_WIDTH = 8.0  # inch


def fit_picture(
    title: str,
    t: np.ndarray,
    run_t: np.ndarray,
    channels: Mapping[str, tuple[str, np.ndarray, np.ndarray, np.ndarray]],
    time: Shown,
) -> Figure:
    """Measured points and the fitted curve, and below them what is left, for each channel.

    Parameters
    ----------
    title : str
        Title of the figure.
    t : ndarray, shape (n,)
        Instants of the measurement, s.
    run_t : ndarray, shape (k,)
        Instants of the fitted run, s.
    channels : mapping of str to (str, ndarray (n,), ndarray (k,), ndarray (n,))
        Unit of each channel, and the measured, fitted and residual values in it.
    time : Shown
        How instants are shown.
    """
    figure = Figure((_WIDTH, 0.6 + 3.4 * len(channels)), layout="constrained")
    axes = figure.subplots(
        2 * len(channels), sharex=True, height_ratios=[2, 1] * len(channels), squeeze=False
    ).ravel()
    for above, below, (name, (unit, measured, fitted, rest)) in zip(
        axes[::2], axes[1::2], channels.items(), strict=True
    ):
        above.plot(time.value(t), measured, ".", color="grey", markersize=3, label="measured")
        above.plot(time.value(run_t), fitted, color="C0", label="fitted")
        above.set_ylabel(f"{name}, {unit}")
        above.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
        below.axhline(0, color="black", linewidth=0.8)
        below.plot(time.value(t), rest, ".", color="C3", markersize=3)
        below.set_ylabel(f"residual, {unit}")
        for axis in (above, below):
            axis.grid(alpha=0.3)
    axes[-1].set_xlabel(f"time, {time.unit}")
    figure.suptitle(title)
    return figure
