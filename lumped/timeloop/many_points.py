"""Functions evaluated at many points, in the language of the time loop."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.code.operations import operations_of
from lumped.kernel import engine
from lumped.kernel.run import Run, Samples
from lumped.timeloop.counted_function import CountedFunction

__all__ = ["ManyPoints"]

_NOTHING = dict.fromkeys(Run.lengths(), 0)


class ManyPoints:
    """A function ``(x, p, t, m) -> results`` of scalar operations, evaluated at many points.

    It is interpreted until it was evaluated so often that compiling it pays; both give the same
    bits.

    Parameters
    ----------
    function : Function
        Its results count one after the other, with their zeros.

    Attributes
    ----------
    results : int
        How many there are.
    counted : CountedFunction
        The function for kernels.
    """

    def __init__(self, function: ca.Function) -> None:
        operations = operations_of(function)
        self.results, self.counted = operations.results, CountedFunction(operations)

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
        found = np.empty((len(t), self.results))
        run = Run({**_NOTHING, "work": self.counted.work, "parameters": len(p)})
        run.p[:] = p
        course = Samples(
            points=len(t),
            states=x.shape[1],
            settings=m.shape[1],
            results=self.results,
            t=np.ascontiguousarray(t, dtype=float),
            x=np.ascontiguousarray(x, dtype=float).ravel(),
            m=np.ascontiguousarray(m, dtype=float).ravel(),
            found=found.ravel(),
        )
        engine.call("values", run, self.counted.for_more(len(t)), course)
        return found
