"""Simulation in time."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Literal, ParamSpec

import numpy as np

from lumped.compiler.system import Changes, Name, System
from lumped.errors import Interrupted, OptionError, SolverError
from lumped.many_runs.read_run import read_run
from lumped.points.start import found_start
from lumped.simulation.certify import certified
from lumped.simulation.compare import between
from lumped.simulation.energy_audit import audited
from lumped.simulation.method_choice import closed_form_pays
from lumped.simulation.run_again import again_from, made, run_from
from lumped.support.arguments import checked
from lumped.support.progress import Progress
from lumped.support.units import in_seconds
from lumped.timeloop.recorder import Recorder, SparingRecorder, output_times
from lumped.timeloop.result import OperatingPoint, Statistics, Trajectory
from lumped.timeloop.run_by_steps import RunBySteps
from lumped.timeloop.validity import refuse_run_outside

__all__ = ["Method", "check_options", "simulate", "simulate_sparingly"]

_MOST_STEPS = 1_000_000
Grid = int | Sequence[float | str] | np.ndarray | None
_P = ParamSpec("_P")
Method = Literal["auto", "explicit", "implicit", "exact", "steps", "taylor"]


def _told(analysis: Callable[_P, Trajectory]) -> Callable[_P, Trajectory]:
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


@_told
@checked
def simulate(
    system: System,
    *,
    until: float | str,
    begin: float | str | None = None,
    parameters: Changes | None = None,
    start: Changes | OperatingPoint | None = None,
    free: Iterable[Name] = (),
    grid: Grid = 500,
    rtol: float = 1e-6,
    atol: float | None = None,
    method: Method = "auto",
    max_steps: int = _MOST_STEPS,
    certify: bool = False,
) -> Trajectory:
    """Simulate from one time to another.

    Where a function of time jumps or has a kink, and where a condition, contact or friction element
    changes its mode, the method stops exactly there and starts anew.

    The time loop is compiled once on a machine, which takes a second or two. The functions of a
    system are interpreted until they were evaluated so often that compiling them would have taken
    as long; results are the same to the last bit. Machine code is kept in the user's folder of
    caches, or in ``LUMPED_CACHE``. That folder is trusted, as what stands there is executed: one
    that belongs to another user, or that others may write, is not used, and a warning says so.

    Parameters
    ----------
    system : System
        From `assemble`.
    until : float or str
        End, s, or with a unit, such as ``"500 ms"``.
    begin : float or str, optional
        Begin, s; default is the time of the start point, or zero. With a start point of another
        time, its states are taken as those at the begin.
    parameters : mapping of name to float, optional
        Parameters to change for this run.
    start : mapping of name to float, or OperatingPoint, optional
        Start values to set or change; or a point to start from, with its time, states, parameters
        and modes: one that `equilibrium` or `start_point` found, or one of an earlier run, which
        then goes on (``start=run.point(2.0)``).
    free : iterable of names
        Parameters that the start values determine (see `start_point`).
    grid : int, sequence of float, or None
        Number of equal output intervals (both sides of a jump are added), or the output times
        themselves, s, (a value at a jump is that after it), or None for the steps of the solver (of
        the closed form the ends of its parts).
    rtol : float
        Relative tolerance.
    atol : float, optional
        Absolute tolerance, relative to the nominal value of each state; default is
        ``rtol / 1000``, at least 1e-12. It governs a state that stays smaller than
        ``atol / rtol`` throughout; `Trajectory` names such states when printed.
    method : {"auto", "explicit", "implicit", "exact", "steps", "taylor"}
        "explicit" is DOP853, "implicit" Rodas5P, "steps" the second while stability
        holds the steps of the first and implicit ones are longer, else the first, as often as that
        changes. "taylor" is the same with explicit steps by Taylor's series of the states, compiled
        for the system and the order that `rtol` asks for: long ones for smooth motions, above all
        of linear drives and at tight tolerances; it is refused where what varies goes through an
        operation without derivatives, or a linkage is closed by iteration. "exact" is the closed
        form, for systems that are linear between jumps, with functions of time that are polynomials
        there. "auto" takes the closed form where there is one, rounding leaves it better than
        `rtol`, and it costs less than steps; else, and for ``grid=None``, "steps". After 50 000
        attempts it goes on as "taylor" if there are series: the rest of such a run is worth
        compiling them.
    max_steps : int
        Give up after so many attempted steps.
    certify : bool
        Run once more by steps with a hundredth of the tolerances and give the differences as
        ``run.certificate``, with the energy balance of the run.

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
    until = in_seconds(until, "until")
    if begin is None:
        begin = start.time if isinstance(start, OperatingPoint) else 0.0
    begin = in_seconds(begin, "begin")
    check_options(begin, until, rtol, atol, method, max_steps)
    times = output_times(grid, until, begin)
    if isinstance(start, OperatingPoint):
        if not start.system.is_chart_of(system) or parameters or tuple(free):
            raise OptionError(
                "simulate: a start point brings its own parameters and belongs to the system that "
                "it was made for; give no parameters or free parameters beside it."
            )
        point = start if start.time == begin else replace(start, time=begin)
        begun = None
    else:
        begun = functools.partial(
            found_start, parameters=parameters, start=start, free=tuple(free), time=begin
        )
        point = begun(system)
    relative_atol = max(rtol * 1e-3, 1e-12) if atol is None else atol
    used = "steps" if method == "auto" and times is None else method
    if used == "auto" and closed_form_pays(point, until, rtol):
        used = "exact"
    both_sides = grid is None or isinstance(grid, int)
    found = run_from(point, until, rtol, relative_atol, used, max_steps, times, both_sides)
    refuse_run_outside(found)
    options = (until, rtol, relative_atol, used, max_steps)
    found = replace(found, read=functools.partial(read_run, point, begun, *options))
    if point.again is not None:
        found = replace(found, again=again_from(point, *options))
    if not certify:
        return found
    closed, tight = used == "exact", max(1e-2 * rtol, 1e-13)

    def again(times: Grid, *, tightly: bool) -> Trajectory:
        share = tight / rtol if tightly else 1.0
        return simulate(
            system,
            until=until,
            start=point,
            grid=times,
            rtol=rtol * share,
            atol=None if atol is None else atol * share,
            method="steps" if tightly and closed else used,
            max_steps=100 * max_steps,
        )

    try:
        inner = between(found)
        times = np.sort(np.concatenate([found.t, inner]))
        same = again(times, tightly=False) if len(inner) else found
        tighter = again(times, tightly=True)
        energy = audited(found, lambda times: again(times, tightly=closed))
        return certified(found, same, tighter, tight, energy)
    except SolverError as error:
        raise SolverError(f"certify: the second run, at rtol = {tight:g}: {error}", found) from None
    except KeyboardInterrupt:
        text = f"{system.name}: interrupted while it was certified; `partial` is the whole run."
        raise Interrupted(text, found) from None


