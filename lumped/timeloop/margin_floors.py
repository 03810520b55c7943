"""Lower bounds of margins over a step, as a function of a plant."""

from __future__ import annotations

import casadi as ca

from lumped.compiler.system import System
from lumped.numerics.interval_bounds import bounds_of

__all__ = ["margin_floors"]


def margin_floors(system: System) -> ca.Function:
    """Lower bounds of the margins while states and time move: (ends, p, t, m).

    Ends are the least values of all states, then the greatest, then the times between which they
    take them.
    """
    inputs = system.inputs
    margins = ca.densify(system.structure.in_states(system.switching.margins[0]))
    function = ca.Function("margins", inputs, [margins])
    x, p, t, m = inputs
    n = x.numel()
    ends = ca.SX.sym("ends", 2 * n + 2)
    place = ca.vertsplit(ends)
    states = [(place[i], place[n + i]) for i in range(n)]
    parameters, settings = ([(v, v) for v in ca.vertsplit(part)] for part in (p, m))
    between = [states, parameters, [(place[2 * n], place[2 * n + 1])], settings]
    floors = [low for low, _ in bounds_of(function, between)[0]]
    return ca.Function("floors", [ends, p, t, m], [ca.vertcat(*floors)])
