"""Limits of torsional stress in propulsion shafts of ships.

After IACS UR M68, as the Korean Register has it in its Rules for the Classification of Steel Ships,
2025, Pt 5 Ch 4, 202 and 206, whose text was read. READ marks what stands there, USER INPUT what the
user must give, and NOT IMPLEMENTED what is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.support.arrays import Real
from lumped.vibration.rules.limits import Limit
from lumped.vibration.speeds.campbell import BarredRange

_SOURCE = "IACS UR M68, read in KR Rules for Steel Ships 2025, 5-4-202"


def barred_about(critical: float, rated: float) -> BarredRange:
    """Barred range around a critical speed, rad/s: ``16 n/(18 - x)`` to ``(18 - x) n/16``."""
    x = critical / rated
    return BarredRange(16 * critical / (18 - x), (18 - x) * critical / 16)


@dataclass(frozen=True)
class MarineShaft:
    """A propulsion shaft and its permitted torsional vibration stresses.

    With ``x`` the speed over the rated speed, ``sigma`` the tensile strength in MPa and ``d`` the
    diameter in mm::

        c_D = 0.35 + 0.93 d^-0.2                                    READ
        tau_C = (sigma + 160) / 18 c_K c_D (3 - 2 x^2),  x < 0.9    READ
        tau_C = (sigma + 160) / 18 c_K c_D 1.38,  0.9 <= x <= 1.05  READ
        tau_T = 1.7 tau_C / sqrt(c_K),  x < 0.8                     READ
        c_K, sigma, d                                               USER INPUT
        hollow shafts                                               NOT IMPLEMENTED

    Parameters
    ----------
    d : float
        Diameter, m.
    tensile : float
        Tensile strength, Pa; no more of it counts than 600 MPa for carbon steel and for propeller
        and stern tube shafts, 800 MPa for intermediate and thrust shafts of low-alloy steel.
    rated : float
        Rated speed, rad/s.
    form_factor : float
        c_K: 1.0 for intermediate shafts with integral flange or shrink fit, 0.6 with a keyway of a
        tapered and 0.45 of a cylindrical seat, 0.5 with a radial hole, 0.3 with a longitudinal
        slot; 0.85 for thrust, 0.55 for propeller and 0.8 for stern tube shafts.

    Raises
    ------
    OptionError
        If a value is not positive, or looks like one in MPa, mm or 1/min.
    """

    d: float
    tensile: float
    rated: float
    form_factor: float = 1.0

    def __post_init__(self) -> None:
        for name, value, low, high, unit in (
            ("d", self.d, 1e-3, 10.0, "m"),
            ("tensile", self.tensile, 5e7, 5e9, "Pa"),
            ("rated", self.rated, 1e-2, 1e5, "rad/s"),
            ("form_factor", self.form_factor, 1e-2, 10.0, "1"),
        ):
            if not low <= value <= high:
                raise OptionError(
                    f"MarineShaft: {name} = {value:g} {unit} must lie between {low:g} and {high:g} "
                    f"{unit}."
                )

    @property
    def size_factor(self) -> float:
        """c_D, which falls with the diameter."""
        return float(0.35 + 0.93 * (1e3 * self.d) ** -0.2)

    def continuous(self, speeds: ArrayLike) -> Real:
        """Permitted stress amplitude in continuous operation, Pa.

        Parameters
        ----------
        speeds : array_like
            rad/s, above zero and up to 1.05 of the rated speed.

        Raises
        ------
        OptionError
            If a speed lies outside.
        """
        x = np.asarray(speeds, dtype=float) / self.rated
        bad = np.ravel(x)[~((np.ravel(x) > 0) & (np.ravel(x) <= 1.05 * (1 + 1e-12)))]
        if len(bad):
            raise OptionError(
                f"MarineShaft: {bad[0] * self.rated:g} rad/s is {bad[0]:.4g} of the rated speed; "
                "the rule holds above 0 and up to 1.05."
            )
        bracket = np.where(x < 0.9, 3 - 2 * x**2, 1.38)
        return 1e6 * (self.tensile / 1e6 + 160) / 18 * self.form_factor * self.size_factor * bracket

    def transient(self, speeds: ArrayLike) -> Real:
        """Permitted stress amplitude where a barred range is passed quickly, Pa."""
        found: Real = 1.7 * self.continuous(speeds) / np.sqrt(self.form_factor)
        return found

    def barred(self, critical: float) -> BarredRange:
        """Barred range around a critical speed, rad/s: ``16 n/(18 - x)`` to ``(18 - x) n/16``."""
        return barred_about(critical, self.rated)

    def limits(self, stress: Name) -> tuple[Limit, Limit]:
        """Limits of a stress in continuous operation and in passing.

        Parameters
        ----------
        stress : name
            Torsional stress of the shaft, Pa.
        """
        steady = self.continuous, "continuous operation"
        brief = self.transient, "transient passage"
        advice = "too much even to pass quickly, so barring does not help"
        return (
            Limit(stress, *steady, clause="tau_C", source=_SOURCE, barred=self.barred),
            Limit(stress, *brief, clause="tau_T", source=_SOURCE, advice=advice),
        )
