"""Rigid loops that leave no motion, such as two gears of unequal ratio between the same shafts.

Such a loop is a regular system: as many constraints as motions, all of them zero. So nothing fails,
and nothing ever moves. Among the blocks of the velocities it is one that needs neither a state nor
a prescribed motion.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from lumped.errors import SingularModelError
from lumped.flattening.flat_model import FlatModel
from lumped.reduction.diagnosis import list_each_once, list_equations, lock
from lumped.reduction.pruning import LeftOut
from lumped.reduction.reduce import Block, Reduced
from lumped.support.sparse_graph import find_sets


def find_locked_loops(reduced: Reduced) -> list[LeftOut]:
    """Rigid loops in which nothing can move because something outside them is held.

    Whether this is meant cannot be known: two brakes may hold a gearbox on purpose.

    Raises
    ------
    SingularModelError
        If a loop locks itself: nothing holds it but open ports that ground themselves.
    """
    loops = _loops(reduced)
    still = _still(reduced, loops)
    if not still.intersection(loops):
        return []
    incidence = reduced.incidence
    flat = incidence.flat
    grounded = _find_grounded(flat)
    by_class = np.argsort(reduced.aliases.classes, kind="stable")
    ends = np.searchsorted(reduced.aliases.classes[by_class], np.arange(reduced.aliases.count + 1))
    found: dict[tuple[int, ...], LeftOut] = {}
    for number in sorted(still.intersection(loops)):
        block = reduced.blocks[number]
        classes = tuple(sorted({reduced.class_and_order(node)[0] for node in block.nodes}))
        members = [by_class[ends[c] : ends[c + 1]].tolist() for c in classes]
        if classes in found or not _move(flat, members):
            continue
        rows = sorted(row for row, _ in block.equations)
        names = _names(flat, members)
        if not block.needs and grounded[_zeros(reduced, block)].all():
            raise SingularModelError(
                f"{flat.name}: these constraints leave no motion of {names}:\n"
                f"{list_equations(incidence, rows)}\n{lock(incidence, rows)}"
            )
        parts = list_each_once(flat.origin(incidence.origin(r)[1])[0].label for r in rows)
        found[classes] = LeftOut(names, f"locked: {parts} and what is held leave no motion")
    return list(found.values())


def _loops(reduced: Reduced) -> list[int]:
    """Blocks of constraints that go round in a circle, without states."""
    found = []
    single: dict[tuple[int, int], list[tuple[int, int]]] = defaultdict(list)
    incidence, differentiations = reduced.incidence, reduced.differentiations.tolist()
    for number, block in enumerate(reduced.blocks):
        row, order = block.equations[0]
        if block.has_state or order >= differentiations[row]:
            continue
        if len(block.nodes) > 1:
            found.append(number)
        elif row < incidence.first_sum and not block.needs:
            origin, place = incidence.place(row)
            single[origin, order].append((number, place))
    for (origin, order), members in single.items():
        seen = incidence.occurrence(origin, order, np.array([place for _, place in members]))
        twice = (seen.classes >= 0).sum(axis=1) > 1  # one motion, at two ends of a part
        found += [number for (number, _), loop in zip(members, twice, strict=True) if loop]
    return found


def _still(reduced: Reduced, loops: list[int]) -> set[int]:
    """Of some blocks and those that they need, the ones whose unknowns are zero at all times."""
    todo: set[int] = set()
    stack = list(loops)
    while stack:
        number = stack.pop()
        if number not in todo:
            todo.add(number)
            stack.extend(reduced.blocks[number].needs)
    still: set[int] = set()
    for number in sorted(todo):
        block = reduced.blocks[number]
        if block.has_state or not still.issuperset(block.needs):
            continue
        if all(reduced.incidence.proportional(*equation) for equation in block.equations):
            still.add(number)
    return still


def _move(flat: FlatModel, members: list[list[int]]) -> bool:
    """Whether quantities are motions of ports, and no torques."""
    kinds = {flat.tree.quantity(u).kind for own in members for u in own}
    return "potential" in kinds and "flow" not in kinds


def _find_grounded(flat: FlatModel) -> np.ndarray:
    """Whether each unknown is the position of an open port that grounds itself."""
    pairs = np.array([pair[:2] for pair in flat.joints.equal], dtype=int).reshape(-1, 2)
    label = find_sets(pairs, flat.tree.unknown_count)
    return np.isin(label, label[[u for u, _ in flat.joints.grounded]])


def _zeros(reduced: Reduced, block: Block) -> np.ndarray:
    """Unknowns in the equations of a block that are zero."""
    incidence, found = reduced.incidence, []
    for row, order in block.equations:
        origin, place = incidence.place(row)
        seen = incidence.occurrence(origin, order, np.array([place]))
        unknowns = seen.group.unknowns[seen.instances[0], seen.residual.locals]
        found.append(unknowns[seen.classes[0] < 0])
    return np.concatenate(found)


def _names(flat: FlatModel, members: list[list[int]]) -> str:
    """A name for each class; a variable's before that of a port."""
    tree = flat.tree
    best = (min(own, key=lambda u: (tree.quantity(u).kind != "variable", u)) for own in members)
    return list_each_once(tree.unknown_name(u) for u in best)
