"""Bounds of quantities over a step, as functions of a plant or of what functionals need."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from lumped.compiler.system import System
from lumped.numerics.interval_bounds import Interval, bounds_of

__all__ = ["heights", "margin_floors"]


def margin_floors(system: System) -> ca.Function:
    """Lower bounds of the margins while states and time move: (ends, p, t, m).

    Ends are the least values of all states, then the greatest, then the times between which they
    take them.
    """
    margins = system.structure.in_states(system.switching.margins[0])
    inputs, bounds = _between(system, margins)
    return ca.Function("floors", inputs, [ca.vertcat(*(low for low, _ in bounds))])


def heights(system: System, quantities: Sequence[ca.SX], signs: Sequence[int]) -> ca.Function:
    """What quantities times their signs do not exceed, likewise; their sizes where that is 0."""
    inputs, bounds = _between(system, ca.vertcat(*quantities))
    upper = [
        ca.fmax(high, -low) if sign == 0 else high if sign > 0 else -low
        for (low, high), sign in zip(bounds, signs, strict=True)
    ]
    return ca.Function("heights", inputs, [ca.densify(ca.vertcat(*upper))])


def _between(system: System, quantities: ca.SX) -> tuple[list[ca.SX], list[Interval]]:
    """Arguments, and the bounds of some quantities."""
    x, p, t, m = system.inputs
    function = ca.Function("quantities", system.inputs, [ca.densify(quantities)])
    n = x.numel()
    ends = ca.SX.sym("ends", 2 * n + 2)
    place = ca.vertsplit(ends)
    states = [(place[i], place[n + i]) for i in range(n)]
    parameters, settings = ([(v, v) for v in ca.vertsplit(part)] for part in (p, m))
    between = [states, parameters, [(place[2 * n], place[2 * n + 1])], settings]
    return [ends, p, t, m], bounds_of(function, between)[0]
