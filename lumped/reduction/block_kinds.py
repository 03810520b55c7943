"""Blocks of equations: which are formulas, which must be solved, and what they consist of."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from lumped.reduction.incidence import Occurrence
from lumped.reduction.reduce import Block, Reduced


def find_solved_blocks(reduced: Reduced, reactions: Iterable[int]) -> tuple[set[int], set[int]]:
    """Blocks that are no formulas, and those of them not linear in their unknowns.

    Equations in `reactions` hold a motion.
    """
    blocks, incidence = reduced.blocks, reduced.incidence
    owner = np.repeat(np.arange(len(blocks)), [len(block.nodes) for block in blocks])
    joint = {b for b, block in enumerate(blocks) if len(block.nodes) > 1}
    loops: set[int] = set()
    block_of = np.append(reduced.block_of, -1)
    rows, orders = equations_of(blocks)
    joint.update(owner[np.isin(rows, list(reactions))].tolist())
    for places, seen in incidence.alike(rows, orders):
        inside = block_of[nodes_of(reduced, seen)] == owner[places][:, None]
        several = np.flatnonzero(inside.sum(axis=1) > 1)
        joint.update(owner[places[several]].tolist())
        affine = seen.residual.affine
        for k in range(len(places)) if not affine.all() else ():
            here = np.flatnonzero(inside[k])
            if not affine[np.ix_(here, here)].all():
                loops.add(int(owner[places[k]]))
    return joint | loops, loops


def nodes_of(reduced: Reduced, seen: Occurrence) -> np.ndarray:
    """Nodes in instances of an equation; one after the last where a quantity is always zero."""
    first = reduced.first
    nodes: np.ndarray = np.where(seen.classes >= 0, first[seen.classes] + seen.orders, first[-1])
    return nodes


def equations_of(blocks: list[Block]) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the equations of blocks, and how often each is differentiated."""
    pairs = [pair for block in blocks for pair in block.equations]
    numbers, orders = np.array(pairs, dtype=int).reshape(-1, 2).T
    return numbers, orders
