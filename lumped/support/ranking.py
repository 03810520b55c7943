"""Order of relative sensitivities."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lumped.errors import OptionError

__all__ = ["ranked"]


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
