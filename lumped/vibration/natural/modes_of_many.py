"""Natural frequencies, damping ratios and their derivatives for many designs, side by side."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
import scipy
from numpy.typing import NDArray

from lumped.numerics.eigen import eigenvalues_of_many, vectors_of_many
from lumped.points.vibrating_states import moving
from lumped.timeloop.plants.many_points import ManyPoints
from lumped.timeloop.results.validity import ranges
from lumped.vibration.natural.mode_designs import ModeDesigns

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

_REPEATED = 1e-6
"""Relative distance below which eigenvalues count as repeated."""
_APART = 1e-3
"""Largest of what should be zero, over the least of what should not, that tells them apart."""
_CHUNK = 4_000_000
"""Numbers in the matrices that are worked on at once."""


@dataclass(frozen=True, eq=False)
class ManyModes:
    """Oscillating modes of n designs, k of each, sorted by frequency.

    Attributes
    ----------
    eigenvalues : ndarray of complex, shape (n, k)
        nan where a design must be looked at alone: it has another number of modes, or modes are too
        near to zero.
    """

    eigenvalues: Complex

    @property
    def hertz(self) -> Real:
        """Natural frequencies, Hz, shape (n, k)."""
        return np.abs(self.eigenvalues) / (2 * np.pi)

    @property
    def damping(self) -> Real:
        """Damping ratios, shape (n, k)."""
        return 0.0 - self.eigenvalues.real / np.abs(self.eigenvalues)


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
        k, n = len(self._begin.hertz), len(x)
        found = np.full((n, k), np.nan, dtype=complex)
        for rows in self._parts_of(n):
            every = [eigenvalues_of_many(block) for block in self._blocks(x[rows])]
            found[rows] = self._oscillating(np.hstack(every))
        return ManyModes(found)

    def slopes(self, x: Real, modes: ManyModes, wanted: list[int]) -> Complex:
        """Derivatives of eigenvalues of some modes by what varies, shape (n, len(wanted), d).

        nan for modes that repeat, and where they must be looked at alone.
        """
        n, d = len(x), x.shape[1]
        found = np.full((n, len(wanted), d), np.nan, dtype=complex)
        for rows in self._parts_of(n):
            blocks = self._blocks(x[rows])
            every = [eigenvalues_of_many(block) for block in blocks]
            for i, mode in enumerate(wanted):
                value = modes.eigenvalues[rows, mode]
                known = np.isfinite(value)
                if not known.any():
                    continue
                own = x[rows][known]
                part = self._part_with(every, value, known)
                for number in np.unique(part):
                    mine = part == number
                    try:
                        right, left = vectors_of_many(
                            blocks[number][known][mine], value[known][mine]
                        )
                    except np.linalg.LinAlgError:  # a shift is an eigenvalue to the last bit
                        continue
                    gap = np.abs(every[number][known][mine] - value[known][mine, None])
                    alone = (gap <= _REPEATED * np.abs(value[known][mine, None])).sum(axis=1) == 1
                    by = self._contract(own[mine], right, left, self._members[number])
                    by[~alone] = np.nan
                    places = np.arange(rows.start, rows.stop)[known][mine]
                    found[places, i] = by
        return found

    def curvatures(self, x: Real, mode: int) -> tuple[complex, Complex, Complex] | None:
        """An eigenvalue at one point, its first and second derivatives, (d,) and (d, d).

        None if the mode repeats, or there is another number of modes here.
        """
        row = x[None]
        value = self.modes(row).eigenvalues[0, mode]
        blocks = self._blocks(row)
        every = [eigenvalues_of_many(block) for block in blocks]
        first = self.slopes(row, ManyModes(np.full((1, mode + 1), value)), [mode])[0, 0]
        if not np.isfinite(first).all():
            return None
        number = int(self._part_with(every, np.array([value]), np.array([True]))[0])
        own = self._members[number]
        right, left = vectors_of_many(blocks[number], np.array([value]))
        v = np.zeros(len(self._system.state_names), dtype=complex)
        w = v.copy()
        v[own], w[own] = right[0], left[0].conj()
        d = len(first)
        theta = self._theta(row)[0]
        point = self._begin.point
        inputs = point.x, theta, point.time, point.settings

        def complexly(function: ca.Function, *vectors: Complex) -> Complex:
            total = 0j
            for part in np.ndindex(*(2 for _ in vectors)):
                real = [(vec.imag if p else vec.real) for p, vec in zip(part, vectors, strict=True)]
                total = total + 1j ** sum(part) * function(*inputs, *real).full()
            return np.asarray(total)

        along, across, twice = self._second
        moved = complexly(along, v)[own] - right[0][:, None] * first  # (A_i - l_i) x
        turned = complexly(across, w)[own] - w[own][:, None] * first
        matrix = blocks[number][0] - value * np.eye(len(own))
        shapes = -np.linalg.lstsq(matrix, moved, rcond=1e-12)[0]
        second = complexly(twice, w, v).reshape(d, d) + turned.T @ shapes + shapes.T @ turned
        return complex(value), first, second

    # -- matrices ------------------------------------------------------------------------------

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
    def _members(self) -> list[NDArray[np.intp]]:
        """States of each part of the drive that can vibrate, as at the beginning."""
        own = np.flatnonzero(moving(self._system, self._begin.point))
        matrix = self._begin.matrix
        matrix.eliminate_zeros()
        label = scipy.sparse.csgraph.connected_components(matrix, directed=False)[1][own]
        return [own[label == part] for part in np.unique(label)]

    def _blocks(self, x: Real) -> list[Real]:
        """State matrices of all parts, shapes (n, m, m)."""
        numbers = self._evaluate(self._matrix, x)
        numbers[:, self._system.cancelling] = 0.0
        whole = np.zeros((len(x), *self._pattern.shape))
        rows, columns = (np.array(each, dtype=int) for each in self._pattern.get_triplet())
        whole[:, rows, columns] = numbers
        return [whole[:, own][:, :, own] for own in self._members]

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

    def _part_with(
        self, every: list[Complex], value: Complex, known: NDArray[np.bool_]
    ) -> NDArray[np.intp]:
        """Number of the part of the drive to which an eigenvalue belongs, for known designs."""
        away = [np.abs(own[known] - value[known, None]).min(axis=1) for own in every]
        found: NDArray[np.intp] = np.argmin(away, axis=0)
        return found

    # -- derivatives ---------------------------------------------------------------------------

    @cached_property
    def _contraction(self) -> ManyPoints:
        states, theta, time, settings = self._system.inputs
        n = states.numel()
        y, v = ca.SX.sym("y", n), ca.SX.sym("v", n)
        product = ca.dot(y, ca.jtimes(self._system.rates, states, v))
        slope = ca.densify(ca.gradient(product, theta)[self._places])
        both = ca.vertcat(states, theta, y, v)
        return ManyPoints(ca.Function("slopes", [both, ca.SX.sym("p", 0), time, settings], [slope]))

    def _contract(self, x: Real, right: Complex, left: Complex, own: NDArray[np.intp]) -> Complex:
        """``y^H (dA/dp) x`` for each design, shape (n, d)."""
        count = len(self._system.state_names)
        x_all, y_all = (np.zeros((len(x), count), dtype=complex) for _ in range(2))
        x_all[:, own], y_all[:, own] = right, left.conj()
        total = np.zeros((len(x), len(self._places)), dtype=complex)
        for a, y in ((1, y_all.real), (1j, y_all.imag)):
            for b, v in ((1, x_all.real), (1j, x_all.imag)):
                total += a * b * self._evaluate(self._contraction, x, y, v)
        return total

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
