"""How natural frequencies and damping ratios change with parameters."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.plots.draw import Backend, draw
from lumped.plots.numbers import tornado
from lumped.points.borders import refuse_kinks
from lumped.points.moved_equilibrium import find_moved_point, places_to, point_matters, still_point
from lumped.points.situation import situation
from lumped.support.arguments import checked
from lumped.support.display_units import Units, choose_units, frequency_unit
from lumped.support.made_once import made_once
from lumped.support.ranking import rank_by_size
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.vibration.natural.eigen_slopes import damping_slopes, hertz_slopes
from lumped.vibration.natural.left_vectors import left_vectors, parts
from lumped.vibration.natural.modes import Modes
from lumped.vibration.natural.repeated_eigenvalues import derive_split

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

_REPEATED = 1e-6
"""Relative distance below which eigenvalues count as repeated."""
_ROUNDING = 1e-12


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
        found: Real = self.hertz * self._values / self.modes.hertz[:, None]
        return found

    @property
    def _values(self) -> Real:
        known = self.modes.point.parameters
        found: Real = np.array([known[name] for name in self.by])
        return found

    @checked
    def ranked(self, mode: int) -> list[tuple[str, float]]:
        """Parameters and relative sensitivities of a mode's frequency, the largest first.

        Raises
        ------
        OptionError
            If there is no such mode, or its eigenvalue repeats.
        """
        count = len(self.modes.hertz)
        if not 0 <= mode < count:
            raise OptionError(f"sensitivity: mode {mode} of {count}; modes count from 0.")
        if mode in self.repeated:
            raise OptionError(
                f"{self.modes.system.name}: the eigenvalue of mode {mode} "
                f"({self.modes.hertz[mode]:.6g} Hz) repeats, so it has no derivative of its own. "
                "Take `split` for one parameter, or change one a little to part the modes."
            )
        what = f"frequency of mode {mode}"
        return rank_by_size(what, self.modes.hertz[mode], self.by, self.relative[mode])

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
        values = self.modes.eigenvalues
        near = np.abs(values - values[mode]) <= _REPEATED * np.abs(values[mode])
        part = parts(self.modes)[np.abs(self.modes.vectors).argmax(axis=0)]
        together = np.flatnonzero(near & (part == part[mode])).tolist()
        (place,) = self.modes.system.places([self.modes.system.key(parameter)])
        return derive_split(self.modes, together, place)

    @checked
    def plot(
        self,
        mode: int = 0,
        *,
        units: Units = None,
        backend: Backend = "matplotlib",
        ax: Any = None,
    ) -> Any:
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
        return draw(picture, backend, ax)

    def __repr__(self) -> str:
        rows, frequency = [], frequency_unit()
        for i, hertz in enumerate(self.modes.hertz[:12]):
            text = "repeated: no derivatives of its own, see split"
            if i not in self.repeated:
                most = [(n, v) for n, v in self.ranked(i)[:4] if v]
                text = "; ".join(f"{name} {value:+.4f}" for name, value in most)
            rows.append((str(i + 1), number(frequency.value(hertz), 9), text))
        point = "moves with the parameters" if self.moving else "held, or without effect"
        head = f"{self.modes.system.name}: relative sensitivities; operating point: {point}"
        head += situation(self.modes.point)
        head += f"\n{self.modes.accuracy}"
        known = self._values
        for i, decay in enumerate(self.modes.decays[: 12 - len(rows)]):
            shares = self.decays[i] * known / decay
            text = "repeated: no derivatives of its own"
            if np.isfinite(shares).all():
                order = np.argsort(-np.abs(shares))[:4].tolist()
                text = "; ".join(f"{self.by[j]} {shares[j]:+.4f}" for j in order)
            rows.append(("decay", f"{decay:.6g} 1/s", text))
        return f"{head}\n" + table(
            ("mode", f"natural frequency, {frequency.unit}", "largest"), rows
        )


@made_once
def _contraction(system: System) -> ca.Function:
    """Derivatives of ``y^T (df/dx) v`` by states and parameters."""
    x, theta, _, _ = system.inputs
    y, v = (ca.SX.sym(name, len(system.state_names)) for name in "yv")
    product = ca.dot(y, ca.jtimes(system.rates, x, v))
    slopes = ca.densify(ca.gradient(product, ca.vertcat(x, theta)))
    return ca.Function("contraction", [*system.inputs, y, v], [slopes])


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
    left = np.hstack([left_vectors(modes), left_vectors(modes, decays=True)])
    function = _contraction(system)

    def contract(a: Real, b: Real, settings: Real) -> Real:
        both = [np.repeat(np.c_[part], a.shape[1], axis=1) for part in (point.theta, settings)]
        states = np.repeat(np.c_[point.x], a.shape[1], axis=1)
        times = np.full((1, a.shape[1]), point.time)
        return np.asarray(function(states, both[0], times, both[1], a, b)).T

    def slopes(settings: Real) -> Complex:
        """Derivatives of the eigenvalues by states and parameters."""
        real = contract(left.real, right.real, settings)
        real = real + contract(left.imag, right.imag, settings)
        imaginary = contract(left.real, right.imag, settings)
        imaginary = imaginary - contract(left.imag, right.real, settings)
        return real + 1j * imaginary

    both = slopes(point.settings)
    matters = point_matters(point, both / np.abs(values)[:, None], _ROUNDING)
    moved = find_moved_point(point, places) if matters else None
    moving = moved is not None
    moved = moved or still_point(point, places)
    refuse_kinks(point, moved, names, slopes)
    found: Complex = moved.through(both)
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
    part = parts(modes)[np.abs(vectors).argmax(axis=0)]
    close = np.abs(values[:, None] - values[None, :]) <= _REPEATED * np.abs(values)[:, None]
    close &= (part[:, None] == part[None, :]) & ~np.eye(len(values), dtype=bool)
    critical = (2 * np.abs(values.imag) <= _REPEATED * np.abs(values)) & (values.imag != 0)
    return np.flatnonzero(close.any(axis=1) | critical)
