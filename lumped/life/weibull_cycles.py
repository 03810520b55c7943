"""Cycles of a load that is known by how often it reaches each amplitude."""

from __future__ import annotations

import numpy as np

from lumped.errors import OptionError
from lumped.life.rainflow import Cycles
from lumped.support.arguments import checked

_BLOCKS = 1000


@checked
def weibull_cycles(
    largest: float, *, cycles: float, shape: float = 1.0, mean: float = 0.0
) -> Cycles:
    """Cycles whose amplitudes have the distribution of Weibull.

    In ``cycles`` cycles the amplitude ``Q(N) = largest (1 - ln N / ln cycles)^(1 / shape)`` is
    reached N times, the largest once: the exceedances of Weibull, ``exp(-(Q/q)^shape)``, with
    ``q = largest / (ln cycles)^(1 / shape)``. With the shape 1 it falls on a straight line over
    ``log N``.

    Parameters
    ----------
    largest : float
        Amplitude that is reached once, in the unit of the load.
    cycles : float
        Their number, such as the blades times the ice loads of each.
    shape : float
        Of the distribution.
    mean : float
        Of every cycle.

    Returns
    -------
    Cycles
        The largest, and blocks of equal width in ``log N`` at their middle.

    Raises
    ------
    OptionError
        If there is no more than one cycle, or the amplitude or the shape is not positive.
    """
    if not (largest > 0 and cycles > 1 and shape > 0):
        raise OptionError(
            f"weibull_cycles: largest = {largest:g} and shape = {shape:g} must be positive, and "
            f"cycles = {cycles:g} above 1."
        )
    share = np.linspace(0.0, 1.0, _BLOCKS + 1)
    middle = 0.5 * (share[1:] + share[:-1])
    amplitudes = largest * np.append(1.0, (1 - middle) ** (1 / shape))
    counts = np.append(1.0, np.diff(cycles**share))
    none = np.empty(0)
    return Cycles(2 * amplitudes, np.full(_BLOCKS + 1, mean), counts, none, none)
