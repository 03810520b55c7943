"""Whether parameters have shares in a variance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lumped.errors import OptionError
from lumped.support.text_table import list_names
from lumped.tolerances.scene import Scene


def find_correlated(scene: Scene) -> NDArray[np.bool_]:
    """Which parameters depend on others, shape (d,)."""
    mixing = scene.marginals.mixing
    off = (mixing != 0) & ~np.eye(len(mixing), dtype=bool)
    found: NDArray[np.bool_] = off.any(axis=0) | off.any(axis=1)
    return found


def refuse_correlated(scene: Scene) -> None:
    """Refuse parameters that depend on each other, as their shares are not defined.

    Raises
    ------
    OptionError
        With their names.
    """
    names = [
        name for name, is_one in zip(scene.names, find_correlated(scene), strict=True) if is_one
    ]
    if names:
        raise OptionError(
            f"{scene.analysis}: {list_names(names)} are correlated, so that the variance has no "
            "share of each. Give distributions without correlation, or take the ranking of "
            "lumped.scatter, which is of each alone."
        )
