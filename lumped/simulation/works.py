"""Work in the course of a run: powers integrated over each step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial.legendre import legvander

from lumped.kernel.observe import NODES, WEIGHTS
from lumped.timeloop.results.recorder import scale
from lumped.timeloop.results.trajectory import Piece, Trajectory

_SETTLED = 3e-11
"""Highest terms of a power in a stretch, over all energy of the run, at which its work is known."""
_PARTS = 4
_ROUNDS = 11
"""Parts of a stretch that is divided, and how often that is done at most."""
_MOST_NODES = 4_000_000
_SHORTEST = 1e-11
"""Stretch, over the times of the run, that is not divided: its nodes lie a rounding apart."""
_HIGHEST = (legvander(2 * np.array(NODES) - 1, 7) * (2 * np.arange(8) + 1))[:, 6:]
"""Gives, by Gauss's rule, the two highest of eight Legendre coefficients."""


def integrate_powers(
    again: Callable[[np.ndarray], Trajectory],
    powers: Callable[[Piece], np.ndarray],
    begin: np.ndarray,
    width: np.ndarray,
    energy: float,
) -> tuple[np.ndarray, float]:
    """Integrals of powers over the steps of a run, by Gauss's rule as functionals have them.

    A step is divided while the highest Legendre coefficients that the nodes show are not small, as
    powers may be faster than all states. Of a smooth power the error is about their square, at a
    kink it is of their size.

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
        These coefficients times the lengths of what was not divided on; zero if all is known.
    """
    shortest = _SHORTEST * scale(float(begin[0]), float(begin[-1] + width[-1]))
    step = np.flatnonzero(width > shortest)
    begin, part, works = begin[step], width[step], None
    for rounds in range(_ROUNDS):
        found, terms, size = _apply_rule(again, powers, begin, part)
        energy = max(energy, size)
        works = np.zeros((len(width), found.shape[1])) if works is None else works
        rough = (terms > _SETTLED * energy) & (part > _PARTS * shortest)
        is_last = rounds == _ROUNDS - 1 or rough.sum() * _PARTS * len(NODES) > _MOST_NODES
        if is_last or not rough.any():
            np.add.at(works, step, found)
            return works, float(terms[rough].sum())
        np.add.at(works, step[~rough], found[~rough])
        begin = begin[rough, None] + part[rough, None] * (np.arange(_PARTS) / _PARTS)
        begin, part = begin.ravel(), np.repeat(part[rough] / _PARTS, _PARTS)
        step = np.repeat(step[rough], _PARTS)
    raise AssertionError


def _apply_rule(
    again: Callable[[np.ndarray], Trajectory],
    powers: Callable[[Piece], np.ndarray],
    begin: np.ndarray,
    width: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, float]:
    """Integrals over stretches, shape (stretches, n), their highest terms, and the largest size."""
    wanted = (begin[:, None] + width[:, None] * np.array(NODES)).ravel()
    pieces = [piece for piece in again(wanted).pieces if len(piece.t)]
    reached = np.concatenate([[], *(piece.t for piece in pieces)])
    assert np.array_equal(reached, wanted), "the finer run has other instants than the steps"
    by_node = np.concatenate([powers(piece) for piece in pieces])
    by_node = by_node.reshape(len(begin), len(NODES), -1)
    by_node *= (width[:, None] * np.array(WEIGHTS))[:, :, None]
    terms = np.abs(np.einsum("skn,kj->sjn", by_node, _HIGHEST)).sum(axis=1).max(axis=1, initial=0.0)
    return by_node.sum(axis=1), terms, float(np.abs(by_node).sum(axis=(0, 1)).max(initial=0.0))
