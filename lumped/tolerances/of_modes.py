"""Natural frequencies and damping ratios at many values of parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from lumped.errors import OptionError, SolverError
from lumped.functionals.readings import Clearance, Damping, Frequency, Reading
from lumped.tolerances.evaluated import Array, Evaluated, Failures, one_by_one
from lumped.vibration.natural.eigen_sensitivity import eigen_sensitivity
from lumped.vibration.natural.find_modes import modes
from lumped.vibration.natural.mode_designs import ManyModes, ModeDesigns, ModesOfMany
from lumped.vibration.natural.modes import Modes
from lumped.vibration.natural.spectrum import damping_slopes, hertz_slopes, second_derivatives


class OfModes(Evaluated):
    """Readings of modes (see `Evaluated`).

    Parameters
    ----------
    begin : Modes
        Those of the nominal drive.
    names : tuple of str
        What varies.
    of : sequence of Reading
    analysis : str
        With which errors begin.
    """

    def __init__(
        self, begin: Modes, names: tuple[str, ...], of: Sequence[Reading], analysis: str
    ) -> None:
        self._begin, self._names, self._of = begin, names, tuple(of)
        self._system, self._base = begin.system, begin.point.parameters
        self._designs = ModeDesigns(begin)
        self._many, count = ModesOfMany(self._designs, names), len(begin.hertz)
        for functional in of:
            if isinstance(functional, Frequency | Damping) and not 0 <= functional.mode < count:
                raise OptionError(
                    f"{analysis}: {functional}: the modes are 0 to {count - 1}, counted from the "
                    "lowest."
                )
            if isinstance(functional, Clearance) and not (
                functional.excitations and min(functional.excitations) > 0
            ):
                raise OptionError(f"{analysis}: {functional}: give positive frequencies in Hz.")

    def values(self, x: Array) -> tuple[Array, Failures]:
        """Functionals of all designs."""
        found = np.full((len(x), len(self._of)), np.nan)
        if self._many.applies:
            many = self._many.modes(x)
            for k, wanted in enumerate(self._of):
                found[:, k] = _values(wanted, many.hertz, many.damping)
        return found, self._alone(x, [found], lambda row: [self._values(self._modes(row))])

    def slopes(self, x: Array) -> tuple[Array, Array, Failures]:
        """Functionals and derivatives of all designs."""
        found = np.full((len(x), len(self._of)), np.nan)
        by = np.full((*found.shape, len(self._names)), np.nan)
        if self._many.applies:
            many = self._many.modes(x)
            used = [_mode_of(wanted, many.hertz) for wanted in self._of]
            for k, (wanted, (mode, side)) in enumerate(zip(self._of, used, strict=True)):
                found[:, k] = _values(wanted, many.hertz, many.damping)
                for own in np.unique(mode):
                    mine = mode == own
                    part = ManyModes(many.eigenvalues[mine])
                    slopes = self._many.slopes(x[mine], part, [int(own)])
                    through = damping_slopes if isinstance(wanted, Damping) else hertz_slopes
                    slope = through(part.eigenvalues[:, [own]], slopes)[:, 0]
                    by[mine, k] = side[mine, None] * slope
        failures = self._alone(x, [found, by], self._with_slopes)
        return found, by, failures

    def curvatures(self, x: Array) -> Array | None:
        """Second derivatives of modes whose state matrix depends on parameters alone."""
        if not self._many.applies:
            return None
        found, hertz = [], self._many.modes(x[None]).hertz[0]
        for wanted in self._of:
            mode, side = slope_of_modes(wanted, hertz)
            own = self._many.curvatures(x, mode)
            if own is None:
                return None
            found.append(side * second_derivatives(*own, of_damping=isinstance(wanted, Damping)))
        return np.array(found)

    def _alone(self, x: Array, found: list[Array], one: Callable[[Array], list[Array]]) -> Failures:
        """Fill in designs that must be looked at alone."""
        left = np.flatnonzero(
            np.any([np.isnan(part).reshape(len(x), -1).any(axis=1) for part in found], axis=0)
        )
        results, failures = one_by_one(x[left], [part.shape[1:] for part in found], one)
        for part, result in zip(found, results, strict=True):
            part[left] = result
        return {int(left[i]): text for i, text in failures.items()}

    def _modes(self, row: Array) -> Modes:
        values = self._base | dict(zip(self._names, row.tolist(), strict=True))
        found = modes(self._system, at=self._designs.point(values))
        if len(found.hertz) != len(self._begin.hertz):
            raise SolverError(
                f"{self._system.name}: there are {len(found.hertz)} oscillating modes instead of "
                f"{len(self._begin.hertz)}: one became a decay or the reverse.",
                None,
            )
        return found

    def _values(self, found: Modes) -> Array:
        each = self._of
        return np.array([value_of_modes(f, found.hertz, found.damping) for f in each])

    def _with_slopes(self, row: Array) -> list[Array]:
        found = self._modes(row)
        by = eigen_sensitivity(found, by=self._names)
        slopes = []
        for wanted in self._of:
            mode, side = slope_of_modes(wanted, found.hertz)
            if mode in by.repeated:
                raise SolverError(
                    f"{self._system.name}: mode {mode} ({found.hertz[mode]:.6g} Hz) coincides with "
                    "another and has no derivative.",
                    None,
                )
            own = by.damping if isinstance(wanted, Damping) else by.hertz
            slopes.append(side * own[mode])
        return [self._values(found), np.array(slopes)]


def value_of_modes(wanted: Reading, hertz: Array, damping: Array) -> float:
    """A functional of natural frequencies, Hz, and damping ratios, both of shape (m,)."""
    return float(_values(wanted, hertz[None], damping[None])[0])


def slope_of_modes(wanted: Reading, hertz: Array) -> tuple[int, float]:
    """The mode by whose frequency, or damping ratio, a functional changes, and how fast."""
    mode, side = _mode_of(wanted, hertz[None])
    return int(mode[0]), float(side[0])


def _values(wanted: Reading, hertz: Array, damping: Array) -> Array:
    """A functional of many designs, whose modes have the shape (n, m)."""
    if isinstance(wanted, Clearance):
        found: Array = np.abs(_away(wanted, hertz)).min(axis=(1, 2))
        return found
    assert isinstance(wanted, Frequency | Damping)
    return (hertz if isinstance(wanted, Frequency) else damping)[:, wanted.mode]


def _mode_of(wanted: Reading, hertz: Array) -> tuple[NDArray[np.intp], Array]:
    """The mode by which a functional changes, and how fast, of many designs."""
    n = len(hertz)
    if isinstance(wanted, Frequency | Damping):
        return np.full(n, wanted.mode), np.ones(n)
    assert isinstance(wanted, Clearance)
    away = _away(wanted, hertz).reshape(n, -1)
    nearest = np.abs(away).argmin(axis=1)
    mode, number = np.divmod(nearest, len(wanted.excitations))
    return mode, np.sign(away[np.arange(n), nearest]) / np.array(wanted.excitations)[number]


def _away(wanted: Clearance, hertz: Array) -> Array:
    """Relative distances of modes from excitations, shape (n, modes, excitations)."""
    found: Array = hertz[:, :, None] / np.array(wanted.excitations) - 1
    return found
