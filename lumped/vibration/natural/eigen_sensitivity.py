"""How natural frequencies and damping ratios change with parameters."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
import scipy
from numpy.typing import NDArray

from lumped.compiler.structure import Name
from lumped.errors import OptionError, SolverError
from lumped.plots.draw import Canvas, draw
from lumped.plots.numbers import tornado
from lumped.points.linearise import moving
from lumped.points.moved_equilibrium import find_moved_point, places_to, still_point
from lumped.points.situation import situation
from lumped.support.arguments import checked
from lumped.support.arrays import Boolean, Complex, Real
from lumped.support.display_units import Units, choose_units, frequency_unit
from lumped.support.ranking import list_largest, rank_by_size
from lumped.support.rich_html import RichHtml
from lumped.vibration.natural.eigenpairs import factors_beside
from lumped.vibration.natural.matrix_slopes import Along, contract, contraction, derive_at_point
from lumped.vibration.natural.modes import Modes
from lumped.vibration.natural.spectrum import REPEATED, damping_slopes, hertz_slopes

_ROUNDING = 1e-12
_DEFECTIVE = 1e-6
"""Angle between left and right vectors below which an eigenvalue has too few shapes."""


@dataclass(frozen=True, eq=False)
class EigenSensitivity(RichHtml):
    """Derivatives of oscillating modes and decays by parameters.

    Attributes
    ----------
    modes : Modes
        What was derived.
    by : tuple of str
        Names.
    eigenvalues : ndarray of complex, shape (k, p)
        Derivatives of the eigenvalues, 1/s for each unit of the parameter.
    decays : ndarray, shape (r, p)
        Derivatives of the decays, 1/s for each unit; nan where two are equal.
    moving : bool
        The operating point is an equilibrium that moves with the parameters, and this is
        included. If False, the point is held, or does not matter.
    repeated : tuple of int
        Numbers (from 0) of modes whose eigenvalue repeats in the same drive. They have no
        derivatives of their own: what is given for them is nan; `split` has them for one
        parameter that changes alone.
    """

    modes: Modes
    by: tuple[str, ...]
    eigenvalues: Complex
    decays: Real
    moving: bool
    repeated: tuple[int, ...]

    @property
    def hertz(self) -> Real:
        """Derivatives of the natural frequencies, Hz for each unit, shape (k, p)."""
        return hertz_slopes(self.modes.eigenvalues, self.eigenvalues)

    @property
    def damping(self) -> Real:
        """Derivatives of the damping ratios, 1 for each unit, shape (k, p)."""
        return damping_slopes(self.modes.eigenvalues, self.eigenvalues)

    @property
    def relative(self) -> Real:
        """Relative change of frequencies for each relative change of a parameter, shape (k, p)."""
        return self.hertz * self._values / self.modes.hertz[:, None]

    @property
    def _values(self) -> Real:
        return self.modes.point.theta[self.modes.system.places(self.by)]

    @checked
    def ranked(self, mode: int) -> list[tuple[str, float]]:
        """Parameters and relative sensitivities of a mode's frequency, the largest first.

        Raises
        ------
        OptionError
            If there is no such mode, or its eigenvalue repeats.
        """
        self.modes.check_mode(mode, "sensitivity")
        if mode in self.repeated:
            raise OptionError(
                f"{self.modes.system.name}: the eigenvalue of mode {mode} "
                f"({self.modes.hertz[mode]:.6g} Hz) repeats, so it has no derivative of its own. "
                "Take `split` for one parameter, or change one a little to part the modes."
            )
        what = f"frequency of mode {mode}"
        changes = self.hertz[mode] * self._values
        return rank_by_size(what, self.modes.hertz[mode], self.by, changes)

    @checked
    def split(self, mode: int, parameter: Name) -> Complex:
        """Derivatives of the eigenvalues into which one that repeats parts, 1/s, shape (m,).

        They hold if this parameter changes and no other: what several do does not add up.

        Raises
        ------
        OptionError
            If the mode does not repeat.
        SolverError
            If there are fewer shapes than eigenvalues; the derivatives are infinite.
        """
        if mode not in self.repeated:
            raise OptionError(f"{self.modes.system.name}: mode {mode} does not repeat.")
        alike = _compare(self.modes, self.modes.eigenvalues, self.modes.vectors)
        together = np.flatnonzero(alike[mode]).tolist()
        (place,) = self.modes.system.places([self.modes.system.key(parameter)])
        return derive_split(self.modes, together, place)

    @checked
    def plot(self, mode: int = 0, *, units: Units = None, **canvas: Unpack[Canvas]) -> Any:
        """Tornado of the parameters that matter most to a natural frequency.

        Parameters
        ----------
        mode : int
            Its number, from 0.
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        modes = self.modes
        found = self.ranked(mode)
        frequency = frequency_unit(choose_units(units, ("frequency", *modes.system.names())))
        told = f"{frequency.value(modes.hertz[mode]):.4g} {frequency.unit}"
        picture = tornado(found, f"{modes.system.name}: {told}", "the frequency")
        return draw(picture, **canvas)

    def __repr__(self) -> str:
        modes, rows = self.modes, list[tuple[str]]()
        for i in range(min(len(modes.hertz), 12)):
            text = "repeated: no derivatives of its own, see split"
            if i not in self.repeated:
                text = list_largest((n, v) for n, v in self.ranked(i) if v)
            rows.append((text,))
        point = "moves with the parameters" if self.moving else "held, or without effect"
        head = f"{modes.system.name}: relative sensitivities; operating point: {point}"
        head += f"{situation(modes.point)}\n{modes.accuracy}"
        more = []
        for decay, slopes in zip(modes.decays[: 12 - len(rows)], self.decays, strict=False):
            shares = slopes * self._values / decay
            text = "repeated: no derivatives of its own"
            if np.isfinite(shares).all():
                text = list_largest(zip(self.by, shares, strict=True))
            more.append(("decay", f"{decay:.6g} 1/s", text))
        return f"{head}\n" + modes.list_modes(("largest",), rows, more)