@_told
def simulate_sparingly(
    system: System,
    *,
    until: float,
    parameters: Changes | None,
    start: Changes | None,
    rtol: float,
    method: Method,
    most: int,
) -> Trajectory:
    """As `simulate` with ``grid=None``, but states at some steps only where all take too much room.

    The pieces then know the ends of all steps, so that these can be made again. Where implicit
    quantities are followed by iteration, whose guesses belong to each step, all are recorded.

    Parameters
    ----------
    most : int
        Size of the states that are recorded, bytes.
    """
    check_options(0.0, until, rtol, None, method, _MOST_STEPS)
    point = found_start(system, parameters, start, (), 0.0)
    used = "steps" if method == "auto" else method
    with Progress(system.name, until) as progress:
        if system.structure.implicit:
            output = Recorder(0.0, until, None, True, progress)
        else:
            output = SparingRecorder(0.0, until, most, progress)
        atol = max(rtol * 1e-3, 1e-12)
        run = RunBySteps(point, until, rtol, output, atol, used, _MOST_STEPS)
        found = made(run, _MOST_STEPS)
    refuse_run_outside(found)
    return found


def check_options(
    begin: float, until: float, rtol: float, atol: float | None, method: str, max_steps: int
) -> None:
    """Refuse options of a run that make no sense.

    Raises
    ------
    OptionError
    """
    if not until > begin:
        what = "a positive, finite time" if begin == 0 else f"after the begin, {begin:g} s"
        what += " (that of the start point, unless begin= says another)" * (begin != 0)
        raise OptionError(f"until = {until!r} s: the end must be {what}.")
    if not 1e-14 <= rtol < 1:
        raise OptionError(f"rtol = {rtol}: the relative tolerance must lie between 1e-14 and 1.")
    if atol is not None and not atol > 0:
        raise OptionError(f"atol = {atol}: the absolute tolerance must be positive.")
    if max_steps < 1:
        raise OptionError(f"max_steps = {max_steps}: at least one step is needed.")
    methods = ("auto", "explicit", "implicit", "exact", "steps", "taylor")
    if method not in methods:
        raise OptionError(f"method = {method!r}: choose one of {', '.join(map(repr, methods))}.")
