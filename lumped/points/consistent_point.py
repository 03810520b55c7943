"""Starts that the chosen states do not reach: found in all that is tied, led by other states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca
import numpy as np

from lumped.compiler.system import Changes, System
from lumped.errors import StartError
from lumped.flattening.residual import VARYING
from lumped.points.consistent_start import ConsistentStart
from lumped.points.start_search import StartSearch
from lumped.points.start_values import declares_followers
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once
from lumped.timeloop.clocks import modes_at
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.settings import close_settings, just_after

_HELD = 1e-9


def consistent_point(
    system: System, theta: np.ndarray, start: Changes, time: float, found: OperatingPoint | None
) -> OperatingPoint | None:
    """The point at which constraints, given and declared values hold, before any impact.

    Parameters
    ----------
    found : OperatingPoint or None
        What the states in use lead to, before any impact; None if they lead to nothing.

    Returns
    -------
    OperatingPoint or None
        None if that is right, or if more is demanded than values of tied quantities.

    Raises
    ------
    StartError
        If nothing was found before, and there is no such point.
    """
    structure = system.structure
    reduced = structure.reduced
    if not is_doubtful(system):
        return None
    search = StartSearch(system, theta, start, [], time)
    search.sort()
    stores = search.fixed, search.targets, search.guessed
    held = {node: value for store in stores for node, (_, value) in store.items()}
    starts = [(reduced.node(u), search.signed(u, v)) for u, v in search.starts.items()]
    declared = {node: value for node, value in starts if node is not None}
    if not held.keys() <= reduced.tied | set(reduced.states):
        return None
    modes = modes_at(system, theta, just_after(time))
    if found is not None:
        modes = found.settings[: len(modes)]
    guess = declared | held
    tied = ConsistentStart(system, theta, time, modes, guess, set(held))
    lost: tuple[str, ...] = ()
    values: dict[int, float] = {}
    turned = False
    if found is not None:
        values = tied_values(system, found)
        lost = _list_lost(system, guess, values)
        turned = any(
            abs(values[n] - guess.get(n, 0.0)) > np.pi
            for n in structure.implicit
            if n in values and _is_angle(system, n)
        )
        if not (lost or turned or tied.is_unfit(values)):
            return None
    try:
        every = tied.find()
    except StartError:
        if found is None or tied.is_unfit(values):
            raise
        return replace(found, lost=lost)
    try:
        pairs = tied.lead(every) if tied.is_unfit(every) else []
    except StartError:
        if found is None:
            raise
        return replace(found, lost=lost)
    if found is not None and not (lost or turned or pairs):
        return None
    led = system.exchange_states(pairs) if pairs else system
    now = {**guess, **every}
    x = np.array([now.get(node, 0.0) for node in led.structure.states])
    guesses = np.array([now.get(node, 0.0) for node in led.structure.implicit])
    settings = close_settings(led, x, theta, time, modes, guesses)
    return OperatingPoint(led, time, x, theta, settings, lost=_list_lost(system, guess, every))


def _list_lost(
    system: System, wanted: Mapping[int, float], values: Mapping[int, float]
) -> tuple[str, ...]:
    """Start values that do not hold, in words."""
    return tuple(
        f"{system.structure.node_name(n)} = {v:.6g}"
        for n, v in wanted.items()
        if n in values and not abs(values[n] - v) <= _HELD * max(1.0, abs(v))
    )


@made_once
def is_doubtful(system: System) -> bool:
    """Whether constraints vary, or declared values of what is no state may not hold."""
    structure = system.structure
    reduced = structure.reduced
    if not reduced.tied:
        return False
    if declares_followers(system):
        return True
    numbers = reduced.differentiations
    rows = np.array([(e, k) for e in np.flatnonzero(numbers) for k in range(numbers[e])])
    alike = reduced.incidence.alike(rows[:, 0], rows[:, 1])
    return any(bool((seen.residual.kinds == VARYING).any()) for _, seen in alike)


@made_once
def _known_nodes(system: System) -> tuple[list[int], ArrayFunction]:
    """Tied nodes that follow from the states in use, and their values."""
    structure = system.structure
    tied = sorted(structure.reduced.tied)
    usable = structure.available(tied, cyclic=True)
    nodes = [n for n, ok in zip(tied, usable, strict=True) if ok]
    values = ca.densify(structure.in_states(structure.values.of(nodes)))
    return nodes, ArrayFunction(ca.Function("tied", system.inputs, [values]))


def tied_values(system: System, point: OperatingPoint) -> dict[int, float]:
    """Values of tied nodes that follow from the states in use."""
    nodes, function = _known_nodes(system)
    return dict(zip(nodes, function(*point.inputs)[0].tolist(), strict=True))


def _is_angle(system: System, node: int) -> bool:
    member = system.structure.members.get(node)
    return member is not None and system.structure.tree.quantity(member).unit == "rad"
