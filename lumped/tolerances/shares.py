"""Shares of parameters in the variance of a result."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lumped.ensembles.laws import Array
from lumped.errors import OptionError
from lumped.support.text_table import listed, table
from lumped.tolerances.scene import Scene

__all__ = ["correlated", "refuse_correlated", "shares_table"]

_MOST = 12
"""Parameters of each functional in a table."""


def correlated(scene: Scene) -> NDArray[np.bool_]:
    """Which parameters depend on others, shape (d,)."""
    slopes = scene.physical_slopes(np.zeros((1, len(scene.names))))[0]
    off = (slopes != 0) & ~np.eye(len(slopes), dtype=bool)
    found: NDArray[np.bool_] = off.any(axis=0) | off.any(axis=1)
    return found


def refuse_correlated(scene: Scene) -> None:
    """Refuse parameters that depend on each other, as their shares are not defined.

    Raises
    ------
    OptionError
        With their names.
    """
    names = [name for name, is_one in zip(scene.names, correlated(scene), strict=True) if is_one]
    if names:
        raise OptionError(
            f"{scene.analysis}: {listed(names)} are correlated, so that the variance has no share "
            "of each. Give distributions without correlation, or take rank_correlations of "
            "lumped.ensemble."
        )


def shares_table(
    names: Sequence[str], rows: Sequence[tuple[str, Array, Array]], digits: int = 3
) -> str:
    """Parameters by their share in the variance, the largest first.

    Parameters
    ----------
    names : sequence of str
        Of the parameters.
    rows : sequence of (str, ndarray, ndarray)
        For each functional its label, and the shares of each parameter alone and with others.
    """
    lines = []
    for label, first, total in rows:
        order = np.argsort(-total, kind="stable")[:_MOST]
        lines += [
            (label, names[j], f"{first[j]:.{digits}f}", f"{total[j]:.{digits}f}") for j in order
        ]
    return table(("share in the variance of", "parameter", "alone", "with others"), lines)
