"""Simulation in time."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import replace
from typing import ParamSpec, Unpack

import numpy as np

from lumped.compiler.system import System
from lumped.errors import Interrupted, SolverError
from lumped.many_runs.native_runs import read_run
from lumped.points.start import run_start
from lumped.simulation.certify import certify_run
from lumped.simulation.compare import between
from lumped.simulation.energy_audit import audit_energy
from lumped.simulation.method_choice import closed_form_pays
from lumped.simulation.run_again import again_from, run_from
from lumped.support.arguments import checked
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.recorder import Recorder, output_times
from lumped.timeloop.results.statistics import Statistics
from lumped.timeloop.results.trajectory import Trajectory
from lumped.timeloop.results.validity import refuse_run_outside
from lumped.timeloop.run_options import Grid, RunOptions, RunPlan, run_plan

_P = ParamSpec("_P")


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
    plan = run_plan(until, rtol, options)
    point = run_start(system, plan)
    if plan.method == "auto" and grid is None:
        plan = plan._replace(method="steps")
    elif plan.method == "auto" and closed_form_pays(point, plan.until, rtol):
        plan = plan._replace(method="exact")
    found = run_on(point, plan, recorder(point, plan, grid))
    return _certify(found, point, plan) if certify else found


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
    found = run_from(point, plan, output)
    refuse_run_outside(found)
    again = None if point.again is None else again_from(point, plan)
    return replace(found, read=functools.partial(read_run, plan, point), again=again)


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
        return certify_run(found, same, tighter, tight, energy)
    except SolverError as error:
        raise SolverError(f"certify: the second run, at rtol = {tight:g}: {error}", found) from None
    except KeyboardInterrupt:
        name = found.system.name
        text = f"{name}: interrupted while it was certified; `partial` is the whole run."
        raise Interrupted(text, found) from None
