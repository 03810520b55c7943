"""Parts that do nothing: connected to nothing, or with all ends in one place; idle parameters."""

from __future__ import annotations

from collections.abc import Iterator

import casadi as ca
import numpy as np

from lumped.flattening.flat_model import FlatModel, Group
from lumped.language.expression import Ref
from lumped.support.sparse_graph import find_sets


def find_idle_parts(flat: FlatModel) -> list[str]:
    """Texts on parts that do nothing, with their paths.

    A part is connected to nothing if it has ports and others are connected. The ends of a part are
    in one place if connections, and equations ``a == b`` of rigid parts, join them; a part that
    joins its own ends, such as an inertia, is not meant.
    """
    joined = np.array([pair[:2] for pair in flat.joints.equal], dtype=int).reshape(-1, 2)
    touched = np.zeros(flat.tree.unknown_count, dtype=bool)
    touched[joined] = True
    return [*_find_alone(flat, touched), *_find_closed(flat, joined, touched)]


def find_idle_parameters(flat: FlatModel) -> list[str]:
    """Names of parameters with a value of their own that no equation and no start value has."""
    own = flat.parameters
    used = {n for g in (*flat.groups, *flat.initial) for n in g.parameters.ravel().tolist()}
    every = [own.values[sorted(used)], *flat.given.values(), *flat.starts.values()]
    found = ca.jacobian_sparsity(ca.vertcat(ca.SX(0, 1), *every), own.theta).get_triplet()[1]
    reached = set(found)
    return [name for i, name in enumerate(own.free_names) if i not in reached]


def _find_alone(flat: FlatModel, touched: np.ndarray) -> Iterator[str]:
    """Parts connected to nothing."""
    parts = [n for n in flat.tree.instances if n.layout.ports and not n.children and n.parent >= 0]
    for node in parts if touched.any() else ():
        if not touched[node.first_unknown : node.first_unknown + len(node.layout.names)].any():
            yield f"{node.label} is connected to nothing. Connect it, or leave it out."


def _find_closed(flat: FlatModel, joined: np.ndarray, touched: np.ndarray) -> Iterator[str]:
    """Parts whose ends are all in one place."""
    tree, pairs, rigid = flat.tree, [joined], set[int]()
    for group in flat.groups:
        columns, count = _same(flat, group), len(group.template.unknowns)
        pairs += [group.unknowns[:, pair] for pair in columns]
        layout = tree.instances[group.nodes[0]].layout
        potentials = {("", name) for name in layout.names[: 2 * len(layout.ports) : 2]}
        own = [i for key, i in group.template.unknowns.items() if key in potentials]
        if len(columns) and len(set(find_sets(columns, count)[own])) < len(own):
            rigid.update(group.nodes)
    place = find_sets(np.concatenate(pairs), tree.unknown_count)
    for number, node in enumerate(tree.instances):
        ends = [i for i in range(len(node.layout.ports)) if touched[node.first_unknown + 2 * i]]
        loose = [i for i in range(len(node.layout.ports)) if i not in ends]
        # at an end that is open and free the part may move
        may_move = any(tree.port(node, i).free for i in loose)
        if len(ends) < 2 or node.children or number in rigid or may_move:
            continue
        if len(set(place[[node.first_unknown + 2 * i for i in ends]])) == 1:
            names = " and ".join(node.layout.ports[i] for i in ends)
            yield (
                f"{node.label} does nothing: its {names} are joined to one another. Connect one "
                "of them to something else, or leave the part out."
            )


def _same(flat: FlatModel, group: Group) -> np.ndarray:
    """Columns of unknowns that an equation of a group makes equal, shape (k, 2)."""
    tree, scope = flat.tree, flat.tree.instances[group.nodes[0]]
    local = group.template.unknowns
    found = []
    for equation in group.equations:
        sides = [s for s in (equation.left, equation.right) if isinstance(s, Ref)]
        if all(side.quantity.kind in ("potential", "variable") for side in sides):
            keys = [(tree.below(side.owner, scope) or "", side.name) for side in sides]
            found.append([local[key] for key in keys if key in local])
    return np.array([pair for pair in found if len(pair) == 2], dtype=int).reshape(-1, 2)
