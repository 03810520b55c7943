"""Cycles to failure over the amplitude of a cycle, and how the mean of a cycle counts.

Sources: Haibach, Betriebsfestigkeit (slope below the knee); Dowling, Mean stress effects in
stress-life and strain-life fatigue, SAE 2004-01-2227 (Goodman, Gerber, Smith-Watson-Topper,
Walker); FKM-Richtlinie, Rechnerischer Festigkeitsnachweis für Maschinenbauteile (Haigh diagram with
the mean-stress sensitivity M).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from lumped.errors import OptionError, shown
from lumped.functionals.damage_law import DamageLaw, MeanStress
from lumped.kernel.cycles import FKM, GERBER, GOODMAN, SMITH_WATSON_TOPPER, WALKER
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.units import plain
from lumped.timeloop.cycle_count import damage_of_cycles

Below = Literal["elementary", "original", "haibach"] | float
"""What holds below the knee; a number is a slope."""
Point = tuple[float | str, float]
"""Amplitude, and cycles to failure."""


@dataclass(frozen=True)
class SNCurve:
    """Cycles to failure over the amplitude: ``N = cycles (knee / amplitude)^slope``.

    Parameters
    ----------
    knee : float or str
        Amplitude at the knee, or with a unit, such as ``"60 MPa"``.
    cycles : float
        Cycles to failure there.
    slope : float
        Slope above the knee; above the last point of `upper`, if there are some.
    below : {"elementary", "original", "haibach"} or float
        Below the knee: the same slope as above it (elementary Miner), no damage (original Miner),
        ``2 slope - 1`` (Haibach), or another slope.
    upper : sequence of (float or str, float)
        Amplitudes above the knee, ascending, and the cycles to failure there; between points the
        curve is straight in logarithmic scales.
    unit : str
        SI unit of the amplitudes.

    Raises
    ------
    OptionError
        If a number is not positive, the cycles do not fall where the amplitude rises, or the curve
        is steeper below the knee than above it.
    UnitError
        If an amplitude has a unit of another kind.
    """

    knee: float | str
    cycles: float
    slope: float
    below: Below = "elementary"
    upper: Sequence[Point] = ()
    unit: str = "Pa"

    def __post_init__(self) -> None:
        def put(name: str, value: Any, unit: str = "1") -> None:
            object.__setattr__(self, name, _positive(name, value, unit))

        put("knee", self.knee, self.unit)
        put("cycles", self.cycles)
        put("slope", self.slope)
        object.__setattr__(self, "upper", check_points(self.upper, "upper", self.unit))
        _check_order(self.points, self.unit)
        if not isinstance(self.below, str):
            put("below", self.below)
        elif self.below not in ("elementary", "original", "haibach"):
            raise OptionError(
                f"SNCurve: below = {self.below!r}: 'elementary', 'original', 'haibach' or a slope."
            )
        lower, above = self.slope_below, self.slopes[0]
        if lower is not None and lower < above:
            raise OptionError(
                f"SNCurve: the slope {lower:g} below the knee (below = {self.below!r}) must be at "
                f"least that above it, {above:g}: small cycles do no more than by its law."
            )

    @classmethod
    @checked
    def of_points(
        cls, points: Sequence[Point], *, below: Below = "elementary", unit: str = "Pa"
    ) -> SNCurve:
        """Curve through points, straight between them in logarithmic scales.

        Above the highest amplitude its last slope goes on.

        Parameters
        ----------
        points : sequence of (float or str, float)
            Amplitudes and cycles to failure, in any order; the lowest amplitude is the knee.
        below : {"elementary", "original", "haibach"} or float
            What holds below the knee.
        unit : str
            SI unit of the amplitudes.

        Returns
        -------
        SNCurve

        Raises
        ------
        OptionError
            If there are less than two, or see `SNCurve`.
        UnitError
            If an amplitude has a unit of another kind.
        """
        found = sorted(check_points(points, "points", unit))
        if len(found) < 2:
            raise OptionError("SNCurve.of_points: at least two points are needed.")
        _check_order(found, unit)
        (knee, cycles), *upper = found
        return cls(knee, cycles, _slope(*found[-2:]), below, tuple(upper), unit)

    @property
    def points(self) -> tuple[tuple[float, float], ...]:
        """Amplitudes and cycles to failure, the knee first."""
        return ((float(self.knee), self.cycles), *self.upper)  # type: ignore[arg-type]

    @property
    def slopes(self) -> tuple[float, ...]:
        """Slope above each of the points."""
        return (*(_slope(a, b) for a, b in itertools.pairwise(self.points)), self.slope)

    @property
    def slope_below(self) -> float | None:
        """Slope below the knee; None if cycles there do no damage."""
        if not isinstance(self.below, str):
            return self.below
        above = self.slopes[0]
        return {"elementary": above, "original": None, "haibach": 2 * above - 1}[self.below]

    @property
    def extends_down(self) -> bool:
        """Whether cycles below the knee do damage: the first row of `table` holds there too."""
        return self.slope_below is not None

    @property
    def table(self) -> Real:
        """Amplitude, damage of one cycle there, and slope from there on, shape (m, 3).

        From each amplitude up to the next a cycle does
        ``damage (amplitude / amplitude of the row)^slope``.
        """
        rows = [(a, 1 / n, k) for (a, n), k in zip(self.points, self.slopes, strict=True)]
        if self.slope_below not in (None, self.slopes[0]):
            rows.insert(0, (*rows[0][:2], self.slope_below))
        return np.array(rows)

    def law(self, mean_stress: MeanStress | None = None, scale: float = 1.0) -> DamageLaw:
        """The curve as the count of cycles takes it."""
        rows = tuple(tuple(row) for row in self.table.tolist())
        return DamageLaw(rows, self.extends_down, mean_stress or MeanStress(), scale)

    @checked
    def damage(self, amplitudes: ArrayLike) -> Real:
        """Damage of one cycle of each amplitude at mean zero, ``1 / N``.

        Parameters
        ----------
        amplitudes : array_like
            In the unit of the knee, not negative.

        Raises
        ------
        OptionError
            If an amplitude is negative.
        """
        given = np.asarray(amplitudes, dtype=float)
        if (given < 0).any():
            raise OptionError(f"damage: amplitudes = {given.min():g} must not be negative.")
        flat = given.ravel()
        _, found = damage_of_cycles(2 * flat, 0 * flat, np.ones(len(flat)), self.law())
        return found[:, 0].reshape(given.shape)


def _positive(name: str, value: Any, unit: str, what: str = "SNCurve") -> float:
    found = plain(value, unit, f"{what}: {name} =", OptionError)
    if not 0 < found < math.inf:
        kind = "" if unit == "1" else f" {unit}"
        raise OptionError(f"{what}: {name} = {found:g}{kind} must be positive and finite.")
    return found


def check_points(
    given: Sequence[Point], name: str, unit: str, what: str = "SNCurve"
) -> tuple[tuple[float, float], ...]:
    """Amplitudes in a unit, and cycles to failure; errors begin with `what`.

    Raises
    ------
    OptionError
        If one is not a pair, or a number is not positive.
    UnitError
        If an amplitude has a unit of another kind.
    """
    found = []
    for i, point in enumerate(given):
        try:
            amplitude, cycles = point
        except (TypeError, ValueError):
            raise OptionError(
                f"{what}: {name}[{i}] = {shown(point)}: an amplitude and its cycles to failure "
                "are needed."
            ) from None
        where = f"{name}[{i}]"
        own = _positive(where, amplitude, unit, what), _positive(f"{where}[1]", cycles, "1", what)
        found.append(own)
    return tuple(found)


def _check_order(points: Sequence[tuple[float, float]], unit: str) -> None:
    for (a, n), (b, m) in itertools.pairwise(points):
        if not (a < b and n > m):
            raise OptionError(
                f"SNCurve: {n:g} cycles at {a:g} {unit}, then {m:g} at {b:g} {unit}: from the knee "
                "on amplitudes must rise, and the cycles to failure fall."
            )


def _slope(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Slope between two points."""
    return math.log(a[1] / b[1]) / math.log(b[0] / a[0])


