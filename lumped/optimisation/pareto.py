"""What one objective costs in terms of another: the Pareto front of two functionals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptimisationError, OptionError
from lumped.functionals import Condition, Functional
from lumped.optimisation.aims import Aims, AimsOfProgramme, AimsOfSearch, Weights, aim_value
from lumped.optimisation.design import Bounds, Objective, Optimum, key_unit, task_of
from lumped.optimisation.design_problem import DesignProblem
from lumped.optimisation.discretisation import repeating
from lumped.optimisation.front_picture import front_picture
from lumped.optimisation.optimise import best
from lumped.plots.draw import Backend, draw
from lumped.plots.picture import label_axis
from lumped.support.arguments import checked
from lumped.support.display_units import Units, choose_units, display
from lumped.support.progress import Progress
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.timeloop.results.trajectory import Trajectory
from lumped.timeloop.run_options import RunOptions, RunPlan, plan_of
from lumped.tolerances.probability import Probability
from lumped.tolerances.scene import Scattered
from lumped.vibration.natural.modes import Modes
from lumped.vibration.ordered.order_response import OrderResponse

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
        return np.array([[aim_value(design, aim) for aim in aims] for design in self.designs])

    @checked
    def plot(self, *, units: Units = None, backend: Backend = "matplotlib", ax: Any = None) -> Any:
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
        units, values, labels = choose_units(units, told), self.values.copy(), []
        for k, (aim, label) in enumerate(zip(self.functionals, told, strict=True)):
            shown = display(label, _unit(aim, system), units)
            values[:, k] = shown.value(values[:, k])
            labels.append(label_axis(label, shown.unit))
        logs = [isinstance(aim, Probability) for aim in self.functionals]
        title = f"{system.name}: {len(values)} designs"
        picture = front_picture(title, values, (labels[0], labels[1]), (logs[0], logs[1]))
        return draw(picture, backend, ax)

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
    if isinstance(run, Scattered):
        aims: Aims = _of_designs(run, vary, minimise, subject_to, plan)
    else:
        aims = _of_run(run, vary, minimise, subject_to, intervals, periodic)
    name = (run if isinstance(run, System) else run.system).name
    return Front((first, second), _designs(aims, count, name))


def _of_designs(
    run: Scattered,
    vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
    minimise: tuple[Objective, Objective],
    subject_to: Condition | Iterable[Condition],
    plan: RunPlan | None,
) -> AimsOfSearch:
    """Aims of what is found anew for each design."""
    system = run if isinstance(run, System) else run.system
    task, _ = (task_of(run, vary, aim, subject_to) for aim in minimise)
    first, second = (_weights(aim, system) for aim in minimise)
    varied = {system.key(name) for name in vary}
    for key in (*first, *second):
        if isinstance(key, str) and key not in varied:
            raise OptionError(f"pareto: {key} is not in `vary`, so it is the same in all designs.")
    return AimsOfSearch(lambda own: best(run, own, plan), task, (first, second))


def _of_run(
    run: Trajectory,
    vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
    minimise: tuple[Objective, Objective],
    subject_to: Condition | Iterable[Condition],
    intervals: int,
    periodic: bool,
) -> AimsOfProgramme:
    """Aims of a run with states at collocation points, or without states."""
    first, second = minimise
    if not (isinstance(first, Functional) and isinstance(second, Functional)):
        raise OptionError(
            f"pareto: minimise = {minimise!r}; give two different functionals. Aims of another "
            "kind need a system and until=, modes or an order response."
        )
    repeats = repeating(run) if periodic and run.system.structure.states else None
    weights: dict[Functional | str, float] = {first: 1.0, second: 1.0}
    bounds = task_of(run, vary, first, subject_to).bounds
    problem = DesignProblem(run, vary, weights, bounds, intervals, repeats)
    return AimsOfProgramme(problem, (first, second))


def _designs(aims: Aims, count: int, name: str) -> tuple[Optimum, ...]:
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
