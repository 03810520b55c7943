"""What one objective costs in terms of another: the Pareto front of two functionals."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptimisationError, OptionError
from lumped.functionals import Condition, Functional
from lumped.optimisation.design import Bounds, Objective, Optimum, Task, key_unit, task_of
from lumped.optimisation.design_problem import DesignProblem
from lumped.optimisation.discretisation import repeating
from lumped.optimisation.optimise import best
from lumped.plots.draw import Canvas, draw
from lumped.plots.picture import Axis, Curve, Panel, Picture, label_axis
from lumped.plots.style import MARKS, look
from lumped.support.arguments import checked
from lumped.support.display_units import Units, choose_units, display
from lumped.support.progress import Progress
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.timeloop.results.trajectory import Trajectory
from lumped.timeloop.run_options import RunOptions, RunPlan, plan_of
from lumped.tolerances.aims import Probability
from lumped.tolerances.scene import Scattered
from lumped.vibration.natural.modes import Modes
from lumped.vibration.ordered.order_response import OrderResponse

Weights = Mapping[Any, float]
"""Of functionals and names of parameters."""

_AGREE = 1e-5
"""Difference of the ends, relative to the start, below which both aims agree."""
_SLACK = 1e-7
"""How much of the range of one functional is given up so that the other has room at an end."""


@dataclass(frozen=True, eq=False)
class Front(RichHtml):
    """Designs of which none is better in both aims.

    Attributes
    ----------
    functionals : tuple
        The two aims: functionals, names, or mappings of these to weights.
    designs : tuple of Optimum
        From the least of the first to the least of the second; one alone if both are least in it.
    """

    functionals: tuple[Objective, Objective]
    designs: tuple[Optimum, ...]

    @property
    def values(self) -> np.ndarray:
        """Values of both, shape (count, 2)."""
        aims = [_weights(aim, self.designs[0].system) for aim in self.functionals]
        return np.array([[_aim_value(design, aim) for aim in aims] for design in self.designs])

    @checked
    def plot(self, *, units: Units = None, **canvas: Unpack[Canvas]) -> Any:
        """The second aim over the first, a probability on a logarithmic axis.

        Parameters
        ----------
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        system, told = self.designs[0].system, [_label(aim) for aim in self.functionals]
        units, points, axes = choose_units(units, told), self.values.T, []
        for k, (aim, label) in enumerate(zip(self.functionals, told, strict=True)):
            shown = display(label, _unit(aim, system), units)
            points[k] = shown.value(points[k])
            axes.append(Axis(label_axis(label, shown.unit), log=isinstance(aim, Probability)))
        line = Curve(points[0], points[1], look=look(0, mark=MARKS[3]))
        title = f"{system.name}: {len(self.designs)} designs"
        return draw(Picture(title, (Panel((line,), axes[0], axes[1], height=3.5),)), **canvas)

    def __repr__(self) -> str:
        names = list(self.designs[0].parameters)
        head = (*map(_label, self.functionals), *names, "iterations", "residual")
        rows = [
            (
                *(number(v, 7) for v in values),
                *(number(design.parameters[name], 7) for name in names),
                str(design.solution.iterations),
                f"{design.solution.residual:.0e}",
            )
            for values, design in zip(self.values, self.designs, strict=True)
        ]
        text = table(head, rows)
        return text if len(rows) > 1 else f"both are least in one design\n{text}"


def _weights(aim: Objective, system: System) -> Weights:
    """Weights of an aim, with the names that a design has."""
    given: Mapping[Any, float] = aim if isinstance(aim, Mapping) else {aim: 1.0}
    return {system.key(k) if isinstance(k, str) else k: weight for k, weight in given.items()}


def _unit(aim: Objective, system: System) -> str:
    """Unit of an aim; a sum has none."""
    if isinstance(aim, Mapping):
        return "1"
    return system.parameter_unit(aim) if isinstance(aim, str) else key_unit(system, aim)


def _label(aim: Objective) -> str:
    """An aim in words."""
    if not isinstance(aim, Mapping):
        return str(aim)
    return " + ".join(str(k) if weight == 1 else f"{weight:g} {k}" for k, weight in aim.items())


