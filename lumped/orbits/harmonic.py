"""Harmonic balance of smooth systems, as trigonometric collocation."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import scipy

from lumped.errors import OptionError, SolverError
from lumped.numerics.damping import damped
from lumped.numerics.singular_factors import factors_of
from lumped.orbits.shooting import Guess, OrbitProblem
from lumped.simulation.simulate import simulate
from lumped.timeloop.instants import clocks
from lumped.timeloop.result import OperatingPoint

__all__ = ["collocate"]

_FIRST, _MOST = 8, 512
"""Harmonics to begin with, and at most."""
_SHORTEST = 2.0**-9
"""Part of a Newton step at which the search ends."""


def collocate(
    problem: OrbitProblem, guess: Guess, harmonics: int | None
) -> tuple[Guess, int, int, int]:
    """Refine a guess; also harmonics used, Newton steps and evaluations.

    The derivative of the trigonometric polynomial through an odd number of points is exact for its
    harmonics (Trefethen, Spectral Methods in MATLAB, 2000, ch. 3, for the odd case). The turn of
    an angle is a straight line beside it.

    Raises
    ------
    OptionError
        If the system is not smooth.
    SolverError
        If Newton's method does not converge, or the harmonics do not fade.
    """
    system = problem.system
    theta = guess.point.theta
    if any(clock.moves for clock in clocks(system)):
        raise OptionError(
            f"periodic: harmonic balance needs a smooth system, but functions of time in "
            f"{system.name} jump or have a kink. Use search='shooting'."
        )
    count = harmonics or _FIRST
    points = 2 * count + 1
    run = simulate(
        system, until=guess.period, start=guess.point, grid=points * 8, rtol=max(problem.rtol, 1e-8)
    )
    X = run.x[: points * 8 : 8][:, problem.active]
    X = X - np.outer(np.arange(points) / points, problem.advance[problem.active])
    balance = _Balance(problem, guess, run.pieces[0].settings[0])
    period, steps, evaluations = guess.period, 0, 0
    while True:
        X, period, used = balance.solve(X, period)
        steps, evaluations = steps + used, evaluations + (used + 1) * len(X)
        if harmonics is not None or _tail(X) <= problem.rtol:
            break
        if 2 * count > _MOST:
            raise SolverError(
                f"{system.name}: {count} harmonics do not fade below rtol = {problem.rtol:g} "
                f"(the last are {_tail(X):.2g} of the largest). Use search='shooting'."
            )
        X, count = _finer(X, 4 * count + 1), 2 * count
    x = guess.point.x.copy()
    x[problem.active] = X[0]
    point = OperatingPoint(system, 0.0, x, theta, guess.point.settings)
    return Guess(point, period, guess.phase), count, steps, evaluations


class _Balance:
    def __init__(self, problem: OrbitProblem, guess: Guess, settings: np.ndarray) -> None:
        self.problem, self.guess, self.settings = problem, guess, settings
        self.advance = problem.advance[problem.active]

    def solve(self, X: np.ndarray, period: float) -> tuple[np.ndarray, float, int]:
        """Newton's method on the values at the points, shape (points, k), damped."""
        problem, free = self.problem, self.problem.free
        phase, anchor = self.guess.phase, self.guess.point.x[problem.active]
        size = np.maximum(np.abs(X).max(axis=0), np.abs(self.advance))
        size = np.maximum(size, 1e-6 * max(size.max(), 1e-300))
        D = _differentiation(len(X))
        missed, matrix, rates = self._residual(X, period, D)
        for iteration in range(problem.iterations + 1):
            columns = np.tile(size, len(X))
            scaled = scipy.sparse.csc_array(
                scipy.sparse.diags_array(1 / columns) @ matrix @ scipy.sparse.diags_array(columns)
            )
            right = -(missed / size).ravel()
            if free:
                row = np.zeros(X.size)
                row[: X.shape[1]] = phase * size
                norm = np.linalg.norm(row)
                border = (rates / size).ravel()[:, None]
                scaled = scipy.sparse.csc_array(
                    scipy.sparse.bmat([[scaled, -border], [row[None, :] / norm, None]])
                )
                right = np.append(right, -float(phase @ (X[0] - anchor)) / norm)
            factors = factors_of(scaled)
            step = None if factors is None else factors.solve(right)
            if step is None or not np.isfinite(step).all():
                raise self._refusal(X, missed / size, iteration, "the equations are singular")
            change = (step[: X.size] * columns).reshape(X.shape)
            stretch = float(step[-1]) if free else 0.0
            if np.abs(step).max() <= 0.1 * problem.rtol:
                return X + change, period * (1 + stretch), iteration
            trial = partial(self._tried, X, change, period, stretch, size, D)
            limit = max(float(np.linalg.norm(right)), 1e-13 * len(X))
            longest = min(1.0, 0.5 / max(abs(stretch), 1e-300))
            better = damped(trial, limit, _SHORTEST, longest)
            if better is None:
                if np.abs(step).max() <= 1e3 * problem.rtol:
                    return X, period, iteration  # rounding
                raise self._refusal(X, missed / size, iteration, "no step makes it smaller")
            (X, period), (missed, matrix, rates) = better
        raise self._refusal(X, missed / size, problem.iterations, "too many iterations")

    def _tried(
        self,
        X: np.ndarray,
        change: np.ndarray,
        period: float,
        stretch: float,
        size: np.ndarray,
        D: np.ndarray,
        part: float,
    ) -> tuple[Any, float]:
        """Points and period after a part of a step with their residual, and how far they miss."""
        tried = X + part * change, period * (1 + part * stretch)
        found = self._residual(*tried, D)
        return (tried, found), float(np.linalg.norm(found[0] / size))

    def _residual(
        self, X: np.ndarray, period: float, D: np.ndarray
    ) -> tuple[np.ndarray, scipy.sparse.csc_array, np.ndarray]:
        """What the balance misses over a period, its Jacobian, and rates times the period."""
        system, active, points = self.problem.system, self.problem.active, len(X)
        part = np.arange(points) / points
        x = np.repeat(self.guess.point.x[:, None], points, axis=1)
        x[active] = (X + np.outer(part, self.advance)).T
        columns = (
            x,
            np.repeat(self.guess.point.theta[:, None], points, axis=1),
            period * part[None, :],
            np.repeat(self.settings[:, None], points, axis=1),
        )
        rates = period * np.asarray(system.rhs.map(points)(*columns)).T[:, active]
        jacobian, _ = system.jacobian.map(points)(*columns)
        every = scipy.sparse.csc_array(jacobian.sparse())
        n = x.shape[0]
        blocks = [every[:, i * n : (i + 1) * n][active][:, active] for i in range(points)]
        missed = D @ X + self.advance - rates
        matrix = scipy.sparse.kron(
            scipy.sparse.csc_array(D), np.eye(len(active))
        ) - period * scipy.sparse.block_diag(blocks)
        return missed, scipy.sparse.csc_array(matrix), rates

    def _refusal(self, X: np.ndarray, missed: np.ndarray, iterations: int, why: str) -> SolverError:
        worst = int(np.argmax(np.abs(missed).max(axis=0)))
        name = self.problem.system.state_names[int(self.problem.active[worst])]
        return SolverError(
            f"{self.problem.system.name}: no periodic motion found by harmonic balance with "
            f"{len(X) // 2} harmonics after {iterations} iterations ({why}); the balance of {name} "
            f"misses {np.abs(missed).max():.2g} of its size. Let it warm up longer, or use "
            "search='shooting'."
        )


def _differentiation(points: int) -> np.ndarray:
    """Derivative by ``t / period`` of the trigonometric polynomial through an odd number."""
    k = np.arange(points)
    difference = k[:, None] - k[None, :]
    with np.errstate(divide="ignore"):
        D = np.pi * (-1.0) ** difference / np.sin(np.pi * difference / points)
    np.fill_diagonal(D, 0.0)
    return D


def _tail(X: np.ndarray) -> float:
    """The last quarter of the harmonics over the largest, the worst of all states."""
    size = np.abs(np.fft.rfft(X, axis=0))
    last = size[len(size) - max(len(size) // 4, 2) :].max(axis=0)
    return float((last / np.maximum(size.max(axis=0), 1e-9 * size.max())).max())


def _finer(X: np.ndarray, points: int) -> np.ndarray:
    found: np.ndarray = np.fft.irfft(np.fft.rfft(X, axis=0), points, axis=0) * (points / len(X))
    return found
