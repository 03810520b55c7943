"""Which method a model asks for."""

from __future__ import annotations

import itertools

import numpy as np

from lumped.errors import OptionError
from lumped.timeloop.instants import instants
from lumped.timeloop.linear_form import linear_form
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.run_in_closed_form import find_closed_form

_MOST_STATES = 200
"""States up to which eigenvalues and eigenvectors cost less than the steps of a short run."""
_MOST_INSTANTS = 300
"""Instants of functions of time up to which parts in closed form cost less than steps."""


def closed_form_pays(point: OperatingPoint, until: float, rtol: float) -> bool:
    """Whether there is a closed form, with few states and rounding below the tolerance."""
    system, theta = point.system, point.theta
    if not 0 < len(system.state_names) <= _MOST_STATES:
        return False
    try:
        form = linear_form(system)
    except OptionError:
        return False
    found = instants(system, theta, point.time, until)
    if len(found.times) > _MOST_INSTANTS:
        return False
    edges = [point.time, *found.times.tolist(), until]
    modes = np.zeros(system.structure.mode_count)
    for (begin, end), now in zip(itertools.pairwise(edges), found.modes, strict=True):
        modes[found.places] = now
        matrix, _ = form.at(theta, begin, modes)
        if not np.isfinite(matrix.data).all():
            return False
        if find_closed_form(system, matrix).rounding(end - begin) > rtol:
            return False
    return True
