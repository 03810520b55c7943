"""Limits of torsional stress in shafts of reciprocating engines and their generators.

After the Rules for the Classification of Steel Ships of the Korean Register, 2025, Pt 5 Ch 4, whose
text was read. They hold where a crankshaft is not calculated in detail (IACS UR M53).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.support.arrays import Real
from lumped.vibration.rules.limits import Limit
from lumped.vibration.rules.marine_rule import barred_about
from lumped.vibration.speeds.campbell import BarredRange

EngineShaftKind = Literal["main engine", "generating set", "generator"]
Firing = Literal["four strokes", "others"]

_FALL_AND_LEAST = {"four strokes": (24.0, 21.0), "others": (29.0, 16.0)}
"""How far the limit of a main engine falls up to its rated speed, and the limit there, MPa."""
_NEAR = 1e-12


@dataclass(frozen=True)
class EngineShaft:
    """A crankshaft or generator shaft, and its permitted torsional vibration stresses, MPa.

    With ``x`` the speed over the rated speed; the second number of a pair is that of two strokes,
    and of vees of four strokes whose firing intervals are neither 45 nor 60 degrees::

        crankshaft of a main engine (201)
            tau_1 = 45 - 24 x^2  or  45 - 29 x^2,                       x <= 1
            tau_1 = 21 or 16, + 237 (x - 0.8) sqrt(x - 1),              1 < x <= 1.15
            tau_2 = 2 tau_1,                                            x <= 0.8
        crankshaft of a generating set (203.1)
            tau_1 = 21 or 16,                                           0.9 <= x <= 1.1
            tau_2 = 90,                                                 x <= 0.9
        shaft of its generator (203.2)
            tau_1 = 31, tau_2 = 118,                                    as above

    tau_1 holds in continuous operation, tau_2 where a range is passed quickly. A tensile strength T
    above 440 MPa raises tau_1 by ``1 + 2/3 (T/440 - 1)``, a yield stress Y above 225 MPa raises
    tau_2 by ``Y/225`` (201.4). The range barred about a critical speed is that of `MarineShaft`
    (206.1).

    Parameters
    ----------
    rated : float
        Maximum continuous speed, rad/s.
    kind : {"main engine", "generating set", "generator"}
        Which shaft.
    firing : {"four strokes", "others"}
        Four strokes in line, or in vee with firing intervals of 45 or 60 degrees; or the others.
    tensile, yield_stress : float
        Specified least tensile strength and yield stress, Pa. Of carbon steel above 590 MPa, and of
        low-alloy steel above 835 MPa, the society decides what counts.

    Raises
    ------
    OptionError
        If a value is not positive, looks like one in MPa or 1/min, or is none of those named.
    """

    rated: float
    kind: EngineShaftKind = "main engine"
    firing: Firing = "four strokes"
    tensile: float = 440e6
    yield_stress: float = 225e6

    def __post_init__(self) -> None:
        for name, low, high, unit in (
            ("rated", 1e-2, 1e5, "rad/s"),
            ("tensile", 5e7, 835e6, "Pa"),
            ("yield_stress", 5e7, self.tensile, "Pa"),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise OptionError(
                    f"EngineShaft: {name} = {value:g} {unit} must lie between {low:g} and {high:g} "
                    f"{unit}."
                )
        for name, kinds in (("kind", get_args(EngineShaftKind)), ("firing", get_args(Firing))):
            if getattr(self, name) not in kinds:
                raise OptionError(
                    f"EngineShaft: {name} = {getattr(self, name)!r}; one of {', '.join(kinds)} is "
                    "needed."
                )

    @property
    def _is_main(self) -> bool:
        return self.kind == "main engine"

    def _share(self, speeds: ArrayLike, low: float, high: float) -> Real:
        x: Real = np.asarray(speeds, dtype=float) / self.rated
        bad = np.ravel(x)[~((np.ravel(x) >= low - _NEAR) & (np.ravel(x) <= high + _NEAR))]
        if len(bad):
            raise OptionError(
                f"EngineShaft: {bad[0] * self.rated:g} rad/s is {bad[0]:.4g} of the rated speed; "
                f"the rule holds from {low:g} to {high:g}."
            )
        return x

    def continuous(self, speeds: ArrayLike) -> Real:
        """Permitted stress amplitude in continuous operation, Pa.

        Parameters
        ----------
        speeds : array_like
            rad/s.

        Raises
        ------
        OptionError
            If a speed lies outside those of the rule.
        """
        x = self._share(speeds, *self._continuous_range)
        fall, least = _FALL_AND_LEAST[self.firing]
        if self._is_main:
            beyond = np.maximum(x - 1, 0.0)
            base = np.where(x <= 1, 45 - fall * x**2, least + 237 * (x - 0.8) * np.sqrt(beyond))
        else:
            base = np.full(x.shape, 31.0 if self.kind == "generator" else least)
        found: Real = 1e6 * base * (1 + 2 / 3 * (max(self.tensile / 440e6, 1.0) - 1))
        return found

    def transient(self, speeds: ArrayLike) -> Real:
        """Permitted stress amplitude where a barred range is passed quickly, Pa.

        Parameters
        ----------
        speeds : array_like
            rad/s.

        Raises
        ------
        OptionError
            If a speed lies outside those of the rule.
        """
        x = self._share(speeds, 0.0, self._last_passed)
        fall, _ = _FALL_AND_LEAST[self.firing]
        if self._is_main:
            base = 2 * (45 - fall * x**2)
        else:
            base = np.full(x.shape, 118.0 if self.kind == "generator" else 90.0)
        found: Real = 1e6 * base * max(self.yield_stress / 225e6, 1.0)
        return found

    @property
    def _continuous_range(self) -> tuple[float, float]:
        return (0.0, 1.15) if self._is_main else (0.9, 1.1)

    @property
    def _last_passed(self) -> float:
        return 0.8 if self._is_main else 0.9

    def barred(self, critical: float) -> BarredRange:
        """Barred range around a critical speed, rad/s."""
        return barred_about(critical, self.rated)

    def limits(self, stress: Name) -> tuple[Limit, Limit]:
        """Limits of a stress in continuous operation and in passing.

        Parameters
        ----------
        stress : name
            Torsional stress of the shaft, Pa.
        """
        clause = "201" if self._is_main else "203"
        source = f"read in KR Rules for Steel Ships 2025, 5-4-{clause}"
        first, last = self._continuous_range
        return (
            Limit(
                stress,
                self.continuous,
                "continuous operation",
                clause="tau_1",
                source=source,
                speeds=(first * self.rated, last * self.rated),
                barred=self.barred,
            ),
            Limit(
                stress,
                self.transient,
                "transient passage",
                clause="tau_2",
                source=source,
                speeds=(0.0, self._last_passed * self.rated),
                advice="too much even to pass quickly, so barring does not help",
            ),
        )
