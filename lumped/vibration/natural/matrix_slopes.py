"""Derivatives of the matrices of a linearised system by parameters, along vectors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.points.borders import refuse_kinks
from lumped.points.moved_equilibrium import MovedPoint, find_moved_point, point_matters, still_point
from lumped.support.arrays import Complex, Real
from lumped.support.made_once import made_once
from lumped.timeloop.results.operating_point import OperatingPoint

Slopes = Callable[[Real], Complex]
"""Slopes of numbers by states and all parameters, shape (m, n + p), for given modes."""


def multiply_complex(function: Callable[..., Any], *vectors: Complex) -> Any:
    """Value for complex vectors of a real function that is linear in each of its arguments."""
    found: list[Any] = [0.0, 0.0]
    for part in np.ndindex(*(2 for _ in vectors)):
        real = [
            v.imag if is_imaginary else v.real
            for is_imaginary, v in zip(part, vectors, strict=True)
        ]
        count = sum(part)
        found[count % 2] = found[count % 2] + (-1) ** (count // 2) * function(*real)
    return found[0] + 1j * found[1]


@made_once
def contraction(system: System, inputs: tuple[str, ...], outputs: tuple[str, ...]) -> ca.Function:
    """Derivatives of ``y^T [A B; C D] v`` by states and parameters."""
    x, theta, _, _ = system.inputs
    moved = ca.vertcat(x, theta[system.places(inputs)]) if inputs else x
    observed = ca.vertcat(system.rates, system.expressions(outputs))
    y, v = ca.SX.sym("y", observed.numel()), ca.SX.sym("v", moved.numel())
    product = ca.dot(y, ca.jtimes(observed, moved, v))
    slopes = ca.densify(ca.gradient(product, ca.vertcat(x, theta)))
    return ca.Function("contraction", [*system.inputs, y, v], [slopes])


def contract(
    function: ca.Function, point: OperatingPoint, thetas: Real, left: Complex, right: Complex
) -> Slopes:
    """Slopes of ``y^T [A B; C D] v`` for vectors in columns, as a function of the modes.

    Parameters
    ----------
    function : Function
        From `contraction`.
    thetas : ndarray, shape (p, m)
        Parameters for each.
    left, right : ndarray of complex, shapes (rows, m) and (columns, m)
        Vectors y and v.
    """
    count = left.shape[1]
    call = function.map(count)
    states, times = np.repeat(np.c_[point.x], count, axis=1), np.full((1, count), point.time)

    def slopes(settings: Real) -> Complex:
        modes = np.repeat(np.c_[settings], count, axis=1)
        found: Complex = multiply_complex(
            lambda y, v: np.asarray(call(states, thetas, times, modes, y, v)).T, left, right
        )
        return found

    return slopes


def derive_at_point(
    point: OperatingPoint,
    names: list[str],
    places: list[int],
    slopes: Slopes,
    sizes: Real,
    rounding: float = 0.0,
) -> tuple[Complex, bool]:
    """Derivatives by parameters, and whether the point moves with them.

    Parameters
    ----------
    names, places : list
        The parameters.
    slopes : callable
        See `Slopes`.
    sizes : ndarray, shape (m,)
        Size of each number, relative to which slopes below `rounding` are none.

    Raises
    ------
    SolverError
        If a derivative has two sides, as the point is exactly where a law changes its piece.
    """
    both = slopes(point.settings)
    moved = None
    if point_matters(point, both / sizes[:, None], rounding):
        moved = find_moved_point(point, places)
    is_moving = moved is not None
    moved = moved or still_point(point, places)
    refuse_kinks(point, moved, names, slopes)
    return moved.through(both), is_moving


class Along:
    """Derivatives by parameters of ``(d outputs / dx) vector``.

    Parameters
    ----------
    outputs : SX
        Expressions of the system.
    moved : MovedPoint
        How the operating point follows the parameters.
    """

    def __init__(self, point: OperatingPoint, outputs: ca.SX, moved: MovedPoint) -> None:
        x, theta, _, _ = point.system.inputs
        v = ca.SX.sym("v", x.numel())
        slope = ca.jacobian(ca.jtimes(outputs, x, v), ca.vertcat(x, theta))
        self._function = ca.Function("along", [*point.system.inputs, v], [slope])
        self._inputs = point.inputs
        self._moved = moved

    def __call__(self, vector: Complex) -> Complex:
        """For a direction of the states that is held, shape (outputs, parameters)."""
        slopes = multiply_complex(
            lambda part: scipy.sparse.csc_array(self._function(*self._inputs, part).sparse()),
            vector,
        )
        found: Complex = self._moved.through(slopes)
        return found
