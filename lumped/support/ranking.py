"""Order of sensitivities and shares by their size, ranks and quantiles of values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lumped.errors import OptionError


def rank(names: Sequence[str], values: np.ndarray) -> list[tuple[str, float]]:
    """Names and values, those of the largest size first."""
    order = np.argsort(-np.abs(values), kind="stable")
    return [(names[i], float(values[i])) for i in order]


def rank_by_size(
    what: str, value: float, names: Sequence[str], changes: np.ndarray
) -> list[tuple[str, float]]:
    """Names and changes relative to a value, the largest first.

    Raises
    ------
    OptionError
        If the value is zero, so that relative values do not exist.
    """
    if not value:
        raise OptionError(f"{what} is zero; a change relative to it has no meaning.")
    return rank(names, changes / value)


def list_largest(pairs: Iterable[tuple[str, Any]], form: str = "{} {:+.4f}", most: int = 4) -> str:
    """Names and values, those of the largest size first, with semicolons.

    Parameters
    ----------
    form : str
        How a name and its value are written.
    most : int
        How many are named.
    """
    ranked = sorted(pairs, key=lambda pair: -abs(pair[1]))
    return "; ".join(form.format(*pair) for pair in ranked[:most])


def ranks(values: np.ndarray) -> np.ndarray:
    """Ranks from 0 on, shape (n,); equal values share the mean of theirs."""
    _, inverse, counts = np.unique(values, return_inverse=True, return_counts=True)
    ends = np.cumsum(counts)
    return (ends - 0.5 * (counts + 1))[inverse]


def quantiles(values: np.ndarray, q: ArrayLike) -> Any:
    """Quantiles, linear between two values; between a number and infinity it is infinity.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Numbers or infinity.
    q : array_like
        Between 0 and 1.
    """
    at: Any = q
    with np.errstate(invalid="ignore"):
        found = np.quantile(values, at)
    return np.where(np.isnan(found), np.quantile(values, at, method="higher"), found)[()]
