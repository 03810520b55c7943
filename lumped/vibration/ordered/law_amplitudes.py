"""Amplitudes at which laws hold, such that they agree with the vibration that follows."""

from __future__ import annotations

from typing import Literal

import numpy as np

from lumped.errors import OptionError, SolverError
from lumped.numerics.settled_amplitudes import SETTLED, solve_amplitudes
from lumped.support.arrays import Integer, Real
from lumped.vibration.ordered.order_solution import OrderEquations
from lumped.vibration.ordered.synthesis import Synthesis
from lumped.vibration.rotating.small_vibrations import AmplitudeLaws


def law_measure(both: Synthesis) -> Literal["half range", "sum"]:
    """What of a vibration counts as its amplitude: the sum, if its orders have no cycle."""
    try:
        return "half range" if both.turns else "sum"
    except OptionError:
        return "sum"


def find_amplitudes(
    equations: OrderEquations, laws: AmplitudeLaws, first: int
) -> tuple[Real, float]:
    """Amplitudes at which laws agree with the vibration that follows from them.

    Parameters
    ----------
    first : int
        Place of the first of the quantities among the outputs of the equations.

    Returns
    -------
    ndarray, float, shape (k, m)
        Amplitudes, and the largest relative difference.

    Raises
    ------
    SolverError
        If none are found.
    """
    steady, orders, count = equations.steady, equations.orders, len(laws.places)
    if not count:
        return np.zeros((len(steady.speeds), 0)), 0.0

    def follows(amplitudes: Real, at: Integer) -> Real:
        y = equations.solve_vibration(amplitudes, at).y[:, :, first : first + count]
        each = [Synthesis("law", "1", steady.speeds[at], orders, y[:, :, i]) for i in range(count)]
        return np.column_stack([b.sum if law_measure(b) == "sum" else b.half_range for b in each])

    found, missed = solve_amplitudes(follows, np.zeros((len(steady.speeds), count)))
    worst = int(missed.argmax())
    if missed[worst] > SETTLED:
        told = ", ".join(
            f"{name} = {value:.6g}" for name, value in zip(laws.names, found[worst], strict=True)
        )
        raise SolverError(
            f"{steady.system.name}: at {steady.speeds[worst]:.9g} rad/s no amplitude was found at "
            f"which laws agree with the vibration: after {told} they still differ by "
            f"{missed[worst]:.1e} of it. Let the rows over the amplitude change less steeply, or "
            "leave this speed out."
        )
    return found, float(missed.max())
