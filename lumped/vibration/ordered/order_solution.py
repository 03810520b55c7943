"""Amplitudes of the orders of a vibration about steady rotation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.numerics.settled_amplitudes import SETTLED, solve_amplitudes
from lumped.numerics.shifted_solutions import elimination, pivots, solve_singly
from lumped.support.arrays import Complex, Integer, Real
from lumped.support.made_once import Recent, made_once
from lumped.timeloop.plants.many_points import ManyPoints
from lumped.vibration.ordered.synthesis import Synthesis
from lumped.vibration.rotating.harmonics import harmonics
from lumped.vibration.rotating.masses import mechanical_states
from lumped.vibration.rotating.rotation import Rotation
from lumped.vibration.rotating.small_vibrations import SmallVibrations, add_products

Excitations: TypeAlias = dict[str, dict[float, Complex]]
"""Amplitudes of inputs, by their names and orders, each at all speeds."""
_MOST_SOLVED = 250
"""States up to which a formula is made for the solution."""
_LOOKS = 7
"""Angles at which torques are compared."""
_UNKNOWN = 1e-7
"""Share of a torque that may differ by rounding."""
_ACCURATE = 1e-10
"""Backward error up to which the formula is believed."""


def input_amplitudes(excitations: Excitations, speeds: Real, orders: Real) -> Complex:
    """Amplitudes of all inputs at speeds and orders, shape (k, o, inputs)."""
    found = np.zeros((len(speeds), len(orders), len(excitations)), dtype=complex)
    for i, given in enumerate(excitations.values()):
        for order, amplitudes in given.items():
            found[:, orders == order, i] = amplitudes[:, None]
    return found


@dataclass(frozen=True, eq=False)
class OrderSolution:
    """Amplitudes, and the equations they solve.

    Attributes
    ----------
    small, steady, orders : SmallVibrations, Rotation, ndarray
        Of the equations.
    u : ndarray of complex, shape (k, o, inputs)
        Amplitudes of inputs.
    y, x : ndarray of complex, shapes (k, o, outputs) and (k, o, n)
        Amplitudes of outputs and of states.
    means : ndarray, shape (k, outputs)
        Means of the outputs over the turns.
    matrices : list of ndarray, shapes (k, o, numbers)
        Numbers of A, B, C, D and M.
    added : tuple of (tuple of ndarray, ndarray), optional
        Places and numbers, shape (k, o, numbers), that a damping ratio adds to ``M^-1 A``.
    residual : float
        Largest backward error.
    """

    small: SmallVibrations
    steady: Rotation
    orders: Real
    u: Complex
    y: Complex
    x: Complex
    means: Real
    matrices: list[Real]
    added: tuple[tuple[Integer, Integer], Real] | None
    residual: float

    @property
    def w(self) -> Real:
        """Frequencies, rad/s, shape (k, o)."""
        return self.orders * self.steady.speeds[:, None]

    def shifted_matrices(self) -> Complex:
        """``j w M - A``, shape (k, o, n, n)."""
        rows, columns = self.small.patterns[0]
        masses = self.small.masses.in_states(self.matrices[4])
        found = np.asarray(1j * self.w[..., None, None] * masses, dtype=complex)
        found[..., rows, columns] -= self.matrices[0]
        if self.added is not None:
            own, numbers = self.added
            more = np.zeros(found.shape)
            more[..., own[0], own[1]] = numbers
            found -= masses @ more
        return found


class OrderEquations:
    """Vibration about a steady rotation.

    Parameters
    ----------
    small : SmallVibrations
        What vibrations do.
    steady : Rotation
        The rotation.
    orders : ndarray, shape (o,)
        Periods for each turn.
    u : ndarray of complex, shape (k, o, inputs)
        Amplitudes of inputs.
    damping_ratio : float
        Of every elastic mode, beside what the model has.
    """

    def __init__(
        self,
        small: SmallVibrations,
        steady: Rotation,
        orders: Real,
        u: Complex,
        damping_ratio: float = 0.0,
    ) -> None:
        self.small, self.steady, self.orders = small, steady, orders
        self._u, self._damping_ratio = u, damping_ratio
        self._rates, self._outputs, self._means, self._matrices = harmonics(small, steady, orders)
        self._stated: list[Real] = []
        if small.places:
            _refuse_unknown_masses(small, steady, orders[-1] * steady.speeds[0])
            stated = small(steady.x, steady.theta, steady.settings, steady.time)
            self._stated = list(stated[2:])

    def solve_vibration(self, amplitudes: Real, at: Integer | None = None) -> OrderSolution:
        """Vibration with laws at amplitudes.

        Parameters
        ----------
        amplitudes : ndarray, shape (k, m)
            At which the laws of `small` hold.
        at : ndarray of int, shape (k,), optional
            Numbers of the speeds; default is all.

        Raises
        ------
        SolverError
            If a vibration is unbounded, or grows by itself.
        """
        every = np.arange(len(self.steady.speeds)) if at is None else at
        small, steady, orders = self.small, self.steady.part(every), self.orders
        system, speeds, u = steady.system, steady.speeds, self._u[every]
        rates, outputs = self._rates[every], self._outputs[every]
        n, shape = rates.shape[2], (len(speeds), len(orders))
        w = orders[None, :] * speeds[:, None]
        matrices = self._by_laws(steady, every, w, amplitudes)
        A, B, C, D, M = matrices
        add_products(rates, small.patterns[1], B, u)
        add_products(outputs, small.patterns[3], D, u)
        rates = small.masses.divide(M, rates)
        (rows, columns), A = small.masses.divide_matrix(M, small.patterns[0], A)
        added = None
        if self._damping_ratio:
            more, block = added = _modal_damping(steady, rows, columns, A, self._damping_ratio)
            rows, columns = np.append(rows, more[0]), np.append(columns, more[1])
            A = np.concatenate([A, block], axis=2)
        _refuse_growth(steady, rows, columns, A[:, 0])
        found, worst = _solve_points(
            system, rows, columns, A.reshape(-1, A.shape[2]), w.ravel(), rates.reshape(-1, n)
        )
        size = np.abs(found).max(axis=1, initial=0.0)
        bad = np.flatnonzero(~np.isfinite(size))
        if len(bad):
            place = np.unravel_index(bad[0], shape)
            raise SolverError(
                f"{system.name}: no finite vibration of order {orders[place[1]]:g} at "
                f"{speeds[place[0]]:.9g} rad/s: an undamped mode resonates there. Leave this speed "
                "out, or add damping."
            )
        found = found.reshape(*shape, n)
        add_products(outputs, small.patterns[2], C, found)
        means = self._means[every]
        numbers = matrices, added, worst
        return OrderSolution(small, steady, orders, u, outputs, found, means, *numbers)

    def _by_laws(self, steady: Rotation, every: Integer, w: Real, amplitudes: Real) -> list[Real]:
        """Numbers of the matrices at frequencies and amplitudes, shapes (k, o, numbers)."""
        count = w.shape[1]
        found = [np.repeat(part[every, None, :], count, axis=1) for part in self._matrices]
        if not self._stated:
            return found
        x, theta, settings, own = (
            np.repeat(part, count, axis=0)
            for part in (steady.x, steady.theta, steady.settings, amplitudes)
        )
        vibration = self.small.at(w.ravel(), own)
        there = self.small(x, theta, settings, steady.time, vibration)
        for held, part, base in zip(found, there[2:], self._stated, strict=True):
            held += part.reshape(held.shape) - base[every, None, :]
        return found


def find_amplitudes(equations: OrderEquations, first: int) -> tuple[Real, float]:
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
    steady, laws = equations.steady, equations.small.laws
    last = first + len(laws.places)
    begin = np.zeros((len(steady.speeds), last - first))
    if not begin.size:
        return begin, 0.0

    def follows(amplitudes: Real, at: Integer) -> Real:
        solved = equations.solve_vibration(amplitudes, at)
        return np.column_stack([_size_for_law(solved, row) for row in range(first, last)])

    found, missed = solve_amplitudes(follows, begin)
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


def synthesis_of(solved: OrderSolution, row: int) -> tuple[Synthesis, Literal["half range", "sum"]]:
    """One of the outputs over a cycle, and what of it is the amplitude at which a law holds.

    It is the sum of amplitudes, if the orders have no common cycle.
    """
    speeds, orders = solved.steady.speeds, solved.orders
    both = Synthesis(solved.small.outputs[row], "", speeds, orders, solved.y[:, :, row])
    return both, "half range" if both.has_cycle else "sum"


def _size_for_law(solved: OrderSolution, row: int) -> Real:
    both, measure = synthesis_of(solved, row)
    return both.measure(measure)


def _refuse_unknown_masses(small: SmallVibrations, steady: Rotation, w: float) -> None:
    """Refuse laws of the frequency that change torques of the turns: a mass is not in M."""
    if not (len(small.masses.rows) and steady.turns_matter):
        return
    x, settings = steady.along(0, 2 * np.pi * steady.turns * np.arange(_LOOKS) / _LOOKS)
    theta, time = steady.theta[0], steady.time
    stated = np.tile(theta[small.laws.places], (_LOOKS, 1))
    held, there = (
        small(x, theta, settings, time, vibration).rates[:, small.masses.own]
        for vibration in (None, small.at(np.full(_LOOKS, w), stated))
    )
    missed = np.ptp(there - held, axis=0)
    if (missed > _UNKNOWN * np.abs(held).max()).any():
        name = steady.system.state_names[small.masses.own[int(missed.argmax())]]
        raise OptionError(
            f"{steady.system.name}: a component moves with {name} whose mass or inertia is not "
            "known beside those that depend on the frequency; give it a method `stored` with its "
            "kinetic energy."
        )


def _modal_damping(
    steady: Rotation, rows: Integer, columns: Integer, A: Real, ratio: float
) -> tuple[tuple[Integer, Integer], Real]:
    """What a damping ratio of every elastic mode adds to A: places, and numbers, shape (k, o, m).

    Without dampers, speeds v and positions p follow ``der(v) = F p``, ``der(p) = E v``, so that
    ``-F E`` has the squares of the natural frequencies; modal damping adds
    ``-2 ratio sqrt(-F E) v`` to ``der(v)``. Laws have the frequency of each order. After the turns
    torques are the same, so F has none of that motion; a mean over some angles has, at kinks.
    """
    system = steady.system
    p, v = mechanical_states(system)
    n = len(system.structure.states)
    way = steady.turning[p] / max(float(np.linalg.norm(steady.turning[p])), 1e-300)
    every = A.reshape(-1, A.shape[2])
    found = np.empty((len(every), len(v) ** 2))
    for k, numbers in enumerate(every):
        if k and np.array_equal(numbers, every[k - 1]):
            found[k] = found[k - 1]
            continue
        matrix = _matrix(rows, columns, numbers, n)
        F = matrix[np.ix_(v, p)]
        F -= np.outer(F @ way, way)
        squares, shapes = np.linalg.eig(-F @ matrix[np.ix_(p, v)])
        largest = np.abs(squares).max(initial=0.0)
        if (np.abs(squares.imag) > 1e-9 * largest).any() or (squares.real < -1e-9 * largest).any():
            raise SolverError(
                f"{system.name}: without dampers the drive has no modes that vibrate without "
                "growing, so that a damping ratio has no meaning; leave out damping_ratio=."
            )
        elastic = np.where(squares.real > 1e-12 * largest, squares.real, 0.0)
        block = -2 * ratio * (shapes * np.sqrt(elastic)) @ np.linalg.inv(shapes)
        found[k] = block.real.ravel()
    return (np.repeat(v, len(v)), np.tile(v, len(v))), found.reshape(*A.shape[:2], -1)


def _matrix(rows: Integer, columns: Integer, numbers: Real, n: int) -> Real:
    """A matrix from its numbers; those at the same place add up."""
    found: Real = scipy.sparse.coo_array((numbers, (rows, columns)), shape=(n, n)).toarray()
    return found


def _refuse_growth(steady: Rotation, rows: Integer, columns: Integer, A: Real) -> None:
    """Refuse a rotation about which vibrations grow; looked at at a few speeds."""
    n = steady.x.shape[1]
    if n > _MOST_SOLVED:
        return
    for k in sorted({0, len(A) // 2, len(A) - 1}):
        matrix = _matrix(rows, columns, A[k], n)
        values = np.linalg.eigvals(matrix)
        grows = values.real * (np.abs(values.imag) > 1e-6 * np.abs(values))
        if grows.max(initial=0.0) > 1e-7 * np.abs(values).max(initial=0.0):
            worst = values[int(np.argmax(grows))]
            raise SolverError(
                f"{steady.system.name}: at {steady.speeds[k]:g} rad/s a vibration of "
                f"{abs(worst.imag) / (2 * np.pi):.4g} Hz grows as exp({worst.real:.4g} t), so no "
                "steady vibration is ever reached. Add damping or control."
            )


def _solve_points(
    system: System, rows: Integer, columns: Integer, entries: Real, w: Real, right: Complex
) -> tuple[Complex, float]:
    """Solutions at all points, and the largest backward error."""
    n = right.shape[1]
    found = np.zeros(right.shape, dtype=complex)
    if not n:
        return found, 0.0
    missed = np.full(len(w), np.inf)
    if n <= _MOST_SOLVED:
        driven = np.flatnonzero(right.any(axis=0))
        few = np.unique(np.linspace(0, len(w) - 1, 5).astype(int))
        typical = np.array([-_matrix(rows, columns, entries[k], n) for k in few], dtype=complex)
        typical[:, np.arange(n), np.arange(n)] += 1j * w[few, None]
        order = pivots(rows, columns, typical)
        key = rows.tobytes(), columns.tobytes(), driven.tobytes(), order
        call = _formulas(system).of(
            key, lambda: ManyPoints(elimination(rows, columns, driven, order))
        )
        given = np.hstack([entries, w[:, None], right[:, driven].real, right[:, driven].imag])
        values = call(given, np.zeros(0), np.zeros(len(w)), np.zeros((len(w), 0)))
        found.real, found.imag, missed = values[:, :n], values[:, n:-1], values[:, -1]
    again = np.flatnonzero(~(missed <= _ACCURATE))
    if len(again):
        singly = solve_singly(rows, columns, entries[again], w[again], right[again])
        found[again], missed[again] = singly
    return found, float(missed[np.isfinite(missed)].max(initial=0.0))


@made_once
def _formulas(_: System) -> Recent[ManyPoints]:
    return Recent(8)
