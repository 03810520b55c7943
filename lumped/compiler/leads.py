"""The same system with other states."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from lumped.compiler.system import System
from lumped.reduction.state_selection import RANK
from lumped.support.made_once import made_once
from lumped.support.process_lock import process_lock


@made_once
def free_coordinates(system: System, node: int) -> System:
    """The same system in redundant coordinates: all that varying constraints tie are states.

    So is the motion of a node (-1 for none), even if an explicit formula determines it.
    """
    ranks = system.structure.ranks if system.structure.redundant else {}
    if node >= 0:
        ranks = _with_rank(system, ranks, node, RANK["always"])
    found = System(system.structure.with_changes(ranks=ranks, redundant=True))
    found.bound = system.bound
    return found


def exchange_states(system: System, pairs: Iterable[tuple[int, int]]) -> System:
    """The same system with the motions of followers as states instead of those of leaders.

    Positions and speeds change places together.
    """
    structure, ranks = system.structure, system.structure.ranks
    for follower, leader in pairs:
        ranks = _with_rank(system, ranks, follower, RANK["always"])
        ranks = _with_rank(system, ranks, leader, RANK["never"])
    own, key = (tuple(sorted(r.items())) for r in (structure.ranks, ranks))
    with process_lock:
        system.by_ranks[own] = system
        if key not in system.by_ranks:
            system.by_ranks[key] = other = System(structure.with_changes(ranks=ranks))
            other.by_ranks = system.by_ranks
        return system.by_ranks[key]


def _with_rank(system: System, ranks: Mapping[int, int], node: int, rank: int) -> dict[int, int]:
    """Ranks in which the motion of a node has another."""
    reduced = system.structure.reduced
    number, _ = reduced.class_and_order(node)
    first, highest = int(reduced.first[number]), int(reduced.highest[number])
    return {**ranks, **dict.fromkeys(range(first, first + highest), rank)}
