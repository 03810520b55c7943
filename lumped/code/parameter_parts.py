"""Parts of functions that depend on parameters only, computed once for a run.

Operations keep their order and rounding, so a function gives the same bits with its parts prepared.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca
import numpy as np

from lumped.code.operations import (
    PARAMETER,
    RESULT,
    OperationRows,
    Operations,
    first_results,
    places_read,
)

_READ = (PARAMETER, ca.OP_CONST)
Row = tuple[int, int, int, int]


def prepare_parts(
    functions: Mapping[str, Operations], parameters: int
) -> tuple[dict[str, Operations], Operations]:
    """Functions that find parts of them behind the parameters, and the function of these parts.

    Parameters
    ----------
    functions : dict of str to Operations
    parameters : int
        Number of parameters.
    """
    common = _Parts(parameters)
    found = {name: common.without(function) for name, function in functions.items()}
    return found, common.operations


class _Parts:
    """Operations on parameters, and which of their values functions find behind the parameters."""

    def __init__(self, parameters: int) -> None:
        self._parameters = parameters
        self._rows = OperationRows()
        self._slots: dict[int, int] = {}

    def _read(self, place: int, value: int) -> Row:
        """The operation that reads a value into a place."""
        slot = self._slots.setdefault(value, len(self._slots))
        return PARAMETER, place, self._parameters + slot, 0

    def without(self, function: Operations) -> Operations:
        """A function that reads what depends on parameters only."""
        held: dict[int, int] = {}
        missing: set[int] = set()
        rows: list[int] = []
        for op, out, a, b in zip(*function.table.T.tolist(), strict=True):
            read = places_read(op, a, b)
            value = None
            if op == ca.OP_CONST:
                value = self._rows.constant(float(function.constants[a]))
            elif op == PARAMETER:
                value = self._rows.apply(op, a, 0)
            elif op != RESULT and read and all(place in held for place in read):
                value = self._rows.apply(op, *(held[place] for place in read))
            if value is not None and op not in _READ:
                held[out] = value
                missing.add(out)
                continue
            for place in read:
                if place in missing:
                    rows += self._read(place, held[place])
                    missing.discard(place)
            rows += (op, out, a, b)
            if op == RESULT:
                continue
            missing.discard(out)
            held.pop(out, None)
            if value is not None:
                held[out] = value
        table = np.array(rows, dtype=np.int64).reshape(-1, 4)
        return first_results(replace(function, table=table), function.results)

    @property
    def operations(self) -> Operations:
        """The function of parameters that gives all parts."""
        for value, slot in self._slots.items():
            self._rows.result(slot, value)
        return self._rows.operations(len(self._slots))
