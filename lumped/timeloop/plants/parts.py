"""Functions and tables of a plant, and their sizes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from lumped.code.bounds import bounds_of
from lumped.code.inverses import multiply_by_inverses
from lumped.code.operations import (
    INPUTS,
    RESULT,
    STATE,
    TIME,
    TWO,
    Operations,
    first_results,
    operations_of,
)
from lumped.compiler.open_conditions import open_conditions
from lumped.compiler.system import System
from lumped.kernel.enclosed import Enclosed
from lumped.kernel.instants.linkages import DIRECTIONS
from lumped.kernel.plant import Plant
from lumped.timeloop.guards import followers
from lumped.timeloop.levers import FAIR_LEVERAGE, levers
from lumped.timeloop.plants.projection import companions, projection
from lumped.timeloop.programs import rank_programs

_FIXED, _EVEN, _TIMED, _MOVING = range(4)
"""What follows parameters and settings; the time linearly; the time; states."""
_NONE = frozenset[int]()


def forcing(rates: Operations) -> Operations:
    """Functions of the time alone of which anything else reads sums and multiples.

    What is linear in the time is left out: both ends of a step tell of it.
    """
    kinds, terms = [_FIXED] * rates.work, [_NONE] * rates.work
    found = _NONE
    for k, (op, out, a, b) in enumerate(zip(*rates.table.T.tolist(), strict=True)):
        if op == RESULT:
            found |= terms[a]
            continue
        kind, together = {STATE: _MOVING, TIME: _EVEN}.get(op, _FIXED), _NONE
        if op not in INPUTS and op != ca.OP_CONST:
            own = kinds[a], kinds[b if op in TWO else a]
            kind = max(own)
            together = terms[a] | terms[b] if op in TWO else terms[a]
            if kind == _MOVING:
                found |= together
                together = _NONE
            elif kind != _FIXED and not _is_linear(op, own):
                kind, together = _TIMED, frozenset([k])
        kinds[out], terms[out] = kind, together
    ends = np.array(sorted(found), dtype=np.int64)
    results = np.zeros((len(ends), 4), dtype=np.int64)
    results[:, 0], results[:, 1], results[:, 2] = RESULT, np.arange(len(ends)), rates.table[ends, 1]
    is_own = rates.table[:, 0] != RESULT
    # results follow what gives them
    order = np.argsort(np.concatenate([np.flatnonzero(is_own), ends]), kind="stable")
    table = np.concatenate([rates.table[is_own], results])[order]
    return first_results(replace(rates, table=table, results=len(ends)), len(ends))


def _is_linear(operation: int, kinds: tuple[int, int]) -> bool:
    """Whether an operation gives sums and multiples of what it is given."""
    if operation in (ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_TWICE):
        return True
    if operation == ca.OP_MUL:
        return min(kinds) == _FIXED
    if operation == ca.OP_DIV:
        return kinds[1] == _FIXED
    return operation == ca.OP_IF_ELSE_ZERO and kinds[0] == _FIXED


class Parts(NamedTuple):
    """What a plant is made of.

    Attributes
    ----------
    functions : dict of str to Operations
        Functions of the plant by the names of its fields, but for the Jacobian.
    sizes : dict of str to int
        States, settings, parameters, and so on (see `lumped.kernel.run`).
    fields : dict of str to int or ndarray
        All other fields of the plant: its sizes and tables.
    """

    functions: dict[str, Operations]
    sizes: dict[str, int]
    fields: dict[str, Any]


def select_enclosed(functions: Mapping[str, Operations]) -> dict[str, Operations]:
    """Those functions of a plant, and of functionals, that are enclosed."""
    wanted = {"margin": "margin", "rates": "forcing", "extreme": "extreme", "load": "load"}
    return {name: functions[name] for name, of in wanted.items() if of in functions}


def find_enclosed_sizes(enclosed: Mapping[str, Operations]) -> dict[str, int]:
    """Sizes of what is needed to enclose the results of functions."""
    rows = max((len(function.table) for function in enclosed.values()), default=0)
    work = max((function.work for function in enclosed.values()), default=0)
    results = max((function.results for function in enclosed.values()), default=0)
    return {"enclosed_rows": rows, "enclosed_work": work, "enclosed_results": results}


def make_enclosed(function: Operations | None) -> Enclosed:
    """The record of a function whose results are enclosed; it may be none."""
    found = {} if function is None else {"own": function}
    sizes = find_enclosed_sizes(found)
    return Enclosed(sizes, results=sizes["enclosed_results"])


def parts_of(system: System, leverage: float = FAIR_LEVERAGE) -> Parts:
    """Functions and tables of a system as a plant has them.

    Parameters
    ----------
    leverage : float
        Ratio of what follows by iteration to the state that leads it above which that is unfit.
    """
    s, implicit = system.switching, len(system.structure.implicit)
    functions = {"rates": system.rhs}
    margins = system.margins.size1_out(0) if s else 0
    if s:
        functions["look"] = system.look
    if margins:
        functions["margin"] = system.margins
    if implicit:
        functions["closure"] = system.closure
    opened = open_conditions(system) if implicit else None
    if opened is not None:
        functions["opened"] = opened
    pairs, ratios = levers(system, leverage)
    if pairs:
        functions["leverage"] = ca.Function("leverage", system.inputs, [ratios])
    invariants = system.structure.invariants.numel()
    if invariants:
        functions["projection"] = projection(system)
    names: list[str] = []
    if s.timed:
        names, following = followers(system)
        functions |= {"following": following} if names else {}
    operations, states = operations_of_each(functions), len(system.state_names)
    if margins:
        floors = first_results(operations["margin"], margins)
        operations["margin_floor"] = bounds_of(floors, states, upper=False)
    forced = forcing(operations["rates"])
    if forced.results:
        operations |= {"forcing": forced, "forcing_range": bounds_of(forced, 0)}
    sizes = {
        "states": states,
        "settings": system.inputs[3].numel(),
        "implicit": implicit,
        "parameters": system.inputs[1].numel(),
        "margins": margins,
        "conditions": len(s.relation_modes),
        "holds": len(s.names),
        "jumps": len(s.jumps),
        "jump_values": s.values.numel(),
        "levers": len(pairs),
        "has_opened": int(opened is not None),
        "followers": len(names),
        "invariants": invariants,
        "forcings": forced.results,
    }
    uses = system.speed_uses
    first, companion = companions(system)
    fields = {
        **plant_sizes(sizes),
        "speed_uses": len(uses[0]),
        "is_moved": _integers([_is_moved(system, node) for node in system.structure.states]),
        "first_companion": _integers(first),
        "companion": _integers(companion),
        "use_hold": _integers(uses[0]),
        "use_state": _integers(uses[1]),
        "any_demand": np.random.default_rng(4).uniform(0.5, 1.5, len(s.names)),
        "any_direction": any_direction(implicit),
        **_tables(system),
    }
    return Parts(operations, sizes, fields)


def _is_moved(system: System, node: int) -> bool:
    """Whether the rate of a state is a state, or follows from states without accelerations."""
    number, order = system.structure.reduced.class_and_order(node)
    return order + 1 < int(system.structure.reduced.highest[number])


def slopes_along(system: System) -> Operations:
    """Change of the rates along a direction, whose numbers and that of the time follow states."""
    x, p, t, m = system.inputs
    v = ca.SX.sym("v", x.numel() + 1)
    along = ca.densify(ca.cse(ca.jtimes(system.rates, ca.vertcat(x, t), v)))
    return operations_of(ca.Function("slopes_along", [ca.vertcat(x, v), p, t, m], [along]))


def operations_of_each(functions: Mapping[str, ca.Function]) -> dict[str, Operations]:
    """Operations of CasADi functions; rates multiply by inverses, wherever they are made again."""
    found = {name: operations_of(function) for name, function in functions.items()}
    if "rates" in found:
        found["rates"] = multiply_by_inverses(found["rates"])
    return found


def plant_sizes(sizes: dict[str, int]) -> dict[str, Any]:
    """Sizes that a plant knows."""
    return {name: size for name, size in sizes.items() if name in Plant.fields}


def any_direction(implicit: int) -> np.ndarray:
    """Directions in which linkages are tried, the same in each run."""
    return np.random.default_rng(3).uniform(-1, 1, DIRECTIONS * implicit)


def _integers(values: Any) -> np.ndarray:
    return np.ascontiguousarray(values, dtype=np.int64)


def _tables(system: System) -> dict[str, Any]:
    """Conditions, holds, jumps and margins as tables."""
    s = system.switching
    place = {node: i for i, node in enumerate(system.structure.states)}
    pieces = [condition.pieces for condition in s.conditions]
    counts = [0 if p is None else p.count * p.width for p in pieces]
    relations = s.relation_modes.tolist()
    begins = np.cumsum([0, *(jump.width for jump in s.jumps)])
    signs = [sign for jump in s.jumps for sign in jump.fill(jump.signs, 0.0)]
    changed = [node for jump in s.jumps for node in jump.fill(jump.nodes, -1)]
    kinds = ("relation", "upper", "lower", "slide")
    integers = {
        "condition_setting": s.relation_modes,
        "is_strict": s.strict,
        "piece_count": [0 if p is None else p.count for p in pieces],
        "piece_width": [1 if p is None else p.width for p in pieces],
        "first_piece": np.cumsum([0, *counts])[:-1],
        "hold_setting": s.first_modes,
        "engaged_by": s.engaged,
        "has_upper": s.has_upper,
        "has_lower": s.has_lower,
        "has_forward": s.has_forward,
        "has_backward": s.has_backward,
        "has_gap": s.has_gap,
        "speed_state": [place.get(node, -1) for node in s.speeds],
        "is_impulsive": ~(s.has_upper & s.has_lower),
        "is_pressed": s.is_pressed,
        "may_leap": s.may_leap,
        "is_direct": s.is_direct,
        "opposite": s.opposite,
        "jump_setting": [jump.mode for jump in s.jumps],
        "jump_condition": [
            relations.index(jump.mode) if jump.mode in relations else -1 for jump in s.jumps
        ],
        "jump_asks": rank_programs(system),
        "jump_begin": begins,
        "jump_state": [place.get(node, -1) for node in changed],
        "margin_kind": [kinds.index(kind) for kind, _ in s.rows],
        "margin_number": [number for _, number in s.rows],
    }
    rows = [p.table.ravel() for _, p in s.tables]
    return {
        **{name: _integers(values) for name, values in integers.items()},
        "jump_sign": np.array(signs, dtype=float),
        "pieces": np.concatenate([np.zeros(0), *rows]),
    }
