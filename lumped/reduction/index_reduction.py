"""Structural analysis: matching, index reduction, and what is wrong with a singular model.

Pantelides' algorithm (SIAM J. Sci. Stat. Comput. 9 (1988) 213) is run on all unmatched
equations at once: the equations to differentiate are those that alternating paths from the
unmatched ones reach, the over-determined part of Dulmage and Mendelsohn.
"""

from __future__ import annotations

import numpy as np

from lumped.errors import SingularModelError
from lumped.reduction.diagnosis import list_equations, misfit
from lumped.reduction.incidence import Entries, Incidence
from lumped.reduction.matching import (
    can_match_all,
    find_competing,
    find_overdetermined,
    invert,
    match_rows,
)
from lumped.support.sparse_graph import links

_MOST_ROUNDS = 12
_MOST_FAULTS = 6


def differentiate(
    incidence: Incidence, entries: Entries, floor: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """How often each equation must be differentiated.

    Parameters
    ----------
    incidence : Incidence
        For the error text.
    entries : Entries
        Entries of the undifferentiated equations.
    floor : ndarray of int, shape (classes,)
        Least order of the highest derivative of each class.

    Returns
    -------
    times : ndarray of int, shape (rows,)
        Differentiations of each equation.
    highest : ndarray of int, shape (classes,)
        Order of the highest derivative of each class.

    Raises
    ------
    SingularModelError
        If there is no end to it.
    """
    count = incidence.count
    times = np.zeros(count, dtype=int)
    for _ in range(_MOST_ROUNDS):
        highest = floor.copy()
        np.maximum.at(highest, entries.classes, entries.orders + times[entries.rows])
        top = entries.orders + times[entries.rows] == highest[entries.classes]
        graph = entries.rows[top], entries.classes[top], (count, len(floor))
        competing = find_overdetermined(*graph)
        if not len(competing):
            return times, highest
        times[competing] += 1
    unmatched = np.flatnonzero(match_rows(*graph) < 0)
    raise SingularModelError(
        f"{incidence.flat.name}: some equations must be differentiated more than "
        f"{_MOST_ROUNDS} times:\n" + list_equations(incidence, unmatched)
    )


def check_matching(incidence: Incidence, entries: Entries) -> None:
    """Refuse a model whose equations cannot be matched to its unknowns.

    Raises
    ------
    SingularModelError
        With the over-determined equations and the undetermined unknowns by name.
    """
    count, classes = incidence.count, incidence.aliases.count
    given = entries.rows, entries.classes, (count, classes)
    if can_match_all(*given):
        return
    graph, match = links(*given), match_rows(*given)
    owner = invert(match, classes)
    unmatched, free = np.flatnonzero(match < 0), np.flatnonzero(owner < 0)
    over = [find_competing(graph, match, np.array([r])) for r in unmatched[:_MOST_FAULTS]]
    turned = graph.T.tocsr()
    under = [find_competing(turned, owner, np.array([c])) for c in free[:_MOST_FAULTS]]
    raise SingularModelError(misfit(incidence, match, over, under, len(free)))
