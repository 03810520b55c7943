"""Harmonics and means over the turns of a steady rotation, and how these follow parameters."""

from __future__ import annotations

import numpy as np
import scipy

from lumped.errors import OptionError
from lumped.numerics.interpolated_rows import fit_rows, interpolate_rows
from lumped.points.moved_equilibrium import find_moved_point
from lumped.points.start_values import relative_positions
from lumped.support.arrays import Complex, Real
from lumped.vibration.rotating.rotation import Rotation, speed_of
from lumped.vibration.rotating.small_vibrations import Parts, SmallVibrations, small_vibrations
from lumped.vibration.rotating.turns import Turns, begin_of, everything_along, turns_of

_ROUNDING = 1e-13
"""Mean over the largest size that is nothing but rounding."""
_EVENLY = 9
"""Speeds at which mean torques are looked at."""
_BALANCED = 1e-6
"""Share of the torques at a part that may be left."""


def harmonics(
    small: SmallVibrations, steady: Rotation, orders: Real
) -> tuple[Complex, Complex, Real, list[Real]]:
    """Harmonics of rates and outputs, means of outputs, and of the numbers of the matrices.

    Where the states at all speeds follow from the model, they are interpolated over the speed from
    some of the speeds (`interpolate_rows`); where points are given at each speed, such as with a
    load that follows it, over the two numbers that set these apart, if these are all (`fit_rows`).

    Returns
    -------
    rates, outputs : ndarray of complex, shapes (k, o, n) and (k, o, q)
    means : ndarray, shape (k, q)
    matrices : list of ndarray, shapes (k, numbers)
    """
    count, n, q = len(steady.speeds), steady.x.shape[1], len(small.outputs)
    if not steady.turns_matter:
        none = np.zeros((count, len(orders), n + q), dtype=complex)
        parts = small(steady.x, steady.theta, steady.settings, steady.time)
        return none[..., :n], none[..., n:], parts.outputs, list(parts[2:])
    cycles = orders * steady.turns
    numbers = np.rint(cycles).astype(int)
    whole = np.abs(cycles - numbers) <= 1e-9

    def row(k: int) -> tuple[Real, Real]:
        """Harmonics of rates and outputs, and all means; and the sizes of the parts of each."""
        turns = turns_of(small, steady, k, orders)
        parts = everything_along(small, steady, turns, k)
        growth = turns.angles[:, None] * _growth(small, steady, k)
        parts = parts._replace(outputs=parts.outputs - growth)
        moving = np.hstack(parts[:2])
        size = np.abs(moving).max(axis=0, initial=0.0)
        spectrum = np.zeros((len(orders), n + q), dtype=complex)
        own = turns.waves(orders[whole]) @ moving
        spectrum[whole] = np.where(np.abs(own) > 1e-13 * size, own, 0)
        still = np.hstack(parts[1:])
        sizes = [np.tile(np.repeat(size, 2), len(orders)), np.abs(still).max(axis=0, initial=0.0)]
        return np.append(spectrum.view(float), turns.weights @ still), np.concatenate(sizes)

    plane = steady.plane
    if len(steady.points) == 1 and (steady.settings == steady.settings[0]).all():
        rows = interpolate_rows(row, steady.speeds)
    elif plane is not None:
        rows = fit_rows(row, plane)
    else:
        rows = np.array([row(k)[0] for k in range(count)])
    end = 2 * len(orders) * (n + q)
    spectra = np.ascontiguousarray(rows[:, :end]).view(complex).reshape(count, len(orders), n + q)
    ends = end + np.cumsum([q, *(len(r) for r, _ in small.patterns)])
    means, *matrices = np.split(rows[:, end:], ends[:-1] - end, axis=1)
    return spectra[..., :n], spectra[..., n:], means, matrices


def mean_matrix(small: SmallVibrations, steady: Rotation, turns: Turns) -> tuple[Real, Real]:
    """The state matrix at the first speed by means over the turns, and the mean numbers of M.

    It is ``mean(M)^-1 mean(A)``, A in torques: shape (n, n).
    """
    parts = everything_along(small, steady, turns)
    numbers = parts.A
    mean = turns.weights @ numbers
    mean[np.abs(mean) <= _ROUNDING * np.abs(numbers).max(axis=0, initial=0.0)] = 0.0
    M = turns.weights @ parts.M
    pattern, mean = small.masses.divide_matrix(M, small.patterns[0], mean)
    matrix: Real = np.zeros((steady.x.shape[1],) * 2)
    matrix[pattern] = mean
    if steady.turns_matter:
        # rates are the same after the turns; a mean over some angles misses that at jumps
        way = steady.turning
        matrix -= np.outer(matrix @ way, way) / (way @ way)
    return matrix, M


def find_met_order(
    small: SmallVibrations, steady: Rotation, above: float
) -> tuple[float, float] | None:
    """The least order above one that meets a natural frequency at some speed, and that, Hz.

    The natural frequencies are those at the first and the last speed, and all between.
    """
    ends, orders = steady.speeds[[0, -1]], np.array([above])
    sizes = [
        np.sort(np.abs(own[own.imag > _ROUNDING * np.abs(own)]))
        for k in (0, -1)
        for turns in [turns_of(small, steady.at(k), 0, orders)]
        for own in [scipy.linalg.eigvals(mean_matrix(small, steady.at(k), turns)[0])]
    ]
    count = min(map(len, sizes))
    pairs = np.array([sizes[0][:count], sizes[1][:count]])
    step = 1 / steady.turns
    first = np.maximum(np.ceil(pairs.min(axis=0) / ends[1] / step) * step, above + step)
    met = first <= pairs.max(axis=0) / ends[0]
    if not met.any():
        return None
    least = int(np.where(met, first, np.inf).argmin())
    return float(first[least]), float(pairs[0, least]) / (2 * np.pi)


