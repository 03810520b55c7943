"""Functions evaluated at many points, in the language of the time loop."""

from __future__ import annotations

from functools import cached_property

import casadi as ca
import numpy as np

from lumped.code.operations import Operations, operations_of
from lumped.code.step_functions import tabulate_steps
from lumped.kernel import engine
from lumped.kernel.run import Run, Samples
from lumped.timeloop.plants.counted_function import CountedFunction

_NOTHING = dict.fromkeys(Run.lengths(), 0)


class ManyPoints:
    """A function ``(x, p, t, m) -> results`` of scalar operations, evaluated at many points.

    It is interpreted until it was evaluated so often that compiling it pays. Tables with many
    pieces in it are looked up. All give the same bits.

    Parameters
    ----------
    function : Function
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
            self._arguments = _Evaluated(self._lookup.arguments)
            operations = self._lookup.rest
        self._rest = _Evaluated(operations)

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
            m = np.hstack([m, self._lookup.settings(self._arguments(x, p, t, m))])
        return self._rest(x, p, t, m)


class _Evaluated:
    """Operations made at many points."""

    def __init__(self, operations: Operations) -> None:
        self._results, self._code = operations.results, CountedFunction(operations)

    def __call__(self, x: np.ndarray, p: np.ndarray, t: np.ndarray, m: np.ndarray) -> np.ndarray:
        found = np.empty((len(t), self._results))
        run = Run({**_NOTHING, "work": self._code.work, "parameters": len(p)})
        run.p[:] = p
        course = Samples(
            points=len(t),
            states=x.shape[1],
            settings=m.shape[1],
            results=self._results,
            t=np.ascontiguousarray(t, dtype=float),
            x=np.ascontiguousarray(x, dtype=float).ravel(),
            m=np.ascontiguousarray(m, dtype=float).ravel(),
            found=found.ravel(),
        )
        engine.call("values", run, self._code.for_more(len(t)), course)
        return found
