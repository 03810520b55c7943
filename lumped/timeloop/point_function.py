"""Functions of a system at points one after the other, in the language of the time loop."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.code.operations import operations_of
from lumped.kernel import engine
from lumped.kernel.plant import Function
from lumped.kernel.run import Run, Samples
from lumped.timeloop.counted_function import CountedFunction

__all__ = ["PointFunction", "at_points"]

_NOTHING = dict.fromkeys(Run.lengths(), 0)


def at_points(
    function: Function,
    width: int,
    work: int,
    theta: np.ndarray,
    t: np.ndarray,
    x: np.ndarray,
    settings: np.ndarray,
) -> np.ndarray:
    """Results of a function at points, shape (points, width).

    Parameters
    ----------
    width, work : int
        How many results it has, and how much room it needs.
    theta : ndarray
        Parameters.
    t, x, settings : ndarray, shapes (points,), (points, n) and (points, m)
        Times, states, and modes with implicit quantities.
    """
    found = np.empty((len(t), width))
    run = Run({**_NOTHING, "work": work, "parameters": len(theta)})
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

    def __call__(
        self, theta: np.ndarray, t: np.ndarray, x: np.ndarray, settings: np.ndarray
    ) -> np.ndarray:
        """Results at points, shape (points, width); see `at_points`."""
        function = self.counted.for_more(len(t))
        return at_points(function, self.width, self.counted.work, theta, t, x, settings)
