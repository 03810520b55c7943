"""Mean power of what dissipates in a vibration."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.support.arrays import Complex, Integer, Real
from lumped.support.made_once import Recent, made_once
from lumped.timeloop.plants.many_points import ManyPoints
from lumped.vibration.rotating.rotation import Rotation
from lumped.vibration.rotating.small_vibrations import SmallVibrations
from lumped.vibration.rotating.turns import begin_of, turns_of


class _Curvature(NamedTuple):
    """Second derivatives of a quantity by states and inputs: places, numbers, what they need."""

    rows: Integer
    columns: Integer
    numbers: ManyPoints
    turns: bool


def mean_power(
    small: SmallVibrations, steady: Rotation, orders: Real, key: str, z: Complex, amplitudes: Real
) -> Real:
    """Mean of a quantity that is quadratic in a vibration, shape (k, o).

    ``z^H H z / 4`` with the amplitudes z of states and inputs of each order, and the second
    derivatives H of the quantity, in which laws hold at the frequency of the order and at the
    amplitudes found.

    Parameters
    ----------
    key : str
        The quantity.
    z : ndarray of complex, shape (k, o, n + inputs)
        Amplitudes of states and inputs.
    amplitudes : ndarray, shape (k, m)
        Those at which laws hold.
    """
    known = _recent_curvatures(steady.system).of(
        (key, small.inputs), lambda: _curvature(small, key, steady.turning)
    )
    count = len(orders)
    found = np.empty(z.shape[:2])
    for k, speed in enumerate(steady.speeds):
        angles, weights, x, settings = (
            turns_of(small, steady, k) if known.turns else begin_of(steady, k)
        )
        w = np.repeat(orders * speed, len(angles))
        vibration = small.at(w, np.tile(amplitudes[k], (len(w), 1)))
        numbers = known.numbers(
            np.hstack([np.tile(x, (count, 1)), vibration]),
            steady.theta[k],
            np.full(len(w), steady.time),
            np.tile(settings, (count, 1)),
        )
        numbers = weights @ numbers.reshape(count, len(angles), -1)
        pairs = (z[k][:, known.rows].conj() * z[k][:, known.columns]).real
        found[k] = 0.25 * (numbers * pairs).sum(axis=1)
    return found


def _curvature(small: SmallVibrations, key: str, turning: Real) -> _Curvature:
    x, theta, time, settings = small.system.inputs
    z = ca.vertcat(x, theta[small.system.places(small.inputs)]) if small.inputs else x
    second = ca.hessian(small.system.expressions([key]), z)[0]
    rows, columns = (np.array(part, dtype=int) for part in second.sparsity().get_triplet())
    numbers = ca.sparsity_cast(second, ca.Sparsity.dense(second.nnz(), 1))
    if small.places:
        numbers = ca.substitute(numbers, theta[small.places], small.vibration)
    given = [ca.vertcat(x, small.vibration), theta, time, settings]
    function = ManyPoints(ca.Function("curvature", given, [ca.cse(numbers)]))
    angles = x[np.flatnonzero(turning).tolist()]
    turns = bool(angles.numel()) and bool(ca.depends_on(numbers, angles))
    return _Curvature(rows, columns, function, turns)


@made_once
def _recent_curvatures(_: System) -> Recent[_Curvature]:
    return Recent(16)
