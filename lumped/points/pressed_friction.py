"""Which friction sticks and which dogs stay in at a start of which all parts move together."""

from __future__ import annotations

import numpy as np

from lumped.flattening.hold_modes import BACKWARD, FORWARD, STUCK
from lumped.points.start_search import StartSearch
from lumped.points.target_values import target_values
from lumped.timeloop.holds import Holds
from lumped.timeloop.results.operating_point import OperatingPoint

_DEPENDENT = 1e-9
"""Part of a speed, not determined by what is demanded, that is rounding."""


def find_loose(point: OperatingPoint, search: StartSearch) -> tuple[int, ...]:
    """Speeds of holds that slide, or close by an impact, though nothing demanded makes them.

    The stronger ones come first, as a train in gear turns against the friction of its bearings, and
    plays last. Losses of gears stick in none.

    Parameters
    ----------
    point : OperatingPoint
        The start that was found.
    search : StartSearch
        What was demanded of it.

    Returns
    -------
    tuple of int
        Nodes of speeds that may all be zero at once.
    """
    system, switching = point.system, point.system.switching
    count = len(system.structure.implicit)
    modes, guesses = np.split(point.settings, [len(point.settings) - count])
    holds, begun = Holds(system, point.theta), point.before or point
    seen = holds.look(point.time, begun.x, modes, guesses)
    parts, places = holds.parts(modes), np.array(switching.speeds)
    slides = parts[FORWARD] | parts[BACKWARD] | (parts[STUCK] & (begun is not point))
    joins = switching.is_pressed | ~(switching.has_upper & switching.has_lower)
    joins &= ~switching.may_leap  # friction beside springs, whose limits are free while it sticks
    slides &= joins & (seen.upper > seen.lower) & (places >= 0)
    strength = np.where(switching.has_gap, -1.0, np.maximum(seen.upper, -seen.lower))
    order = [h for h in np.argsort(-strength, kind="stable").tolist() if slides[h]]
    sliding = tuple(dict.fromkeys(places[order].tolist()))
    if not sliding:
        return ()
    demanded = (*search.targets, *sliding)
    values = target_values(system, demanded, tuple(search.free))
    rows = values(search.x, search.theta, search.time, point.settings)[1]
    rows = np.asarray(rows if isinstance(rows, np.ndarray) else rows.toarray())
    rows[:, [search.position[node] for node in search.fixed]] = 0.0
    own = np.arange(len(search.targets), len(demanded))
    basis = _span(np.delete(rows, own, axis=0))
    found = []
    for node, row in zip(sliding, rows[own], strict=True):
        left = row - basis.T @ (basis @ row)
        left -= basis.T @ (basis @ left)
        size = np.linalg.norm(left)
        if size > _DEPENDENT * max(float(np.linalg.norm(row)), 1e-300):
            basis = np.vstack([basis, left / size])
            found.append(node)
    return tuple(found)


def _span(rows: np.ndarray) -> np.ndarray:
    """Orthonormal rows that span the same."""
    sizes = np.linalg.norm(rows, axis=1, keepdims=True)
    _, values, found = np.linalg.svd(rows / np.where(sizes > 0, sizes, 1.0), full_matrices=False)
    return found[values > _DEPENDENT]
