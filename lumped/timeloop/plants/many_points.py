"""Functions evaluated at many points, in the language of the time loop."""

from __future__ import annotations

import threading
from functools import cached_property

import casadi as ca
import numpy as np

from lumped.code.functions import (
    Columns,
    compile_columns,
    compile_functions,
    load_columns,
    load_functions,
)
from lumped.code.machine_code import Code
from lumped.code.operations import Operations, operations_of
from lumped.code.step_functions import tabulate_steps
from lumped.compiler.system import System
from lumped.kernel import engine
from lumped.kernel.plant import Function as KernelFunction
from lumped.kernel.run import Run, Samples
from lumped.support.made_once import Recent, made_once
from lumped.support.process_lock import process_lock
from lumped.timeloop.plants.executable import WORTH

_NOTHING = dict.fromkeys(Run.lengths(), 0)
_NAME = "function"
"""Name of a function in its machine code."""
_KEPT = 64
"""Quantities whose functions a system keeps."""


class CountedFunction:
    """A function for kernels, interpreted until compiling it pays by how often it was evaluated.

    Both give the same bits. Code that was made before is taken from the cache.

    Parameters
    ----------
    operations : Operations
        What it does.
    columns : Columns, optional
        Of its last states, in which it is linear.

    Attributes
    ----------
    work : int
        Numbers that it needs while it is interpreted.
    """

    def __init__(self, operations: Operations, columns: Columns | None = None) -> None:
        self._operations, self._columns = operations, columns
        self.work = operations.work
        self._evaluations, self._own = 0, threading.local()
        self._code: Code | None = None
        self._record = KernelFunction(
            count=len(operations.table),
            operations=operations.table.ravel(),
            constants=operations.constants,
        )
        if columns:
            self._take(load_columns(operations, columns))
        else:
            self._take(load_functions({_NAME: operations}))

    def for_more(self, evaluations: int) -> KernelFunction:
        """The function, which will be evaluated so many times more."""
        if self._code is None:
            with process_lock:
                self._count(evaluations * (self._columns.width if self._columns else 1))
        return self._record

    def along(self, x: np.ndarray, p: np.ndarray, t: np.ndarray, m: np.ndarray) -> np.ndarray:
        """Results at each point, shape (points, results); arguments as for `ManyPoints`."""
        found = np.empty((len(t), self._operations.results))
        course = Samples(
            points=len(t),
            states=x.shape[1],
            settings=m.shape[1],
            results=self._operations.results,
            t=np.ascontiguousarray(t, dtype=float),
            x=np.ascontiguousarray(x, dtype=float).ravel(),
            m=np.ascontiguousarray(m, dtype=float).ravel(),
            found=found.ravel(),
        )
        engine.call("values", self._run_at(p), self.for_more(len(t)), course)
        return found

    def _run_at(self, p: np.ndarray) -> Run:
        """The same run each time, of this thread, with other parameters."""
        run: Run | None = getattr(self._own, "run", None)
        if run is None:
            run = self._own.run = Run({**_NOTHING, "work": self.work, "parameters": len(p)})
        run.p[:] = p
        return run

    def _count(self, evaluations: int) -> None:
        self._evaluations += evaluations
        if self._code is not None or self._evaluations <= WORTH:
            return
        if self._columns:
            self._take(compile_columns(self._operations, self._columns))
        else:
            self._take(compile_functions({_NAME: self._operations}))

    def _take(self, code: Code | None) -> None:
        if code is None:
            return
        self._code = code
        if self._columns:
            self._record.wide_address = code.address("columns")
        else:
            self._record.address = code.address(_NAME)


class ManyPoints:
    """A function ``(x, p, t, m) -> results`` of scalar operations, evaluated at many points.

    It is interpreted until it was evaluated so often that compiling it pays. Tables with many
    pieces in it are looked up. All give the same bits.

    Parameters
    ----------
    function : casadi.Function
        Its results count one after the other, with their zeros.

    Attributes
    ----------
    results : int
        How many there are.
    """

    def __init__(self, function: ca.Function) -> None:
        self._whole = operations = operations_of(function)
        self.results = operations.results
        self._lookup = tabulate_steps(operations, function.numel_in(3))
        if self._lookup is not None:
            self._arguments = CountedFunction(self._lookup.arguments)
            operations = self._lookup.rest
        self._rest = CountedFunction(operations)

    @cached_property
    def counted(self) -> CountedFunction:
        """The function for kernels."""
        return CountedFunction(self._whole)

    def __call__(self, x: np.ndarray, p: np.ndarray, t: np.ndarray, m: np.ndarray) -> np.ndarray:
        """Results at each point, shape (points, results).

        Parameters
        ----------
        x, m : ndarray, shapes (points, n) and (points, settings)
            States, and settings.
        p : ndarray
            Parameters, the same at all points.
        t : ndarray, shape (points,)
            Times.
        """
        if self._lookup is not None:
            m = np.hstack([m, self._lookup.settings(self._arguments.along(x, p, t, m))])
        return self._rest.along(x, p, t, m)


def quantity_along(
    system: System,
    key: str,
    theta: np.ndarray,
    t: np.ndarray,
    x: np.ndarray,
    settings: np.ndarray,
) -> np.ndarray:
    """A quantity at points one after the other; shape (points,).

    Parameters
    ----------
    key : str
        Its name in the system.
    theta : ndarray
        Parameters.
    t, x, settings : ndarray, shapes (points,), (points, n) and (points, m)
        Times, states, and modes with implicit quantities.
    """
    function = _recent_points(system).of(key, lambda: ManyPoints(system.function([key])))
    return function(x, theta, t, settings)[:, 0]


@made_once
def _recent_points(_: System) -> Recent[ManyPoints]:
    return Recent(_KEPT)
