"""Natural frequencies and damping ratios at many values of parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from lumped.errors import OptionError, SolverError
from lumped.simulation.functional_kinds import Clearance, Damping, Frequency, Modal, unit_of
from lumped.tolerances.evaluated import Array, Failures, one_by_one
from lumped.vibration.eigen_sensitivity import eigen_sensitivity
from lumped.vibration.mode_designs import ModeDesigns
from lumped.vibration.modes import Modes, modes

__all__ = ["OfModes", "slope_of_modes", "value_of_modes"]


class OfModes:
    """Functionals of modes (see `Evaluated`).

    Parameters
    ----------
    begin : Modes
        Those of the nominal drive.
    names : tuple of str
        What varies.
    of : mapping of str to functional
    analysis : str
        With which errors begin.
    """

    def __init__(
        self, begin: Modes, names: tuple[str, ...], of: Mapping[str, Modal], analysis: str
    ) -> None:
        self._begin, self._names, self._of = begin, names, dict(of)
        self._system, self._base = begin.system, begin.point.parameters
        self._designs, count = ModeDesigns(begin), len(begin.hertz)
        for functional in of.values():
            if isinstance(functional, Frequency | Damping) and not 0 <= functional.mode < count:
                raise OptionError(
                    f"{analysis}: {functional}: the modes are 0 to {count - 1}, counted from the "
                    "lowest."
                )
            if isinstance(functional, Clearance) and not (
                functional.excitations and min(functional.excitations) > 0
            ):
                raise OptionError(f"{analysis}: {functional}: give positive frequencies in Hz.")
        self.labels = tuple(of)
        self.units = tuple(unit_of(begin.system, f) for f in of.values())

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
        each = self._of.values()
        return np.array([value_of_modes(f, found.hertz, found.damping) for f in each])

    def values(self, x: Array) -> tuple[Array, Failures]:
        """Functionals of all designs."""
        (values,), failures = one_by_one(
            x, [(len(self._of),)], lambda row: [self._values(self._modes(row))]
        )
        return values, failures

    def slopes(self, x: Array) -> tuple[Array, Array, Failures]:
        """Functionals and derivatives of all designs."""
        k, d = len(self._of), len(self._names)

        def one(row: Array) -> list[Array]:
            found = self._modes(row)
            by = eigen_sensitivity(found, to=self._names)
            slopes = []
            for wanted in self._of.values():
                mode, side = slope_of_modes(wanted, found.hertz)
                own = by.damping if isinstance(wanted, Damping) else by.hertz
                slopes.append(side * own[mode])
            return [self._values(found), np.array(slopes)]

        (values, slopes), failures = one_by_one(x, [(k,), (k, d)], one)
        return values, slopes, failures

    def curvature(self, x: Array, k: int) -> Array:
        """Second derivatives of modes."""
        raise OptionError("modes: second derivatives are not formed yet.")


def value_of_modes(wanted: Modal, hertz: Array, damping: Array) -> float:
    """A functional of natural frequencies, Hz, and damping ratios."""
    if isinstance(wanted, Clearance):
        return abs(_nearest(wanted, hertz)[2])
    return float((hertz if isinstance(wanted, Frequency) else damping)[wanted.mode])


def slope_of_modes(wanted: Modal, hertz: Array) -> tuple[int, float]:
    """The mode by whose frequency, or damping ratio, a functional changes, and how fast."""
    if isinstance(wanted, Clearance):
        mode, number, away = _nearest(wanted, hertz)
        return mode, math.copysign(1 / wanted.excitations[number], away)
    return wanted.mode, 1.0


def _nearest(wanted: Clearance, hertz: Array) -> tuple[int, int, float]:
    """Mode, excitation and relative distance of the two that are nearest."""
    away = hertz[:, None] / np.array(wanted.excitations) - 1
    mode, number = np.unravel_index(np.abs(away).argmin(), away.shape)
    return int(mode), int(number), float(away[mode, number])
