"""Structural analysis: matching, index reduction, and what is wrong with a singular model.

Pantelides' algorithm (SIAM J. Sci. Stat. Comput. 9 (1988) 213) is run on all unmatched
equations at once: the equations to differentiate are those that alternating paths from the
unmatched ones reach, the over-determined part of Dulmage and Mendelsohn.
"""

from __future__ import annotations

import itertools

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, maximum_bipartite_matching

from lumped.errors import SingularModelError
from lumped.incidence import Entries, Incidence

__all__ = ["check_matching", "differentiate"]

_MOST_ROUNDS = 12


def _graph(rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]) -> csr_array:
    return csr_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=shape)


def _match(graph: csr_array) -> np.ndarray:
    """Column matched to each row, -1 for none."""
    found: np.ndarray = maximum_bipartite_matching(graph, perm_type="column")
    return found


def _reached(graph: csr_array, match: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Rows that alternating paths from the rows `starts` reach, themselves included."""
    n, m = graph.shape
    row_of = np.full(m, -1)
    row_of[match[match >= 0]] = np.flatnonzero(match >= 0)
    pairs = graph.tocoo()
    to = row_of[pairs.col]
    known = to >= 0
    sources = np.concatenate([pairs.row[known], np.full(len(starts), n)])
    targets = np.concatenate([to[known], starts])
    links = _graph(sources, targets, (n + 1, n + 1))
    order = breadth_first_order(links, n, return_predecessors=False)
    return np.sort(order[order < n])


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
    """
    count = incidence.count
    times = np.zeros(count, dtype=int)
    for _ in range(_MOST_ROUNDS):
        highest = floor.copy()
        np.maximum.at(highest, entries.classes, entries.orders + times[entries.rows])
        top = entries.orders + times[entries.rows] == highest[entries.classes]
        graph = _graph(entries.rows[top], entries.classes[top], (count, len(floor)))
        match = _match(graph)
        unmatched = np.flatnonzero(match < 0)
        if not len(unmatched):
            return times, highest
        times[_reached(graph, match, unmatched)] += 1
    raise SingularModelError(
        f"{incidence.flat.name}: some equations must be differentiated more than "
        f"{_MOST_ROUNDS} times:\n" + _listed(incidence, unmatched)
    )


def check_matching(incidence: Incidence, entries: Entries) -> None:
    """Refuse a model whose equations cannot be matched to its unknowns.

    Raises
    ------
    SingularModelError
        With the over-determined equations and the undetermined unknowns by name.
    """
    count, classes = incidence.count, incidence.aliases.count
    graph = _graph(entries.rows, entries.classes, (count, classes))
    match = _match(graph)
    if count == classes and (match >= 0).all():
        return
    unmatched = np.flatnonzero(match < 0)
    free = np.setdiff1d(np.arange(classes), match[match >= 0])
    text = [
        f"{incidence.flat.name} has {count} equations for {classes} unknowns left after "
        "joining what is equal, and they do not fit."
    ]
    if len(unmatched):
        text += _over(incidence, graph, match, unmatched)
    if len(free):
        text += _under(incidence, graph, match, free)
    text.append(_hint(incidence, unmatched))
    raise SingularModelError("\n".join(line for line in text if line))


def _over(
    incidence: Incidence, graph: csr_array, match: np.ndarray, unmatched: np.ndarray
) -> list[str]:
    lines = []
    empty = [r for r in unmatched if graph.indptr[r] == graph.indptr[r + 1]]
    for row in empty[:3]:
        lines.append("Too many equations; these say the same thing or contradict each other:")
        lines += [f"  {line}" for line in _circle(incidence, int(row))]
    others = np.setdiff1d(unmatched, empty)
    if len(others):
        reached = _reached(graph, match, others)
        lines.append("Too many equations for the unknowns in them:")
        lines.append(_listed(incidence, reached))
    return lines


def _under(
    incidence: Incidence, graph: csr_array, match: np.ndarray, free: np.ndarray
) -> list[str]:
    names = [", ".join(class_names(incidence, int(c), 3)) for c in free[:6]]
    more = f" and {len(free) - 6} more" if len(free) > 6 else ""
    return [f"Nothing determines: {'; '.join(names)}{more}."]


def _hint(incidence: Incidence, unmatched: np.ndarray) -> str:
    flat, aliases = incidence.flat, incidence.aliases
    touched = {u for r in unmatched for u in _raw_unknowns(incidence, *incidence.origin(int(r)))}
    motions = {int(aliases.classes[u]) for u in touched} - {-1}
    meeting = [
        where
        for a, b, where in flat.joints.equal
        if flat.tree.quantity(a).kind == "potential" and int(aliases.classes[a]) in motions
    ]
    meeting += [where for a, _, where in flat.joints.equal if a in touched]
    if meeting:
        return (
            f"Likely two supports or prescribed motions meet at {meeting[0]} without an elastic "
            "part between them. Remove one, or put a spring between them."
        )
    return (
        "Look for a part that is missing, connected twice, or driven by two sources; "
        "each unknown needs exactly one equation."
    )


def _circle(incidence: Incidence, row: int) -> list[str]:
    """The used-up equations that together say the same as a redundant one."""
    import networkx as nx

    aliases = incidence.aliases
    kind, number = incidence.origin(row)
    graph = nx.Graph()
    for i, (_, _, unknowns) in enumerate(aliases.used):
        members = unknowns if len(unknowns) > 1 else [*unknowns, -1]
        for a, b in itertools.pairwise(members):
            graph.add_edge(a, b, used=i)
    raw = _raw_unknowns(incidence, kind, number)
    targets = raw if len(raw) > 1 else [*raw, -1]
    lines = [equation_text(incidence, kind, number)]
    for a, b in itertools.pairwise(targets):
        if a in graph and b in graph and nx.has_path(graph, a, b):
            path = nx.shortest_path(graph, a, b)
            for u, v in itertools.pairwise(path):
                kind_used, number_used, _ = aliases.used[graph.edges[u, v]["used"]]
                line = equation_text(incidence, kind_used, number_used)
                if line not in lines:
                    lines.append(line)
    return lines


def _raw_unknowns(incidence: Incidence, kind: str, number: int) -> list[int]:
    flat = incidence.flat
    if kind == "sum":
        return [int(u) for u in flat.joints.sums[number][0]]
    for group in flat.groups:
        n = len(group.template.equations)
        offset = number - group.first_equation
        if 0 <= offset < n * len(group.nodes):
            instance, e = divmod(offset, n)
            locals_ = np.unique(group.template.residual(e).locals)
            return [int(u) for u in group.unknowns[instance, locals_]]
    raise IndexError(number)


def equation_text(incidence: Incidence, kind: str, number: int) -> str:
    """An equation as the user wrote it, and where."""
    joints = incidence.flat.joints
    if kind == "equation":
        node, text = incidence.flat.origin(number)
        return f"{text:<40} in {node.label}"
    if kind == "sum":
        flows, _, where = joints.sums[number]
        name = incidence.flat.tree.quantity(int(flows[0])).text
        return f"sum of '{name}' is zero".ljust(40) + f" at {where}"
    if kind == "equal":
        a, b, where = joints.equal[number]
        tree = incidence.flat.tree
        return f"{tree.unknown_name(a)} = {tree.unknown_name(b)}".ljust(40) + f" at {where}"
    return f"{joints.grounded[number][1]} is left open and grounded"


def _listed(incidence: Incidence, rows: np.ndarray, most: int = 10) -> str:
    lines = [f"  {equation_text(incidence, *incidence.origin(int(r)))}" for r in rows[:most]]
    if len(rows) > most:
        lines.append(f"  ... and {len(rows) - most} more")
    return "\n".join(lines)


def class_names(incidence: Incidence, number: int, most: int) -> list[str]:
    """Names of the unknowns in a class."""
    members = np.flatnonzero(incidence.aliases.classes == number)
    names = [incidence.flat.tree.unknown_name(int(u)) for u in members[:most]]
    return [*names, "..."] if len(members) > most else names
