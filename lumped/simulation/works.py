"""Work in the course of a run: powers integrated over each step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lumped.kernel.observe import NODES, WEIGHTS
from lumped.timeloop.results.recorder import scale
from lumped.timeloop.results.trajectory import Piece, Trajectory

_SETTLED = 1e-10
"""Change by division, over all energy of the run, up to which an integral is known."""
_ROUNDS = 10
_PARTS = 4
"""Parts of a stretch that is divided once more, and how often that is done at most."""
_MOST_NODES = 2_000_000
_SHORTEST = 1e-11
"""Stretch, over the times of the run, that is not divided: its nodes lie a rounding apart."""


def integrate_powers(
    again: Callable[[np.ndarray], Trajectory],
    powers: Callable[[Piece], np.ndarray],
    begin: np.ndarray,
    width: np.ndarray,
    energy: float,
) -> tuple[np.ndarray, float]:
    """Integrals of powers over the steps of a run, by Gauss's rule as functionals have them.

    Each step is taken once as a whole and once in halves; where these differ it is divided on, as
    powers may be faster than all states.

    Parameters
    ----------
    again : callable
        The same run at given times.
    powers : callable
        Powers at the times of a piece, shape (k, n).
    begin, width : ndarray, shape (steps,)
        Where the steps begin, ascending, and how long they are, s.
    energy : float
        Size of other energies of the balance, against which rounding of works is small, J.

    Returns
    -------
    works : ndarray, shape (steps, n)
    unsettled : float
        Change of a work by the last division, summed over what was not divided on; zero if all
        integrals are known.
    """
    shortest = _SHORTEST * scale(float(begin[0]), float(begin[-1] + width[-1]))
    step = np.flatnonzero(width > 2 * shortest)
    begin, width, count = begin[step], width[step], len(width)
    coarse, size = _apply_rule(again, powers, begin, width)
    most = max(energy, size)
    works, parts = np.zeros((count, coarse.shape[1])), 2
    for rounds in range(_ROUNDS):
        inner = (begin[:, None] + width[:, None] * (np.arange(parts) / parts)).ravel()
        fine, size = _apply_rule(again, powers, inner, np.repeat(width / parts, parts))
        most = max(most, size)
        sums = fine.reshape(len(begin), parts, -1).sum(axis=1)
        change = np.abs(sums - coarse).max(axis=1, initial=0.0)
        rough = (change > _SETTLED * most) & (width > parts * _PARTS * shortest)
        is_last = rounds == _ROUNDS - 1 or rough.sum() * parts * _PARTS * len(NODES) > _MOST_NODES
        if is_last or not rough.any():
            np.add.at(works, step, sums)
            return works, float(change[rough].sum())
        np.add.at(works, step[~rough], sums[~rough])
        divided = np.repeat(rough, parts)
        begin, coarse = inner[divided], fine[divided]
        step, width = np.repeat(step[rough], parts), np.repeat(width[rough] / parts, parts)
        parts = _PARTS
    raise AssertionError


def _apply_rule(
    again: Callable[[np.ndarray], Trajectory],
    powers: Callable[[Piece], np.ndarray],
    begin: np.ndarray,
    width: np.ndarray,
) -> tuple[np.ndarray, float]:
    """Integrals over stretches, shape (stretches, n), and the largest one of a size over all."""
    wanted = (begin[:, None] + width[:, None] * np.array(NODES)).ravel()
    pieces = [piece for piece in again(wanted).pieces if len(piece.t)]
    reached = np.concatenate([[], *(piece.t for piece in pieces)])
    assert np.array_equal(reached, wanted), "the finer run has other instants than the steps"
    found = np.concatenate([powers(piece) for piece in pieces])
    by_node = found.reshape(len(begin), len(NODES), -1)
    by_node = by_node * (width[:, None] * np.array(WEIGHTS))[:, :, None]
    return by_node.sum(axis=1), float(np.abs(by_node).sum(axis=(0, 1)).max(initial=0.0))
