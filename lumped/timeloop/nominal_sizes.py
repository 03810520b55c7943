"""Sizes of the states, to which tolerances and changes are relative."""

from __future__ import annotations

import numpy as np

from lumped.compiler.system import System
from lumped.support.made_once import made_once


@made_once
def nominals(system: System) -> np.ndarray:
    """Nominal value of each state."""
    names = system.state_names
    return np.array([system.quantity(n).nominal if "(" not in n else 1.0 for n in names])
