"""A design problem: what is asked for, what may vary, and what was found."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.functionals import Condition, Functional
from lumped.functionals.functional import refuse_other
from lumped.numerics.nlp import Solution
from lumped.orbits.orbit import PeriodicOrbit
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.support.units import amount
from lumped.timeloop.results.trajectory import Trajectory
from lumped.tolerances.aims import Probability, RobustAim
from lumped.tolerances.of_designs import CheckedAim, CheckedProbability
from lumped.tolerances.scene import Scattered
from lumped.vibration.natural.modes import Modes
from lumped.vibration.ordered.order_response import OrderResponse

Bounds = tuple[float | None, float | None]
"""Lower and upper bound; None is none."""

Key = Functional | RobustAim | Probability
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


@dataclass(frozen=True, eq=False)
class Task:
    """What `optimise` is asked for, and where it begins.

    Attributes
    ----------
    vary : mapping of name to (low, high)
        Parameters and their bounds.
    weights : mapping of functional or name to float
        What is made small.
    bounds : mapping of functional to (low, high)
        Bounds of functionals and probabilities, in SI units.
    at_most : tuple of (mapping, float)
        Weighted sums beside the objective, and their greatest values.
    told : tuple of functional
        What is told besides, of the best design.
    begin : mapping of str to float
        Parameters with which the search begins; those left out as in the model.
    """

    vary: Mapping[Any, Bounds]
    weights: Mapping[Any, float]
    bounds: Mapping[Any, Bounds]
    at_most: tuple[tuple[Mapping[Any, float], float], ...] = ()
    told: tuple[Any, ...] = ()
    begin: Mapping[str, float] = field(default_factory=dict)

    @property
    def keys(self) -> list[Any]:
        """All functionals and names, each once."""
        sums = [key for weights, _ in self.at_most for key in weights]
        return list(dict.fromkeys([*self.weights, *self.bounds, *sums, *self.told]))

    @property
    def is_scattered(self) -> bool:
        """Whether probabilities or sums over samples are asked for."""
        return any(isinstance(key, RobustAim | Probability) for key in self.keys)


@dataclass(frozen=True, eq=False)
class Optimum(RichHtml):
    """A design that is best, at least among its neighbours.

    Attributes
    ----------
    run : Trajectory, Modes or OrderResponse
        The run, the modes or the vibration with this design.
    parameters, start : dict of str to float
        What was varied: its values now and at the start.
    objective : float
        What was made small: the weighted sum.
    values : dict
        All functionals of objective and constraints: of `run`, between its output times too; at the
        instants of the run for a system without states.
    active : tuple of str
        Bounds and constraints that hold the design where it is.
    error : float
        Greatest difference between functionals of the programme and those of `run` between its
        output times too, relative to their values there.
    solution : Solution
        Status, iterations, evaluations, residual, violation, condition, seconds.
    others : tuple of (float, dict)
        What searches from other starts found: objective and parameters, the best first.
    checks : tuple of CheckedProbability and CheckedAim
        Probabilities and what sums up scatter, each with an estimate by samples of its own.
    """

    run: Trajectory | Modes | OrderResponse
    parameters: dict[str, float]
    start: dict[str, float]
    objective: float
    values: dict[Key, float]
    active: tuple[str, ...]
    error: float
    solution: Solution
    others: tuple[tuple[float, dict[str, float]], ...] = ()
    checks: tuple[CheckedProbability | CheckedAim, ...] = ()

    @property
    def system(self) -> System:
        """What was optimised."""
        return self.run.system

    def __repr__(self) -> str:
        rows = []
        for name, value in self.parameters.items():
            unit = self.system.parameter_unit(name)
            begin, _ = amounts(name, unit, self.start[name])
            rows.append((name, begin, *amounts(name, unit, value, digits=9)))
        rows += [
            (str(key), "", *amounts(str(key), key_unit(self.system, key), value, digits=9))
            for key, value in self.values.items()
        ]
        rows.append(("objective", "", number(self.objective, 9), ""))
        lines = [
            *solution_lines(self.system, self.solution),
            table(("", "start", "optimum", "unit"), rows),
            "active: " + (", ".join(self.active) or "nothing"),
        ]
        if self.others:
            told = ", ".join(number(objective, 9) for objective, _ in self.others[:6])
            lines.append(f"searches from other starts found {told}")
        lines += [str(check) for check in self.checks]
        if isinstance(self.run, Trajectory):
            lines.append(f"values as in a run of their own to {self.error:.1e}")
        elif isinstance(self.run, OrderResponse):
            lines += self.run.notes
        return "\n".join(lines)


def solution_lines(system: System, solution: Solution) -> list[str]:
    """What a search cost, and how well its conditions are met."""
    s = solution
    return [
        f"{system.name}: {s.status}, {s.iterations} iterations, {s.evaluations} evaluations, "
        f"{s.seconds:.2g} s",
        f"conditions of optimality met to {s.residual:.1e}, constraints to {s.violation:.1e}; "
        f"condition {s.condition:.1e}",
    ]


def find_varied(
    system: System, vary: Mapping[str, Bounds] | Mapping[Name, Bounds], theta: np.ndarray
) -> tuple[list[str], np.ndarray, np.ndarray]:
    """What may vary: names, rows of (start, low, high), and scales.

    Raises
    ------
    OptionError
        If bounds contradict each other, the start, or the range of the parameter.
    """
    if not vary:
        raise OptionError("optimise: name at least one parameter in `vary`, with its bounds.")
    parameters = system.structure.parameters
    names, box, scales = [], [], []
    for name, given in vary.items():
        place = system.places([name])[0]
        key = parameters.free_names[place]
        low, high = room_of(key, given)
        start, unit = float(theta[place]), system.parameter_unit(key)
        for bound in (low, high):
            fault = np.isfinite(bound) and parameters.fault(parameters.free[place], bound)
            if fault:
                raise OptionError(f"optimise: a bound of vary cannot be: {fault}.")
        if not low <= start <= high:
            raise OptionError(
                f"optimise: the search would begin with {key} = {amount(start, unit)}, outside its "
                f"bounds ({low:g}, {high:g}). Begin with a value between them."
            )
        finite = [abs(v) for v in (start, low, high) if np.isfinite(v) and v]
        span = high - low
        names.append(key)
        box.append((start, low, high))
        scales.append(span if 0 < span < np.inf else max(finite, default=1.0))
    return names, np.array(box), np.array(scales)


def key_unit(system: System, key: Key) -> str:
    """Unit of what can be minimised or bounded."""
    if isinstance(key, Probability):
        return "1"
    return (key.of if isinstance(key, RobustAim) else key).unit(system)


def bounds_of(name: str, given: Bounds) -> tuple[float, float]:
    """Bounds as numbers, checked."""
    try:
        low, high = (
            default if bound is None else float(bound)
            for bound, default in zip(given, (-np.inf, np.inf), strict=True)
        )
    except (TypeError, ValueError):
        low, high = np.nan, np.nan
    if not low <= high:
        raise OptionError(
            f"bounds of {name} = {given!r}; give (low, high) with low at most high, and "
            "None where there is none."
        )
    return low, high


def room_of(name: str, given: Bounds) -> tuple[float, float]:
    """Bounds of what varies, checked, with something between them."""
    low, high = bounds_of(name, given)
    if low == high:
        raise OptionError(
            f"bounds of {name} = {given!r} leave nothing to search between; widen them, or leave "
            f"{name} out of `vary`."
        )
    return low, high


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
    chosen = [key for key in weights if isinstance(key, Probability)]
    if chosen and (len(weights) > 1 or weights[chosen[0]] != 1):
        raise OptionError(
            f"optimise: {chosen[0]} has no weight among others: it is made small alone. Bound it "
            "by subject_to=, or take pareto for what it costs."
        )
    system = run if isinstance(run, System) else run.system  # type: ignore[attr-defined]
    bounds: dict[Key, Bounds] = {}  # in SI units, those of one functional together
    for condition in conditions:
        low, high = condition.bounds(key_unit(system, condition.of), "optimise")
        least, most = bounds.get(condition.of, (-np.inf, np.inf))
        bounds[condition.of] = max(low, least), min(high, most)  # type: ignore[type-var]
    return Task(vary, weights, bounds)


def _check_keys(run: object, keys: Iterable[Key | str]) -> None:
    """Refuse functionals that belong to something else."""
    for key in keys:
        if isinstance(key, RobustAim | Probability):
            if not isinstance(run, Scattered):
                raise OptionError(f"optimise: {key}: {_NEEDED}")
        elif not isinstance(key, str):
            refuse_other([key], _KINDS[type(run)], "optimise")


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
