"""What a system does to small vibrations: ``M der(x) = A x + B u``, ``y = C x + D u`` at points."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.support.made_once import Recent, made_once
from lumped.timeloop.many_points import ManyPoints
from lumped.vibration.masses import masses

__all__ = ["Parts", "SmallVibrations", "small_vibrations"]

Real = NDArray[np.float64]
Pattern = tuple[NDArray[np.int64], NDArray[np.int64]]


class Parts(NamedTuple):
    """Rates, outputs and the numbers of the matrices at points, shapes (points, ...).

    Rates, A and B of masses that vary are torques and forces: they are multiplied by M.
    """

    rates: Real
    outputs: Real
    A: Real
    B: Real
    C: Real
    D: Real
    M: Real


class SmallVibrations:
    """Rates, outputs and matrices of a system as functions of points and of the frequency.

    Parameters
    ----------
    system : System
        From `assemble`.
    inputs, outputs : tuple of str
        Full names of parameters that vary, and of quantities.

    Attributes
    ----------
    patterns : tuple of (rows, columns)
        Places of the numbers of A, B, C, D and M.
    expressions : list of SX
        Rates, outputs, A, B, C, D and M; of the inputs of the system and of `frequency`.
    masses : Masses
        Which rows M has; those of all other states are those of the unit matrix.
    frequency : SX
        Stands for the frequencies of vibration among the parameters, rad/s.
    """

    def __init__(self, system: System, inputs: tuple[str, ...], outputs: tuple[str, ...]) -> None:
        self.system, self.inputs, self.outputs = system, inputs, outputs
        x, theta, _, _ = system.inputs
        self.places = system.structure.parameters.vibrating
        self.frequency = ca.SX.sym("vibration", len(self.places))
        u = theta[system.places(inputs)] if inputs else ca.SX(0, 1)
        y = system.expressions(outputs)
        self.masses, M = masses(system)
        torques = self.masses.times(M, system.rates)
        found = [torques, y]
        found += [ca.jacobian(f, by) for f in (torques, y) for by in (x, u)]
        found.append(M)
        if self.places:
            found = ca.substitute(found, [theta[self.places]], [self.frequency])
        self.expressions = found
        triplets = [matrix.sparsity().get_triplet() for matrix in found[2:]]
        self.patterns: tuple[Pattern, ...] = tuple(
            (np.array(rows, dtype=int), np.array(columns, dtype=int)) for rows, columns in triplets
        )
        numbers = [ca.densify(found[0]), ca.densify(found[1])]
        numbers += [_nonzeros(m) for m in found[2:]]
        self._ends = np.cumsum([n.numel() for n in numbers])[:-1]
        inputs_ = [ca.vertcat(x, self.frequency), *system.inputs[1:]]
        self._call = ManyPoints(ca.Function("vibrations", inputs_, [ca.cse(ca.vertcat(*numbers))]))

    def __call__(
        self, x: Real, theta: Real, settings: Real, time: float, frequency: Real | None = None
    ) -> Parts:
        """Everything at points.

        Parameters
        ----------
        x, settings : ndarray, shapes (points, n) and (points, m)
            States and modes.
        theta : ndarray
            Parameters.
        time : float
            Instant, s.
        frequency : ndarray, shape (points,), optional
            Of the vibration, rad/s; by default laws hold at the frequencies in `theta`.

        Raises
        ------
        SolverError
            If a number is not finite.
        """
        shape = (len(x), len(self.places))
        if frequency is None:
            own = np.broadcast_to(theta[self.places], shape)
        else:
            own = np.broadcast_to(frequency[:, None], shape)
        values = self._call(np.hstack([x, own]), theta, np.full(len(x), time), settings)
        if not np.isfinite(values).all():
            raise SolverError(
                f"{self.system.name}: a rate or its derivative is not finite where the drive turns "
                "steadily; change the operating point, the speeds or the parameters."
            )
        return Parts(*np.split(values, self._ends, axis=1))

    @cached_property
    def _slopes(self) -> ManyPoints:
        x, theta, _, _ = self.system.inputs
        numbers = ca.vertcat(
            ca.densify(self.expressions[0]),
            ca.densify(self.expressions[1]),
            *(_nonzeros(m) for m in self.expressions[2:]),
        )
        weights = ca.SX.sym("weights", numbers.numel())
        by = ca.vertcat(x, self.frequency, theta)
        slope = ca.gradient(ca.dot(numbers, weights), by)
        inputs = [ca.vertcat(x, self.frequency, weights), *self.system.inputs[1:]]
        return ManyPoints(ca.Function("slopes", inputs, [ca.cse(ca.densify(slope))]))

    def slopes(
        self,
        weights: Parts,
        x: Real,
        theta: Real,
        settings: Real,
        time: float,
        frequency: Real | None = None,
    ) -> tuple[Real, Real]:
        """Derivatives of a weighted sum of everything, by states and by parameters.

        Parameters
        ----------
        weights : Parts
            One for each number, shapes (points, ...).

        Returns
        -------
        ndarray, ndarray, shapes (points, n) and (points, p)
        """
        n, places = x.shape[1], self.places
        own = theta[places] if frequency is None else frequency[:, None]
        given = np.hstack([x, np.broadcast_to(own, (len(x), len(places))), *weights])
        found = self._slopes(given, theta, np.full(len(x), time), settings)
        by_theta = found[:, n + len(places) :]
        if frequency is None:
            by_theta[:, places] += found[:, n : n + len(places)]
        return found[:, :n], by_theta


def small_vibrations(
    system: System, inputs: tuple[str, ...], outputs: tuple[str, ...]
) -> SmallVibrations:
    """What a system does to small vibrations; the latest are kept."""
    made = _latest(system)
    return made.of((inputs, outputs), lambda: SmallVibrations(system, inputs, outputs))


def _nonzeros(matrix: ca.SX) -> ca.SX:
    """Numbers of a matrix in one column."""
    return ca.sparsity_cast(matrix, ca.Sparsity.dense(matrix.nnz(), 1))


@made_once
def _latest(_: System) -> Recent[SmallVibrations]:
    return Recent(8)
