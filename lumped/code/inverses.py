"""Divisions of a function as products with inverses, one for all divisions by the same number.

The inverse of what depends on parameters alone is then computed once for a run (see
`parameter_parts`). A product with an inverse may differ from the quotient in its last bit.
"""

from __future__ import annotations

import casadi as ca

from lumped.code.operations import INPUTS, RESULT, OperationRows, Operations, places_read


def multiply_by_inverses(function: Operations) -> Operations:
    """The same function without divisions of anything but one."""
    rows = OperationRows()
    held = [0] * function.work
    for op, out, a, b in zip(*function.table.T.tolist(), strict=True):
        if op == RESULT:
            rows.result(out, held[a])
        elif op == ca.OP_CONST:
            held[out] = rows.constant(float(function.constants[a]))
        elif op in INPUTS:
            held[out] = rows.apply(op, a, 0)
        elif op == ca.OP_DIV:
            held[out] = rows.apply(ca.OP_MUL, held[a], rows.apply(ca.OP_INV, held[b]))
        else:
            held[out] = rows.apply(op, *(held[place] for place in places_read(op, a, b)))
    return rows.operations(function.results)
