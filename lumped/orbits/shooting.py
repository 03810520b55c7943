"""Periodic motions by Newton's method on the states after a period."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.errors import OptionError, ParameterError, SolverError
from lumped.flattening.hold_modes import PARTED
from lumped.gradients.forward import Forward
from lumped.gradients.steps import steps_of
from lumped.numerics.damping import damp_step
from lumped.orbits.settled import settle_at_start
from lumped.simulation.simulate import simulate_led
from lumped.support.made_once import made_once
from lumped.timeloop.nominal_sizes import nominals
from lumped.timeloop.plants.executable import evaluate_at
from lumped.timeloop.programs import refuse_programs
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Trajectory

_DEPTH = 1e-8
"""Least gap at which bodies may part, m or rad, but for rounding zero."""
_SHORTEST = 2.0**-7
"""Fraction of a Newton step below which the search gives up."""


@dataclass(frozen=True, eq=False)
class OrbitProblem:
    """What must repeat.

    Attributes
    ----------
    system : System
        From `assemble`.
    advance : ndarray, shape (n,)
        By what each state grows in a period.
    active : ndarray of int, shape (k,)
        States that must repeat; the others have no effect on them.
    free : bool
        The period is unknown, or a parameter in its place.
    rtol : float
        Relative tolerance of runs, and of the residual.
    iterations : int
        Give up after so many.
    clock : int or None
        Place of the parameter that is the period.
    parameter : int or None
        Place of the parameter that is unknown in place of the period, while a motion is searched.
    """

    system: System
    advance: np.ndarray
    active: np.ndarray
    free: bool
    rtol: float
    iterations: int
    clock: int | None = None
    parameter: int | None = None

    def __post_init__(self) -> None:
        refuse_programs(self.system, "a periodic motion")


@dataclass(frozen=True, eq=False)
class Guess:
    """A start point, a period, s, and what fixes the phase, shape (k,); zeros if the time does."""

    point: OperatingPoint
    period: float
    phase: np.ndarray


@dataclass(frozen=True, eq=False)
class Orbit:
    """What was found.

    Attributes
    ----------
    guess : Guess
        Start point and period.
    run : Trajectory
        One period, at the steps of the solver.
    monodromy : ndarray, shape (k, k)
        Derivatives of the active states after a period by those before it.
    residuals : ndarray, shape (k,)
        What the active states miss after a period, over their size.
    condition : float
        Condition number of the Jacobian, in states over their size.
    iterations, evaluations : int
        Newton steps, evaluations of the right-hand side.
    """

    guess: Guess
    run: Trajectory
    monodromy: np.ndarray
    residuals: np.ndarray
    condition: float
    iterations: int
    evaluations: int


class Shot:
    """A run over one period and what it misses."""

    def __init__(self, problem: OrbitProblem, guess: Guess) -> None:
        self.guess = guess
        system, active = problem.system, problem.active
        self.run = simulate_led(
            system, until=guess.period, start=guess.point, grid=None, rtol=problem.rtol
        )
        last = self.run.pieces[-1]
        if last.system is not system:
            raise SolverError(
                f"{system.name}: states change places during the period (see run.events); "
                "periodic motions are not followed across that.",
                self.run,
            )
        self.end, self.settings = last.x[-1], last.settings[-1]
        missed = (self.end - guess.point.x - problem.advance)[active]
        self.size = sizes(problem, self.run.x)
        self.residuals: np.ndarray = missed / self.size
        self.active = active

    @cached_property
    def rate(self) -> np.ndarray:
        """Derivatives of the active states at the end."""
        point = self.end, self.run.theta, self.guess.period, self.settings
        found: np.ndarray = evaluate_at(self.run.system, "rates", *point)[self.active]
        return found


def in_modes(point: OperatingPoint, settings: np.ndarray) -> np.ndarray:
    """Settings of a point with other modes; its implicit quantities, where angles did not turn."""
    count = len(settings) - len(point.system.structure.implicit)
    return np.concatenate([settings[:count], point.settings[count:]])


def sizes(problem: OrbitProblem, x: np.ndarray) -> np.ndarray:
    """How large the active states become, at least what runs resolve."""
    least = max(1e-3, 1e-12 / problem.rtol) * nominals(problem.system)
    found: np.ndarray = np.maximum(np.abs(x).max(axis=0), least)[problem.active]
    return found


def refuse_beyond(shot: Shot) -> None:
    """A run that begins beyond a stop counts its gap from there, and repeats though it must not."""
    system = shot.run.system
    for h, first in enumerate(system.switching.first_modes.tolist()):
        depth = -min(float(piece.settings[0, first + PARTED]) for piece in shot.run.pieces)
        if depth > _DEPTH:
            name, unit = system.switching.names[h], system.switching.gap_units[h]
            raise SolverError(
                f"{system.name}: the motion found begins {depth:.3g} {unit} beyond the stop of "
                f"{name}. Give start values within it, and let it warm up longer.",
                shot.run,
            )


def refuse_rest(problem: OrbitProblem, run: Trajectory) -> None:
    """An equilibrium repeats after any period."""
    if (np.ptp(run.x, axis=0)[problem.active] < 1e-6 * sizes(problem, run.x)).all():
        raise SolverError(
            f"{problem.system.name}: what was found is an equilibrium, not a periodic motion. "
            "Give start values farther from it, and let it warm up less.",
            run,
        )


def shoot(problem: OrbitProblem, guess: Guess) -> Orbit:
    """Newton's method, damped, until the residual is below the tolerance.

    Where no part of a step makes it smaller, the motion goes on for a period by itself. Where an
    orbit is so unstable that it amplifies the errors of a run beyond that, they are the
    tolerance.

    The Jacobian is the monodromy matrix less one (Parker and Chua, Practical Numerical Algorithms
    for Chaotic Systems, 1989, ch. 5), from the sensitivity equations, exact across events; an
    unknown period adds the rates at the end as a column and the phase as a row, an unknown
    parameter the derivatives by it.

    Raises
    ------
    OptionError
        If the motion does not depend on the unknown parameter.
    SolverError
        If it does not converge, or motions beside the one found are periodic too.
    """
    places = () if problem.parameter is None else (problem.parameter,)
    forward = forward_by(problem, places, guess.point.theta)
    shot = Shot(problem, guess)
    evaluations = shot.run.statistics.evaluations
    for iteration in range(problem.iterations + 1):
        if np.abs(shot.residuals).max(initial=0.0) <= problem.rtol:
            return _finish(problem, shot, forward, iteration, evaluations)
        if iteration == problem.iterations:
            break
        slopes = slopes_of(problem, shot, forward)
        better, used = _shorten_step(problem, shot, *_newton_step(problem, shot, slopes, forward))
        evaluations += used
        if better is not None:
            shot = better
        else:
            own = slopes[:, : len(shot.size)] * shot.size / shot.size[:, None]
            amplified = problem.rtol * np.abs(own).max()
            if np.abs(shot.residuals).max() <= amplified:
                return _finish(problem, shot, forward, iteration, evaluations)
            shot = Shot(problem, _move_guess(problem, shot, shot.end - problem.advance, 0.0))
            evaluations += shot.run.statistics.evaluations
    raise _refusal(problem, shot)


def border_matrix(problem: OrbitProblem, orbit: Orbit, rate: np.ndarray) -> np.ndarray:
    """Derivative of residuals and phase by states and period (without both if it is known)."""
    matrix = orbit.monodromy - np.eye(len(problem.active))
    if not problem.free:
        return matrix
    return np.block([[matrix, rate[:, None]], [orbit.guess.phase[None, :], 0.0]])


def forward_by(problem: OrbitProblem, places: tuple[int, ...], theta: np.ndarray) -> Forward:
    """Sensitivity equations by start states and parameters, with a count of their own.

    A parameter counts in units of the power of two near its value.
    """
    units = tuple(float(2.0 ** np.rint(np.log2(abs(theta[i]) or 1.0))) for i in places)
    return copy(_make_forward(problem.system, len(problem.active), problem.rtol, places, units))


@made_once
def _make_forward(
    system: System, varied: int, rtol: float, places: tuple[int, ...], units: tuple[float, ...]
) -> Forward:
    seed = np.zeros((system.inputs[1].numel(), varied + len(places)))
    seed[list(places), varied + np.arange(len(places))] = units
    return Forward(steps_of(system, ()), seed, rtol)


def slopes_of(problem: OrbitProblem, shot: Shot, forward: Forward) -> np.ndarray:
    """Derivatives of the active states after a period, by them and by unknown parameters.

    What only jumps, as the lock of a synchroniser, and did not, has one of few values and is not
    disturbed.
    """
    k = len(problem.active)
    settled = settle_at_start(shot.run, forward.seed[:, k:])
    n = len(settled)
    S = np.hstack([settled[:, problem.active], settled[:, n:]])
    found: np.ndarray = forward.at_end(shot.run, S)[problem.active]
    nodes = [problem.system.structure.states[i] for i in problem.active]
    jumping = np.isin(
        nodes, [node for jump in problem.system.switching.jumps for node in jump.nodes]
    )
    found[jumping & (found == np.eye(*found.shape)).all(axis=1)] = 0.0
    return found


def _move_guess(problem: OrbitProblem, shot: Shot, x: np.ndarray, change: float) -> Guess:
    """A new guess, in the modes in which the last run ended; period or parameter changed too."""
    old, period = shot.guess.point, shot.guess.period
    theta, settings = old.theta, in_modes(old, shot.settings)
    if problem.parameter is None:
        period += change
    else:
        theta = theta.copy()
        theta[problem.parameter] += change
        old.system.check_parameters(theta)
    return Guess(OperatingPoint(old.system, 0.0, x, theta, settings), period, shot.guess.phase)


def _shorten_step(
    problem: OrbitProblem, shot: Shot, step: np.ndarray, change: float
) -> tuple[Shot | None, int]:
    """The run after the longest part of a step that misses less, and evaluations in all tried."""
    evaluations = 0

    def trial(part: float) -> tuple[Shot | None, float]:
        nonlocal evaluations
        if problem.parameter is None and not 0.3 < 1 + part * change / shot.guess.period < 3:
            return None, np.inf
        x = shot.guess.point.x.copy()
        x[problem.active] += part * step
        try:
            found = Shot(problem, _move_guess(problem, shot, x, part * change))
        except (SolverError, ParameterError):
            return None, np.inf
        evaluations += found.run.statistics.evaluations
        return found, float(np.linalg.norm(found.residuals))

    better = damp_step(trial, float(np.linalg.norm(shot.residuals)), _SHORTEST)
    return better, evaluations


def _newton_step(
    problem: OrbitProblem, shot: Shot, slopes: np.ndarray, forward: Forward
) -> tuple[np.ndarray, float]:
    """Changes of the active states and of the period or the parameter."""
    k, size = len(problem.active), shot.size
    (matrix, _), right = _scale_jacobian(problem, shot, slopes), -shot.residuals
    if not problem.free:
        return scipy.linalg.solve(matrix, right) * size, 0.0
    found = scipy.linalg.solve(matrix, np.append(right, 0.0))
    place = problem.parameter
    unit = shot.guess.period if place is None else forward.seed[place, k]
    return found[:k] * size, float(found[k] * unit)


def _scale_jacobian(
    problem: OrbitProblem, shot: Shot, slopes: np.ndarray
) -> tuple[np.ndarray, float]:
    """Jacobian in states over their size and the other unknown over its own, and its condition."""
    k, size = len(problem.active), shot.size
    matrix = (slopes[:, :k] - np.eye(k)) * size / size[:, None]
    if problem.free:
        row, column = shot.guess.phase * size, shot.rate * shot.guess.period / size
        if problem.parameter is not None:
            column = slopes[:, k] / size
            if not column.any():
                raise OptionError(
                    f"periodic: the period does not depend on {_parameter(problem)}; free a "
                    "parameter that changes it."
                )
        row = row / np.linalg.norm(row)
        matrix = np.block([[matrix, column[:, None]], [row[None, :], 0.0]])
    _, values, rows = scipy.linalg.svd(matrix)
    if values[-1] <= max(1e-9, 10 * problem.rtol) * max(values[0], 1.0):
        _refuse_singular(problem, shot, np.abs(rows[-1, :k]))
    return matrix, float(values[0] / values[-1])


def _refuse_singular(problem: OrbitProblem, shot: Shot, shares: np.ndarray) -> None:
    names = [problem.system.state_names[i] for i in problem.active]
    moved = [names[i] for i in np.argsort(-shares) if shares[i] > 0.1 * shares.max()]
    raise SolverError(
        f"{problem.system.name}: motions with other {', '.join(moved[:6])} are periodic too "
        "(the monodromy matrix has a multiplier 1 along them), so none is determined. Where an "
        "angle goes on turning, give its turn; where the period is not prescribed by a function "
        "of time, give near= instead of period=; add damping or a load where nothing settles.",
        shot.run,
    )


def _finish(
    problem: OrbitProblem, shot: Shot, forward: Forward, iterations: int, evaluations: int
) -> Orbit:
    first = shot.run.pieces[0].x[0]
    if np.abs(first - shot.guess.point.x)[problem.active].max(initial=0.0) > 1e-9:
        raise SolverError(
            f"{problem.system.name}: states jump at the very start of the period. Choose another "
            "phase (start values, or begin functions of time later).",
            shot.run,
        )
    refuse_beyond(shot)
    slopes = slopes_of(problem, shot, forward)
    _, condition = _scale_jacobian(problem, shot, slopes)
    monodromy = slopes[:, : len(problem.active)]
    evaluations += forward.evaluations
    cost = iterations, evaluations
    return Orbit(shot.guess, shot.run, monodromy, shot.residuals, condition, *cost)


def _refusal(problem: OrbitProblem, shot: Shot) -> SolverError:
    worst = int(np.argmax(np.abs(shot.residuals)))
    number = int(problem.active[worst])
    name = problem.system.state_names[number]
    unit = "" if "(" in name else f" {problem.system.quantity(name).unit}"
    missed = shot.residuals[worst] * shot.size[worst]
    if problem.parameter is not None:
        value = shot.guess.point.theta[problem.parameter]
        return SolverError(
            f"{problem.system.name}: no {_parameter(problem)} for which the period is "
            f"{shot.guess.period:.9g} s was found in {problem.iterations} iterations; for "
            f"{value:.6g} {name} misses its value by {missed:.4g}{unit} after it. Begin with a "
            "value nearer to it.",
            shot.run,
        )
    return SolverError(
        f"{problem.system.name}: no periodic motion found after {problem.iterations} iterations: "
        f"after T = {shot.guess.period:.9g} s {name} misses its value by {missed:.4g}{unit}, "
        f"{abs(shot.residuals[worst]):.2g} of its size (tolerance {problem.rtol:.2g}). Let it "
        "warm up longer, give start values nearer to it, or check the period.",
        shot.run,
    )


def _parameter(problem: OrbitProblem) -> str:
    """Name of the unknown parameter."""
    assert problem.parameter is not None
    return problem.system.structure.parameters.free_names[problem.parameter]
