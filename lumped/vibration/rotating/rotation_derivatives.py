"""How a steady rotation follows parameters and the speed."""

from __future__ import annotations

import numpy as np

from lumped.points.moved_equilibrium import find_moved_point
from lumped.points.start_values import relative_positions
from lumped.support.arrays import Real
from lumped.vibration.rotating.rotation import Rotation, samples_of, speed_of
from lumped.vibration.rotating.small_vibrations import Parts, SmallVibrations, small_vibrations


def derive_by_parameters(steady: Rotation, slope: Real) -> Real:
    """Derivatives by all parameters of what has a slope by the states, shape (p,).

    The adjoint of what determines the states: the balance of mean torques, or that all parts turn
    together with the shaft. Given operating points move with the parameters if they are equilibria.

    Parameters
    ----------
    steady : Rotation
        At one speed.
    slope : ndarray, shape (n,)
        Derivatives by the states where the shaft's angle is that of the operating point.
    """
    count = steady.theta.shape[1]
    if not slope.any():
        return np.zeros(count)
    if steady.shaft is None or steady.is_given:
        moved = find_moved_point(steady.points[0], list(range(count)))
        return np.zeros(count) if moved is None else slope @ moved.states
    small, (x, settings), adjoint = _adjoint(steady, slope)
    n, samples = x.shape[1], len(x)
    weights = np.tile(adjoint / samples, (samples, 1))
    zeros = [np.zeros((samples, len(rows))) for rows, _ in small.patterns]
    _, by_theta, _ = small.slopes(
        Parts(weights[:, :n], weights[:, n:], *zeros),
        x,
        steady.theta[0],
        settings,
        steady.points[0].time,
    )
    found: Real = -by_theta.sum(axis=0)
    return found


def derive_by_speed(steady: Rotation, slope: Real) -> float:
    """Derivative by the speed of the shaft of what has a slope by the states, s/rad.

    Given operating points hold at all speeds.

    Parameters
    ----------
    over, slope
        As in `derive_by_parameters`.
    """
    if steady.shaft is None or steady.is_given or not slope.any():
        return 0.0
    _, _, adjoint = _adjoint(steady, slope)
    return float(adjoint[:-1] @ steady.turning + adjoint[-1])


def _adjoint(steady: Rotation, slope: Real) -> tuple[SmallVibrations, tuple[Real, Real], Real]:
    """Equations, states and settings over the turns, and a multiplier of each mean equation.

    The equations are the mean rates, less those of steady rotation, and the speed of the shaft,
    less the speed that is given; shape (n + 1,).
    """
    assert steady.shaft is not None
    system, free = steady.system, steady.balancing
    small = small_vibrations(
        system, () if free is None else (free,), (speed_of(system, steady.shaft),)
    )
    samples = 1 if free is None else samples_of(steady)
    _, x, settings = steady.along(0, samples)
    parts = small(x, steady.theta[0], settings, steady.points[0].time)
    n, inputs = x.shape[1], len(small.inputs)
    matrix = np.zeros((n + 1, n + inputs))
    corners = ((0, 0), (0, n), (n, 0), (n, n))
    for numbers, (rows, columns), (top, left) in zip(
        parts[2:6], small.patterns[:4], corners, strict=True
    ):
        matrix[rows + top, columns + left] = numbers.mean(axis=0)
    relative = np.isin(system.structure.states, relative_positions(system))
    turning = steady.turning != 0
    if free is None:
        equations = np.append(np.flatnonzero(relative), n)
        unknown = np.flatnonzero(~relative & ~turning)
    else:
        equations = np.append(np.flatnonzero(~steady.idle), n)
        unknown = np.append(np.flatnonzero(~turning & ~steady.idle), n)
    wanted = np.append(slope, np.zeros(inputs))[unknown]
    own = matrix[np.ix_(equations, unknown)]
    size = np.maximum(np.abs(own).max(axis=1), 1e-300)
    adjoint = np.zeros(n + 1)
    adjoint[equations] = np.linalg.lstsq((own / size[:, None]).T, wanted)[0] / size
    return small, (x, settings), adjoint
