"""Structural analysis: matching, index reduction, and what is wrong with a singular model.

Pantelides' algorithm (SIAM J. Sci. Stat. Comput. 9 (1988) 213) is run on all unmatched
equations at once: the equations to differentiate are those that alternating paths from the
unmatched ones reach, the over-determined part of Dulmage and Mendelsohn.
"""

from __future__ import annotations

import numpy as np
import scipy

from lumped.errors import SingularModelError
from lumped.reduction.diagnosis import list_equations, misfit
from lumped.reduction.incidence import Entries, Incidence
from lumped.support.sparse_graph import find_reached, links

_MOST_ROUNDS = 12
_MOST_FAULTS = 6


def _match(graph: scipy.sparse.csr_array) -> np.ndarray:
    """Column matched to each row, -1 for none."""
    found: np.ndarray = scipy.sparse.csgraph.maximum_bipartite_matching(graph, perm_type="column")
    return found


def _inverse(match: np.ndarray, count: int) -> np.ndarray:
    """Row matched to each column, -1 for none."""
    rows = np.full(count, -1)
    rows[match[match >= 0]] = np.flatnonzero(match >= 0)
    return rows


def _find_reached(
    graph: scipy.sparse.csr_array, match: np.ndarray, starts: np.ndarray
) -> np.ndarray:
    """Rows that alternating paths from the rows `starts` reach, themselves included."""
    n, m = graph.shape
    to = _inverse(match, m)[graph.indices]
    known = to >= 0
    rows = np.repeat(np.arange(n), np.diff(graph.indptr))
    return find_reached(rows[known], to[known], starts, n)


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
        graph = links(entries.rows[top], entries.classes[top], (count, len(floor)))
        match = _match(graph)
        unmatched = np.flatnonzero(match < 0)
        if not len(unmatched):
            return times, highest
        times[_find_reached(graph, match, unmatched)] += 1
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
    graph = links(entries.rows, entries.classes, (count, classes))
    match = _match(graph)
    owner = _inverse(match, classes)
    unmatched, free = np.flatnonzero(match < 0), np.flatnonzero(owner < 0)
    if not len(unmatched) and not len(free):
        return
    over = [_find_reached(graph, match, np.array([r])) for r in unmatched[:_MOST_FAULTS]]
    turned = graph.T.tocsr()
    under = [_find_reached(turned, owner, np.array([c])) for c in free[:_MOST_FAULTS]]
    raise SingularModelError(misfit(incidence, match, over, under, len(free)))
