"""The two problems of an instant, for impulses and for reactions, solved by SciPy."""

import numpy as np
from scipy.optimize import lsq_linear, nnls

_SOFT = 1e-6
_ROUNDING = 1e-13
"""Accelerations that are rounding, as bodies and loads are about 1."""


class NoAnswerError(Exception):
    """A problem of an instant has no answer."""


def nearest(J, v, W, least, D):
    """Speeds nearest to v in the kinetic metric with ``W v >= least`` and ``D v == 0``.

    Raises
    ------
    NoAnswerError
        If there are none.
    """
    root = np.sqrt(J)
    rows = np.concatenate([W, D, -D])
    if not len(rows):
        return v
    wanted = np.concatenate([least, np.zeros(2 * len(D))]) - rows @ v
    sizes = np.linalg.norm(rows / root, axis=1)
    size = np.abs(wanted).max(initial=0.0) + 1e-300
    E = np.vstack([(rows / root).T / sizes, wanted / sizes / size])
    for order in (np.arange(len(rows)), np.arange(len(rows))[::-1]):
        p, rest = nnls(E[:, order], np.append(np.zeros(len(J)), 1.0), maxiter=1000)
        if rest < 1e-7:
            raise NoAnswerError("Newton's law asks for speeds that others forbid")
        gone = E[:, order] @ p
        after = v - size * gone[:-1] / (gone[-1] - 1.0) / root
        room = (rows @ (after - v) - wanted)[order]
        if (room > -1e-8 * size).all() and (room[p > 1e-9 * p.max()] < 1e-8 * size).all():
            return after
    raise NoAnswerError("least squares ended beside the answer")


def least_accelerations(J, free, rows, low, high):
    """Accelerations and reactions by Gauss's principle: in a box, least in the kinetic metric.

    Redundant reactions are told apart by their squares, which count `_SOFT` squared of the rest.

    Raises
    ------
    NoAnswerError
        If what is found is not the least.
    """
    if not len(rows):
        return free, np.zeros(0)
    root = np.sqrt(J)
    G = (rows / root).T
    soft = np.eye(len(rows)) * _SOFT * np.linalg.norm(G)
    wanted = np.append(-root * free, np.zeros(len(rows)))
    box = {"bounds": (low, high), "method": "bvls", "tol": 1e-15, "max_iter": 500}
    r = lsq_linear(np.vstack([G, soft]), wanted, **box).x
    found = root * free + G @ r
    slopes, size = G.T @ found, 1e-9 * (np.abs(root * free).max() + np.abs(G * r).max()) + _ROUNDING
    room = 1e-9 * np.abs(r).max()
    if ((slopes > size) & (r > low + room)).any() or ((slopes < -size) & (r < high - room)).any():
        raise NoAnswerError("bounded least squares ended before the least")
    return found / root, r
