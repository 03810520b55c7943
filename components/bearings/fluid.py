"""Viscosity over temperature, and a magnitude without a kink."""

from __future__ import annotations

from lumped import Expr
from lumped.language.expression import Datum, Number
from lumped.ops import exp, log, sqrt

__all__ = ["magnitude", "viscosity"]

_T_40, _T_100 = 313.15, 373.15


def viscosity(T: Expr, nu_40: Number, nu_100: Number) -> Expr:
    """Kinematic viscosity of an oil: ``log(log(nu + 0.8)) = A - B log(T)``, nu in mm2/s.

    The straight line of Ubbelohde and Walther through the viscosities at 40 and 100 degrees
    Celsius (DIN 51563:2011). For ISO VG 46, `nu_40` is 46e-6 m2/s.

    Parameters
    ----------
    T : expression
        Temperature, K.
    nu_40, nu_100 : float or expression
        At 40 and 100 degrees Celsius, m2/s.

    Returns
    -------
    Expr
        In m2/s.
    """

    def ordinate(nu: Number) -> Expr:
        return log(log(Datum(1e6) * nu + 0.8))

    share = log(T / Datum(_T_40)) / log(Datum(_T_100) / _T_40)
    at_40 = ordinate(nu_40)
    return Datum(1e-6) * (exp(exp(at_40 + share * (ordinate(nu_100) - at_40))) - 0.8)


def magnitude(x: Expr, small: float) -> Expr:
    """``sqrt(x^2 + small^2)``: the magnitude, rounded off at zero.

    A root of it has a derivative everywhere. It is 5e-7 too large at a thousand times `small`.

    Parameters
    ----------
    x : expression
        A number.
    small : float
        Its value at zero.

    Returns
    -------
    Expr
    """
    return sqrt(x * x + small**2)
