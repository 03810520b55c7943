"""How derivatives cross what lies between smooth parts of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lumped.gradients.instant_values import margin_sizes
from lumped.gradients.jumps import Crossing
from lumped.gradients.legs import Leg
from lumped.gradients.saltation import saltation_of
from lumped.timeloop.results.trajectory import Trajectory

_AT_ONCE = 1e-10
"""Part of a run within which changes are at the same instant."""


@dataclass(frozen=True)
class AdjointPoint:
    """Derivatives of a result through one instant of a run.

    Attributes
    ----------
    leg : int
        Number of the smooth part.
    time : float
        Where in it, s.
    column : int
        Number of the result.
    by_states, by_parameters : ndarray, shapes (n,) and (p,)
        Derivatives of the result at that instant.
    edge : int
        Number of the leg with whose begin the instant moves; 0 if it does not move.
    late : float
        Derivative of the result by that begin.
    name : str
        Component whose change this is about, if others may change at the same instant.
    """

    leg: int
    time: float
    column: int
    by_states: np.ndarray
    by_parameters: np.ndarray
    edge: int = 0
    late: float = 0.0
    name: str = ""


def crossings_of(run: Trajectory, legs: list[Leg], rtol: float) -> list[Crossing]:
    """How derivatives jump where each leg but the first begins.

    Raises
    ------
    SolverError
        Where the run has no derivatives.
    """
    saltation = saltation_of(run.system)
    found = saltation.between(run, legs, rtol)
    soon = _AT_ONCE * float(legs[-1].t[-1])
    for k in range(len(found) - 1):
        if found[k + 1].t - found[k].t <= soon and found[k].orders:
            accuracy = max(rtol, _AT_ONCE) * margin_sizes(run, [legs[k]])[0]
            both = saltation.join(run, found[k], found[k + 1], accuracy)
            if both is not None:
                found[k], found[k + 1] = Crossing(found[k].t, ()), both
    return found