@checked
def pareto(
    run: Trajectory | Modes | OrderResponse | System,
    *,
    vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
    minimise: tuple[Objective, Objective],
    subject_to: Condition | Iterable[Condition] = (),
    count: int = 20,
    intervals: int = 50,
    periodic: bool = False,
    until: float | str | None = None,
    rtol: float = 1e-8,
    **options: Unpack[RunOptions],
) -> Front:
    """Pareto front of two aims, such as cost and probability.

    The least first aim for equal steps of a bound on the second, which also finds the parts of a
    front that are not convex. Each search begins at the design before, or, where it then fails, at
    the least second. The bounds of a probability are equal steps of its reliability index.

    Parameters
    ----------
    run, vary, subject_to, intervals, periodic, until
        As for `optimise`.
    rtol : float
        Of runs that are made for each design, tighter than elsewhere: near an optimum a search
        compares runs that hardly differ.
    minimise : (aim, aim)
        The two. Of a run both are functionals. Of a system, modes or an order response each is what
        `optimise` makes small: a functional, a name, a mapping of these to weights, or a
        `probability`.
    count : int
        Number of designs. Where both aims are least in one design, that alone is the front.
    **options : RunOptions
        For a system: of each run (see `RunOptions`).

    Returns
    -------
    Front

    Raises
    ------
    OptionError, UnknownNameError, OptimisationError
        As for `optimise`; if there are not two aims, or fewer than two designs.

    Notes
    -----
    Miettinen, Nonlinear Multiobjective Optimization, 1999, section 3.2.
    """
    first, second = minimise
    if first is second or _label(first) == _label(second):
        raise OptionError(f"pareto: minimise = {minimise!r}; give two different functionals.")
    if count < 2:
        raise OptionError(f"pareto: count = {count}; a front has at least two designs.")
    plan = plan_of(run, "pareto", until, rtol, options)
    are_functionals = all(isinstance(aim, Functional) for aim in minimise)
    if not isinstance(run, Scattered) and not are_functionals:
        raise OptionError(
            f"pareto: minimise = {minimise!r}; give two different functionals. Aims of another "
            "kind need a system and until=, modes or an order response."
        )
    task, _ = (task_of(run, vary, aim, subject_to) for aim in minimise)
    if isinstance(run, Scattered):
        aims: _Aims = _of_designs(run, task, minimise, plan)
    else:
        aims = _of_run(run, task, minimise, intervals, periodic)
    name = (run if isinstance(run, System) else run.system).name
    return Front((first, second), _designs(aims, count, name))


def _of_designs(
    run: Scattered, task: Task, minimise: tuple[Objective, Objective], plan: RunPlan | None
) -> _AimsOfSearch:
    """Aims of what is found anew for each design."""
    system = run if isinstance(run, System) else run.system
    first, second = (_weights(aim, system) for aim in minimise)
    varied = {system.key(name) for name in task.vary}
    for key in (*first, *second):
        if isinstance(key, str) and key not in varied:
            raise OptionError(f"pareto: {key} is not in `vary`, so it is the same in all designs.")
    return _AimsOfSearch(lambda own: best(run, own, plan), task, (first, second))


def _of_run(
    run: Trajectory, task: Task, minimise: tuple[Any, Any], intervals: int, periodic: bool
) -> _AimsOfProgramme:
    """Aims of a run with states at collocation points, or without states."""
    repeats = repeating(run) if periodic and run.system.structure.states else None
    weights = dict.fromkeys(minimise, 1.0)
    problem = DesignProblem(run, task.vary, weights, task.bounds, intervals, repeats)
    return _AimsOfProgramme(problem, minimise)


class _AimsOfProgramme:
    """Two functionals of a run in one programme.

    Attributes
    ----------
    sizes : list of float
        Of both, at the start.
    """

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


class _AimsOfSearch:
    """Weighted sums and probabilities of what is found anew for each design.

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
        numbers = [_aim_value(design, aim) for aim in self.aims]
        for k, (key, *_) in enumerate(self.aims):
            if isinstance(key, Probability):
                numbers[k] = float(scipy.special.ndtri(numbers[k]))
        return numbers


_Aims = _AimsOfProgramme | _AimsOfSearch


def _aim_value(design: Optimum, aim: Weights) -> float:
    """A weighted sum of functionals and parameters of a design."""
    return sum(
        weight * (design.parameters[key] if isinstance(key, str) else design.values[key])
        for key, weight in aim.items()
    )


def _designs(aims: _Aims, count: int, name: str) -> tuple[Optimum, ...]:
    """Designs of a front; one alone if both aims are least in it."""
    alone = aims.best(0, None, {}), aims.best(1, None, {})
    least = [aims.read_values(design)[k] for k, design in enumerate(alone)]
    # among designs with the least of one, those with the least of the other
    ends = (
        aims.best(1, alone[0], {0: least[0] + _SLACK * aims.sizes[0]}),
        aims.best(0, alone[1], {1: least[1] + _SLACK * aims.sizes[1]}),
    )
    both = [aims.read_values(end) for end in ends]
    apart = np.abs(np.subtract(both[0], both[1])) / aims.sizes
    if (apart <= _AGREE).any():  # what is least for one is least for the other
        return (ends[0],)
    designs = [ends[0]]
    with Progress(f"{name}: designs", count) as progress:
        for bound in np.linspace(both[0][1], both[1][1], count)[1:-1].tolist():
            try:
                found = aims.best(0, designs[-1], {1: bound})
            except OptimisationError:  # the other end meets the bound
                found = aims.best(0, ends[1], {1: bound})
            designs.append(found)
            progress.at(len(designs))
    return (*designs, ends[1])
