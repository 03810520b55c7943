"""Order of relative sensitivities, and ranks of values."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lumped.errors import OptionError

__all__ = ["ranked", "ranks"]


def ranked(
    what: str, value: float, names: Sequence[str], relative: np.ndarray
) -> list[tuple[str, float]]:
    """Names and relative sensitivities, the largest first.

    Raises
    ------
    OptionError
        If the value is zero, so that relative values do not exist.
    """
    if not value:
        raise OptionError(f"{what} is zero; a change relative to it has no meaning.")
    order = np.argsort(-np.abs(relative), kind="stable")
    return [(names[i], float(relative[i])) for i in order]


def ranks(values: np.ndarray) -> np.ndarray:
    """Ranks from 0 on, shape (n,); equal values share the mean of theirs."""
    _, inverse, counts = np.unique(values, return_inverse=True, return_counts=True)
    ends = np.cumsum(counts)
    found: np.ndarray = (ends - 0.5 * (counts + 1))[inverse]
    return found
