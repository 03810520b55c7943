"""Turning points of a quantity of a run, between its recorded points too."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.gradients.legs import SmoothParts, legs_of
from lumped.gradients.readings import turning_points as between_steps
from lumped.gradients.steps import steps_of
from lumped.support.arguments import checked
from lumped.timeloop.cycle_count import count_cycles
from lumped.timeloop.results.trajectory import Trajectory


@checked
def turning_points(run: Trajectory, of: Name, *, rtol: float = 1e-6) -> NDArray[np.float64]:
    """Values at which a quantity of a run turns, with its first and last.

    It is enclosed inside the steps of the run, so an extreme between two output times is found as
    well, however short it is.
    Where the quantity jumps, both sides count.

    Parameters
    ----------
    run : Trajectory
        From `simulate`, best with ``grid=None``, which records all steps.
    of : name or expression
        The quantity.
    rtol : float
        Swings that are smaller than this part of its range are left out.

    Returns
    -------
    ndarray, shape (t,)
        At least two, to be given to `rainflow`.

    Raises
    ------
    OptionError
        If `rtol` is not between 0 and 1, or the run has no steps.
    SolverError
        If the output times are too far apart to follow the quantity between them.
    UnknownNameError
        If the quantity does not exist.
    """
    if not 0 < rtol < 1:
        raise OptionError(f"turning_points: rtol = {rtol:g} must be between 0 and 1.")
    key, system = run.system.key(of), run.system
    if not len(run.t) or run.t[-1] == run.t[0]:
        raise OptionError(f"{system.name}: the run has no steps in which {key} could turn.")
    found: list[float] = []
    # states may change places; from then on another system leads the run
    pieces = (piece for piece in run.pieces if len(piece.t))
    for leading, group in itertools.groupby(pieces, lambda piece: piece.system):
        part = replace(run, system=leading, pieces=tuple(group), _known={})
        course = SmoothParts(part, legs_of(part), steps_of(leading, ()), rtol)
        points = between_steps.turning_points(course, (key,))
        found += [point.value for point in points]
    values = np.array(found)
    turning = values[count_cycles(values).turning]
    return turning if len(turning) > 1 else values[:2]
