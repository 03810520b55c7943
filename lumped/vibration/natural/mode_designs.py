"""Modes of designs, found again for other parameters as they were found, or side by side."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lumped.compiler.system import Changes
from lumped.numerics.eigen import eigenvalues_of_many, vectors_of_many
from lumped.points.equilibrium import equilibrium
from lumped.points.linearise import moving
from lumped.points.moved_equilibrium import find_moved_point
from lumped.points.start import start_point
from lumped.support.arrays import Complex, Real
from lumped.timeloop.plants.many_points import ManyPoints
from lumped.timeloop.results.operating_point import Kept, OperatingPoint
from lumped.timeloop.results.validity import ranges
from lumped.vibration.natural.eigenpairs import label_parts
from lumped.vibration.natural.matrix_slopes import contraction, multiply_complex
from lumped.vibration.natural.modes import Modes
from lumped.vibration.natural.spectrum import REPEATED, Spectrum

_APART = 1e-3
"""Largest of what should be zero, over the least of what should not, that tells them apart."""
_CHUNK = 4_000_000
"""Numbers in the matrices that are worked on at once."""


def equilibrium_again(point: OperatingPoint, parameters: Changes) -> OperatingPoint:
    """The equilibrium of other parameters, found as that of a point was."""
    system, kept = point.system, point.kept or Kept()
    names = system.structure.parameters.free_names
    return equilibrium(
        system,
        parameters=parameters,
        start=kept.start,
        free=[names[place] for place in kept.free],
        rest=kept.rest,
        time=point.time,
    )


class ModeDesigns:
    """Modes of one system for other parameters.

    Parameters
    ----------
    begin : Modes
        Those with which the designs are compared.

    Attributes
    ----------
    is_held : bool
        The states of the point are the same for all designs.
    """

    def __init__(self, begin: Modes) -> None:
        self.begin, self.system, point = begin, begin.system, begin.point
        self._settled = find_moved_point(point, []) is not None
        x = start_point(self.system, parameters=point.parameters).x
        self._plain = np.array_equal(x, point.x)
        self.is_held = point.kept is None and not self._plain and not self._settled

    def point(self, values: dict[str, float]) -> OperatingPoint:
        """The operating point of a design: found as that of the modes was, else held."""
        begin = self.begin.point
        if begin.kept is not None:
            return equilibrium_again(begin, values)
        if self._plain:
            return start_point(self.system, parameters=values)
        if self._settled:
            states = dict(zip(self.system.state_names, begin.x.tolist(), strict=True))
            return equilibrium(self.system, parameters=values, start=states, time=begin.time)
        return replace(begin, theta=self.system.theta(values))


@dataclass(frozen=True, eq=False)
class ManyModes(Spectrum):
    """Oscillating modes of n designs, k of each, sorted by frequency.

    Attributes
    ----------
    eigenvalues : ndarray of complex, shape (n, k)
        nan where a design must be looked at alone: it has another number of modes, or modes are too
        near to zero.
    """

    eigenvalues: Complex


class ModesOfMany:
    """Modes of a system whose state matrix depends on parameters alone.

    Parameters
    ----------
    designs : ModeDesigns
    names : tuple of str
        What varies.

    Attributes
    ----------
    applies : bool
        Whether the state matrix depends on parameters alone, or the states are held; else each
        design has a point of its own.
    """

    def __init__(self, designs: ModeDesigns, names: tuple[str, ...]) -> None:
        self._begin, self._system = designs.begin, designs.system
        system, point = self._system, designs.begin.point
        self._places = system.places(names)
        self._pattern = system.jacobian.sparsity_out(0)
        inputs = system.inputs
        matrix = ca.SX(system.jacobian(*inputs)[0])
        self._numbers = ca.SX(matrix.nz[:])
        kept = point.kept
        found = [] if kept is None else [inputs[1][place] for place in kept.free]
        moved = ca.vertcat(inputs[0], *found)
        self.applies = bool(matrix.nnz()) and (
            designs.is_held
            or not (len(point.settings) or ranges(system) or ca.depends_on(self._numbers, moved))
        )

    def modes(self, x: Real) -> ManyModes:
        """Modes for parameters of shape (n, d)."""
        found = np.full((len(x), len(self._begin.hertz)), np.nan, dtype=complex)
        for rows in self._parts_of(len(x)):
            found[rows] = self._oscillating(self._eigenvalues(self._matrices(x[rows])))
        return ManyModes(found)

    def slopes(self, x: Real, modes: ManyModes, wanted: list[int]) -> Complex:
        """Derivatives of eigenvalues of some modes by what varies, shape (n, len(wanted), d).

        nan for modes that repeat, and where they must be looked at alone.
        """
        found = np.full((len(x), len(wanted), x.shape[1]), np.nan, dtype=complex)
        for rows in self._parts_of(len(x)):
            matrices = self._matrices(x[rows])
            every = self._eigenvalues(matrices)
            for i, mode in enumerate(wanted):
                values = modes.eigenvalues[rows, mode]
                gaps = np.abs(every - values[:, None])
                near = (gaps <= REPEATED * np.abs(values)[:, None]).sum(axis=1)
                alone = np.flatnonzero(near == 1)
                try:
                    right, left = vectors_of_many(matrices[alone], values[alone])
                except np.linalg.LinAlgError:  # a shift is an eigenvalue to the last bit
                    continue
                found[rows.start + alone, i] = self._contract(x[rows][alone], right, left)
        return found

    def curvatures(self, x: Real, mode: int) -> tuple[complex, Complex, Complex] | None:
        """An eigenvalue at one point, its first and second derivatives, (d,) and (d, d).

        None if the mode repeats, or there is another number of modes here.
        """
        row = x[None]
        modes = self.modes(row)
        value = modes.eigenvalues[0, mode]
        first = self.slopes(row, modes, [mode])[0, 0]
        if not np.isfinite(first).all():
            return None
        matrices, own = self._matrices(row), self._members
        right, left = vectors_of_many(matrices, np.array([value]))
        v, w = self._in_states(right)[0], self._in_states(left.conj())[0]
        point = self._begin.point
        inputs = point.x, self._theta(row)[0], point.time, point.settings
        along, across, twice = (
            lambda *vectors, part=part: part(*inputs, *vectors).full() for part in self._second
        )
        moved = multiply_complex(along, v)[own] - right[0][:, None] * first  # (A_i - l_i) x
        turned = multiply_complex(across, w)[own] - w[own][:, None] * first
        matrix = matrices[0] - value * np.eye(len(own))
        shapes = -np.linalg.lstsq(matrix, moved, rcond=1e-12)[0]
        second = multiply_complex(twice, w, v).reshape(len(first), -1)
        return complex(value), first, second + turned.T @ shapes + shapes.T @ turned

    def _theta(self, x: Real) -> Real:
        theta: Real = np.tile(self._begin.point.theta, (len(x), 1))
        theta[:, self._places] = x
        return theta

    @cached_property
    def _matrix(self) -> ManyPoints:
        states, theta, time, settings = self._system.inputs
        both = ca.vertcat(states, theta)
        return ManyPoints(
            ca.Function("matrix", [both, ca.SX.sym("p", 0), time, settings], [self._numbers])
        )

    def _evaluate(self, function: ManyPoints, x: Real, *more: Real) -> Real:
        point, n = self._begin.point, len(x)
        states = np.tile(point.x, (n, 1))
        settings = np.tile(point.settings, (n, 1))
        every = np.hstack([states, self._theta(x), *more])
        return function(every, np.zeros(0), np.full(n, point.time), settings)

    @cached_property
    def _members(self) -> NDArray[np.intp]:
        """States that can vibrate, as at the beginning."""
        return np.flatnonzero(moving(self._system, self._begin.point))

    def _matrices(self, x: Real) -> Real:
        """State matrices of what can vibrate, shape (n, m, m)."""
        numbers = self._evaluate(self._matrix, x)
        numbers[:, self._system.cancelling] = 0.0
        whole = np.zeros((len(x), *self._pattern.shape))
        rows, columns = (np.array(each, dtype=int) for each in self._pattern.get_triplet())
        whole[:, rows, columns] = numbers
        return whole[:, self._members][:, :, self._members]

    def _eigenvalues(self, matrices: Real) -> Complex:
        """Eigenvalues of all parts that do not touch, as at the beginning, shape (n, m)."""
        label = label_parts(self._begin.matrix)[self._members]
        own = [np.flatnonzero(label == part) for part in np.unique(label)]
        return np.hstack([eigenvalues_of_many(matrices[:, p][:, :, p]) for p in own])

    def _parts_of(self, n: int) -> list[slice]:
        size = max(1, _CHUNK // max(1, self._pattern.shape[0] ** 2))
        return [slice(begin, min(begin + size, n)) for begin in range(0, n, size)]

    def _oscillating(self, values: Complex) -> Complex:
        """Of each design the eigenvalues of its oscillating modes, ascending, or nan."""
        begin = self._begin
        count, k = 2 * len(begin.hertz) + len(begin.decays), len(begin.hertz)
        order = np.argsort(np.abs(values), axis=1)
        values = np.take_along_axis(values, order, axis=1)
        zeros = values.shape[1] - count
        found = np.full((len(values), k), np.nan, dtype=complex)
        rest = values[:, zeros:]
        above = (rest.imag > 0) & np.isfinite(rest)
        sound = above.sum(axis=1) == k
        if zeros and count:
            sound &= np.abs(values[:, zeros - 1]) <= _APART * np.abs(values[:, zeros])
        found[sound] = rest[sound][above[sound]].reshape(-1, k)
        return found

    @cached_property
    def _contraction(self) -> ManyPoints:
        states, theta, time, settings = self._system.inputs
        n = states.numel()
        y, v = ca.SX.sym("y", n), ca.SX.sym("v", n)
        slopes = contraction(self._system, (), ())(states, theta, time, settings, y, v)
        slope = slopes[[n + place for place in self._places]]
        both = ca.vertcat(states, theta, y, v)
        return ManyPoints(ca.Function("slopes", [both, ca.SX.sym("p", 0), time, settings], [slope]))

    def _contract(self, x: Real, right: Complex, left: Complex) -> Complex:
        """``y^H (dA/dp) x`` for each design, shape (n, d)."""
        found: Complex = multiply_complex(
            lambda y, v: self._evaluate(self._contraction, x, y, v),
            self._in_states(left.conj()),
            self._in_states(right),
        )
        return found

    def _in_states(self, vectors: Complex) -> Complex:
        """Vectors of what can vibrate among all states, shapes (n, m) to (n, states)."""
        found = np.zeros((len(vectors), len(self._system.state_names)), dtype=complex)
        found[:, self._members] = vectors
        return found

    @cached_property
    def _second(self) -> tuple[ca.Function, ca.Function, ca.Function]:
        """Derivatives by what varies of A v and w A, and second ones of w A v."""
        states, theta, *_ = inputs = self._system.inputs
        n = states.numel()
        w, v = ca.SX.sym("w", n), ca.SX.sym("v", n)
        rates, varied = self._system.rates, theta[self._places]
        along = ca.jtimes(rates, states, v)
        across = ca.jtimes(rates, states, w, True)
        twice = ca.jacobian(ca.jacobian(ca.dot(w, along), varied), varied)
        return (
            ca.Function("along", [*inputs, v], [ca.jacobian(along, varied)]),
            ca.Function("across", [*inputs, w], [ca.jacobian(across, varied)]),
            ca.Function("twice", [*inputs, w, v], [twice]),
        )