@checked
def eigen_sensitivity(modes: Modes, *, by: Iterable[Name] | None = None) -> EigenSensitivity:
    """Exact derivatives of eigenvalues by parameters.

    ``dl/dp = y^H (dA/dp) x`` with right and left eigenvectors, ``y^H x == 1`` (Fox and Kapoor,
    AIAA Journal 6, 1968). One reverse sweep for each mode gives the derivatives by all parameters.

    If the operating point of the modes is an equilibrium, the states follow the parameters so that
    it stays one; of several possible the nearest. Else the states are held. Parameters at which
    functions of time or what sticks would change are not watched.

    Parameters
    ----------
    modes : Modes
        From `lumped.modes`.
    by : iterable of names, optional
        Parameters; default is all that can be changed.

    Returns
    -------
    EigenSensitivity

    Raises
    ------
    OptionError
        If there is neither an oscillating mode nor a decay, or the modes are those of a mean over
        turns.
    UnknownNameError
        If a parameter does not exist, or is bound to others.
    SolverError
        If a derivative is not finite, or has two sides, as the point is exactly where a law
        changes its piece.
    """
    modes.refuse_mean("eigen_sensitivity")
    system, point = modes.system, modes.point
    count = len(modes.eigenvalues)
    values: Complex = np.append(modes.eigenvalues, modes.decays)
    if not len(values):
        raise OptionError(f"{system.name}: no oscillating mode and no decay to derive.")
    names, places = places_to(point, by)
    right = np.hstack([modes.vectors, modes.decay_vectors])
    left = np.hstack([modes.left_vectors, modes.left_decay_vectors])
    thetas = np.repeat(np.c_[point.theta], len(values), axis=1)
    slopes = contract(contraction(system, (), ()), point, thetas, left.conj(), right)
    found, moving = derive_at_point(point, names, places, slopes, np.abs(values), _ROUNDING)
    repeated = _find_repeated(modes, values, right)
    found[repeated] = np.nan
    alone = np.setdiff1d(np.arange(len(found)), repeated)
    if not np.isfinite(found[alone]).all():
        row, place = np.argwhere(~np.isfinite(found[alone]))[0]
        raise SolverError(
            f"{system.name}: the derivative of eigenvalue {values[alone[row]]:.6g} by "
            f"{names[place]} = "
            f"{point.theta[places[place]]:g} is not finite. Change this value, or leave it out of "
            "`by`."
        )
    return EigenSensitivity(
        modes,
        tuple(names),
        found[:count],
        found[count:].real,
        moving,
        tuple(repeated[repeated < count].tolist()),
    )


