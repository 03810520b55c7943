"""Turning points of a quantity of a run, between its recorded points too."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lumped.compiler.system import Name
from lumped.errors import OptionError, SolverError
from lumped.gradients import turning_points as between_steps
from lumped.gradients.legs import Leg
from lumped.gradients.steps import steps_of
from lumped.support.arguments import checked
from lumped.timeloop.result import Trajectory

__all__ = ["turning_points"]


@checked
def turning_points(run: Trajectory, of: Name, *, rtol: float = 1e-6) -> NDArray[np.float64]:
    """Values at which a quantity of a run turns, with its first and last.

    The steps of the run are looked into, so an extreme between two output times is found as well.
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
        To be given to `rainflow`.

    Raises
    ------
    OptionError
        If `rtol` is not between 0 and 1, or the run has no steps.
    SolverError
        If the output times are too far apart to follow the quantity between them, or states of the
        run change places.
    UnknownNameError
        If the quantity does not exist.
    """
    if not 0 < rtol < 1:
        raise OptionError(f"turning_points: rtol = {rtol:g} must be between 0 and 1.")
    key, system = run.system.key(of), run.system
    if not len(run.t) or run.t[-1] == run.t[0]:
        raise OptionError(f"{system.name}: the run has no steps in which {key} could turn.")
    pieces = [piece for piece in run.pieces if len(piece.t)]
    if any(piece.system is not system for piece in pieces):
        raise SolverError(
            f"{system.name}: states of the run change places (see run.events), so {key} is not "
            "followed between its points. Count the recorded values on a fine grid: "
            f"rainflow(run['{key}']).",
            run,
        )
    legs = [Leg(run, piece) for piece in pieces]
    found = between_steps.turning_points(run, legs, steps_of(system, ()), key, rtol)
    return np.array([point.value for point in found])
