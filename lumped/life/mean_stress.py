"""How the mean of a cycle counts: rules that give the amplitude of equal damage at mean zero.

Sources: Dowling, Mean stress effects in stress-life and strain-life fatigue, SAE 2004-01-2227
(Goodman, Gerber, Smith-Watson-Topper, Walker); FKM-Richtlinie, Rechnerischer Festigkeitsnachweis
für Maschinenbauteile (Haigh diagram with the mean-stress sensitivity M).
"""

from __future__ import annotations

import math

from lumped.errors import OptionError
from lumped.functionals.damage_law import MeanStress
from lumped.kernel.cycles import FKM, GERBER, GOODMAN, SMITH_WATSON_TOPPER, WALKER
from lumped.support.arguments import checked
from lumped.support.units import plain


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
