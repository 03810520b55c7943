"""Which method a model asks for."""

from __future__ import annotations

import itertools

import numpy as np

from lumped.errors import OptionError
from lumped.points.linearise import sparse_state_matrix
from lumped.timeloop.instants import instants
from lumped.timeloop.linear_form import linear_form
from lumped.timeloop.result import OperatingPoint
from lumped.timeloop.run_in_closed_form import closed

__all__ = ["closed_form_pays", "stiff"]

_MOST_STATES = 200
"""States up to which eigenvalues and eigenvectors cost less than the steps of a short run."""
_MOST_INSTANTS = 300
"""Instants of functions of time up to which parts in closed form cost less than steps."""
_REACH = 6.0
"""Largest decay of a mode within an explicit step."""
_TIMES = 10.0
"""How many times more steps stability must ask for than accuracy."""
_FEWEST = 20.0
"""Steps of a run in which nothing vibrates."""
_LASTING = 20.0
"""Time constants in which a mode is gone."""


def closed_form_pays(point: OperatingPoint, until: float, rtol: float) -> bool:
    """Whether there is a closed form, with few states and rounding below the tolerance."""
    system, theta = point.system, point.theta
    if not 0 < len(system.states) <= _MOST_STATES:
        return False
    try:
        form = linear_form(system)
    except OptionError:
        return False
    found = instants(system, theta, point.time, until)
    if len(found.times) > _MOST_INSTANTS:
        return False
    edges = [point.time, *found.times.tolist(), until]
    modes = np.zeros(system._flat.mode_count)
    for (begin, end), now in zip(itertools.pairwise(edges), found.modes, strict=True):
        modes[found.places] = now
        matrix, _ = form.at(theta, begin, modes)
        if not np.isfinite(matrix.data).all():
            return False
        if closed(system, matrix).rounding(end - begin) > rtol:
            return False
    return True


def stiff(point: OperatingPoint, until: float, rtol: float) -> bool:
    """Whether stability would ask for far more explicit steps than accuracy for implicit ones.

    Judged by the eigenvalues at the start point: an explicit step reaches over a few time constants
    of the fastest decay, an implicit one over a part of a vibration as long as that lasts.
    """
    if not 0 < len(point.x) <= _MOST_STATES:
        return False
    matrix = sparse_state_matrix(point.system, point).toarray()
    if not np.isfinite(matrix).all():
        return False
    values = np.linalg.eigvals(matrix)
    decay = np.maximum(-values.real, 0.0)
    span = until - point.time
    lasting = np.minimum(span, _LASTING / np.maximum(decay, 1e-300))
    accuracy = _FEWEST + float((np.abs(values.imag) * lasting).max())
    accuracy *= max(1.0, (1e-6 / rtol) ** 0.2)
    return bool(span * float(decay.max()) / _REACH > _TIMES * accuracy)
