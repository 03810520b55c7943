"""Functions of a system at points one after the other, in the language of the time loop."""

from __future__ import annotations

import threading

import casadi as ca
import numpy as np

from lumped.code.operations import operations_of
from lumped.kernel import engine
from lumped.kernel.plant import Function
from lumped.kernel.run import Run, Samples
from lumped.timeloop.counted_function import CountedFunction

__all__ = ["PointFunction", "at_points", "room_for"]

_NOTHING = dict.fromkeys(Run.lengths(), 0)


def at_points(
    function: Function,
    width: int,
    run: Run,
    theta: np.ndarray,
    t: np.ndarray,
    x: np.ndarray,
    settings: np.ndarray,
) -> np.ndarray:
    """Results of a function at points, shape (points, width).

    Parameters
    ----------
    width : int
        How many results it has.
    run : Run
        From `room_for`, of this thread.
    theta : ndarray
        Parameters.
    t, x, settings : ndarray, shapes (points,), (points, n) and (points, m)
        Times, states, and modes with implicit quantities.
    """
    found = np.empty((len(t), width))
    run.p[:] = theta
    course = Samples(
        points=len(t),
        states=x.shape[1],
        settings=settings.shape[1],
        width=width,
        t=np.ascontiguousarray(t),
        x=np.ascontiguousarray(x).ravel(),
        m=np.ascontiguousarray(settings).ravel(),
        found=found.ravel(),
    )
    engine.call("values", run, function, course)
    return found


def room_for(work: int, parameters: int) -> Run:
    """Room to evaluate functions that need so many numbers."""
    return Run({**_NOTHING, "work": work, "parameters": parameters})


class PointFunction:
    """A function of states, parameters, time and settings that is compiled when that pays.

    Parameters
    ----------
    function : Function
        (x, p, t, m); of sparse results only the nonzeros are given.

    Attributes
    ----------
    width : int
        Number of its results.
    counted : CountedFunction
        The function for kernels.
    """

    def __init__(self, function: ca.Function) -> None:
        operations = operations_of(function, full=False)
        self.width, self.counted = operations.results, CountedFunction(operations)
        self._own = threading.local()

    def __call__(
        self, theta: np.ndarray, t: np.ndarray, x: np.ndarray, settings: np.ndarray
    ) -> np.ndarray:
        """Results at points, shape (points, width); see `at_points`."""
        run: Run | None = getattr(self._own, "run", None)
        if run is None:
            run = self._own.run = room_for(self.counted.work, len(theta))
        function = self.counted.for_more(len(t))
        return at_points(function, self.width, run, theta, t, x, settings)
