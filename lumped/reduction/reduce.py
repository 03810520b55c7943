"""Reduce a flat model: aliases, index, states, and the order in which everything is computed."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, NoReturn

import numpy as np

from lumped.errors import SingularModelError
from lumped.flattening.flat_model import FlatModel
from lumped.reduction.aliases import Aliases, eliminate_aliases
from lumped.reduction.diagnosis import class_names, equation_text, find_combination, list_equations
from lumped.reduction.incidence import Entries, GenericPoint, Incidence, Occurrence
from lumped.reduction.index_reduction import check_matching, differentiate
from lumped.reduction.matching import match_rows
from lumped.reduction.state_selection import RANK, constraint_rows, select_dependent
from lumped.support.sparse_graph import find_strong_sets


class Block(NamedTuple):
    """Equations to be solved together for as many unknowns.

    Attributes
    ----------
    equations : list of (int, int)
        Equation and how often it is differentiated.
    nodes : list of int
        Unknowns (numbers of class and derivative) that it determines.
    needs : list of int
        Blocks whose unknowns occur in its equations.
    has_state : bool
        A state occurs in its equations.
    """

    equations: list[tuple[int, int]]
    nodes: list[int]
    needs: list[int]
    has_state: bool


@dataclass(frozen=True, eq=False)
class Reduced:
    """A model after index reduction and state selection.

    A *node* is a class of equal quantities at one order of time derivative.

    Attributes
    ----------
    incidence : Incidence
        Which classes occur in which equations.
    aliases : Aliases
        Classes of equal quantities.
    first : ndarray of int, shape (classes + 1,)
        Number of the node of each class at order 0; orders follow.
    highest : ndarray of int, shape (classes,)
        Order of the highest derivative of each class.
    differentiations : ndarray of int, shape (equations,)
        How often each equation was differentiated.
    states : list of int
        Nodes that are states, in order of declaration.
    dependent : list of int
        Candidates that constraints determine; formulas with factors that do not pass zero
        determine the first ones.
    explicit : int
        Number of these.
    tied : frozenset of int
        Candidates that occur in constraints.
    invariants : list of (int, int)
        Constraints that determine no candidate, as equation and how often it is differentiated:
        they hold if they hold at the start.
    blocks : list of Block
        In an order in which they can be computed.
    block_of : ndarray of int, shape (nodes,)
        Block that determines each node, -1 for states.
    """

    incidence: Incidence
    aliases: Aliases
    first: np.ndarray
    highest: np.ndarray
    differentiations: np.ndarray
    states: list[int]
    dependent: list[int]
    explicit: int
    tied: frozenset[int]
    invariants: list[tuple[int, int]]
    blocks: list[Block]
    block_of: np.ndarray

    @cached_property
    def is_kinematic(self) -> bool:
        """Whether constraints are of positions and speeds only, as no equation of motion is one."""
        return int(self.differentiations.max(initial=0)) <= 2

    def node(self, unknown: int) -> int | None:
        """Node of an unknown; None if it is zero. Its value is its sign times the node's."""
        node = int(self.nodes[unknown])
        return None if node < 0 else node

    @cached_property
    def nodes(self) -> np.ndarray:
        """Node of each unknown, -1 if it is zero, shape (unknowns,)."""
        return find_nodes(self.aliases, self.first)

    def nodes_of(self, seen: Occurrence) -> np.ndarray:
        """Nodes in instances of an equation; one after the last for what is always zero."""
        nodes: np.ndarray = self.first[seen.classes] + seen.orders
        nodes[seen.classes < 0] = self.first[-1]
        return nodes

    def find_solved_blocks(self, reactions: Iterable[int]) -> tuple[set[int], set[int]]:
        """Blocks that are no formulas, and those of them not linear in their unknowns.

        Equations in `reactions` hold a motion.
        """
        owner = np.repeat(np.arange(len(self.blocks)), [len(block.nodes) for block in self.blocks])
        joint = {b for b, block in enumerate(self.blocks) if len(block.nodes) > 1}
        loops: set[int] = set()
        block_of = np.append(self.block_of, -1)
        rows, orders = equations_of(self.blocks)
        joint.update(owner[np.isin(rows, list(reactions))].tolist())
        for places, seen in self.incidence.alike(rows, orders):
            inside = block_of[self.nodes_of(seen)] == owner[places][:, None]
            several = np.flatnonzero(inside.sum(axis=1) > 1)
            joint.update(owner[places[several]].tolist())
            affine = seen.residual.affine
            for k in range(len(places)) if not affine.all() else ():
                here = np.flatnonzero(inside[k])
                if not affine[np.ix_(here, here)].all():
                    loops.add(int(owner[places[k]]))
        return joint | loops, loops

    def class_and_order(self, node: int) -> tuple[int, int]:
        """Class and order of derivative of a node."""
        number = int(np.searchsorted(self.first, node, side="right")) - 1
        return number, node - int(self.first[number])


