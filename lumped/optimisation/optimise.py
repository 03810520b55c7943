"""Parameters that make a run or modes best, under bounds, with exact derivatives."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, Unpack, cast

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import LumpedError, OptionError
from lumped.functionals import Condition, Functional
from lumped.optimisation.design import Bounds, Objective, Optimum, Task, task_of
from lumped.optimisation.design_problem import DesignProblem
from lumped.optimisation.discretisation import of_orbit, repeating
from lumped.optimisation.first_designs import first_designs
from lumped.optimisation.optimise_orders import OrderSearch
from lumped.optimisation.optimise_runs import RunSearch
from lumped.optimisation.search import DesignSearch
from lumped.optimisation.spectral_search import ModeSearch
from lumped.orbits.orbit import PeriodicOrbit
from lumped.support.arguments import checked
from lumped.timeloop.results.trajectory import Trajectory
from lumped.timeloop.run_options import RunOptions, RunPlan, plan_of
from lumped.tolerances.scene import Scattered
from lumped.vibration.natural.modes import Modes
from lumped.vibration.ordered.order_response import OrderResponse


@checked
def optimise(
    run: Trajectory | PeriodicOrbit | Modes | OrderResponse | System,
    *,
    vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
    minimise: Objective,
    subject_to: Condition | Iterable[Condition] = (),
    intervals: int = 50,
    periodic: bool = False,
    until: float | str | None = None,
    rtol: float = 1e-8,
    searches: int = 1,
    **options: Unpack[RunOptions],
) -> Optimum:
    """Parameters for which a run is best, or natural frequencies are where they are wanted.

    Without states (prescribed motion, inverse dynamics) quantities are evaluated at the instants
    of the run, so give `simulate` or `inverse` a grid that is fine enough. With states the run
    becomes equations for the states at collocation points, and the optimum is simulated anew as a
    check. Solved by IPOPT with
    exact first and second derivatives; greatest values enter by a bound of their own (epigraph),
    so their kinks do no harm.

    Natural frequencies and damping ratios have exact gradients (`eigen_sensitivity`) and are placed
    by sequential quadratic programming; if the modes are those of a point from `equilibrium`, it is
    found anew for each design, with the same start values and free parameters; a point of a run is
    held.

    Vibrations of an order response, with its natural frequencies at its first speed, have exact
    gradients too (`order_sensitivity`). A limit of an `order_peak` holds at all its speeds: those
    at which a design is worst are added to the search until none exceeds it. A `separation` keeps
    critical speeds away from those of operation, each at the mean state of its speed.

    Long or stiff runs and those with events are simulated whole for each design (single shooting):
    give the system and `until` in place of a run. Gradients are those of `gradient`, and the
    search is the same as for modes. Kinks of a peak, where one crest overtakes another, may stop
    it.

    Where parameters scatter, `subject_to` limits probabilities: a design is held by its reliability
    index, with exact derivatives at the design point, and checked by samples around it. If these
    do not agree, the index asked for is shifted by the difference, and the design is searched
    again. `mean_plus` and `quantile` of `lumped.tolerances` are minimised or bounded over one
    sample, the same for all designs, and told again for another one.

    Parameters
    ----------
    run : Trajectory, PeriodicOrbit, Modes, OrderResponse or System
        From `simulate`, `inverse`, `periodic`, `modes` or `order_response`, with the parameters at
        which the search begins; or a system, to be simulated for each design. A motion from
        `periodic` stays periodic, of its period, or of one that is found where it is unknown; what
        its `free` parameter shall be is found too if it is in `vary`.
    vary : mapping of name to (low, high)
        Parameters and their bounds.
    minimise : functional, or mapping of functional or parameter name to weight
        Such as ``peak("motor.tau")``, or ``{rms("motor.tau"): 1.0, "flywheel.J": 0.2}``; of modes
        `frequency`, `damping` and `clearance`; of an order response `order_peak` and
        `separation` too. A negative weight makes large. What sums up scatter, such as
        ``lumped.tolerances.mean_plus(frequency(0), -3, over=...)``, is a functional here; a
        `probability` is made small alone, without weights.
    subject_to : condition or iterable of conditions, optional
        What functionals may not pass, such as ``peak("shaft.tau") <= "5 kN.m"``; of a system, modes
        and an order response probabilities too, such as
        ``lumped.probability(peak("shaft.tau"), above="5 kN.m", over=...) <= 1e-4``.
    intervals : int
        For a system with states: number of intervals of its collocation, for each part of the run
        between jumps of functions of time.
    periodic : bool
        The states at the end are those at the start, which are free, except for whole turns that
        angles make in the run; states on which nothing depends stay as they start. Else the states
        start as in the run.
    until, rtol
        For a system, as for `gradient`. `rtol` is tighter than elsewhere: near the optimum a
        search compares runs that hardly differ.
    searches : int
        For a system, modes and an order response: number of searches. The first begins with the
        parameters of `run`, the others between the bounds, far from each other; of a system at the
        best of 128 designs each, run by `ensemble`. The best result counts; ``others`` has the
        rest, so local minima show.
    **options : RunOptions
        For a system: of each run (see `RunOptions`); the search begins with `parameters`.

    Returns
    -------
    Optimum

    Raises
    ------
    OptionError
        If bounds contradict each other or the start, a parameter has no effect, the run has
        changes of modes, or a parameter of `vary` scatters by a distribution that is not `scaled`.
    UnknownNameError
        If a name does not exist.
    OptimisationError
        If no optimum is found, with the constraint that is violated most, or samples do not confirm
        a probability.
    SolverError
        If a run or an equilibrium fails on the way.

    Notes
    -----
    Waechter and Biegler, Mathematical Programming 106, 2006 (IPOPT); Kraft, DFVLR-FB 88-28, 1988
    (SLSQP); Tu, Choi and Park, Journal of Mechanical Design 121, 1999 (reliability index as a
    constraint).
    """
    task = task_of(run, vary, minimise, subject_to)
    if searches > 1 and task.is_scattered:
        raise OptionError(
            f"optimise: searches = {searches}: where parameters scatter, there is one search. "
            "Begin it with other parameters instead."
        )
    plan = plan_of(run, "optimise", until, rtol, options)
    if searches < 1 or (searches > 1 and not isinstance(run, Scattered)):
        raise OptionError(
            f"optimise: searches = {searches}: at least one search is needed, and several for a "
            "system, modes or an order response only."
        )
    if isinstance(run, Scattered):
        return best(run, task, plan, searches)
    wanted = cast(dict[Functional | str, float], dict(task.weights))
    repeats = None
    if isinstance(run, PeriodicOrbit):
        given = {run.system.key(name) for name in vary}
        for name in run.free:
            if name not in given:
                raise OptionError(
                    f"optimise: {name} is free at this motion, which determines it; name it in "
                    "`vary`, with the bounds in which it may be found."
                )
        repeats, run = of_orbit(run), run.run
    elif periodic and run.system.structure.states:
        repeats = repeating(run)
    problem = DesignProblem(run, vary, wanted, task.bounds, intervals, repeats)
    return problem.optimum(problem.solve(list(wanted.values())), wanted)


def best(what: Scattered, task: Task, plan: RunPlan | None, searches: int = 1) -> Optimum:
    """The part of `optimise` for what is found anew for each design."""
    begin: Callable[[Task], DesignSearch]
    if isinstance(what, Modes):
        begin = partial(ModeSearch, what)
    elif isinstance(what, OrderResponse):
        begin = partial(OrderSearch, what)
    else:
        assert plan is not None
        plan = plan.by_steps("optimise", are_followed=True)
        begin = partial(RunSearch, what, plan=plan)
    first: DesignSearch = begin(task)
    designs = first_designs(first, searches - 1, plan) if searches > 1 else ()
    found, faults = list[tuple[DesignSearch, Any]](), list[LumpedError]()
    for own in (None, *designs):
        try:
            search = first
            if own is not None:
                search = begin(replace(task, begin=first.design(own)))
            found.append((search, search.confirm()))
        except LumpedError as fault:
            faults.append(fault)
    if not found:
        raise faults[0]
    found.sort(key=lambda each: float(each[1][0].objective))
    (search, solution), *rest = found
    others = tuple((other.objective, each.design(other.w)) for each, (other, *_) in rest)
    start = dict(zip(first.names, first.start.tolist(), strict=True))
    return replace(search.optimum(*solution), start=start, others=others)
