"""A search for the best design: scaled parameters, an objective and rows that are not negative."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.errors import OptimisationError
from lumped.functionals import Functional
from lumped.numerics.nlp import Solution
from lumped.numerics.sqp import list_bound_rows, sqp
from lumped.optimisation.design import Key, Optimum, Task, bounds_of, find_varied
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.run_options import RunPlan
from lumped.tolerances.aims import Probability, RobustAim
from lumped.tolerances.of_designs import (
    CheckedProbability,
    DesignAim,
    DesignProbability,
    MovedScene,
)
from lumped.tolerances.scene import Scattered

Row = tuple[float, np.ndarray, str]
"""What must not be negative, its gradient by the scaled unknowns, and its name."""

_PRESSES = 1e-4
"""Distance of a reliability index from its bound below which the bound holds the design."""
_SEARCHES = 8
"""How often a design is searched for a probability that samples confirm."""


class DesignSearch:
    """Sequential quadratic programming in scaled parameters.

    Parameters
    ----------
    what : System, Modes or OrderResponse
        What is optimised.
    point : OperatingPoint
        Whose parameters hold at the start.
    task : Task
        What is wanted.
    plan : RunPlan, optional
        Options of the runs of a system.
    """

    tolerance = 1e-12
    """Relative change of the objective at which a search ends."""

    def __init__(
        self, what: Scattered, point: OperatingPoint, task: Task, plan: RunPlan | None = None
    ) -> None:
        self.system = what if isinstance(what, System) else what.system
        self.base = point.parameters
        self.names, box, self.scale = find_varied(self.system, task.vary, point.theta)
        for row, name in zip(box, self.names, strict=True):
            row[0] = task.begin.get(name, row[0])
        self.start = box[:, 0].copy()
        self.weights = dict(task.weights)
        self.bounds = {k: b for k, b in task.bounds.items() if not isinstance(k, Probability)}
        self.most = {k: b[1] or 0.0 for k, b in task.bounds.items() if isinstance(k, Probability)}
        self.at_most, self.keys = task.at_most, task.keys
        self.box = box / self.scale[:, None]
        self.count = 0
        for key in self.keys:
            if isinstance(key, str):
                self.system.places([key])

        def scatter_of(of: RobustAim | Probability) -> MovedScene:
            return MovedScene(what, of.of, of.over, self.names, "optimise", plan)

        self.aims = {k: DesignAim(k, scatter_of(k)) for k in self.keys if isinstance(k, RobustAim)}
        self.probabilities = {
            k: DesignProbability(k, scatter_of(k)) for k in self.keys if isinstance(k, Probability)
        }
        self.shift = dict.fromkeys(self.probabilities, 0.0)

    @property
    def scattered(self) -> list[DesignAim | DesignProbability]:
        """What is found by samples and design points."""
        return [*self.aims.values(), *self.probabilities.values()]

    # -- numbers of a design -------------------------------------------------------------------

    def result(self, w: np.ndarray) -> Any:
        """Run, modes or response of a design."""
        raise NotImplementedError

    def functional(self, key: Functional, w: np.ndarray) -> tuple[float, np.ndarray]:
        """A functional and its gradient by the scaled unknowns."""
        raise NotImplementedError

    def design(self, w: np.ndarray) -> dict[str, float]:
        """What varies, by name."""
        own = (w[: len(self.names)] * self.scale).tolist()
        return dict(zip(self.names, own, strict=True))

    def values_at(self, w: np.ndarray) -> dict[str, float]:
        """Parameters by name."""
        return self.base | self.design(w)

    def text(self, w: np.ndarray) -> str:
        """What varies, in words."""
        return ", ".join(f"{name} = {value:.6g}" for name, value in self.design(w).items())

    def value(self, key: Any, w: np.ndarray) -> tuple[float, np.ndarray]:
        """A number and its gradient by the scaled unknowns; of a probability minus beta."""
        slope = np.zeros(len(w))
        if isinstance(key, str):
            name = self.system.key(key)
            if name not in self.names:
                return self.base[name], slope
            place = self.names.index(name)
            slope[place] = self.scale[place]
            return float(w[place] * self.scale[place]), slope
        if isinstance(key, RobustAim):
            value, by = self.aims[key].at(self.design(w))
        elif isinstance(key, Probability):
            beta, beta_by = self.probabilities[key].betas(self.design(w))[0]
            value, by = -beta, -beta_by
        else:
            return self.functional(key, w)
        slope[: len(self.names)] = by * self.scale
        return value, slope

    def convert_value(self, key: Any, value: float) -> float:
        """What `value` gives: a probability instead of minus beta."""
        if isinstance(key, Probability):
            return float(scipy.special.ndtr(value + self.shift[key]))
        return value

    def least_beta(self, key: Probability) -> float:
        """Reliability index of the greatest probability."""
        return float(-scipy.special.ndtri(self.most[key]))

    # -- the programme -------------------------------------------------------------------------

    def bound_rows(self, key: Any, w: np.ndarray) -> list[Row]:
        """What must not be negative for the bounds of a key."""
        return list_bound_rows(
            str(key), *self.value(key, w), *bounds_of(str(key), self.bounds[key])
        )

    def rows(self, w: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[str]]:
        """What must not be negative, scaled, its gradients and names."""
        every = [row for key in self.bounds for row in self.bound_rows(key, w)]
        for key, most in self.most.items():
            for beta, by in self.probabilities[key].betas(self.design(w)):
                slope = np.zeros(len(w))
                slope[: len(self.names)] = by * self.scale
                text = f"{key} = {self.convert_value(key, -beta):.3g}, at most {most:g}"
                every.append((beta - self.least_beta(key) - self.shift[key], slope, text))
        for weights, most in self.at_most:
            label = " + ".join(f"{weight:g} {key}" for key, weight in weights.items())
            every += list_bound_rows(label, *self.total(weights, w), -np.inf, most)
        every += self.more_rows(w)
        values, slopes, labels = map(list, zip(*every, strict=True)) if every else ([], [], [])
        return np.array(values), np.array(slopes).reshape(-1, len(w)), labels

    def more_rows(self, w: np.ndarray) -> list[Row]:
        """What else must not be negative."""
        return []

    def total(self, weights: Mapping[Any, float], w: np.ndarray) -> tuple[float, np.ndarray]:
        """A weighted sum and its gradient."""
        total, slope = 0.0, np.zeros(len(w))
        for key, weight in weights.items():
            value, by = self.value(key, w)
            total, slope = total + weight * value, slope + weight * by
        return total, slope

    def objective(self, w: np.ndarray) -> tuple[float, np.ndarray]:
        """What is made small, and its gradient."""
        return self.total(self.weights, w)

    def solve_design(self) -> tuple[Solution, tuple[str, ...]]:
        """Best unknowns, checked by their own conditions of optimality, and what is active."""
        return sqp(
            self.system.name,
            self.names,
            self.box,
            self.objective,
            self.rows,
            lambda: self.count + sum(each.evaluations for each in self.scattered),
            self.tolerance,
        )

    def confirm(self) -> tuple[Solution, tuple[str, ...], tuple[CheckedProbability, ...]]:
        """The same, with probabilities that samples confirm.

        Where an estimate by samples does not agree with the design point, the reliability index is
        shifted by the difference of both methods. If this moves a bound that holds the design, it
        is searched again.

        Raises
        ------
        OptimisationError
            If samples never confirm a probability.
        """
        iterations, seconds = 0, 0.0
        for searches in range(1, _SEARCHES + 1):
            solution, active = self.solve_design()
            iterations, seconds = iterations + solution.iterations, seconds + solution.seconds
            solution = replace(solution, iterations=iterations, seconds=seconds)
            design = self.design(solution.w)
            checks = [
                own.check(design, self.most.get(key), self.shift[key], searches)
                for key, own in self.probabilities.items()
            ]
            moved = [self._shift_beta(check) for check in checks]
            if not any(moved):
                told = (replace(check, shift=self.shift[check.wanted]) for check in checks)
                return solution, active, tuple(told)
            self.box[:, 0] = solution.w
        worst = "; ".join(str(check) for check in checks if check.most is not None)
        raise OptimisationError(
            f"{self.system.name}: {worst}: samples do not confirm this. Take more samples, "
            "probability(..., runs=), or begin elsewhere.",
            "not confirmed",
        )

    def _shift_beta(self, check: CheckedProbability) -> bool:
        """Shift beta if samples do not agree; whether its bound is passed now, or is too tight."""
        if check.sampled is None or check.sampled.interval is None:
            return False
        key, (low, high) = check.wanted, check.sampled.interval
        before = self.shift[key]
        if not low <= scipy.special.ndtr(before - check.beta) <= high:
            self.shift[key] = check.beta + float(scipy.special.ndtri(check.sampled.probability))
        if check.most is None:
            return False
        room = check.beta - self.least_beta(key) - before
        loosened = before - self.shift[key]
        return room + loosened < -_PRESSES or (room < _PRESSES and loosened > _PRESSES)

    def optimum(
        self,
        solution: Solution,
        active: tuple[str, ...],
        checks: tuple[CheckedProbability, ...],
    ) -> Optimum:
        """What was found, with the analysis of the best design."""
        design = self.design(solution.w)
        numbers: dict[Key, float] = {
            k: self.convert_value(k, self.value(k, solution.w)[0])
            for k in self.keys
            if not isinstance(k, str)
        }
        (first, *_) = self.weights
        return Optimum(
            self.result(solution.w),
            design,
            dict(zip(self.names, self.start.tolist(), strict=True)),
            self.convert_value(first, solution.objective),
            numbers,
            active,
            0.0,
            solution,
            checks=(*checks, *(aim.check(design) for aim in self.aims.values())),
        )