@checked
def goodman(ultimate: float | str) -> MeanStress:
    """Goodman's line: ``amplitude / (1 - mean / ultimate)``.

    A mean in compression is no advantage.

    Parameters
    ----------
    ultimate : float or str
        Ultimate strength, Pa, or with a unit, such as ``"700 MPa"``.

    Returns
    -------
    MeanStress

    Raises
    ------
    OptionError
        If the strength is not positive.
    """
    return MeanStress(GOODMAN, _strength("goodman", ultimate))


@checked
def gerber(ultimate: float | str) -> MeanStress:
    """Gerber's parabola: ``amplitude / (1 - (mean / ultimate)^2)``.

    A mean in compression is no advantage.

    Parameters
    ----------
    ultimate : float or str
        Ultimate strength, Pa, or with a unit, such as ``"700 MPa"``.

    Returns
    -------
    MeanStress

    Raises
    ------
    OptionError
        If the strength is not positive.
    """
    return MeanStress(GERBER, _strength("gerber", ultimate))


def smith_watson_topper() -> MeanStress:
    """Smith, Watson and Topper: ``sqrt((mean + amplitude) amplitude)``; none in compression.

    Returns
    -------
    MeanStress
    """
    return MeanStress(SMITH_WATSON_TOPPER, 0.0)


@checked
def walker(exponent: float) -> MeanStress:
    """Walker: ``(mean + amplitude)^(1 - exponent) amplitude^exponent``; none in compression.

    Parameters
    ----------
    exponent : float
        Of the amplitude: 1 where means have no effect in tension, 0.5 as Smith, Watson and Topper.

    Returns
    -------
    MeanStress

    Raises
    ------
    OptionError
        If the exponent is not above 0 and at most 1.
    """
    if not 0 < exponent <= 1:
        raise OptionError(f"walker: exponent = {exponent:g} must be above 0 and at most 1.")
    return MeanStress(WALKER, exponent)


@checked
def fkm(sensitivity: float) -> MeanStress:
    """Haigh diagram of the FKM guideline, four straight lines.

    With the sensitivity M, the amplitude a, the mean m and the ratio R of the lowest to the highest
    stress: ``a (1 - M)`` in compression (R > 1), ``a + M m`` up to R = 0,
    ``(1 + M) / (1 + M/3) (a + M/3 m)`` up to R = 0.5, and ``a (1 + M)^2 / (1 + M/3)`` beyond.

    Parameters
    ----------
    sensitivity : float
        M; for normal stress in steel ``0.35e-3 R_m - 0.1`` with the tensile strength in MPa, for
        shear stress ``1 / sqrt(3)`` of it.

    Returns
    -------
    MeanStress

    Raises
    ------
    OptionError
        If the sensitivity is not between 0 and 1.
    """
    if not 0 <= sensitivity < 1:
        raise OptionError(f"fkm: sensitivity = {sensitivity:g} must be at least 0 and below 1.")
    return MeanStress(FKM, sensitivity)


def _strength(rule: str, ultimate: float | str) -> float:
    found = plain(ultimate, "Pa", f"{rule}: ultimate =", OptionError)
    if not 0 < found < math.inf:
        raise OptionError(f"{rule}: ultimate = {found:g} Pa must be positive and finite.")
    return found
