"""Conditions before linkages are closed: their sides at the guesses of implicit quantities."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.compiler.switching import Switching
from lumped.compiler.system import System
from lumped.reduction.open_loops import OpenLoops
from lumped.support.made_once import made_once


@made_once
def open_conditions(system: System) -> ca.Function | None:
    """Greater and lesser sides of all conditions, with guesses for implicit nodes: (x, p, t, m).

    None if no implicit node depends on a condition.
    """
    structure, modes = system.structure, system.switching.relation_modes
    values = structure.values
    sparsity = ca.jacobian_sparsity(values.of(structure.implicit), values.modes)
    if not np.isin(sparsity.get_triplet()[1], modes).any():
        return None
    opened = OpenLoops(structure.reduced)
    opened.list_constraints()
    sides = Switching(opened, foresee=structure.foresee)
    own, symbols = (ca.vertcat(v.guesses, v.states, v.time, v.modes) for v in (opened, values))
    found = ca.substitute(ca.vertcat(sides.greater, sides.less), own, symbols)
    return ca.Function("opened", system.inputs, [ca.densify(structure.in_states(found))])
