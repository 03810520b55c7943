"""Parts of functions that depend on parameters only, computed once for a run.

Operations keep their order and rounding, so a function gives the same bits with its parts prepared.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import casadi as ca
import numpy as np

from lumped.code.operations import (
    PARAMETER,
    RESULT,
    Operations,
    first_results,
    places_read,
    reuse_places,
)

_READ = (PARAMETER, ca.OP_CONST)
Row = tuple[int, int, int, int]


def prepare_parts(
    functions: Mapping[str, Operations], parameters: int, inverted: Collection[str] = ()
) -> tuple[dict[str, Operations], Operations]:
    """Functions that find parts of them behind the parameters, and the function of these parts.

    Parameters
    ----------
    functions : dict of str to Operations
    parameters : int
        Number of parameters.
    inverted : collection of str
        Functions that multiply by the inverse of what depends on parameters alone, instead of
        dividing by it; their last bits may change.
    """
    common = _Parts(parameters)
    found = {
        name: common.without(function, name in inverted) for name, function in functions.items()
    }
    return found, common.operations


class _Parts:
    """Operations on parameters, each value in a place of its own."""

    def __init__(self, parameters: int) -> None:
        self._parameters = parameters
        self._rows: list[Row] = []
        self._known: dict[Row, int] = {}
        self._constants: list[float] = []
        self._slots: dict[int, int] = {}

    def _value(self, row: Row) -> int:
        """Place of a value; the same operation on the same values is done once."""
        op, _, a, b = row
        key = (op, 0, a, b)
        if key not in self._known:
            self._known[key] = len(self._rows)
            self._rows.append((op, len(self._rows), a, b))
        return self._known[key]

    def _constant(self, value: float) -> int:
        # by bits, as zeros of both signs are equal
        bits = np.float64(value).view(np.int64).item()
        key = (ca.OP_CONST, 1, bits, 0)
        if key not in self._known:
            self._known[key] = self._value((ca.OP_CONST, 0, len(self._constants), 0))
            self._constants.append(value)
        return self._known[key]

    def without(self, function: Operations, inverts: bool = False) -> Operations:
        """A function that reads what depends on parameters only."""
        held: dict[int, int] = {}
        missing: set[int] = set()
        rows: list[int] = []

        def need(place: int) -> None:
            if place in missing:
                slot = self._slots.setdefault(held[place], len(self._slots))
                rows.extend((PARAMETER, place, self._parameters + slot, 0))
                missing.discard(place)

        for op, out, a, b in zip(*function.table.T.tolist(), strict=True):
            if op == RESULT:
                need(a)
                rows += (op, out, a, b)
                continue
            read = places_read(op, a, b)
            if op in _READ:
                constant = op == ca.OP_CONST
                value = (
                    self._constant(function.constants[a])
                    if constant
                    else self._value((op, 0, a, 0))
                )
                rows += (op, out, a, b)
                held[out] = value
                missing.discard(out)
            elif read and all(place in held for place in read):
                first, last = held[read[0]], held[read[-1]]
                held[out] = self._value((op, 0, first, last))
                missing.add(out)
            elif inverts and op == ca.OP_DIV and b in held:
                need(a)
                inverse = self._value((ca.OP_INV, 0, held[b], held[b]))
                slot = self._slots.setdefault(inverse, len(self._slots))
                rows += (PARAMETER, function.work, self._parameters + slot, 0)
                rows += (ca.OP_MUL, out, a, function.work)
                held.pop(out, None)
                missing.discard(out)
            else:
                for place in read:
                    need(place)
                rows += (op, out, a, b)
                held.pop(out, None)
                missing.discard(out)
        table = np.array(rows, dtype=np.int64).reshape(-1, 4)
        whole = replace(function, table=table, work=function.work + inverts)
        return first_results(whole, whole.results)

    @property
    def operations(self) -> Operations:
        """The function of parameters that gives all parts."""
        rows: list[Row] = [*self._rows]
        rows += [(RESULT, slot, value, 0) for value, slot in self._slots.items()]
        whole = Operations(
            np.array(rows, dtype=np.int64).reshape(-1, 4),
            np.array(self._constants),
            max(len(self._rows), 1),
            len(self._slots),
        )
        return reuse_places(first_results(whole, whole.results))
