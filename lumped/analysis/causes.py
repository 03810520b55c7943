"""Why a run stops at an instant."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np
import scipy

__all__ = ["Cause", "merged", "sparse"]


class Cause(NamedTuple):
    """One reason why a run stops.

    Attributes
    ----------
    used : tuple of int
        Margins that are used up.
    row : ndarray, shape (n + p,)
        Derivatives of the instant.
    names : tuple of str
        Components.
    modes : tuple of int
        What changes with it.
    gap : ndarray or None, shape (n + p,)
        Derivatives of a gap that closes at the end of ever smaller bounces.
    plain : tuple or None
        Derivatives by states, parameters and time of a margin that only matters after another
        change.
    """

    used: tuple[int, ...]
    row: np.ndarray
    names: tuple[str, ...]
    modes: tuple[int, ...]
    gap: np.ndarray | None = None
    plain: tuple[np.ndarray, float] | None = None


def merged(causes: list[Cause], sizes: np.ndarray) -> list[Cause]:
    """Causes whose instants move alike are one."""
    found: list[Cause] = []
    for cause in causes:
        for i, other in enumerate(found):
            both = np.abs(np.array([cause.row, other.row]) * sizes)
            apart = np.abs((cause.row - other.row) * sizes).max(initial=0.0)
            if apart <= 1e-6 * (1e-6 + both.max(initial=0.0)):
                names = tuple(dict.fromkeys((*other.names, *cause.names)))
                modes = tuple(dict.fromkeys((*other.modes, *cause.modes)))
                found[i] = Cause((*other.used, *cause.used), other.row, names, modes)
                break
        else:
            found.append(cause)
    return found


def sparse(matrix: ca.DM) -> scipy.sparse.csc_array:
    """The same for scipy."""
    return scipy.sparse.csc_array(ca.DM(matrix).sparse())
