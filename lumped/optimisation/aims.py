"""Two aims of a front: the best design for one of them, with limits of both."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Protocol

import scipy

from lumped.functionals import Functional
from lumped.optimisation.design import Optimum, Task
from lumped.optimisation.design_problem import DesignProblem
from lumped.tolerances.aims import Probability

Weights = Mapping[Any, float]
"""Of functionals and names of parameters."""


class Aims(Protocol):
    """Two numbers of designs, which shall both be small.

    Attributes
    ----------
    sizes : list of float
        Of both, at the start.
    """

    sizes: list[float]

    def best(self, which: int, begin: Optimum | None, limits: Mapping[int, float]) -> Optimum:
        """The design in which one is least while both keep limits."""

    def read_values(self, design: Optimum) -> list[float]:
        """Both, as limits bound them."""


class AimsOfProgramme:
    """Functionals of a run in one programme (see `Aims`)."""

    def __init__(self, problem: DesignProblem, aims: tuple[Functional, Functional]) -> None:
        self.problem, self.aims = problem, aims
        self.sizes = [problem.terms[aim].scale for aim in aims]

    def best(self, which: int, begin: Optimum | None, limits: Mapping[int, float]) -> Optimum:
        """The design in which one is least while both keep limits."""
        weights = [float(k == which) for k in range(2)]
        solution = self.problem.solve(
            weights,
            limits={self.aims[k]: most for k, most in limits.items()},
            begin=None if begin is None else begin.solution.w,
        )
        return self.problem.optimum(solution, dict(zip(self.aims, weights, strict=True)))

    def read_values(self, design: Optimum) -> list[float]:
        """Both, by the programme, whose functionals are those of a run only to `error`."""
        promised = self.problem.read_functionals(design.solution)
        return [promised[aim] for aim in self.aims]


class AimsOfSearch:
    """Weighted sums and probabilities of what is found anew for each design (see `Aims`).

    A probability is bounded by minus its reliability index.

    Parameters
    ----------
    solve : callable
        The best design of a task.
    task : Task
        What holds for all designs.
    aims : tuple of two mappings
        Weights of functionals and names.
    """

    def __init__(
        self, solve: Callable[[Task], Optimum], task: Task, aims: tuple[Weights, Weights]
    ) -> None:
        self.solve, self.task, self.aims = solve, task, aims
        self.sizes = [1.0, 1.0]

    def best(self, which: int, begin: Optimum | None, limits: Mapping[int, float]) -> Optimum:
        """The design in which one is least while both keep limits."""
        sums, bounds = list(self.task.at_most), dict(self.task.bounds)
        for k, most in limits.items():
            (key, *_) = self.aims[k]
            if isinstance(key, Probability):
                _, own = bounds.get(key, (None, 1.0))
                bounds[key] = None, min(float(own or 1.0), float(scipy.special.ndtr(most)))
            else:
                sums.append((self.aims[k], most))
        task = replace(
            self.task,
            weights=self.aims[which],
            at_most=tuple(sums),
            bounds=bounds,
            told=(*self.aims[0], *self.aims[1]),
            begin={} if begin is None else begin.parameters,
        )
        found = self.solve(task)
        if begin is None:
            size = abs(self.read_values(found)[which])
            self.sizes[which] = size or 1.0
        return found

    def read_values(self, design: Optimum) -> list[float]:
        """Both, a probability as minus its reliability index."""
        numbers = [aim_value(design, aim) for aim in self.aims]
        for k, (key, *_) in enumerate(self.aims):
            if isinstance(key, Probability):
                numbers[k] = float(scipy.special.ndtri(numbers[k]))
        return numbers


def aim_value(design: Optimum, aim: Weights) -> float:
    """A weighted sum of functionals and parameters of a design."""
    return sum(
        weight * (design.parameters[key] if isinstance(key, str) else design.values[key])
        for key, weight in aim.items()
    )