def equations_of(blocks: list[Block]) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the equations of blocks, and how often each is differentiated."""
    pairs = [pair for block in blocks for pair in block.equations]
    numbers, orders = np.array(pairs, dtype=int).reshape(-1, 2).T
    return numbers, orders


def reduce(
    flat: FlatModel, ranks: Mapping[int, int] | None = None, *, redundant: bool = False
) -> Reduced:
    """Index reduction, state selection and block order of a flat model.

    Parameters
    ----------
    flat : FlatModel
        The model.
    ranks : mapping of int to int, optional
        Wishes (see `lumped.reduction.state_selection.RANK`) that override those declared, for
        nodes as an earlier reduction of the same model numbers them.
    redundant : bool
        All coordinates that varying constraints tie are states.

    Returns
    -------
    Reduced

    Raises
    ------
    SingularModelError
        If equations and unknowns do not fit, or constraints are redundant.
    """
    aliases = eliminate_aliases(flat)
    incidence = Incidence(flat, aliases)
    plain = np.zeros(incidence.count, dtype=int)
    entries = incidence.entries(plain)
    check_matching(incidence, entries)
    wish = _wishes(flat, aliases)
    floor = np.zeros(aliases.count, dtype=int)
    for (number, order), rank in wish.items():
        if rank >= RANK["prefer"]:
            floor[number] = max(floor[number], order + 1)
    alive = aliases.classes >= 0
    np.maximum.at(floor, aliases.classes[alive], aliases.shifts[alive])
    differentiations, highest = differentiate(incidence, entries, floor)
    first = np.concatenate([[0], np.cumsum(highest + 1)])
    dependent, explicit, tied, invariants = _select_dependent(
        incidence, differentiations, highest, first, wish, ranks or {}, redundant
    )
    is_state = np.ones(first[-1], dtype=bool)
    is_state[first[:-1] + highest] = False
    is_state[dependent] = False
    states = np.flatnonzero(is_state)
    blocks, block_of = _find_blocks(incidence, differentiations, first, is_state, invariants)
    return Reduced(
        incidence,
        aliases,
        first,
        highest,
        differentiations,
        _by_declaration(aliases, first, states),
        dependent,
        explicit,
        tied,
        invariants,
        blocks,
        block_of,
    )


def _wishes(flat: FlatModel, aliases: Aliases) -> dict[tuple[int, int], int]:
    """Wish of each class and order: `never` wins, then the highest rank."""
    wish: dict[tuple[int, int], int] = {}
    keys = zip(aliases.classes.tolist(), aliases.shifts.tolist(), strict=True)
    for key, quantity in zip(keys, flat.tree.quantities, strict=True):
        if quantity.kind != "variable" or key[0] < 0:
            continue
        rank = RANK[quantity.wish]
        old = wish.get(key)
        if old is None or rank == 0 or (rank > old > 0):
            wish[key] = rank
    return wish


def _select_dependent(
    incidence: Incidence,
    differentiations: np.ndarray,
    highest: np.ndarray,
    first: np.ndarray,
    wish: dict[tuple[int, int], int],
    ranks: Mapping[int, int],
    redundant: bool,
) -> tuple[list[int], int, frozenset[int], list[tuple[int, int]]]:
    """Nodes that constraints determine, how many explicitly; all that they tie; invariants."""
    if not differentiations.any():
        return [], 0, frozenset(), []
    column = first[:-1, None] + np.arange(int(highest.max()) + 1)[None, :]

    def constraints_under(load: float) -> list[Entries]:
        point = GenericPoint(incidence.flat, incidence.aliases, highest, load)
        return [
            incidence.entries(np.full(incidence.count, order), point, differentiations > order)
            for order in range(int(differentiations.max()))
        ]

    constraints = constraints_under(1.0)
    rows, equations = constraint_rows(constraints, column)
    tied = frozenset(node for row in rows for node in row)
    rank = np.full(first[-1], RANK["avoid"])
    for (number, order), value in wish.items():
        if order <= highest[number]:
            rank[first[number] + order] = value
    for node, value in ranks.items():
        rank[node] = value
    dependent, explicit, unused = select_dependent(
        rows,
        rank,
        lambda: constraint_rows(constraints_under(1e-3), column)[0],
        explicit_only=redundant,
    )
    if redundant:
        return dependent, explicit, tied, [equations[row] for row in unused]
    if unused or len(dependent) < int(differentiations.sum()):
        row, order = equations[unused[0]] if unused else (int(np.argmax(differentiations)), 0)
        raise SingularModelError(
            f"{incidence.flat.name}: these constraints are redundant or contradict each other:\n"
            + list_equations(incidence, find_combination(constraints[order], row))
            + "\nLikely a closed loop of rigid gears or linkages fixes the same motion twice. "
            "Make one member of the loop elastic, or remove it."
        )
    return dependent, explicit, tied, []


def _by_declaration(aliases: Aliases, first: np.ndarray, states: np.ndarray) -> list[int]:
    """States sorted by the first declared quantity that they are."""
    where = np.full(first[-1] + 1, len(aliases.classes))
    np.minimum.at(where, find_nodes(aliases, first), np.arange(len(aliases.classes)))
    return sorted(states.tolist(), key=lambda n: (where[n], n))


def find_nodes(aliases: Aliases, first: np.ndarray) -> np.ndarray:
    """Node of each unknown, -1 if it is zero, from the first node of each class."""
    return np.where(aliases.classes >= 0, first[aliases.classes] + aliases.shifts, -1)


def _find_blocks(
    incidence: Incidence,
    differentiations: np.ndarray,
    first: np.ndarray,
    is_state: np.ndarray,
    invariants: list[tuple[int, int]],
) -> tuple[list[Block], np.ndarray]:
    """Strongly connected sets of equations in the order of computation."""
    rows, nodes, equations = _list_entries(incidence, differentiations, first, invariants)
    unknown = np.flatnonzero(~is_state)
    column = np.full(first[-1], -1)
    column[unknown] = np.arange(len(unknown))
    known = column[nodes] < 0
    n = len(equations)
    match = match_rows(rows[~known], column[nodes[~known]], (n, len(unknown)))
    if n != len(unknown) or (match < 0).any():
        lost = [equations[r] for r in np.flatnonzero(match < 0)[:8]]
        free = unknown[np.setdiff1d(np.arange(len(unknown)), match)[:6]]
        _refuse_unmatched(incidence, lost, np.searchsorted(first, free, side="right") - 1)
    row_of = np.empty(len(unknown), dtype=int)
    row_of[match] = np.arange(n)
    users, needed = rows[~known], row_of[column[nodes[~known]]]
    owner = find_strong_sets(users, needed, n)
    has_state = np.zeros(owner.max(initial=-1) + 1, dtype=bool)
    has_state[owner[rows[known]]] = True
    return _order_blocks(
        equations, unknown[match], owner, has_state, owner[users], owner[needed], first[-1]
    )


def _refuse_unmatched(
    incidence: Incidence, lost: list[tuple[int, int]], free: np.ndarray
) -> NoReturn:
    """Name equations without an unknown to solve for, and classes without an equation."""
    raise SingularModelError(
        f"{incidence.flat.name}: after index reduction nothing is left to solve for in\n  "
        + "\n  ".join(equation_text(incidence, *incidence.origin(r)) for r, _ in lost)
        + "\nIn undetermined unknowns: "
        + "; ".join(", ".join(class_names(incidence, int(c), 2)) for c in free)
    )


def _list_entries(
    incidence: Incidence,
    differentiations: np.ndarray,
    first: np.ndarray,
    invariants: list[tuple[int, int]],
) -> tuple[np.ndarray, np.ndarray, list[tuple[int, int]]]:
    """Entries of all equations and their derivatives: place among these, node; and these."""
    row_parts, node_parts = [], []
    equations: list[tuple[int, int]] = []
    for order in range(int(differentiations.max(initial=0)) + 1):
        picked = differentiations >= order
        picked[[row for row, k in invariants if k == order]] = False
        e = incidence.entries(np.full(incidence.count, order), picked=picked)
        number = np.full(incidence.count, -1)
        number[picked] = len(equations) + np.arange(int(picked.sum()))
        equations += [(r, order) for r in np.flatnonzero(picked).tolist()]
        row_parts.append(number[e.rows])
        node_parts.append(first[e.classes] + e.orders)
    return np.concatenate(row_parts), np.concatenate(node_parts), equations


def _order_blocks(
    equations: list[tuple[int, int]],
    solved: np.ndarray,
    owner: np.ndarray,
    has_state: np.ndarray,
    users: np.ndarray,
    needed: np.ndarray,
    node_count: int,
) -> tuple[list[Block], np.ndarray]:
    """Blocks from equations, the nodes matched to them, and the number of the block of each.

    Block ``users[k]`` needs block ``needed[k]``; both may occur there several times. States occur
    in the equations of block k if ``has_state[k]``.
    """
    count = len(has_state)
    other = users != needed
    pairs = np.unique(users[other].astype(np.int64) * count + needed[other])
    users, needed = np.divmod(pairs, count)
    needs = _group_by_key(users, needed, count)
    users_of = _group_by_key(needed, users, count)
    waiting = [len(n) for n in needs]
    order = [c for c in range(count) if not waiting[c]]
    for block in order:
        for user in users_of[block]:
            waiting[user] -= 1
            if not waiting[user]:
                order.append(user)
    place = np.empty(count, dtype=int)
    place[order] = np.arange(count)
    needs = _group_by_key(place[users], place[needed], count)
    block_of = np.full(node_count, -1)
    block_of[solved] = place[owner]
    own, nodes = _group_by_key(place[owner], np.arange(len(equations)), count), solved.tolist()
    return [
        Block([equations[r] for r in rows], [nodes[r] for r in rows], sorted(before), state)
        for rows, before, state in zip(own, needs, has_state[order].tolist(), strict=True)
    ], block_of


def _group_by_key(keys: np.ndarray, values: np.ndarray, count: int) -> list[list[int]]:
    """Values of each key 0 .. count-1."""
    sort = np.argsort(keys, kind="stable")
    ends = np.searchsorted(keys[sort], np.arange(count + 1)).tolist()
    items = values[sort].tolist()
    return [items[a:b] for a, b in itertools.pairwise(ends)]
