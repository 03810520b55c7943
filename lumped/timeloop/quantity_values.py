"""Values of a quantity at the points of a run, computed in the language of the time loop."""

from __future__ import annotations

import numpy as np

from lumped.code.operations import operations_of
from lumped.compiler.system import System
from lumped.kernel.plant import Function
from lumped.support.made_once import Recent, made_once
from lumped.timeloop.point_function import at_points, room_for

__all__ = ["quantity_along"]

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
    work, function = _known(system).of(key, lambda: _made(system, key))
    run = room_for(work, len(theta))
    return at_points(function, 1, run, theta, t, x, settings).ravel()


def _made(system: System, key: str) -> tuple[int, Function]:
    """Room that the function of a quantity needs, and the function."""
    operations = operations_of(system.function([key]))
    function = Function(
        count=len(operations.table),
        operations=operations.table.ravel(),
        constants=operations.constants,
    )
    return operations.work, function


@made_once
def _known(_: System) -> Recent[tuple[int, Function]]:
    return Recent(_KEPT)
