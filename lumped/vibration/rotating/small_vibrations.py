"""What a system does to small vibrations: ``M der(x) = A x + B u``, ``y = C x + D u`` at points."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from lumped.code.operations import operations_of
from lumped.code.step_functions import PieceNumbers, number_pieces
from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.support.arrays import Integer, Real
from lumped.support.made_once import Recent, made_once
from lumped.timeloop.plants.many_points import CountedFunction, ManyPoints
from lumped.vibration.rotating.masses import masses

Pattern = tuple[Integer, Integer]


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


class AmplitudeLaws(NamedTuple):
    """Parameters that are amplitudes at which laws hold.

    Attributes
    ----------
    places : list of int
        Among the parameters that have a value of their own.
    names : tuple of str
        Of the parameters.
    quantities : tuple of str
        What vibrates with these amplitudes.
    """

    places: list[int]
    names: tuple[str, ...]
    quantities: tuple[str, ...]


@made_once
def amplitude_laws(system: System) -> AmplitudeLaws:
    """Those of a system that its motion depends on."""
    parameters = system.structure.parameters
    known = parameters.amplitudes
    if not known:
        return AmplitudeLaws([], (), ())
    places = list(known)
    used = ca.which_depends(system.rates, system.inputs[1][places], 1, False)
    chosen = [place for place, is_used in zip(places, used, strict=True) if is_used]
    names = [parameters.free_names[place] for place in chosen]
    return AmplitudeLaws(chosen, tuple(names), tuple(known[place] for place in chosen))


class SmallVibrations:
    """Rates, outputs and matrices of a system as functions of points and of the vibration.

    Laws may hold at its frequency and at amplitudes that it has.

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
        Rates, outputs, A, B, C, D and M; of the inputs of the system and of `vibration`.
    masses : Masses
        Which rows M has; those of all other states are those of the unit matrix.
    vibration : SX
        Stands for the frequencies, rad/s, and then the amplitudes of vibration among the
        parameters.
    places : list of int
        Of these among the parameters.
    laws : AmplitudeLaws
        Those of amplitudes.
    kinks : ndarray
        Angles of the shaft at which pieces changed in the latest rotation (see `turns_of`).
    """

    def __init__(self, system: System, inputs: tuple[str, ...], outputs: tuple[str, ...]) -> None:
        self.system, self.inputs, self.outputs = system, inputs, outputs
        x, theta, _, _ = system.inputs
        self.laws, self.kinks = amplitude_laws(system), np.zeros(0)
        self._frequencies = len(system.structure.parameters.vibrating)
        self.places = system.structure.parameters.vibrating + self.laws.places
        self.vibration = ca.SX.sym("vibration", len(self.places))
        u = theta[system.places(inputs)] if inputs else ca.SX(0, 1)
        y = system.expressions(outputs)
        self.masses, M = masses(system)
        torques = self.masses.times(M, system.rates)
        found = [torques, y]
        found += [ca.jacobian(f, by) for f in (torques, y) for by in (x, u)]
        found.append(M)
        if self.places:
            found = ca.substitute(found, [theta[self.places]], [self.vibration])
        self.expressions = found
        triplets = [matrix.sparsity().get_triplet() for matrix in found[2:]]
        self.patterns: tuple[Pattern, ...] = tuple(
            (np.array(rows, dtype=int), np.array(columns, dtype=int)) for rows, columns in triplets
        )
        numbers = [ca.densify(found[0]), ca.densify(found[1]), *map(_nonzeros, found[2:])]
        self._ends = np.cumsum([n.numel() for n in numbers])[:-1]
        self._numbers = ca.vertcat(*numbers)
        self._calls: Recent[ManyPoints] = Recent(4)

    def __call__(
        self, x: Real, theta: Real, settings: Real, time: float, vibration: Real | None = None
    ) -> Parts:
        """Everything at points.

        Parameters
        ----------
        x, settings : ndarray, shapes (points, n) and (points, m)
            States and modes.
        theta : ndarray, shape (p,) or (points, p)
            Parameters.
        time : float
            Instant, s.
        vibration : ndarray, shape (points, frequencies and amplitudes), optional
            From `at`; by default laws hold at what is in `theta`.

        Raises
        ------
        SolverError
            If a number is not finite.
        """
        every = np.atleast_2d(theta)
        varied = np.flatnonzero((every != every[0]).any(axis=0)).tolist()
        given = every[:, self.places] if vibration is None else vibration
        own = [np.broadcast_to(g, (len(x), g.shape[1])) for g in (given, every[:, varied])]
        call = self._calls.of(tuple(varied), lambda: self._varying(varied))
        values = call(np.hstack([x, *own]), every[0], np.full(len(x), time), settings)
        if not np.isfinite(values).all():
            raise SolverError(
                f"{self.system.name}: a rate or its derivative is not finite where the drive turns "
                "steadily; change the operating point, the speeds or the parameters."
            )
        return Parts(*np.split(values, self._ends, axis=1))

    def whole_matrix(self, parts: Parts, weights: Real) -> Real:
        """Mean of ``[[A, B], [C, D]]`` over points with weights."""
        n, inputs = parts.rates.shape[1], len(self.inputs)
        found = np.zeros((n + len(self.outputs), n + inputs))
        corners = ((0, 0), (0, n), (n, 0), (n, n))
        for numbers, (rows, columns), (top, left) in zip(
            parts[2:6], self.patterns[:4], corners, strict=True
        ):
            found[rows + top, columns + left] = weights @ numbers
        return found

    def _varying(self, varied: list[int]) -> ManyPoints:
        """The numbers, of which some parameters vary from point to point."""
        x, theta, *others = self.system.inputs
        own = ca.SX.sym("own", len(varied))
        numbers = ca.cse(self._numbers)
        if varied:
            numbers = ca.substitute(numbers, theta[varied], own)
        inputs = [ca.vertcat(x, self.vibration, own), theta, *others]
        return ManyPoints(ca.Function("vibrations", inputs, [numbers]))

    def at(self, w: Real, amplitudes: Real) -> Real:
        """What laws need of vibrations, of their frequencies, rad/s, (points,), and amplitudes."""
        return np.hstack([np.repeat(w[:, None], self._frequencies, axis=1), amplitudes])

    def pieces(self, x: Real, theta: Real, settings: Real, time: float) -> Real:
        """What changes where rates or outputs have kinks or jumps in given modes."""
        numbers, function = self._pieces
        return numbers.settings(function.along(x, theta, np.full(len(x), time), settings))

    @cached_property
    def _pieces(self) -> tuple[PieceNumbers, CountedFunction]:
        system = self.system
        found = ca.densify(ca.vertcat(system.rates, system.expressions(self.outputs)))
        numbers = number_pieces(operations_of(ca.Function("kinks", system.inputs, [found])))
        return numbers, CountedFunction(numbers.arguments)

    @cached_property
    def _slopes(self) -> ManyPoints:
        x, theta, _, _ = self.system.inputs
        weights = ca.SX.sym("weights", self._numbers.numel())
        by = ca.vertcat(x, self.vibration, theta)
        slope = ca.gradient(ca.dot(self._numbers, weights), by)
        inputs = [ca.vertcat(x, self.vibration, weights), *self.system.inputs[1:]]
        return ManyPoints(ca.Function("slopes", inputs, [ca.cse(ca.densify(slope))]))

    def slopes(
        self,
        weights: Parts,
        x: Real,
        theta: Real,
        settings: Real,
        time: float,
        vibration: Real | None = None,
    ) -> tuple[Real, Real, Real]:
        """Derivatives of a weighted sum of everything, by states, parameters and amplitudes.

        Parameters
        ----------
        weights : Parts
            One for each number, shapes (points, ...).

        Returns
        -------
        ndarray, ndarray, ndarray, shapes (points, n), (points, p) and (points, amplitudes)
            Those by amplitudes, if `vibration` is given; else they count as parameters.
        """
        n, places = x.shape[1], self.places
        own = theta[places] if vibration is None else vibration
        given = np.hstack([x, np.broadcast_to(own, (len(x), len(places))), *weights])
        found = self._slopes(given, theta, np.full(len(x), time), settings)
        by_vibration, by_theta = found[:, n : n + len(places)], found[:, n + len(places) :]
        if vibration is None:
            by_theta[:, places] += by_vibration
            by_vibration = np.zeros_like(by_vibration)
        return found[:, :n], by_theta, by_vibration[:, self._frequencies :]


def add_products(total: Any, pattern: Pattern, numbers: Any, vectors: Any) -> None:
    """Add ``matrix vector`` to vectors, (..., n), of matrices with one pattern, (..., numbers)."""
    for k, (i, j) in enumerate(zip(*pattern, strict=True)):
        total[..., i] += numbers[..., k] * vectors[..., j]


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
