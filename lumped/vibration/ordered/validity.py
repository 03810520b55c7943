"""Vibrations that take a component beyond where its equations hold."""

from __future__ import annotations

import numpy as np

from lumped.errors import OptionError
from lumped.support.arrays import Complex, Real
from lumped.timeloop.results.validity import ranges
from lumped.vibration.ordered.synthesis import Synthesis
from lumped.vibration.rotating.rotation import Rotation
from lumped.vibration.rotating.small_vibrations import SmallVibrations


def refuse_vibration_outside(
    small: SmallVibrations,
    steady: Rotation,
    orders: Real,
    means: Real,
    amplitudes: Complex,
    at: Real,
) -> None:
    """Stop where equations do not hold.

    At a mean, at an extreme over the cycle, at a frequency, or at an amplitude of a law.

    Parameters
    ----------
    means : ndarray, shape (k, r)
        Means of what must lie in the ranges of the components, the last outputs of `small`.
    amplitudes : ndarray of complex, shape (k, o, r)
        Its amplitudes.
    at : ndarray, shape (k, m)
        Amplitudes at which laws hold.

    Raises
    ------
    SolverError
    """
    found = ranges(steady.system)
    if not found:
        return
    for i, held in enumerate(found):
        high, low = _extremes(steady.speeds, orders, amplitudes[:, :, i])
        for part, what in ((0.0, "in the mean"), (high, "with the vibration"), (low, "")):
            values = means[:, i] + part
            for k in np.flatnonzero(held.outside(values))[:1]:
                where = f"{what or 'with the vibration'} at {steady.speeds[k]:.6g} rad/s"
                raise held.make_error(float(values[k]), where)
    if not small.places:
        return
    time = steady.time
    ends = [(0, orders[0]), (len(steady.speeds) - 1, orders[-1])]
    places = [(int(k), orders[0], "with the vibration at") for k in at.argmax(axis=0)]
    places += [(k, order, f"for order {order:g} at") for k, order in ends]
    for k, order, which in places:
        w = small.at(order * steady.speeds[k : k + 1], at[k : k + 1])
        point = steady.x[k : k + 1], steady.theta[k], steady.settings[k : k + 1]
        values = small(*point, time, w).outputs[0, -len(found) :]
        for held, value in zip(found, values, strict=True):
            if held.outside(np.array([value]))[0]:
                where = f"{which} {steady.speeds[k]:.6g} rad/s"
                raise held.make_error(float(value), where)


def _extremes(speeds: Real, orders: Real, amplitudes: Complex) -> tuple[Real, Real]:
    """Highest and lowest value over the cycle; if there is none, as if all orders met in phase."""
    both = Synthesis("range", "1", speeds, orders, amplitudes)
    try:
        (_, high), (_, low) = both.extremes
    except OptionError:
        return both.sum, -both.sum
    return high, low
