"""Initial states: start values and initial equations hold, declared defaults fill the rest."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from lumped.compiler.constraints import constraints_of
from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError, SolverError, StartError, shown
from lumped.points.consistent_point import consistent_point
from lumped.points.direct_start import direct_start
from lumped.points.pressed_friction import find_loose
from lumped.points.start_search import StartSearch
from lumped.points.start_values import read_start_values
from lumped.points.watched_point import watch_formulas
from lumped.support.arguments import checked
from lumped.timeloop.clocks import modes_at
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.run_options import RunOptions, RunPlan, run_plan
from lumped.timeloop.settings import begin, just_after


@checked
def start_point(
    system: System,
    *,
    parameters: Changes | None = None,
    start: Changes | None = None,
    free: Iterable[Name] = (),
    time: float = 0.0,
    together: bool = False,
) -> OperatingPoint:
    """States at the start of a run.

    Start values given to instances (``Inertia(J=1, w=100)``), those in `start`, and the
    ``initial_equations`` of components hold exactly. States that they do not determine take their
    declared defaults; where a given quantity is not itself a state, the least wanted states follow
    from it. Stated defaults of other quantities win over states without one; ``point.lost`` names
    those that do not hold. Of a motion that a closed linkage determines, a start value holds too,
    unless others leave nothing free: then it chooses the assembly, and is in ``point.lost``. Where
    states lead nothing at the start, as at a dead centre, others lead (``point.system``). Where
    bodies collide at once, the start values are those before the impact, and the states those after
    it.

    Newton's method starts from the defaults. If it fails, the wanted values are approached step by
    step from those that the quantities have there. What is demanded holds in the positions that
    conditions, friction and contacts have at the start: it is met in the positions of the defaults,
    positions are found where that ends, and so on until both agree. ``point.residual`` tells how
    far the worst of it is missed.

    Parameters
    ----------
    system : System
        From `assemble`.
    parameters, start : mapping of name to float, optional
        Parameters to change, start values to set.
    free : iterable of names
        Parameters that the start values determine, for example the rest length of a spring that
        holds a body at a given place with a given acceleration.
    time : float
        Instant of the start, s.
    together : bool
        Parts move together: no twist of a spring and no play changes, friction that is pressed
        sticks, dogs and freewheels stay in and tyres roll, so that one given speed turns a whole
        drive train. Twists themselves keep their start values. Friction slips where start values
        say so; parts that only a damper or free friction joins move as they are given.

    Returns
    -------
    OperatingPoint

    Raises
    ------
    StartError
        If start values and initial equations contradict each other, do not determine a free
        parameter, cannot hold in any positions that follow from them, or put bodies inside each
        other.
    OptionError
        If `start` is no mapping.
    """
    return find_start(system, parameters, start, free, time, together)


def run_start(system: System, plan: RunPlan) -> OperatingPoint:
    """Where the run of a system starts.

    Raises
    ------
    OptionError
        If the start point belongs to another system.
    StartError
        As `start_point`.
    """
    if not isinstance(plan.start, OperatingPoint):
        return find_start(system, plan.parameters, plan.start, plan.free, plan.begin)
    system, point = plan.watching(system, ()), plan.start
    if point.time != plan.begin:
        point = replace(point, time=plan.begin)
    if system is not point.system:
        point = watch_formulas(point, system)
    if not plan.parameters:
        return point
    theta = system.theta(plan.changes(system))
    if (theta == point.theta).all():
        return point
    settings, modes = point.settings.copy(), modes_at(system, theta, just_after(plan.begin))
    settings[: len(modes)] = modes
    return _begin_motion(replace(point, theta=theta, settings=settings))


def search_start(
    system: System, parameters: Changes | None, start: Changes | OperatingPoint | None
) -> OperatingPoint:
    """Where a search for a motion starts; states of a point are taken as those at the time zero."""
    options: RunOptions = {"begin": 0.0, "parameters": parameters, "start": start}
    return run_start(system, run_plan(1.0, 1e-6, options))


def find_start(
    system: System,
    parameters: Changes | None,
    start: Changes | None,
    free: Iterable[Name],
    time: float,
    together: bool = False,
) -> OperatingPoint:
    """States at the start (see `start_point`), of arguments that were checked."""
    fault, point, free = None, None, tuple(free)
    try:
        point = start_by_states(system, parameters, start, free, time, together)
    except StartError as error:
        fault = error
    if constraints_of(system) and not (free or together or system.structure.flat.initial):
        before = point if point is None or point.before is None else point.before
        try:
            better = consistent_point(
                system, system.theta(parameters), by_name(start), time, before
            )
        except StartError as error:
            if fault is None or str(error) == str(fault):
                raise
            raise StartError(f"{fault} {error}") from None
        if better is not None:
            is_kept = before is not None and better.system is system and better.x is before.x
            if point is not None and is_kept:
                return replace(point, lost=better.lost)
            again = None
            if system.structure.lost_states:
                kept = by_key(system, parameters, by_name(start), free)
                again = partial(find_start, **kept, time=time)
            return _begin_motion(replace(better, again=again))
    if point is None:
        assert fault is not None
        raise fault
    return point


def start_by_states(
    system: System,
    parameters: Changes | None,
    start: Changes | None,
    free: tuple[Name, ...],
    time: float,
    together: bool = False,
) -> OperatingPoint:
    """The start as the states in use lead to it."""
    theta, values = system.theta(parameters), by_name(start)
    places = free_places(system, free)
    again = None
    if system.structure.lost_states:
        given = by_key(system, parameters, values, free)
        again = partial(find_start, **given, time=time, together=together)
    if not (places or together):
        point = _direct(system, theta, values, time, again)
        if point is not None:
            return point

    def find(pressed: tuple[int, ...]) -> tuple[OperatingPoint, StartSearch]:
        search = StartSearch(system, theta, values, places, time, together, pressed)
        x, modes = (
            search.solve()[system.structure.in_use],
            modes_at(system, search.theta, just_after(time)),
        )
        begun = np.concatenate([modes, search.settings[len(modes) :]])
        point = OperatingPoint(
            system, time, x, search.theta, begun, residual=search.residual, again=again
        )
        point = _begin_motion(point)
        if not point.collisions:
            search.check(point.settings)
        return point, search

    pressed: tuple[int, ...] = ()
    point, search = find(pressed)
    while together and system.switching:
        loose = find_loose(point, search)
        if not set(loose) - set(pressed):
            break
        pressed = (*pressed, *loose)
        try:
            point, search = find(pressed)
        except StartError:  # it cannot stick, and slips as it was found
            break
    return point


def by_key(
    system: System, parameters: Changes | None, start: Changes | None, free: Iterable[Name]
) -> dict[str, Any]:
    """What a point was found from, by full names."""
    changed = {system.key(name): value for name, value in (parameters or {}).items()}
    given = {system.key(name): value for name, value in (start or {}).items()}
    return {"parameters": changed, "start": given, "free": tuple(map(system.key, free))}


def _direct(
    system: System,
    theta: np.ndarray,
    start: Changes,
    time: float,
    again: Callable[[System], OperatingPoint] | None,
) -> OperatingPoint | None:
    """The start where nothing must be searched for; None otherwise."""
    changed = read_start_values(system, start)
    form = direct_start(system, tuple(changed))
    found = None if form is None else form.states(theta, time, list(changed.values()))
    if form is None or found is None:
        return None
    x, missed = found
    settings = modes_at(system, theta, just_after(time))
    residual = missed if form.searches else None
    make = partial(OperatingPoint, system, time, theta=theta, residual=residual, again=again)
    return _make_begun(make, x, theta, time, settings, system)


def free_places(system: System, free: Iterable[Name]) -> list[int]:
    """Places of parameters that are to be found.

    Raises
    ------
    OptionError
        If one is named twice.
    """
    names = [system.key(name) for name in free]
    if not names:
        return []
    for name in names:
        if names.count(name) > 1:
            raise OptionError(f"{system.name}: the free parameter {name} is named twice.")
    return system.places(names)


def point_at(
    analysis: str, system: System, at: Callable[[float], OperatingPoint], value: float
) -> OperatingPoint:
    """Operating point that a function of the user gives for a value.

    Raises
    ------
    OptionError
        If it gives anything else, or a point of another system.
    """
    point = at(value)
    if (
        not isinstance(point, OperatingPoint)
        or point.system.structure.flat is not system.structure.flat
    ):
        raise OptionError(
            f"{analysis}: at({value:g}) gave {shown(point)}; an operating point of this system "
            "is needed."
        )
    return point


def point_or_start(
    analysis: str, system: System, at: OperatingPoint | None, parameters: Changes | None
) -> OperatingPoint:
    """Operating point that is given, or the start point of parameters.

    Raises
    ------
    OptionError
        If both are given.
    """
    if at is not None and parameters:
        raise OptionError(f"{analysis}: give the parameters when making the operating point `at`.")
    point = at or start_point(system, parameters=parameters)
    if point.system.structure.redundant:
        raise OptionError(
            f"{analysis}: at this point a linkage of {system.name} is so near a position in which "
            "its constraints depend on each other that no states lead it. Choose another point."
        )
    return point


def by_name(start: object) -> Changes:
    """Start values by name; none if nothing is given.

    Raises
    ------
    OptionError
        If it is something else, such as a point, from which only runs start.
    """
    if start is None:
        return {}
    if isinstance(start, Mapping):
        return start
    if isinstance(start, OperatingPoint):
        raise OptionError(
            f"{start.system.name}: start is a point at t = {start.time:g} s, from which only runs "
            "and what takes at= can go on. Here start values by name are needed, such as "
            "{'rotor.w': 100.0}."
        )
    raise OptionError(
        f"start = {start!r}: start values by name are needed, such as {{'rotor.w': 100.0}}, or "
        "for a run from an equilibrium the point that lp.equilibrium(system) returns."
    )


def _begin_motion(point: OperatingPoint) -> OperatingPoint:
    """The point in its positions, after what collides there at once."""
    if not point.system.switching:
        return point
    return _make_begun(partial(replace, point), *point.inputs, point.system)


def _make_begun(
    make: Callable[..., OperatingPoint],
    x: np.ndarray,
    theta: np.ndarray,
    time: float,
    settings: np.ndarray,
    system: System,
) -> OperatingPoint:
    """The point of some states and settings in its positions, after what collides there at once."""
    if not system.switching:
        return make(x=x, settings=settings)
    try:
        begun, positions, hits = begin(system, theta, time, x, settings)
    except SolverError as error:
        raise StartError(str(error)) from None
    before = make(x=x, settings=settings) if hits else None
    return make(x=begun, settings=positions, collisions=hits, before=before)
