"""Branches that cross another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy

from lumped.errors import SolverError
from lumped.orbits.branch_equations import BranchProblem, MissedError, Station, correct_motion
from lumped.orbits.shooting import Guess

_ASIDE = (1e-2, 3e-3, 3e-2, 1e-3)
"""Lengths to go aside, in turn."""


def double_period(problem: BranchProblem, station: Station) -> tuple[BranchProblem, Station]:
    """What repeats after two periods, and a motion on its branch.

    It leaves along the eigenvector of the multiplier -1 (Kuznetsov, Elements of Applied Bifurcation
    Theory, 2004, sec. 10.3).

    Raises
    ------
    SolverError
        If none is found.
    """
    values, vectors = np.linalg.eig(station.monodromy)
    aside = np.zeros(len(station.z))
    k = len(station.monodromy)
    aside[:k] = vectors[:, np.argmin(np.abs(values + 1))].real / station.scale[:k]
    other = _repeat_period(problem, 2)
    theta, old = station.guess.point.theta, station.guess
    period = other.period(float(theta[problem.place]), 2 * old.period)
    return other, _aside(other, station, Guess(old.point, period, old.phase), aside)


def crossing_branch(problem: BranchProblem, station: Station) -> tuple[BranchProblem, Station]:
    """The same equations, and a motion on the other branch through a branch point.

    The Jacobian has two directions without change there, one of them along the branch.

    Raises
    ------
    SolverError
        If none is found.
    """
    row = np.vstack([station.matrix, station.tangent])
    aside = scipy.linalg.svd(row)[2][-1]
    return problem, _aside(problem, station, station.guess, aside)


def _aside(problem: BranchProblem, station: Station, old: Guess, aside: np.ndarray) -> Station:
    """A motion beside another, in a direction in unknowns over the scale."""
    aside = aside / np.linalg.norm(aside)
    z, scale = problem.unknowns(old), station.scale.copy()
    if problem.extra and problem.follows is None:
        scale[-2] *= old.period / station.guess.period
    fault = ""
    for length in _ASIDE:
        try:
            guess = problem.guess(z + length * scale * aside, old, old.point.settings)
            found = correct_motion(problem, guess, scale, aside, None, aside)
        except MissedError as error:
            fault = str(error)
            continue
        apart = (found.z - z) / scale
        if abs(aside @ apart) > 0.5 * length:
            return found
    raise SolverError(
        f"{problem.orbits.system.name}: no motion was found on the branch that crosses there"
        f"{f' ({fault})' if fault else ''}.",
        station.run,
    )


def _repeat_period(problem: BranchProblem, factor: int) -> BranchProblem:
    """What must repeat after several periods."""
    orbits = replace(problem.orbits, advance=factor * problem.orbits.advance, clock=None)
    return replace(
        problem,
        orbits=orbits,
        turns=None if problem.turns is None else factor * problem.turns,
        cycles=None if problem.cycles is None else factor * problem.cycles,
    )
