"""Picture of measured and fitted curves."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lumped.plots.picture import Axis, Curve, Level, Panel, Picture, label_axis
from lumped.plots.style import ZERO, look
from lumped.support.display_units import Shown

_POINTS = {"dash": "", "mark": "circle", "size": 2.5}


def draw_fit(
    title: str,
    t: np.ndarray,
    run_t: np.ndarray,
    channels: Mapping[str, tuple[str, np.ndarray, np.ndarray, np.ndarray]],
    time: Shown,
) -> Picture:
    """Measured points and the fitted curve, and below them what is left, for each channel.

    Parameters
    ----------
    title : str
        Title of the picture.
    t : ndarray, shape (n,)
        Instants of the measurement, s.
    run_t : ndarray, shape (k,)
        Instants of the fitted run, s.
    channels : mapping of str to (str, ndarray (n,), ndarray (k,), ndarray (n,))
        Unit of each channel, and the measured, fitted and residual values in it.
    time : Shown
        How instants are shown.
    """
    x, panels = Axis(label_axis("time", time.unit)), []
    for name, (unit, measured, fitted, rest) in channels.items():
        curves = (
            Curve(time.value(t), measured, "measured", look(1, **_POINTS)),
            Curve(time.value(run_t), fitted, "fitted", look(0)),
        )
        left = Level(0.0, look=ZERO), Curve(time.value(t), rest, "", look(1, **_POINTS))
        panels.append(Panel(curves, x, Axis(label_axis(name, unit)), height=2.2))
        panels.append(Panel(left, x, Axis(label_axis("residual", unit)), height=1.3))
    return Picture(title, tuple(panels), shared=True)