def _find_repeated(modes: Modes, values: Complex, vectors: Complex) -> NDArray[np.intp]:
    """Eigenvalues that are those of others in the same part of the drive."""
    alike = _compare(modes, values, vectors).sum(axis=1) > 1
    critical = (2 * np.abs(values.imag) <= REPEATED * np.abs(values)) & (values.imag != 0)
    return np.flatnonzero(alike | critical)


def _compare(modes: Modes, values: Complex, vectors: Complex) -> Boolean:
    """Which eigenvalues are the same in the same part of the drive, shape (k, k)."""
    part = modes.parts[np.abs(vectors).argmax(axis=0)]
    close = np.abs(values[:, None] - values[None, :]) <= REPEATED * np.abs(values)[:, None]
    found: Boolean = close & (part[:, None] == part[None, :])
    return found


def derive_split(modes: Modes, together: list[int], place: int) -> Complex:
    """Derivatives of the eigenvalues into which one that repeats parts, 1/s, shape (m,).

    With bases X and Y of the right and left eigenvectors they are the eigenvalues of
    ``(Y^H X)^-1 Y^H (dA/dp) X`` (Lancaster, Numerische Mathematik 6, 1964).

    Parameters
    ----------
    together : list of int
        The modes whose eigenvalue is the same.
    place : int
        Place of the parameter.

    Raises
    ------
    SolverError
        If there are fewer shapes than eigenvalues, where the derivatives are infinite.
    """
    system, point = modes.system, modes.point
    own = modes.own_part(modes.vectors[:, together[0]])
    own = own[moving(system, point)[own]]
    block = scipy.sparse.csc_array(system.state_matrix(point.inputs))[own][:, own].astype(complex)
    value = modes.eigenvalues[together[0]]
    factors = factors_beside(block, value)
    left = np.random.default_rng(3).standard_normal((len(own), len(together))).astype(complex)
    for _ in range(4):
        left = scipy.linalg.qr(factors.solve(left, trans="H"), mode="economic")[0]
    right = scipy.linalg.qr(modes.vectors[own][:, together], mode="economic")
    angles = np.linalg.svd(left.conj().T @ right[0], compute_uv=False)
    sizes = np.abs(np.diag(right[1]))
    if min(angles.min(), sizes.min() / sizes.max()) < _DEFECTIVE:
        raise SolverError(
            f"{system.name}: the eigenvalue of mode {together[0]} ({value:.6g} 1/s) repeats with "
            "fewer shapes than eigenvalues: its derivatives are infinite. Change a parameter a "
            "little."
        )
    vectors = np.zeros((len(point.x), len(together)), dtype=complex)
    vectors[own] = right[0]
    moved = find_moved_point(point, [place]) or still_point(point, [place])
    along = Along(point, system.rates, moved)
    change = np.column_stack([along(v)[own, 0] for v in vectors.T])
    small = np.linalg.solve(left.conj().T @ right[0], left.conj().T @ change)
    found = np.linalg.eigvals(small).astype(complex)
    return found[np.lexsort((found.real, found.imag))]
