"""Simulation in time."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ParamSpec, Unpack

import numpy as np

from lumped.compiler.system import System
from lumped.errors import Interrupted, SolverError, doubt
from lumped.many_runs.native_runs import read_run
from lumped.points.start import run_start
from lumped.simulation.certify import Certificate, between, choose_names, compare_runs
from lumped.simulation.energy_audit import audit_energy
from lumped.support.arguments import checked
from lumped.timeloop.closed_form_choice import closed_form_pays
from lumped.timeloop.results.operating_point import OperatingPoint, PointOfRun
from lumped.timeloop.results.recorder import Recorder, output_times
from lumped.timeloop.results.statistics import Statistics
from lumped.timeloop.results.trajectory import Again, Read, Trajectory
from lumped.timeloop.results.validity import refuse_point_outside, refuse_run_outside
from lumped.timeloop.run import Simulation
from lumped.timeloop.run_by_steps import RunBySteps
from lumped.timeloop.run_in_closed_form import RunInClosedForm
from lumped.timeloop.run_options import Grid, RunOptions, RunPlan, run_plan

_P = ParamSpec("_P")
_SAME = 1e-12
"""Distance in time, over the end of the run, below which an instant is that of an event."""


def run_from(
    point: OperatingPoint,
    plan: RunPlan,
    output: Recorder,
    read: Read | None = None,
    again: Again | None = None,
) -> Trajectory:
    """The run from a point by the method of its plan, which a recorder takes."""
    kind = RunInClosedForm if plan.method == "exact" else RunBySteps
    with output.progress:
        run = kind(point, plan, output)
        try:
            run.go()
            return run.trajectory(read, again)
        except KeyboardInterrupt:
            raise _make_interrupted(run) from None
        except SolverError as error:
            if plan.method == "exact" or run.steps + run.rejected >= plan.max_steps:
                raise  # rounding and the number of steps are limits of ours, not of the drive
            raise SolverError(doubt(plan.rtol) + str(error), error.partial) from None


def _make_interrupted(run: Simulation) -> Interrupted:
    partial = run.partial()
    return Interrupted(
        f"{run.system.name}: interrupted at t = {partial.t[-1]:.6g} s; `partial` is the run.",
        partial,
    )


@dataclass(eq=False, slots=True)
class _RepeatedRun:
    """Makes a run again, with the states that were left out.

    A run that goes on from another begins with what that one had, and so on in a row. Rows may be
    long, so nothing here calls itself along them.

    Attributes
    ----------
    point : OperatingPoint
        Where it starts; of a run that goes on from another, without that.
    plan : RunPlan
        Its options.
    before : _RepeatedRun or None
        The run from which it goes on.
    left : float
        When it left that, s.
    whole : OperatingPoint or None
        Where it starts, with the states that were left out, once these are known.
    """

    point: OperatingPoint
    plan: RunPlan
    before: _RepeatedRun | None = None
    left: float = math.nan
    whole: OperatingPoint | None = None

    def __call__(self, times: np.ndarray) -> Trajectory:
        row = [self]
        while row[-1].whole is None and row[-1].before is not None:
            row.append(row[-1].before)
        if row[-1].whole is None:
            row[-1].whole = row[-1].point.whole
        for before, run in itertools.pairwise(row[::-1]):
            run.whole = replace(run.point, again=PointOfRun(before._again, run.left)).whole
        return self._again(times)

    def _again(self, times: np.ndarray) -> Trajectory:
        """The same run of the whole system, at some times; its start is known."""
        assert self.whole is not None
        until = float(times[-1])
        if until == self.whole.time:
            until = self.plan.until
        output = Recorder(self.whole, until, times, True)
        return run_from(self.whole, self.plan._replace(until=until), output)

    def __reduce__(self) -> tuple[Any, ...]:
        row = [self]
        while row[-1].before is not None:
            row.append(row[-1].before)
        return _as_row, tuple((r.point, r.plan, r.left, r.whole) for r in row[::-1])


def _as_row(*parts: Any) -> _RepeatedRun | None:
    """The last of runs that go on from each other."""
    found = None
    for point, plan, left, whole in parts:
        found = _RepeatedRun(point, plan, found, left, whole)
    return found


def _again_from(point: OperatingPoint, plan: RunPlan) -> _RepeatedRun:
    """Makes the run from a point again."""
    came = point.again
    if plan.start is not None:
        plan = plan._replace(start=None)
    if not isinstance(came, PointOfRun):
        return _RepeatedRun(point, plan)
    return _RepeatedRun(replace(point, again=None), plan, came.run, came.time)


def interruptible(analysis: Callable[_P, Trajectory]) -> Callable[_P, Trajectory]:
    """The same, with an error of ours where it is interrupted before there is a run."""

    @functools.wraps(analysis)
    def run(*args: _P.args, **options: _P.kwargs) -> Trajectory:
        try:
            return analysis(*args, **options)
        except Interrupted:
            raise
        except KeyboardInterrupt:
            system = args[0] if args else options["system"]
            assert isinstance(system, System)
            text = f"{system.name}: interrupted before the run began; `partial` is empty."
            raise Interrupted(text, _nothing(system)) from None

    return run


def _nothing(system: System) -> Trajectory:
    cost = Statistics((), 0, 0, 0, 0, 0.0, ())
    return Trajectory(system, (), system.theta(None), (), cost)


@interruptible
@checked
def simulate(
    system: System,
    *,
    until: float | str,
    grid: Grid = 500,
    rtol: float = 1e-6,
    certify: bool = False,
    **options: Unpack[RunOptions],
) -> Trajectory:
    """Simulate from one time to another.

    Where a function of time jumps or has a kink, and where a condition, contact or friction element
    changes its mode, the method stops exactly there and starts anew.

    The time loop is compiled once on a machine, which takes a second or two. The functions of a
    system are interpreted until they were evaluated so often that compiling them would have taken
    as long; results are the same to the last bit. Machine code is kept in the user's folder of
    caches, or in ``LUMPED_CACHE``. That folder is trusted, as what it holds is executed: one
    that belongs to another user, or that others may write, is not used, and a warning says so.

    Parameters
    ----------
    system : System
        From `assemble`.
    until : float or str
        End, s, or with a unit, such as ``"500 ms"``.
    grid : int, sequence of float, or None
        Number of equal output intervals (both sides of a jump are added), or the output times
        themselves, s, (a value at a jump is that after it), or None for the steps of the solver (of
        the closed form the ends of its parts).
    rtol : float
        Relative tolerance.
    certify : bool
        Run once more by steps with a hundredth of the tolerances and give the differences as
        ``run.certificate``, with the energy balance of the run.
    **options : RunOptions
        `begin`, `parameters`, `start`, `free`, `atol`, `method` and `max_steps` of the run (see
        `RunOptions`).

    Returns
    -------
    Trajectory

    Raises
    ------
    OptionError
        If `until`, `begin`, `grid`, `rtol`, `atol` or `method` make no sense, the start point
        belongs to another system, `method` is "exact" and the system is not linear, or it is
        "taylor" and there are no series.
    StartError
        If the start values contradict each other.
    SolverError
        If the run cannot be completed; its `partial` holds the run up to there. Or if it takes a
        component beyond where its equations hold; `partial` is the whole run.
    Interrupted
        If it is interrupted (Ctrl-C); with `partial` too.
    """
    found, point, plan = _run_by_plan(system, run_plan(until, rtol, options), grid)
    return _certify(found, point, plan) if certify else found


@interruptible
def simulate_led(
    system: System, *, until: float, start: OperatingPoint, grid: Grid, rtol: float
) -> Trajectory:
    """A run for analyses that follow its states: these lead as long as they lead at all."""
    plan = run_plan(until, rtol, {"start": start})._replace(is_led=True)
    return _run_by_plan(system, plan, grid)[0]


def _run_by_plan(
    system: System, plan: RunPlan, grid: Grid
) -> tuple[Trajectory, OperatingPoint, RunPlan]:
    """A run, where it starts, and its options with the method that was taken."""
    point = run_start(system, plan)
    output = recorder(point, plan, grid)
    if plan.method == "auto" and output.times is None:
        plan = plan._replace(method="steps")
    elif plan.method == "auto" and closed_form_pays(point, plan, output.size):
        plan = plan._replace(method="exact")
    return run_on(point, plan, output), point, plan


def recorder(point: OperatingPoint, plan: RunPlan, grid: Grid) -> Recorder:
    """What takes the output of a run at some times (see `simulate`).

    Raises
    ------
    OptionError
        If they make no sense.
    """
    times = output_times(grid, plan.until, plan.begin)
    return Recorder(point, plan.until, times, grid is None or isinstance(grid, int))


def run_on(point: OperatingPoint, plan: RunPlan, output: Recorder) -> Trajectory:
    """The run from a point, which can be read and made again, and leaves no range of equations."""
    again = None if point.again is None else _again_from(point, plan)
    try:
        found = run_from(point, plan, output, functools.partial(read_run, plan, point), again)
    except SolverError as error:  # equations that do not hold may have no solution either
        refuse_point_outside(point, "at the start")
        if error.partial is not None:
            refuse_run_outside(error.partial)
        raise
    refuse_run_outside(found)
    return found


def _certify(found: Trajectory, point: OperatingPoint, plan: RunPlan) -> Trajectory:
    """The run with a certificate, by steps at a hundredth of the tolerances."""
    closed, tight = plan.method == "exact", max(1e-2 * plan.rtol, 1e-13)
    same_plan = plan._replace(start=point, max_steps=100 * plan.max_steps)

    def again(times: Grid, *, tightly: bool) -> Trajectory:
        own = same_plan.at(plan.rtol * (tight / plan.rtol)) if tightly else same_plan
        if tightly and closed:
            own = own._replace(method="steps")
        return run_on(point, own, recorder(point, own, times))

    try:
        inner = between(found)
        times = np.sort(np.concatenate([found.t, inner]))
        same = again(times, tightly=False) if len(inner) else found
        tighter = again(times, tightly=True)
        energy = audit_energy(found, lambda times: again(times, tightly=closed))
        names = choose_names(found.system, None) if found.system.structure.states else []
        states = compare_runs(same, tighter, tight, names)
        certificate = Certificate(same, tighter, len(inner), tight, states, energy)
        return replace(found, certificate=certificate)
    except SolverError as error:
        raise SolverError(f"certify: the second run, at rtol = {tight:g}: {error}", found) from None
    except KeyboardInterrupt:
        name = found.system.name
        text = f"{name}: interrupted while it was certified; `partial` is the whole run."
        raise Interrupted(text, found) from None


def run_sampled(system: System, plan: RunPlan, t: np.ndarray) -> Trajectory:
    """A run by steps to the last of some instants, with output at each of them.

    Both sides of jumps are recorded too, so that derivatives can be followed across them.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Instants, ascending, s.
    """
    point = run_start(system, plan)
    times = np.union1d(plan.begin, t)
    return run_from(point, plan, Recorder(point, plan.until, times, True))


def places_of(run: Trajectory, t: np.ndarray) -> np.ndarray:
    """Points of such a run at its instants; on a jump those after it."""
    found: np.ndarray = np.searchsorted(run.t, t + _SAME * run.t[-1], "right") - 1
    return found
