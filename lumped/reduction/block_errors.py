"""Texts that say why a block of equations cannot be solved."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import casadi as ca
import numpy as np

from lumped.errors import SingularModelError
from lumped.reduction.diagnosis import class_names, equation_text, factors, list_each_once
from lumped.reduction.incidence import GenericPoint, Incidence
from lumped.reduction.reduce import Reduced


def singular_block(
    reduced: Reduced, rows: list[int], nodes: list[int], holds: list[int]
) -> SingularModelError:
    """The error for a block that determines `nodes` and has no pivot left in `rows`.

    `holds` are those of its equations that hold or slide.
    """
    incidence = reduced.incidence
    listed = [equation_text(incidence, *incidence.origin(r)) for r in rows[:8]]
    why = "Likely two rigid paths transmit the same torque, so that its shares are unknown. "
    what = "Make one of them elastic."
    signals = _signals(reduced, nodes)
    rank, dependent, lost = _find_dependent(reduced, nodes)
    zeros = _zero_parameters(reduced, nodes)
    if not zeros and lost and all(reduced.class_and_order(node)[1] for node in lost):
        listed = [equation_text(incidence, *incidence.origin(r)) for r in dependent[:8]]
        why = (
            f"The matrix of its derivatives has rank {rank}, not {len(nodes)}: multiples of these "
            f"equations add up to one without {_names(reduced, lost[:12])}. "
        )
        what = "Write that one in place of one of them."
    elif signals:
        why = f"Likely {list_each_once(signals)} form a loop of signals whose gain is 1. "
        what = "Change a gain, or put a part with a state into the loop, such as a Filter."
    sliding = list(dict.fromkeys(_owner(incidence, row) for row in holds))
    if len(sliding) > 1 and rank == len(nodes):  # but for what sticks or slides
        why = (
            f"{list_each_once(sliding)} hold and slide without inertia between them, so that "
            "nothing determines the speed between two that slide at once. "
        )
        what = "Put an Inertia or Mass between each two of them."
    if zeros:
        why = f"These parameters in its equations are zero: {', '.join(zeros[:6])}. "
        what = "Give them values, or take parts without them (a Spring for a SpringDamper)."
    return SingularModelError(
        f"{incidence.flat.name}: these equations determine nothing more, "
        "or contradict the rest:\n  "
        + "\n  ".join(listed)
        + f"\nUnknowns of the block: {_names(reduced, nodes[:12])}.\n{why}{what}"
    )


class UnheldError(SingularModelError):
    """Constraints whose reactions are known and whose speeds are not.

    Attributes
    ----------
    massless : dict of str to bool
        Paths of the parts that they belong to, and whether the springs beside them are damped.
    """

    def __init__(self, message: str, massless: Mapping[str, bool] | None = None) -> None:
        super().__init__(message)
        self.massless = dict(massless or {})


def make_unheld_error(
    reduced: Reduced,
    holds: Mapping[int, tuple[int | None, int | None]],
    of: Callable[[list[int]], ca.SX],
) -> UnheldError:
    """The error for constraints whose reactions are known and whose speeds are not."""
    incidence = reduced.incidence
    states = _symbols(of(reduced.states))
    massless: dict[str, bool] = {}
    for block in reduced.blocks:
        for row, _ in block.equations:
            reaction, speed = holds.get(row, (None, None))
            if reaction is not None and reaction not in block.nodes:
                motion = set() if speed is None else _symbols(of([speed]))
                is_damped = bool(_symbols(of([reaction])) & motion & states)
                massless[_owner(incidence, row)] = is_damped
    name = next(iter(massless))
    return UnheldError(
        f"{incidence.flat.name}: {name} holds and slides, but one of its sides has no "
        "inertia, so that its reaction is known and its speed is not while it slides. Beside "
        "springs this is solved for friction that does not depend on the sliding speed, or if "
        f"they are damped. Put an Inertia or Mass on each side of {name}.",
        massless,
    )


def _symbols(expressions: ca.SX) -> set[int]:
    """Symbols in expressions."""
    return {symbol.element_hash() for symbol in ca.symvar(expressions)}


def _owner(incidence: Incidence, row: int) -> str:
    """Path of the part that an equation belongs to."""
    block, place = incidence.place(row)
    group, _, instances, _ = incidence.blocks[block]
    return group.names[int(instances[place])] or incidence.flat.name


def _signals(reduced: Reduced, nodes: list[int]) -> list[str]:
    """Parts of the block that determines the nodes; none if one of them has ports."""
    incidence = reduced.incidence
    found: dict[str, None] = {}
    for row, _ in reduced.blocks[reduced.block_of[nodes[0]]].equations:
        if incidence.origin(row)[0] == "sum":
            return []
        block, place = incidence.place(row)
        group, _, instances, _ = incidence.blocks[block]
        node = incidence.flat.tree.instances[group.nodes[int(instances[place])]]
        if node.layout.ports:
            return []
        found[_owner(incidence, row)] = None
    return list(found)


def _find_dependent(reduced: Reduced, nodes: list[int]) -> tuple[int, list[int], list[int]]:
    """Rank of a block at a generic point, equations that depend on each other, and unknowns.

    The unknowns are those that such equations leave open.
    """
    incidence = reduced.incidence
    orders = np.full(incidence.count, -1)
    rows, times = np.array(reduced.blocks[reduced.block_of[nodes[0]]].equations).T
    orders[rows] = times
    point = GenericPoint(incidence.flat, incidence.aliases, reduced.highest)
    entries = incidence.entries(orders, point, orders >= 0)
    unknown = {node: j for j, node in enumerate(nodes)}
    row = {number: i for i, number in enumerate(rows.tolist())}
    matrix = np.zeros((len(rows), len(nodes)))
    found = zip(entries.rows.tolist(), reduced.first[entries.classes] + entries.orders, strict=True)
    for (number, node), value in zip(found, entries.values.tolist(), strict=True):
        if int(node) in unknown:
            matrix[row[number], unknown[int(node)]] = np.nan_to_num(value)
    size = np.abs(matrix).max(axis=1, keepdims=True)
    U, sizes, V = np.linalg.svd(matrix / np.where(size > 0, size, 1.0))
    rank = int((sizes > 1e-12 * sizes[0]).sum())
    left, open_ = (
        np.abs(part).max(axis=1, initial=0.0) > 1e-9 for part in (U[:, rank:], V[rank:].T)
    )
    return (
        rank,
        rows[left].tolist(),
        [node for node, lost in zip(nodes, open_, strict=True) if lost],
    )


def _names(reduced: Reduced, nodes: Iterable[int]) -> str:
    found = []
    for node in nodes:
        number, order = reduced.class_and_order(node)
        name = class_names(reduced.incidence, number, 1)[0]
        found.append("der(" * order + name + ")" * order)
    return ", ".join(found)


def _zero_parameters(reduced: Reduced, nodes: list[int]) -> list[str]:
    """Parameters that are zero in the equations of the block that determines the nodes."""
    parameters = reduced.incidence.flat.parameters
    return [
        parameters.names[number]
        for row, order in reduced.blocks[reduced.block_of[nodes[0]]].equations
        for number in factors(reduced.incidence, row, order)
        if parameters.numbers[number] == 0
    ]
