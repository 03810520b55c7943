"""Natural vibrations of a drive that turns, by the means of its equations over the turns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError, SolverError
from lumped.points.linearise import finite
from lumped.support.arguments import checked
from lumped.support.arrays import Complex, Real
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.vibration.natural.find_modes import modes_of
from lumped.vibration.natural.modes import Modes
from lumped.vibration.natural.spectrum import REPEATED, Spectrum
from lumped.vibration.rotating.find_rotation import find_rotation
from lumped.vibration.rotating.harmonics import (
    derive_by_parameters,
    derive_by_speed,
    mean_matrix,
    sweep_turns,
)
from lumped.vibration.rotating.rotation import Rotation
from lumped.vibration.rotating.small_vibrations import SmallVibrations, small_vibrations
from lumped.vibration.rotating.turns import turns_of

_VIBRATES = 1e-6
"""Imaginary part of an eigenvalue, relative to its size, above which it belongs to a vibration."""
_SLOWEST = 1e-6
"""Size of an eigenvalue, relative to the largest, below which it is a zero with rounding."""


@checked
def mean_modes(
    system: System,
    *,
    shaft: Name,
    speed: float,
    turns: int = 1,
    at: OperatingPoint | Callable[[float], OperatingPoint] | None = None,
    free: Name | None = None,
    parameters: Changes | None = None,
) -> Modes:
    """Modes of the equivalent with constant inertias, of an engine with cranks for example.

    Inertias, stiffness and damping are their means over the turns of a shaft that turns steadily,
    as in `order_response`. What gas pressures add to the stiffness at single angles has no mean.
    Of an inertia that varies its mean counts, by the kinetic energy at equal speed: for a crank
    that of what rotates and about half of the mass that moves to and fro, at the crank radius. The
    true frequency (Floquet's exponent) is higher by the square of the variation.

    A component whose inertia varies must say its kinetic energy by a method `stored`, as all of the
    library do; otherwise the mean of one over its inertia counts.

    Source: Pasricha, ASEAN Journal on Science and Technology for Development 23 (2006) 1, abstract
    (conventional theory takes the mean values of the varying inertias); Nestorides, A Handbook on
    Torsional Vibration (1958), ch. 1 (not read).

    Parameters
    ----------
    system : System
        From `assemble`.
    shaft : name
        Angle of the shaft, rad.
    speed : float
        Its speed, rad/s.
    turns : int
        Turns of it after which everything repeats: 2 for a four-stroke engine.
    at, free, parameters : optional
        As in `order_response`.

    Returns
    -------
    Modes

    Raises
    ------
    OptionError
        If the speed is not positive, or the drive is another after the turns.
    SolverError
        If there is no steady rotation.
    """
    if not speed > 0:
        raise OptionError(f"mean_modes: speed = {speed:g} rad/s must be above zero.")
    turning = find_rotation(
        "mean_modes", system, shaft, np.array([speed]), turns, at, parameters, free
    )
    first = turning.points[0]
    point = replace(first, x=turning.x[0], theta=turning.theta[0], settings=turning.settings[0])
    small = small_vibrations(turning.system, (), ())
    matrix, _ = mean_matrix(small, turning, turns_of(small, turning))
    found = modes_of(finite(point), scipy.sparse.csr_array(matrix), is_mean=True)
    return replace(found, turning=turning.turning)


class MeanSpectrum(Spectrum):
    """Vibrations of the mean equations of a drive that turns steadily, at one speed.

    Laws of the frequency hold at the frequencies that parameters state.

    Parameters
    ----------
    small : SmallVibrations
        Equations of small vibrations.
    steady : Rotation
        At one speed.
    orders : ndarray
        Orders of which the samples over the turns must know.

    Attributes
    ----------
    eigenvalues : ndarray of complex, shape (m,)
        One of each conjugate pair, the slowest first, 1/s.
    """

    def __init__(self, small: SmallVibrations, steady: Rotation, orders: Real) -> None:
        self._small, self._steady = small, steady
        self._turns = turns_of(small, steady, 0, orders)
        matrix, self._masses = mean_matrix(small, steady, self._turns)
        values, self._left, self._right = scipy.linalg.eig(matrix, left=True, right=True)
        fastest = np.abs(values).max(initial=0.0)
        chosen = np.flatnonzero(values.imag > _VIBRATES * np.abs(values))
        chosen = chosen[np.abs(values[chosen]) > _SLOWEST * fastest]
        chosen = chosen[np.argsort(np.abs(values[chosen]), kind="stable")]
        self.eigenvalues: Complex = values[chosen]
        self._all, self._chosen = values, chosen

    def hertz_by(self, mode: int) -> Real:
        """Derivatives of a natural frequency by all parameters, shape (p,)."""
        return self._slope(mode, self._of_hertz(mode))

    def damping_by(self, mode: int) -> Real:
        """Derivatives of a damping ratio by all parameters, shape (p,)."""
        value = self.eigenvalues[mode]
        size = np.abs(value)
        return self._slope(mode, value.real * value.conjugate() / size**3 - 1 / size)

    def hertz_by_speed(self, mode: int) -> float:
        """Derivative of a natural frequency by the speed of the shaft, Hz s/rad."""
        return derive_by_speed(self._steady, self._sweep(mode, self._of_hertz(mode))[0])

    def _of_hertz(self, mode: int) -> complex:
        """What the change of an eigenvalue counts in that of the frequency."""
        value = self.eigenvalues[mode]
        found: complex = value.conjugate() / np.abs(value) / (2 * np.pi)
        return found

    def _slope(self, mode: int, weight: complex) -> Real:
        """Derivatives of the real part of an eigenvalue times a weight."""
        by_x, slope = self._sweep(mode, weight)
        return slope + derive_by_parameters(self._steady, by_x)

    def _sweep(self, mode: int, weight: complex) -> tuple[Real, Real]:
        """The same by the states, and by parameters while the states stay."""
        place = self._chosen[mode]
        value, small = self._all[place], self._small
        near = np.abs(np.delete(self._all, place) - value).min(initial=np.inf)
        if near <= REPEATED * np.abs(value):
            raise SolverError(
                f"{small.system.name}: mode {mode} ({np.abs(value) / (2 * np.pi):.6g} Hz) "
                "coincides with another and has no derivative. Change a parameter a little."
            )
        rows, columns = small.patterns[0]
        left, right = self._left[:, place].conj(), self._right[:, place]
        masses, size = small.masses, left @ right
        left = masses.divide(self._masses, left)  # M is symmetric
        own = (weight * left[rows] * right[columns] / size).real
        means = [own, *(np.zeros(len(pattern[0])) for pattern in small.patterns[1:4])]
        means.append((-weight * value * left[masses.rows] * right[masses.columns] / size).real)
        still = [np.zeros_like(self._turns.x), np.zeros((len(self._turns.x), len(small.outputs)))]
        return sweep_turns(small, self._steady, self._turns, still, means)
