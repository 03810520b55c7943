"""Load terms of the friction of rolling bearings, by type.

Constants of deep groove and angular contact ball bearings: SKF, Rolling bearings, 2018 (the SKF
model for calculating the frictional moment, tables of geometric constants), as public programs have
them; the catalogue itself was not read. Each type is called with the radial and axial load, N, the
mean diameter, mm, and the speed, 1/min, and gives the variables of rolling and sliding friction; a
function of your own does as well.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields

from lumped import Expr
from lumped.components.bearings.fluid import magnitude
from lumped.errors import ParameterError
from lumped.language.expression import Datum
from lumped.ops import minimum, pi, sin, where

__all__ = ["DEEP_GROOVE", "AngularContact", "BearingType", "DeepGroove", "SphericalRoller"]

BearingType = Callable[[Expr, Expr, Expr, Expr], tuple[Expr, Expr]]
"""From radial load, axial load, mean diameter and speed to ``G_rr`` and ``G_sl``."""


_SMALL = 1e-9
"""Load, N, at which powers of it become straight lines: their slope has no bound at zero."""


class _Constants:
    """Constants that must be positive numbers."""

    def __post_init__(self) -> None:
        for field in fields(self):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if not (isinstance(value, int | float) and 0 < value < float("inf")):
                raise ParameterError(
                    f"{type(self).__name__}: {field.name} = {value!r} must be a positive, finite "
                    "number; take it from the catalogue of the bearing."
                )


@dataclass(frozen=True)
class DeepGroove(_Constants):
    """Deep groove ball bearing: ``G_rr = R1 d_m^1.96 (F_r + R2 F_a / sin(alpha))^0.54``.

    ``G_sl = S1 d_m^-0.145 (F_r^5 + S2 d_m^1.5 F_a^4 / sin(alpha))^(1/3)`` with the angle of
    contact ``alpha = 24.6 (F_a / C_0)^0.24`` in degrees. Without axial load,
    ``G_rr = R1 d_m^1.96 F_r^0.54`` and ``G_sl = S1 d_m^-0.26 F_r^(5/3)``; as `F_a` vanishes, G_sl
    jumps, as it does in the catalogue.

    Parameters
    ----------
    C_0 : float
        Basic static load rating, N.
    R1, R2, S1, S2 : float
        Geometric constants; for a series, ``DeepGroove(C_0, *DEEP_GROOVE["62"])``.
    """

    C_0: float
    R1: float
    R2: float
    S1: float
    S2: float

    def __call__(self, F_r: Expr, F_a: Expr, d_m: Expr, n: Expr) -> tuple[Expr, Expr]:
        """Variables of rolling and sliding friction."""
        loaded = F_a > 0
        F_r, axial = magnitude(F_r, _SMALL), magnitude(F_a, _SMALL)
        per_sine = Datum(1.0) / sin(pi / 180 * 24.6 * (axial / Datum(self.C_0)) ** 0.24)
        both = F_r + self.R2 * axial * per_sine
        G_rr = self.R1 * d_m**1.96 * where(loaded, both, F_r) ** 0.54
        thrust = F_r**5 + self.S2 * d_m**1.5 * axial**4 * per_sine
        G_sl = self.S1 * where(loaded, d_m**-0.145 * thrust ** (1 / 3), d_m**-0.26 * F_r ** (5 / 3))
        return G_rr, G_sl


DEEP_GROOVE: dict[str, tuple[float, float, float, float]] = {
    "2": (4.4e-7, 1.7, 2.00e-3, 100.0),
    "3": (4.4e-7, 1.7, 2.00e-3, 100.0),
    "42": (5.4e-7, 0.96, 3.00e-3, 40.0),
    "43": (5.4e-7, 0.96, 3.00e-3, 40.0),
    "60": (4.1e-7, 1.7, 3.73e-3, 14.6),
    "630": (4.1e-7, 1.7, 3.73e-3, 14.6),
    "62": (3.9e-7, 1.7, 3.23e-3, 36.5),
    "622": (3.9e-7, 1.7, 3.23e-3, 36.5),
    "63": (3.7e-7, 1.7, 2.84e-3, 92.8),
    "623": (3.7e-7, 1.7, 2.84e-3, 92.8),
    "64": (3.6e-7, 1.7, 2.43e-3, 198.0),
    "160": (4.3e-7, 1.7, 4.63e-3, 4.25),
    "161": (4.3e-7, 1.7, 4.63e-3, 4.25),
    "617": (4.7e-7, 1.7, 6.50e-3, 0.78),
    "618": (4.7e-7, 1.7, 6.50e-3, 0.78),
    "628": (4.7e-7, 1.7, 6.50e-3, 0.78),
    "637": (4.7e-7, 1.7, 6.50e-3, 0.78),
    "638": (4.7e-7, 1.7, 6.50e-3, 0.78),
    "619": (4.3e-7, 1.7, 4.75e-3, 3.6),
    "639": (4.3e-7, 1.7, 4.75e-3, 3.6),
}
"""R1, R2, S1 and S2 of deep groove ball bearings by series (SKF, Rolling bearings, 2018)."""


@dataclass(frozen=True)
class AngularContact(_Constants):
    """Single row angular contact ball bearing: ``G_rr = R1 d_m^1.97 (F_r + F_g + R2 F_a)^0.54``.

    ``G_sl = S1 d_m^0.26 ((F_r + F_g)^(4/3) + S2 F_a^(4/3))``. ``F_g = R3 d_m^4 n^2`` in rolling and
    ``S3 d_m^4 n^2`` in sliding friction: the centrifugal load of the balls.
    """

    R1: float = 5.03e-7
    R2: float = 1.97
    R3: float = 1.90e-12
    S1: float = 1.30e-2
    S2: float = 0.68
    S3: float = 1.91e-12

    def __call__(self, F_r: Expr, F_a: Expr, d_m: Expr, n: Expr) -> tuple[Expr, Expr]:
        """Variables of rolling and sliding friction."""
        F_r, F_a = magnitude(F_r, _SMALL), magnitude(F_a, _SMALL)
        ball = d_m**4 * n**2
        G_rr = self.R1 * d_m**1.97 * (F_r + self.R3 * ball + self.R2 * F_a) ** 0.54
        radial = (F_r + self.S3 * ball) ** (4 / 3)
        return G_rr, self.S1 * d_m**0.26 * (radial + self.S2 * F_a ** (4 / 3))


@dataclass(frozen=True)
class SphericalRoller(_Constants):
    """Spherical roller bearing: the smaller one of an elliptic and a line contact.

    ``G_rr = min(R1 d_m^1.85 (F_r + R2 F_a)^0.54, R3 d_m^2.3 (F_r + R4 F_a)^0.31)`` and
    ``G_sl = min(S1 d_m^0.25 (F_r^4 + S2 F_a^4)^(1/3), S3 d_m^0.94 (F_r^3 + S4 F_a^3)^(1/3))``.

    Parameters
    ----------
    R1, R2, R3, R4, S1, S2, S3, S4 : float
        Geometric constants of the series, from the catalogue.
    """

    R1: float
    R2: float
    R3: float
    R4: float
    S1: float
    S2: float
    S3: float
    S4: float

    def __call__(self, F_r: Expr, F_a: Expr, d_m: Expr, n: Expr) -> tuple[Expr, Expr]:
        """Variables of rolling and sliding friction."""
        F_r, F_a = magnitude(F_r, _SMALL), magnitude(F_a, _SMALL)
        G_rr: Expr = minimum(
            self.R1 * d_m**1.85 * (F_r + self.R2 * F_a) ** 0.54,
            self.R3 * d_m**2.3 * (F_r + self.R4 * F_a) ** 0.31,
        )
        G_sl: Expr = minimum(
            self.S1 * d_m**0.25 * (F_r**4 + self.S2 * F_a**4) ** (1 / 3),
            self.S3 * d_m**0.94 * (F_r**3 + self.S4 * F_a**3) ** (1 / 3),
        )
        return G_rr, G_sl
