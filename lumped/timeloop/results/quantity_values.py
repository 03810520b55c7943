"""Values of a quantity at the points of a run."""

from __future__ import annotations

import numpy as np

from lumped.compiler.system import System
from lumped.support.made_once import Recent, made_once
from lumped.timeloop.plants.many_points import ManyPoints

_KEPT = 64
"""Quantities whose functions a system keeps."""


def quantity_along(
    system: System,
    key: str,
    theta: np.ndarray,
    t: np.ndarray,
    x: np.ndarray,
    settings: np.ndarray,
) -> np.ndarray:
    """A quantity at points one after the other; shape (points,).

    Parameters
    ----------
    key : str
        Its name in the system.
    theta : ndarray
        Parameters.
    t, x, settings : ndarray, shapes (points,), (points, n) and (points, m)
        Times, states, and modes with implicit quantities.
    """
    function = _recent_points(system).of(key, lambda: ManyPoints(system.function([key])))
    return function(x, theta, t, settings)[:, 0]


@made_once
def _recent_points(_: System) -> Recent[ManyPoints]:
    return Recent(_KEPT)
