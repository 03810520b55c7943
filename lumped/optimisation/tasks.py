"""What `optimise` and `pareto` are asked for, checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from lumped.compiler.system import Name, System
from lumped.errors import OptionError
from lumped.functionals.functional import refuse_other
from lumped.optimisation.design import Bounds, Key, Scattered, Task
from lumped.orbits.orbit import PeriodicOrbit
from lumped.timeloop.result import Trajectory
from lumped.tolerances.probability import Probability, ProbabilityLimit
from lumped.tolerances.robust_aims import RobustAim
from lumped.vibration.modes import Modes
from lumped.vibration.order_response import OrderResponse

__all__ = ["Objective", "task_of"]

Objective = Key | str | Mapping[Key | str, float]
"""What is made small: a functional, or functionals and parameters with weights."""

_KINDS: dict[type, str] = {
    Trajectory: "run",
    PeriodicOrbit: "run",
    Modes: "modes",
    OrderResponse: "order response",
    System: "run",
}
"""What can be optimised, and what functionals read."""
_NEEDED = (
    "runs are needed that are made anew for each sample. Give the system and until= instead of a "
    "run or an orbit; modes and order responses do too."
)


def task_of(
    run: object,
    vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
    minimise: Objective,
    subject_to: Mapping[Key | str, Bounds] | None,
    such_that: ProbabilityLimit | Sequence[ProbabilityLimit],
) -> Task:
    """What is asked for; arguments as for `optimise`.

    Raises
    ------
    OptionError
        If the run has no such functional, or weights and conditions make no sense.
    """
    weights = _weights(minimise)
    if type(run) not in _KINDS:
        raise OptionError(
            f"optimise: {type(run).__name__} is nothing that can be optimised; give a run, a "
            "motion from periodic, modes or a system."
        )
    conditions = (such_that,) if isinstance(such_that, ProbabilityLimit) else tuple(such_that)
    task = Task(vary, weights, subject_to or {}, conditions)
    _check_keys(run, task)
    _check_probabilities(task)
    return task


def _check_keys(run: object, task: Task) -> None:
    """Refuse functionals that belong to something else."""
    for key in (*task.keys, *task.such_that):
        if isinstance(key, RobustAim | Probability | ProbabilityLimit):
            if not isinstance(run, Scattered):
                raise OptionError(f"optimise: {key}: {_NEEDED}")
        elif not isinstance(key, str):
            refuse_other([key], _KINDS[type(run)], "optimise")


def _check_probabilities(task: Task) -> None:
    """Refuse probabilities that have weights or bounds like functionals."""
    chosen = [key for key in task.weights if isinstance(key, Probability)]
    if chosen and (len(task.weights) > 1 or task.weights[chosen[0]] != 1):
        raise OptionError(
            f"optimise: {chosen[0]} has no weight among others: it is made small alone. Bound it "
            "by such_that=, or take pareto for what it costs."
        )
    for key in task.subject_to:
        if isinstance(key, Probability):
            raise OptionError(
                f"optimise: {key} is bounded by such_that=lumped.probability(...) <= 1e-4, not by "
                "subject_to."
            )


def _weights(minimise: Objective) -> dict[Key | str, float]:
    """Weights of an objective, checked."""
    weights: dict[Key | str, float] = {}
    weights.update(minimise if isinstance(minimise, Mapping) else {minimise: 1.0})
    for key, weight in weights.items():
        if not (isinstance(weight, int | float | np.number) and np.isfinite(weight)):
            raise OptionError(f"optimise: {key} has the weight {weight}; give a finite number.")
    if not any(weights.values()):
        raise OptionError("optimise: nothing to minimise; give one functional or weight.")
    return weights
