"""Kinds of shaft sections by their geometry."""

from __future__ import annotations

import scipy

from lumped import Expr, Param, param
from lumped.components.shafts.shaft import Section
from lumped.errors import DeclarationError
from lumped.language.component import path_of
from lumped.language.declared import values_of
from lumped.language.expression import Number
from lumped.ops import minimum, pi

__all__ = ["Disc", "Hollow", "Keyed", "Solid", "Splined", "Taper"]


class _Uniform(Section):
    """Section of one diameter from end to end."""

    def heavy_diameter(self) -> Expr:
        """Outside diameter that counts for the inertia, m."""
        return self.ends()[0]

    def inertia(self) -> Expr:
        d, bore = self.heavy_diameter(), self.hole()
        return pi / 32 * self.rho * self.L * (d**4 - bore**4)


class Solid(_Uniform):
    """Solid cylinder: ``c = pi G d^4 / (32 L)``, ``J = pi rho d^4 L / 32``."""

    d: Param = param("m", "diameter", above=0)

    def ends(self) -> tuple[Expr, Expr]:
        return (d := self.d, d)


class Hollow(_Uniform):
    """Cylinder with a bore: ``c = pi G (d^4 - bore^4) / (32 L)``, J likewise."""

    bore: Param = param("m", "diameter of the bore", min=0)
    d: Param = param("m", "outside diameter", above=bore)

    def ends(self) -> tuple[Expr, Expr]:
        return (d := self.d, d)

    def hole(self) -> Expr:
        return self.bore


class Disc(Hollow):
    """Flange or coupling hub, a disc by diameter and length: ``J = pi rho (d^4 - bore^4) L / 32``.

    The bore is where there is no material; a hub on its shaft has none.
    """

    symbol = "inertia"
    bore: Param = param("m", "diameter of the bore", 0.0, min=0)
    d: Param = param("m", "outside diameter", above=bore)


class Keyed(_Uniform):
    """Shaft with one keyway: ``c = pi G (d - t)^4 / (32 L)``, ``J = pi rho d^4 L / 32``.

    Less the bore in both. The stress is that of ``d - t``, too.
    ``d - t`` is the circle that touches the bottom of the keyway: a convention, taken from no
    standard. `Keyway` gives the stress at its end.
    """

    bore: Param = param("m", "diameter of the bore", 0.0, min=0)
    t: Param = param("m", "depth of the keyway, less than the wall", min=0)
    d: Param = param("m", "diameter", above=bore + 2 * t)

    def ends(self) -> tuple[Expr, Expr]:
        return (d := self.d - self.t, d)

    def outside(self) -> tuple[Expr, Expr]:
        return self.d, self.d

    def hole(self) -> Expr:
        return self.bore

    def heavy_diameter(self) -> Expr:
        return self.d


class Splined(_Uniform):
    """Splined shaft: ``c = pi G d_root^4 / (32 L)``, ``J = pi rho ((d + d_root) / 2)^4 L / 32``.

    Less the bore in both. The stress is that of the root. A convention, taken from no standard.
    `SplineEnd` gives the stress at its end.
    """

    bore: Param = param("m", "diameter of the bore", 0.0, min=0)
    d_root: Param = param("m", "diameter at the root of the teeth", above=bore)
    d: Param = param("m", "outside diameter", min=d_root)

    def ends(self) -> tuple[Expr, Expr]:
        return (d := self.d_root, d)

    def outside(self) -> tuple[Expr, Expr]:
        return self.d, self.d

    def hole(self) -> Expr:
        return self.bore

    def heavy_diameter(self) -> Expr:
        return (self.d + self.d_root) / 2


_POINTS = 24
"""Points of Gauss's rule; its error is below 1e-12 for walls above a fifth of the larger one."""


class Taper(Section):
    """Cone from `d_a` to `d_b`, bored straight: ``c = G / integral(dx / I_p)``.

    Without a bore ``c = 3 pi G d_a^3 d_b^3 / (32 L (d_a^2 + d_a d_b + d_b^2))``; what a bore adds
    to the integral is taken by Gauss's rule. `stress` is that at the thin end.
    """

    symbol = "taper"
    bore: Param = param("m", "diameter of the bore", 0.0, min=0)
    d_a: Param = param("m", "outside diameter at flange a", above=bore)
    d_b: Param = param("m", "outside diameter at flange b", above=bore)
    soft: Param = param("1/m3", "integral of 1 / I_p", lambda t: t.integral(), above=0)

    def ends(self) -> tuple[Expr, Expr]:
        return self.d_a, self.d_b

    def hole(self) -> Expr:
        return self.bore

    def thin(self) -> Expr:
        return minimum(self.d_a, self.d_b)

    def softness(self) -> Expr:
        return self.soft

    def integral(self) -> Expr:
        """Integral of ``1 / I_p`` over the length, 1/m3."""
        return self.L * self._mean_softness(self.d_a, self.d_b, _POINTS)

    def inertia(self) -> Expr:
        a, b = self._levers(self.d_a, self.d_b)
        return pi / 32 * self.rho * self.L * (a + b)

    def shares(self, begin: float, end: float) -> tuple[Number, Number, Number, Number]:
        length, (p, q) = end - begin, (self._at(begin), self._at(end))
        soft: Number = 1.0
        if length < 1:
            if "soft" in values_of(self):
                raise DeclarationError(
                    f"{path_of(self)} (Taper): soft is given, but a cone that is cut into elements "
                    "needs it from its diameters. Give c instead."
                )
            soft = self.L * self._mean_softness(p, q, 4 + int(_POINTS * length)) / self.soft
        whole = sum(self._levers(self.d_a, self.d_b))
        heavy_a, heavy_b = (length * lever / whole for lever in self._levers(p, q))
        thin, thinnest = minimum(p, q), self.thin()
        modulus = self.polar_moment(thin) * thinnest / (self.polar_moment(thinnest) * thin)
        return length * soft, heavy_a, heavy_b, modulus

    def _at(self, place: float) -> Expr:
        return self.d_a + place * (self.d_b - self.d_a)

    def _mean_softness(self, p: Expr, q: Expr, count: int) -> Expr:
        """Mean of ``1 / I_p`` as d goes from p to q, with so many points for what a bore adds."""
        mean, hole4 = (p**2 + p * q + q**2) / (3 * p**3 * q**3), self.bore**4
        points, weights = scipy.special.roots_legendre(count)
        for point, weight in zip(points.tolist(), weights.tolist(), strict=True):
            d4 = (p + (q - p) * ((point + 1) / 2)) ** 4
            mean = mean + weight / 2 * hole4 / (d4 * (d4 - hole4))
        return 32 / pi * mean

    def _levers(self, p: Expr, q: Expr) -> tuple[Expr, Expr]:
        """Means of ``d^4 - bore^4`` as d goes from p to q, with weights that fall and that rise."""

        def lever(p: Expr, q: Expr) -> Expr:
            powers = 5 * p**4 + 4 * p**3 * q + 3 * p**2 * q**2 + 2 * p * q**3 + q**4
            return powers / 30 - self.bore**4 / 2

        return lever(p, q), lever(q, p)
