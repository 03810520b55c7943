"""Texts that say what is wrong with a singular model: which equations, which parts, what to do."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

import casadi as ca
import numpy as np
import scipy

from lumped.flattening.flat_model import FlatModel
from lumped.language.port import Pin
from lumped.reduction.incidence import Entries, Incidence
from lumped.support.text_table import list_lines, list_names
from lumped.support.units import amount

Origin = tuple[str, int]
"""Kind and number of an equation, as in `Aliases.used`."""


def equation_text(incidence: Incidence, kind: str, number: int) -> str:
    """An equation as the user wrote it, and where."""
    joints = incidence.flat.joints
    if kind == "equation":
        node, text = incidence.flat.origin(number)
        return f"{text:<40} in {node.label}"
    if kind == "sum":
        flows, _, where = joints.sums[number]
        name = incidence.flat.tree.quantity(flows[0]).text
        return f"sum of '{name}' is zero".ljust(40) + f" at {where}"
    if kind == "equal":
        a, b, where = joints.equal[number]
        tree = incidence.flat.tree
        return f"{tree.unknown_name(a)} = {tree.unknown_name(b)}".ljust(40) + f" at {where}"
    return f"{joints.grounded[number][1]} is left open and grounded"


def class_names(incidence: Incidence, number: int, most: int) -> list[str]:
    """Names of the unknowns in a class."""
    members = np.flatnonzero(incidence.aliases.classes == number)
    names = [incidence.flat.tree.unknown_name(int(u)) for u in members[:most]]
    return [*names, "..."] if len(members) > most else names


def list_equations(incidence: Incidence, rows: Iterable[int], most: int = 10) -> str:
    """Lines with the equations of some rows."""
    return list_lines([equation_text(incidence, *incidence.origin(int(r))) for r in rows], most)


def list_each_once(names: Iterable[str]) -> str:
    """Names in a row, each once, the first few."""
    return list_names(list(dict.fromkeys(names)))


# -- equations and unknowns that do not fit ------------------------------------------------------


@dataclass
class _Fault:
    """Equations of which there are too many for their unknowns.

    Attributes
    ----------
    origins : list of (str, int)
        The equations.
    unknowns : set of int
        The unknowns that they determine too often.
    repeated : bool
        They only repeat each other: what is left of one of them says ``0 = 0``, or a number.
    locking : list of int
        Those that determine all the unknowns as zero, if there are as many.
    """

    incidence: Incidence
    origins: list[Origin]
    unknowns: set[int]
    repeated: bool
    locking: list[int] = field(default_factory=list)

    @property
    def what(self) -> str:
        if not self.repeated:
            return "Too many equations for the unknowns in them:"
        if not self.unknowns:
            return "Too many equations; in this one no unknown is left:"
        return "Too many equations; these say the same thing or contradict each other:"

    @cached_property
    def kinds(self) -> set[str]:
        """Kinds of the unknowns."""
        tree = self.incidence.flat.tree
        return {tree.quantity(u).kind for u in self.unknowns}

    @property
    def parts(self) -> str:
        """Paths of the parts that have the unknowns."""
        tree = self.incidence.flat.tree
        return list_each_once(
            tree.node_of_unknown(u).path or tree.instances[0].label for u in sorted(self.unknowns)
        )

    @property
    def places(self) -> list[str]:
        """First connection of each motion that is determined too often."""
        incidence = self.incidence
        found: dict[int, str] = {}
        for a, _, where in incidence.flat.joints.equal:
            if a in self.unknowns and incidence.flat.tree.quantity(a).kind == "potential":
                found.setdefault(int(incidence.aliases.classes[a]), where)
        return list(found.values())

    @property
    def electric(self) -> bool:
        """Whether all the potentials are electric."""
        tree = self.incidence.flat.tree
        quantities = [tree.quantity(u) for u in self.unknowns]
        return all(q is Pin.potential for q in quantities if q.kind == "potential")

    @property
    def leading(self) -> str:
        """Kind of port quantity that is determined too often; its partner lacks an equation."""
        return next((kind for kind in ("potential", "flow") if kind in self.kinds), "")

    def hint(self) -> str:
        """What the user probably did, and what to do."""
        owners = {
            self.incidence.flat.origin(number)[0].label if kind == "equation" else ""
            for kind, number in self.origins
        }
        if not self.unknowns:
            return (
                "Both sides cancel, or hold only numbers and parameters. Write an equation that "
                "determines something."
            )
        if len(owners) == 1 and "" not in owners:
            return (
                f"The equations of {owners.pop()} say one thing twice and leave another open, "
                "though their count is right. Correct them."
            )
        if self.leading == "potential" and self.electric:
            where = " and ".join(self.places[:3]) or self.parts
            return (
                f"Likely sources of voltage or grounds meet at {where} without anything between "
                "them that takes a voltage, and nothing tells the current. Remove one, or put a "
                "resistor between them."
            )
        if self.leading == "potential":
            if self.repeated and not any(kind == "ground" for kind, _ in self.origins):
                return (
                    f"Likely a closed rigid loop runs through {self.parts}, and nothing tells how "
                    "its branches share the load. Remove one of them, or make it elastic."
                )
            if self.locking:
                return lock(self.incidence, self.locking)
            count = "two" if len(self.places) < 2 else "too many"
            where = " and ".join(self.places[:3]) or self.parts
            return (
                f"Likely {count} supports or prescribed motions meet at {where} without an "
                "elastic part between them. Remove one, or put a spring between them."
            )
        if self.leading == "flow":
            return (
                "Likely an inertia, a support or (electric) a ground is missing: nothing holds "
                f"{self.parts}. Connect one of these parts to one."
            )
        return (
            f"Likely {self.parts} only repeat each other's signals. Give one of them a value of "
            "its own."
        )


def misfit(
    incidence: Incidence,
    match: np.ndarray,
    over: list[np.ndarray],
    under: list[np.ndarray],
    lacking: int,
) -> str:
    """What is wrong with equations that cannot be matched to the unknowns.

    Parameters
    ----------
    incidence : Incidence
        The equations.
    match : ndarray of int, shape (rows,)
        Class matched to each equation, -1 for none.
    over : list of ndarray of int
        For each unmatched equation, it and those that compete with it for unknowns.
    under : list of ndarray of int
        For each undetermined class, it and those that could be left open instead.
    lacking : int
        Number of undetermined classes.
    """
    faults = list(_faults(incidence, match, over))
    text = [
        f"{incidence.flat.name} has {incidence.count} equations for {incidence.aliases.count} "
        "unknowns left after joining what is equal, and they do not fit."
    ]
    for fault in faults:
        text += [fault.what, list_lines([equation_text(incidence, *o) for o in fault.origins], 10)]
    open_ = [", ".join(class_names(incidence, c, 3)) for c in _open(incidence, faults, under)]
    if open_:
        more = f" and {lacking - len(open_)} more" if lacking > len(open_) else ""
        text.append(f"Nothing determines: {'; '.join(open_)}{more}.")
    text += dict.fromkeys(fault.hint() for fault in faults)
    return "\n".join(text)


def _faults(incidence: Incidence, match: np.ndarray, over: list[np.ndarray]) -> Iterator[_Fault]:
    shared: list[set[int]] = []
    for rows in over:
        if len(rows) == 1 and match[rows[0]] < 0:
            origins, unknowns = _circle(incidence, int(rows[0]))
            yield _Fault(incidence, origins, unknowns, repeated=True)
            continue
        others = [s for s in shared if s.isdisjoint(rows.tolist())]
        joined = set(rows.tolist()).union(*(s for s in shared if s not in others))
        shared = [*others, joined]
    for members in shared:
        ordered = sorted(members)
        determined = np.isin(incidence.aliases.classes, match[ordered][match[ordered] >= 0])
        origins = [incidence.origin(r) for r in ordered]
        locking = [r for r in ordered if incidence.proportional(r)]
        if len(locking) < len(np.unique(incidence.aliases.classes[determined])):
            locking = []
        unknowns = set(np.flatnonzero(determined).tolist())
        yield _Fault(incidence, origins, unknowns, repeated=False, locking=locking)


def _open(incidence: Incidence, faults: list[_Fault], under: list[np.ndarray]) -> list[int]:
    """Of each set of classes that could be left open, the one that tells most."""
    tree, classes = incidence.flat.tree, incidence.aliases.classes
    partner = {"potential": 1, "flow": -1}
    wanted = {
        u + partner[tree.quantity(u).kind]
        for fault in faults
        for u in fault.unknowns
        if tree.quantity(u).kind == fault.leading
    }
    chosen: list[int] = []
    for choice in under:
        members = np.flatnonzero(np.isin(classes, np.setdiff1d(choice, chosen)))
        best = max(members.tolist(), key=lambda u: (u in wanted, u), default=None)
        if best is not None:
            chosen.append(int(classes[best]))
    return chosen


def _circle(incidence: Incidence, row: int) -> tuple[list[Origin], set[int]]:
    """A redundant equation with the used-up ones that together say the same; their unknowns."""
    import networkx as nx

    used = incidence.aliases.used
    graph = nx.Graph()
    for i, origin in enumerate(used):
        unknowns = _unknowns_of(incidence.flat, origin)
        members = unknowns if len(unknowns) > 1 else [*unknowns, -1]
        for a, b in itertools.pairwise(members):
            graph.add_edge(a, b, used=i)
    raw = _unknowns_of(incidence.flat, incidence.origin(row))
    origins, found = [incidence.origin(row)], set(raw)
    for a, b in itertools.pairwise(raw if len(raw) > 1 else [*raw, -1]):
        if a in graph and b in graph and nx.has_path(graph, a, b):
            path = nx.shortest_path(graph, a, b)
            found.update(path)
            for u, v in itertools.pairwise(path):
                origin = used[graph.edges[u, v]["used"]]
                if origin not in origins:
                    origins.append(origin)
    return origins, found - {-1}


def _unknowns_of(flat: FlatModel, origin: Origin) -> list[int]:
    """Unknowns of an equation before anything was joined."""
    kind, number = origin
    if kind == "equal":
        return list(flat.joints.equal[number][:2])
    if kind == "ground":
        return [flat.joints.grounded[number][0]]
    if kind == "sum":
        return flat.joints.sums[number][0]
    group, instance, e = flat.place(number)
    locals_ = np.unique(group.template.residual(e).locals)
    return [int(u) for u in group.unknowns[instance, locals_]]


# -- rigid loops ---------------------------------------------------------------------------------


def factors(incidence: Incidence, row: int, order: int = 0) -> list[int]:
    """Numbers of the parameters that are factors of unknowns in an equation."""
    if row >= incidence.first_sum:
        return []
    origin, place = incidence.place(row)
    group, e, instances, _ = incidence.blocks[origin]
    symbols = ca.vertcat(ca.SX(0, 1), *group.template.parameters.values())
    present = ca.which_depends(group.template.residual(e, order).partials, symbols)
    numbers: list[int] = group.parameters[instances[place]][np.array(present, dtype=bool)].tolist()
    return numbers


def lock(incidence: Incidence, rows: Iterable[int]) -> str:
    """What rigid parts that lock each other are, why they do, and what to do."""
    rows = list(rows)
    flat = incidence.flat
    owners = [flat.origin(incidence.origin(r)[1])[0] for r in rows]
    parts = list_each_once(owner.path or owner.label for owner in owners)
    numbers = dict.fromkeys(n for r in rows for n in factors(incidence, r))
    parameters = flat.parameters
    values = [
        f"{parameters.names[n]} = {amount(parameters.numbers[n], parameters.declared[n].unit)}"
        for n in numbers
    ]
    ratios = f": {list_each_once(v.removesuffix(' 1') for v in values)}" if values else ""
    return (
        f"Likely a closed rigid loop runs through {parts}{ratios}. Rigid paths side by side can "
        "turn only if their ratios agree, and then nothing tells how they share the load. Remove "
        "one of them, or let the ratios agree and make one path elastic."
    )


# -- redundant constraints -----------------------------------------------------------------------


def find_combination(constraints: Entries, row: int) -> list[int]:
    """Rows of which multiples add up to a redundant one, itself included."""
    rows, i = np.unique(constraints.rows, return_inverse=True)
    nodes = constraints.classes * (constraints.orders.max() + 1) + constraints.orders
    columns, j = np.unique(nodes, return_inverse=True)
    matrix = scipy.sparse.csr_array((constraints.values, (i, j)), shape=(len(rows), len(columns)))
    others = matrix[rows != row]
    share = scipy.sparse.linalg.lsqr(
        others.T, matrix[rows == row].toarray().ravel(), atol=1e-12, btol=1e-12
    )[0]
    used = np.abs(share) > 1e-6 * np.abs(share).max(initial=0.0)
    return sorted([row, *rows[rows != row][used].tolist()])
