"""A function of a plant that is compiled as soon as that is worth it."""

from __future__ import annotations

from lumped.code.functions import (
    compile_columns,
    compile_functions,
    load_columns,
    load_functions,
)
from lumped.code.machine_code import Code
from lumped.code.operations import Operations
from lumped.kernel.plant import Function
from lumped.support.process_lock import process_lock
from lumped.timeloop.plants.executable import WORTH


class CountedFunction:
    """A function, interpreted until it was evaluated so often that compiling it pays.

    Both give the same bits. Code that was made before is taken from the cache.

    Parameters
    ----------
    operations : Operations
        What it does.
    columns, columns_from : int
        How many columns its last states have, and the first of these; no columns by default.

    Attributes
    ----------
    work : int
        Numbers that it needs while it is interpreted.
    """

    def __init__(self, operations: Operations, columns: int = 0, columns_from: int = 0) -> None:
        self._operations, self._columns, self._from = operations, columns, columns_from
        self.work = operations.work
        self._evaluations = 0
        self._code: Code | None = None
        self._record = Function(
            count=len(operations.table),
            operations=operations.table.ravel(),
            constants=operations.constants,
        )
        if columns:
            self._take(load_columns(operations, columns, columns_from))
        else:
            self._take(load_functions({"columns": operations}))

    def for_more(self, evaluations: int) -> Function:
        """The function, which will be evaluated so many times more."""
        if self._code is None:
            with process_lock:
                self._count(evaluations * max(self._columns, 1))
        return self._record

    def _count(self, evaluations: int) -> None:
        self._evaluations += evaluations
        if self._code is not None or self._evaluations <= WORTH:
            return
        if self._columns:
            self._take(compile_columns(self._operations, self._columns, self._from))
        else:
            self._take(compile_functions({"columns": self._operations}))

    def _take(self, code: Code | None) -> None:
        if code is None:
            return
        self._code = code
        name = "wide_address" if self._columns else "address"
        setattr(self._record, name, code.address("columns"))
