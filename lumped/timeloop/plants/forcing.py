"""What of the rates follows the time alone."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np

from lumped.code.operations import (
    INPUTS,
    RESULT,
    STATE,
    TIME,
    TWO,
    Operations,
    first_results,
)

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
