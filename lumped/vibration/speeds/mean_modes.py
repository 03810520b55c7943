"""Modes of a drive whose inertias and stiffnesses vary with an angle, by their means."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError
from lumped.points.vibrating_states import finite
from lumped.support.arguments import checked
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.vibration.natural.find_modes import modes_of
from lumped.vibration.natural.modes import Modes
from lumped.vibration.rotating.find_rotation import rotation
from lumped.vibration.rotating.harmonics import mean_matrix
from lumped.vibration.rotating.small_vibrations import small_vibrations


@checked
def mean_modes(
    system: System,
    *,
    shaft: Name,
    speed: float,
    turns: int = 1,
    at: OperatingPoint | Callable[[float], OperatingPoint] | None = None,
    free: Name | None = None,
    parameters: Changes | None = None,
) -> Modes:
    """Modes of the equivalent with constant inertias, of an engine with cranks for example.

    Inertias, stiffness and damping are their means over the turns of a shaft that turns steadily,
    as in `order_response`. What gas pressures add to the stiffness at single angles has no mean.
    Of an inertia that varies its mean counts, by the kinetic energy at equal speed: for a crank
    that of what rotates and about half of the mass that moves to and fro, at the crank radius. The
    true frequency (Floquet's exponent) is higher by the square of the variation.

    A component whose inertia varies must say its kinetic energy by a method `stored`, as all of the
    library do; otherwise the mean of one over its inertia counts.

    Source: Pasricha, ASEAN Journal on Science and Technology for Development 23 (2006) 1, abstract
    (conventional theory takes the mean values of the varying inertias); Nestorides, A Handbook on
    Torsional Vibration (1958), ch. 1 (not read).

    Parameters
    ----------
    system : System
        From `assemble`.
    shaft : name
        Angle of the shaft, rad.
    speed : float
        Its speed, rad/s.
    turns : int
        Turns of it after which everything repeats: 2 for a four-stroke engine.
    at, free, parameters : optional
        As in `order_response`.

    Returns
    -------
    Modes

    Raises
    ------
    OptionError
        If the speed is not positive, or the drive is another after the turns.
    SolverError
        If there is no steady rotation.
    """
    if not speed > 0:
        raise OptionError(f"mean_modes: speed = {speed:g} rad/s must be above zero.")
    turning = rotation(system, shaft, np.array([speed]), turns, at, parameters, free)
    first = turning.points[0]
    point = replace(first, x=turning.x[0], theta=turning.theta[0], settings=turning.settings[0])
    matrix, _ = mean_matrix(small_vibrations(turning.system, (), ()), turning, np.ones(1))
    return modes_of(finite(point), scipy.sparse.csr_array(matrix), is_mean=True)
