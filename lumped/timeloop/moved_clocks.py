"""Functions of time whose instants move when some parameters vary."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from lumped.compiler.system import System
from lumped.timeloop.clocks import clocks


@dataclass(frozen=True, eq=False)
class MovedClocks:
    """Clocks that move with some parameters.

    Attributes
    ----------
    are_plain : bool
        Whether all that move are linear in the time and no other needs them; if not, `numbers` is
        empty.
    numbers : list of int
        Numbers of these clocks.
    relations : list of (int, bool)
        Mode of each, and whether it is false where its sides are equal.
    function : Function
        Their arguments, then the slopes of these by time: (x, p, t, m) -> (2 k,).
    """

    are_plain: bool
    numbers: list[int]
    relations: list[tuple[int, bool]]
    function: ca.Function


def find_moved_clocks(system: System, varied: ca.SX) -> MovedClocks:
    """Clocks that move with parameters, given as symbols."""
    everything = clocks(system)
    moved = [
        k
        for k, clock in enumerate(everything)
        if varied.numel() and ca.depends_on(clock.condition.argument, varied)
    ]
    needed = {i for clock in everything for i in clock.needs}
    are_plain = all(
        everything[k].condition.pieces is None and everything[k].even and not everything[k].needs
        for k in moved
    ) and needed.isdisjoint(moved)
    chosen = moved if are_plain else []
    own = [everything[k] for k in chosen]
    columns = [ca.SX(0, 1), *(c.condition.argument for c in own), *(c.slope for c in own)]
    function = ca.Function("at", system.inputs, [ca.densify(ca.vertcat(*columns))])
    relations = [(c.condition.mode, bool(c.condition.relation.strict)) for c in own]
    return MovedClocks(are_plain, chosen, relations, function)
