"""Reference files of the eccentric shear, computed independently with numpy and scipy."""

from functools import partial

import numpy as np
from references import columns

data = partial(columns, "eccentric_shear")
DEGREES = np.radians(np.arange(361.0))


def nearest(phi: np.ndarray) -> np.ndarray:
    """Rows of a run that stand at the degrees of a turn."""
    rows = np.abs(phi[:, None] - DEGREES).argmin(axis=0)
    assert np.abs(phi[rows] - DEGREES).max() < 1e-9
    return rows
