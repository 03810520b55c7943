"""Picture of a front."""

from __future__ import annotations

import numpy as np

from lumped.plots.picture import Axis, Curve, Panel, Picture
from lumped.plots.style import MARKS, look


def front_picture(
    title: str, values: np.ndarray, labels: tuple[str, str], logs: tuple[bool, bool]
) -> Picture:
    """Designs of a front, a line through them.

    Parameters
    ----------
    title : str
        Title of the picture.
    values : ndarray, shape (count, 2)
        Of both aims.
    labels : (str, str)
        The aims with their units.
    logs : (bool, bool)
        Which axis is logarithmic.
    """
    line = Curve(values[:, 0], values[:, 1], look=look(0, mark=MARKS[3]))
    x, y = (Axis(label, log=log) for label, log in zip(labels, logs, strict=True))
    return Picture(title, (Panel((line,), x, y, height=3.5),))
