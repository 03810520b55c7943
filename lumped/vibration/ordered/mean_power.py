"""Mean power of what dissipates in a vibration."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.support.arrays import Complex, Integer, Real
from lumped.support.made_once import Recent, made_once
from lumped.timeloop.plants.many_points import ManyPoints
from lumped.vibration.rotating.rotation import Rotation, samples_of
from lumped.vibration.rotating.small_vibrations import amplitude_laws


class _Curvature(NamedTuple):
    """Second derivatives of a quantity by states and inputs: places, numbers, what they need."""

    rows: Integer
    columns: Integer
    numbers: ManyPoints
    turns: bool


def mean_power(
    steady: Rotation,
    orders: Real,
    key: str,
    inputs: tuple[str, ...],
    z: Complex,
    amplitudes: Real,
) -> Real:
    """Mean of a quantity that is quadratic in a vibration, shape (k, o).

    ``z^H H z / 4`` with the amplitudes z of states and inputs of each order, and the second
    derivatives H of the quantity, in which laws hold at the frequency of the order and at the
    amplitudes found.

    Parameters
    ----------
    key : str
        The quantity.
    inputs : tuple of str
        What is excited.
    z : ndarray of complex, shape (k, o, n + inputs)
        Amplitudes of states and inputs.
    amplitudes : ndarray, shape (k, m)
        Those at which laws hold.
    """
    system = steady.system
    turning = steady.turning
    known = _recent_curvatures(system).of(
        (key, inputs), lambda: _curvature(system, key, inputs, turning)
    )
    count, time = len(orders), steady.time
    found = np.empty(z.shape[:2])
    for k, speed in enumerate(steady.speeds):
        samples = samples_of(steady) if known.turns else 1
        x, settings = steady.along(k, samples)
        w = np.repeat(orders * speed, samples)[:, None]
        own = np.tile(amplitudes[k], (len(w), 1))
        points = np.hstack([np.tile(x, (count, 1)), w, own])
        numbers = known.numbers(
            points, steady.theta[k], np.full(len(w), time), np.tile(settings, (count, 1))
        )
        numbers = numbers.reshape(count, samples, -1).mean(axis=1)
        pairs = (z[k][:, known.rows].conj() * z[k][:, known.columns]).real
        found[k] = 0.25 * (numbers * pairs).sum(axis=1)
    return found


def _curvature(system: System, key: str, inputs: tuple[str, ...], turning: Real) -> _Curvature:
    x, theta, time, settings = system.inputs
    frequency = ca.SX.sym("vibration")
    z = ca.vertcat(x, theta[system.places(inputs)]) if inputs else x
    second = ca.hessian(system.expressions([key]), z)[0]
    rows, columns = second.sparsity().get_triplet()
    numbers = ca.sparsity_cast(second, ca.Sparsity.dense(second.nnz(), 1))
    places, laws = system.structure.parameters.vibrating, amplitude_laws(system)
    amplitudes = ca.SX.sym("amplitudes", len(laws.places))
    if places or laws.places:
        there = ca.vertcat(ca.repmat(frequency, len(places), 1), amplitudes)
        numbers = ca.substitute(numbers, theta[places + laws.places], there)
    angles = x[np.flatnonzero(turning).tolist()]
    function = ca.Function(
        "curvature",
        [ca.vertcat(x, frequency, amplitudes), theta, time, settings],
        [ca.cse(numbers)],
    )
    return _Curvature(
        np.array(rows, dtype=int),
        np.array(columns, dtype=int),
        ManyPoints(function),
        bool(angles.numel()) and bool(ca.depends_on(numbers, angles)),
    )


@made_once
def _recent_curvatures(_: System) -> Recent[_Curvature]:
    return Recent(16)
