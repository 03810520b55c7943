"""A published problem: the model of a user, the same by hand in NumPy, and its reference."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

import lumped as lp

Rate = Callable[[float, np.ndarray], Any]


class ByHand(NamedTuple):
    """Rates of states in NumPy, their start, and how the quantities of the reference are read."""

    rate: Rate
    start: Sequence[float]
    read: Callable[[np.ndarray], Sequence[float]]


@dataclass(frozen=True, eq=False)
class Problem:
    """A run whose end is published.

    Parameters
    ----------
    name, source : str
        As the page names it; where model and reference are from.
    model : callable
        Makes the model.
    until : float
        End of the run, s.
    end : mapping of str to float
        Reference of quantities at the end.
    by_hand : ByHand, optional
        The same in NumPy, if it has rates in closed form.
    digits : float
        Relative error of the reference itself.
    largest : sequence of float, optional
        Largest value of each of them during the run, in two digits, where errors are relative to
        these; default is relative to the reference itself.
    start : mapping of str to float, optional
        Start values that the model does not declare.
    """

    name: str
    source: str
    model: Callable[[], lp.Component]
    until: float
    end: Mapping[str, float]
    by_hand: ByHand | None = None
    digits: float = 1e-13
    largest: Sequence[float] | None = None
    start: Mapping[str, float] | None = None

    def error(self, found: Sequence[float]) -> float:
        """Largest relative error at the end."""
        end = np.array(list(self.end.values()))
        scale = end if self.largest is None else self.largest
        return float(np.max(np.abs((np.asarray(found) - end) / scale)))

    def simulate(self, system: lp.System, rtol: float) -> lp.Trajectory:
        """Run by lumped without any hint."""
        start = dict(self.start) if self.start else None
        return lp.simulate(system, until=self.until, rtol=rtol, grid=[self.until], start=start)

    def error_of(self, run: lp.Trajectory) -> float:
        """Error of a run by lumped."""
        return self.error([run[name][-1] for name in self.end])


def accelerate(
    mass: np.ndarray, slope: np.ndarray, force: np.ndarray, bent: np.ndarray
) -> np.ndarray:
    """Accelerations of ``mass a + slope' l = force``, ``slope a + bent = 0``."""
    n, none = len(mass), np.zeros((len(slope), len(slope)))
    matrix = np.block([[mass, slope.T], [slope, none]])
    return np.linalg.solve(matrix, np.concatenate([force, -bent]))[:n]
