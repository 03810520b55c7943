"""Loads and life of rolling bearings.

Source: ISO 281:1990, Rolling bearings, Dynamic load ratings and rating life (life of other
reliabilities by a Weibull distribution of slope 1.5); ISO 76, Static load ratings. The factor of
the temperature is that of bearing catalogues.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from lumped.errors import OptionError
from lumped.functionals.functional import Functional
from lumped.language.expression import Expr
from lumped.life.equivalent_load import ROLLER, check_exponent
from lumped.ops import where
from lumped.support.arguments import checked
from lumped.support.units import plain

Force = TypeVar("Force", float, Expr)
Sum = TypeVar("Sum", float, Functional)

_HOT = (
    *((120, 1.0), (125, 0.95), (150, 0.90), (175, 0.85), (200, 0.80), (225, 0.75), (250, 0.70)),
    (300, 0.60),
)
"""Temperatures in degree Celsius, and the dynamic load rating over that of a cold bearing."""
_CELSIUS = 273.15
_WEIBULL = 1.5


@dataclass(frozen=True)
class Bearing:
    """Rolling bearing by the numbers of its catalogue.

    The equivalent dynamic load is ``X_1 F_r + Y_1 F_a`` where ``F_a <= e F_r``, else
    ``X_2 F_r + Y_2 F_a``; the static one is ``F_r + Y_0 F_a``. The defaults of X and of the
    exponent are those of double-row taper roller bearings.

    Parameters
    ----------
    dynamic, static : float or str
        Load ratings C and C_0, N, or with a unit, such as ``"1.2 MN"``.
    e : float
        Axial over radial load at which the other pair of factors begins.
    Y_1, Y_2, Y_0 : float
        Factors of the axial load.
    X_1, X_2 : float
        Factors of the radial load.
    exponent : float
        Of the life: 10/3 for rollers, 3 for balls.
    """

    dynamic: float | str
    static: float | str
    e: float
    Y_1: float
    Y_2: float
    Y_0: float
    X_1: float = 1.0
    X_2: float = 0.67
    exponent: float = ROLLER

    def __post_init__(self) -> None:
        for name in ("dynamic", "static"):
            value = plain(getattr(self, name), "N", f"Bearing: {name} =", OptionError)
            if not 0 < value < math.inf:
                raise OptionError(f"Bearing: {name} = {value:g} N must be positive and finite.")
            object.__setattr__(self, name, value)
        if not self.e > 0:
            raise OptionError(f"Bearing: e = {self.e:g} must be positive.")
        check_exponent(self.exponent, "Bearing")

    def dynamic_load(self, radial: Force, axial: Force) -> Force:
        """Equivalent dynamic load of forces, numbers or expressions of a run.

        Parameters
        ----------
        radial, axial : float or expression
            Forces, N; their signs do not matter.

        Returns
        -------
        float or expression
            N.
        """
        radial, axial = abs(radial), abs(axial)
        weak = self.X_1 * radial + self.Y_1 * axial
        strong = self.X_2 * radial + self.Y_2 * axial
        if isinstance(weak, Expr):
            return where(axial <= self.e * radial, weak, strong)
        return weak if axial <= self.e * radial else strong

    def static_load(self, radial: Force, axial: Force) -> Force:
        """Equivalent static load of forces, to be compared with `static`.

        Parameters
        ----------
        radial, axial : float or expression
            Forces, N; their signs do not matter.

        Returns
        -------
        float or expression
            N.
        """
        return abs(radial) + self.Y_0 * abs(axial)

    def revolutions(self, load: Sum) -> Sum:
        """Life that 90 per cent of the bearings reach: ``1e6 (C / P)^p`` revolutions.

        Shocks and heat count as a load that is larger by f_p / f_t, another reliability as a life
        that is longer by `reliability_factor`.

        Parameters
        ----------
        load : float or Functional
            Equivalent dynamic load, N, such as that of a run by `equivalent_load`.

        Returns
        -------
        float or Functional

        Raises
        ------
        OptionError
            If the load is a number that is not positive.
        """
        load = _positive("load", load, "N")
        found: Sum = 1e6 * (float(self.dynamic) / load) ** self.exponent
        return found

    def hours(self, load: Sum, *, speed: float | Sum) -> Sum:
        """Life that 90 per cent of the bearings reach, h.

        Parameters
        ----------
        load : float or Functional
            Equivalent dynamic load, N, such as that of a run by `equivalent_load`.
        speed : float or Functional
            Speed, rad/s, such as that of a run by `mean_speed`.

        Returns
        -------
        float or Functional

        Raises
        ------
        OptionError
            If one of them is a number that is not positive.
        """
        speed = _positive("speed", speed, "rad/s")
        return self.revolutions(load) * (2 * math.pi / 3600) / speed


def _positive(name: str, value: Any, unit: str) -> Any:
    """A functional, or a number or a text with a unit that is above zero."""
    if isinstance(value, Functional):
        return value
    found = plain(value, unit, f"Bearing: {name} =", OptionError)
    if not found > 0:
        raise OptionError(f"Bearing: {name} = {found:g} {unit} must be positive.")
    return found


@checked
def reliability_factor(percent: float) -> float:
    """Life that a share of bearings reaches, over that which 90 per cent reach, a_1.

    ``(ln(1/S) / ln(1/0.9))^(1/1.5)``: 1, 0.62, 0.53, 0.44, 0.33 and 0.21 for 90 and 95 to 99 per
    cent, as the tables say.

    Parameters
    ----------
    percent : float
        Share of the bearings, per cent.

    Returns
    -------
    float

    Raises
    ------
    OptionError
        If it is not at least 90 and below 100.
    """
    if not 90 <= percent < 100:
        raise OptionError(f"reliability_factor: percent = {percent:g}: 90 to less than 100.")
    return float((math.log(percent / 100) / math.log(0.9)) ** (1 / _WEIBULL))


@checked
def temperature_factor(temperature: float | str) -> float:
    """Dynamic load rating of a hot bearing over that of a cold one, f_t.

    1 up to 120 degrees Celsius, 0.60 at 300, straight between the values of the table.

    Parameters
    ----------
    temperature : float or str
        K, or with a unit, such as ``"150 degC"``.

    Returns
    -------
    float

    Raises
    ------
    OptionError
        If it is above 300 degrees Celsius.
    """
    found = plain(temperature, "K", "temperature_factor: temperature =", OptionError) - _CELSIUS
    if not found <= _HOT[-1][0]:
        raise OptionError(f"temperature_factor: {found:g} degC: the table ends at 300 degC.")
    degrees, factors = np.array(_HOT).T
    return float(np.interp(found, degrees, factors))
