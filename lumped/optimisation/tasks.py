"""What `optimise` and `pareto` are asked for, checked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.functionals import Condition
from lumped.functionals.functional import refuse_other
from lumped.optimisation.design import Bounds, Key, Task, key_unit
from lumped.orbits.orbit import PeriodicOrbit
from lumped.timeloop.results.trajectory import Trajectory
from lumped.tolerances.aims import Probability, RobustAim
from lumped.tolerances.scene import Scattered
from lumped.vibration.natural.modes import Modes
from lumped.vibration.ordered.order_response import OrderResponse

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
    subject_to: Condition | Iterable[Condition],
) -> Task:
    """What is asked for; arguments as for `optimise`.

    Raises
    ------
    OptionError
        If the run has no such functional, or weights and conditions make no sense.
    UnitError
        If a bound has a unit of another dimension than its functional.
    """
    weights = _weights(minimise)
    if type(run) not in _KINDS:
        raise OptionError(
            f"optimise: {type(run).__name__} is nothing that can be optimised; give a run, a "
            "motion from periodic, modes or a system."
        )
    conditions = (subject_to,) if isinstance(subject_to, Condition) else tuple(subject_to)
    _check_keys(run, (*weights, *(each.of for each in conditions)))
    _check_probabilities(weights)
    system = run if isinstance(run, System) else run.system  # type: ignore[attr-defined]
    return Task(vary, weights, _bounds(system, conditions))


def _bounds(system: System, conditions: Iterable[Condition]) -> dict[Key, Bounds]:
    """Bounds in SI units, those of one functional together."""
    found: dict[Key, Bounds] = {}
    for condition in conditions:
        low, high = condition.bounds(key_unit(system, condition.of), "optimise")
        least, most = found.get(condition.of, (-np.inf, np.inf))
        found[condition.of] = max(low, least), min(high, most)  # type: ignore[type-var]
    return found


def _check_keys(run: object, keys: Iterable[Key | str]) -> None:
    """Refuse functionals that belong to something else."""
    for key in keys:
        if isinstance(key, RobustAim | Probability):
            if not isinstance(run, Scattered):
                raise OptionError(f"optimise: {key}: {_NEEDED}")
        elif not isinstance(key, str):
            refuse_other([key], _KINDS[type(run)], "optimise")


def _check_probabilities(weights: Mapping[Key | str, float]) -> None:
    """Refuse probabilities that have weights."""
    chosen = [key for key in weights if isinstance(key, Probability)]
    if chosen and (len(weights) > 1 or weights[chosen[0]] != 1):
        raise OptionError(
            f"optimise: {chosen[0]} has no weight among others: it is made small alone. Bound it "
            "by subject_to=, or take pareto for what it costs."
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