def refuse_unbalanced(small: SmallVibrations, steady: Rotation, what: str) -> None:
    """Refuse what needs means, where mean torques do not balance.

    Raises
    ------
    OptionError
    """
    states = steady.system.state_names
    for k in np.unique(np.linspace(0, len(steady.speeds) - 1, _EVENLY).astype(int)).tolist():
        turns = turns_of(small, steady, k)
        parts = everything_along(small, steady, turns, k)
        matrix = small.whole_matrix(parts, turns.weights)[: len(states), : len(states)]
        missing = turns.weights @ parts.rates - steady.speeds[k] * steady.turning
        size = np.abs(parts.rates).max(axis=0) + np.abs(matrix) @ np.abs(steady.x[k])
        share = np.where(steady.idle | (size == 0), 0.0, np.abs(missing) / (size + (size == 0)))
        worst = int(share.argmax())
        if share[worst] > _BALANCED:
            raise OptionError(
                f"{what}: at {steady.speeds[k]:.6g} rad/s mean torques do not balance, so there "
                f"are no means: {states[worst]} keeps a mean rate of {missing[worst]:.3g}. Name "
                "in order_response what balances them, such as free='load.tau', or give operating "
                "points, at=."
            )


def sweep_turns(
    small: SmallVibrations, steady: Rotation, turns: Turns, own: list[Real], means: list[Real]
) -> tuple[Real, Real]:
    """One reverse sweep over the turns: derivatives by states and by parameters.

    Parameters
    ----------
    steady : Rotation
        At one speed.
    turns : Turns
        Its points.
    own : list of ndarray, shapes (samples, n) and (samples, q)
        Weights of rates and outputs at each of the samples.
    means : list of ndarray, shapes (numbers,)
        Weights of the means of the numbers of A, B, C, D and M.
    """
    weights = Parts(*own, *(turns.weights[:, None] * part for part in means))
    by_x, by_theta, _ = small.slopes(weights, turns.x, steady.theta[0], turns.settings, steady.time)
    return by_x.sum(axis=0), by_theta.sum(axis=0)


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
    small, turns, adjoint = _adjoint(steady, slope)
    weights = np.split(turns.weights[:, None] * adjoint, [len(slope)], axis=1)
    zeros = [np.zeros(len(rows)) for rows, _ in small.patterns]
    return -sweep_turns(small, steady, turns, weights, zeros)[1]


def derive_by_speed(steady: Rotation, slope: Real) -> float:
    """Derivative by the speed of the shaft of what has a slope by the states, s/rad.

    Given operating points hold at all speeds.

    Parameters
    ----------
    steady, slope
        As in `derive_by_parameters`.
    """
    if steady.shaft is None or steady.is_given or not slope.any():
        return 0.0
    _, _, adjoint = _adjoint(steady, slope)
    n = len(slope)
    return float(adjoint[:n] @ steady.turning + adjoint[n])


def _adjoint(steady: Rotation, slope: Real) -> tuple[SmallVibrations, Turns, Real]:
    """Equations, points over the turns, and a multiplier of each mean equation.

    The equations are the mean rates, less those of steady rotation, and the speed of the shaft,
    less the speed that is given, and speeds that holds keep at zero.
    """
    assert steady.shaft is not None
    system, free = steady.system, steady.balancing
    outputs = (speed_of(system, steady.shaft), *steady.standing)
    small = small_vibrations(system, () if free is None else (free,), outputs)
    n = len(slope)
    turns = begin_of(steady) if free is None else turns_of(small, steady)
    matrix = small.whole_matrix(everything_along(small, steady, turns), turns.weights)
    relative = np.isin(system.structure.states, relative_positions(system))
    turning = steady.turning != 0
    if free is None:
        balanced = relative
        unknown = np.flatnonzero(~relative & ~turning)
    else:
        balanced = ~steady.idle
        unknown = np.append(np.flatnonzero(~turning & ~steady.idle), n)
    equations = np.append(np.flatnonzero(balanced), n + np.arange(len(outputs)))
    wanted = np.append(slope, np.zeros(len(small.inputs)))[unknown]
    own = matrix[np.ix_(equations, unknown)]
    size = np.maximum(np.abs(own).max(axis=1), 1e-300)
    adjoint = np.zeros(n + len(outputs))
    adjoint[equations] = np.linalg.lstsq((own / size[:, None]).T, wanted)[0] / size
    return small, turns, adjoint


def _growth(small: SmallVibrations, steady: Rotation, k: int) -> Real:
    """By what outputs, such as angles, grow with the angle of the shaft, shape (q,)."""
    cycle = 2 * np.pi * steady.turns
    x, settings = steady.along(k, np.array([0.0, cycle]))
    begin, end = small(x, steady.theta[k], settings, steady.time).outputs
    found: Real = (end - begin) / cycle
    return found
