"""Derivatives of a periodic motion by parameters."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.gradients.forward import Forward
from lumped.gradients.steps import steps_of
from lumped.orbits.settled import settle_at_start
from lumped.orbits.shooting import Orbit, OrbitProblem, border_matrix
from lumped.orbits.smooth_curves import Extreme, values_along
from lumped.support.arguments import checked
from lumped.support.by_name import find_place
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.timeloop.results.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class OrbitSensitivity(RichHtml):
    """Derivatives of an orbit; ``found["motor.w", "motor.J"]`` gives one over the times of its run.

    Times are understood as fractions of the period: ``t / period`` is kept while both change.

    Attributes
    ----------
    run : Trajectory
        One period.
    of, to : tuple of str
        What is differentiated, and by what.
    period : dict of str to float
        Derivatives of the period by each parameter; zero if it is prescribed, one by the parameter
        that it is.
    start : ndarray, shape (n, len(by))
        Derivatives of the states at the start of the period.
    derivatives : ndarray, shape (len(run.t), len(of), len(by))
        Derivatives of the quantities.
    mean, greatest : ndarray, shape (len(of), len(by))
        Derivatives of the means over the period and of the greatest values.
    evaluations : int
        Evaluations of the right-hand side with its derivatives.
    """

    run: Trajectory
    of: tuple[str, ...]
    by: tuple[str, ...]
    period: dict[str, float]
    start: np.ndarray
    derivatives: np.ndarray
    mean: np.ndarray
    greatest: np.ndarray
    evaluations: int

    @checked
    def __getitem__(self, pair: tuple[Name, Name]) -> np.ndarray:
        row, column = (
            find_place(self.run.system.key(name), known, "was not asked for")
            for name, known in zip(pair, (self.of, self.by), strict=True)
        )
        return self.derivatives[:, row, column]

    def __repr__(self) -> str:
        head = f"{self.run.system.name}: derivatives along a periodic motion, "
        rows = [("period", name, number(value), "") for name, value in self.period.items()]
        for i, name in enumerate(self.of):
            for k, parameter in enumerate(self.by):
                rows.append((name, parameter, number(self.mean[i, k]), number(self.greatest[i, k])))
        return f"{head}{self.evaluations} evaluations\n" + table(
            ("of", "by", "itself or mean", "greatest"), rows
        )


def orbit_sensitivity(
    problem: OrbitProblem,
    orbit: Orbit,
    run: Trajectory,
    of: tuple[Name, ...],
    by: tuple[Name, ...],
    tops: list[Extreme],
    free: tuple[str, ...],
) -> OrbitSensitivity:
    """Implicit function theorem on what must vanish after a period.

    Parameters
    ----------
    tops : list of Extreme
        The greatest value of each quantity.
    free : tuple of str
        A parameter that follows the others, so that the period stays; empty if none does.

    Raises
    ------
    OptionError
        If `of` or `by` is empty.
    UnknownNameError
        If a name in `by` is no parameter that can be changed.
    """
    if not of or not by:
        raise OptionError("sensitivity: name at least one quantity in `of` and parameter in `by`.")
    system, active, T = problem.system, problem.active, orbit.guess.period
    names = tuple(system.key(name) for name in of)
    places = system.places((*by, *free))
    k, n = len(active), len(system.state_names)
    scale = np.abs(run.theta[places])
    scale[scale == 0] = 1.0
    seed = np.zeros((len(run.theta), k + len(places)))
    seed[places, k + np.arange(len(places))] = scale
    forward = Forward(steps_of(system, ()), seed, problem.rtol)
    settled = settle_at_start(run, seed[:, k:])
    begin = np.hstack([settled[:, active], settled[:, n:]])
    courses, instants = forward.sensitivities(run, begin)
    last = run.pieces[-1]
    point = (last.x[-1], run.theta, T, last.settings[-1])
    rate = np.asarray(system.rhs(*point)).ravel()[active]
    right = -courses[-1][-1][active][:, k:]
    if problem.free:
        right = np.vstack([right, np.zeros(len(places))])
    given = np.where(np.array(places) == problem.clock, scale, 0.0)  # how the period follows
    right[:k] -= np.outer(rate, given)
    found = scipy.linalg.solve(border_matrix(problem, orbit, rate), right)
    moved, stretch = found[:k], found[k] if problem.free else given
    chosen = np.eye(len(places))
    if free:
        chosen = np.vstack([chosen[:-1, :-1], -stretch[:-1] / stretch[-1]])
        moved, stretch, scale = moved @ chosen, np.zeros(len(by)), scale[:-1]
    columns = forward.along(run, courses, names)
    values = columns[:, :, :k] @ moved + columns[:, :, k:] @ chosen
    rates = _rates(run, names)
    values += rates[:, :, None] * (run.t / T)[:, None, None] * stretch
    # how far each instant moves beside its fraction of the period
    moves = [i.slopes[:k] @ moved + i.slopes[k:] @ chosen - i.t / T * stretch for i in instants]
    start = np.zeros((n, len(by)))
    start[active] = moved / scale
    keys = tuple(system.key(name) for name in by)
    by_key = dict(zip(keys, (stretch / scale).tolist(), strict=True))
    y = np.column_stack([run[name] for name in names])
    mean, greatest = _means(run, y, values, moves), _greatest(run, y, values, rates, moves, tops)
    return OrbitSensitivity(
        run,
        names,
        keys,
        by_key,
        start,
        values / scale,
        mean / T / scale,
        greatest / scale,
        forward.evaluations,
    )


def _slices(run: Trajectory) -> list[slice]:
    """Where each piece stands among the times of a run."""
    ends = np.cumsum([0, *(len(piece.t) for piece in run.pieces if len(piece.t))]).tolist()
    return [slice(*pair) for pair in itertools.pairwise(ends)]


def _means(
    run: Trajectory, y: np.ndarray, values: np.ndarray, moves: list[np.ndarray]
) -> np.ndarray:
    """Derivatives of the integrals of quantities over the fraction of the period, times it."""
    places = _slices(run)
    found: np.ndarray = sum(scipy.integrate.simpson(values[p], x=run.t[p], axis=0) for p in places)
    for before, after, move in zip(places, places[1:], moves, strict=False):
        found = found + np.outer(y[before][-1] - y[after][0], move)
    return found


def _greatest(
    run: Trajectory,
    y: np.ndarray,
    values: np.ndarray,
    rates: np.ndarray,
    moves: list[np.ndarray],
    tops: list[Extreme],
) -> np.ndarray:
    """Derivatives where quantities are greatest; at an instant that moves they move with it."""
    found = np.zeros(values.shape[1:])
    places, near = _slices(run), 1e-9 * run.t[-1]
    for i, (value, time) in enumerate(tops):
        best = np.inf
        for k, place in enumerate(places):
            t = run.t[place]
            if not t[0] - near <= time <= t[-1] + near:
                continue
            if len(t) == 1:
                here, by = y[place][0, i], values[place][0, i]
            else:
                here = float(scipy.interpolate.CubicSpline(t, y[place][:, i])(time))
                by = scipy.interpolate.CubicSpline(t, values[place][:, i])(time)
            if abs(here - value) < best:
                best, found[i] = abs(here - value), by
                if k and time - t[0] <= near:
                    found[i] += rates[place][0, i] * moves[k - 1]
                elif k < len(moves) and t[-1] - time <= near:
                    found[i] += rates[place][-1, i] * moves[k]
    return found


def _rates(run: Trajectory, names: tuple[str, ...]) -> np.ndarray:
    """Time derivatives of quantities, shape (len(run.t), len(names))."""
    system = run.system
    x, _, t, _ = system.inputs
    along = ca.vertcat(system.rates, 1)
    rate = ca.jtimes(system.expressions(names), ca.vertcat(x, t), along)
    function = ca.Function("rates", system.inputs, [ca.densify(rate)])
    return np.hstack(values_along(function, run)).T
