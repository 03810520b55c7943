"""Notches of shafts in torsion: stress where the torque passes a fillet, keyway, hole or spline."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lumped import Component, Expr, Param, param
from lumped.components.shafts.notch import Notch
from lumped.components.shafts.sections import Splined
from lumped.components.shafts.shaft import neighbours
from lumped.errors import UnknownNameError, nearest, shown
from lumped.language.component import path_of
from lumped.ops import exp, interpolate, log, maximum, minimum, pi

__all__ = ["Fillet", "Keyway", "RadialHole", "SplineEnd"]


def _beside(choose: Callable[[Expr, Expr], Expr]) -> Any:
    """Default of a diameter: the smaller or larger one of the sections beside a notch."""

    def default(notch: Component) -> Expr | None:
        before, behind = neighbours(notch)
        at_a = None if before is None else before.outside()[1]
        at_b = None if behind is None else behind.outside()[0]
        if at_a is None or at_b is None:
            return at_b if at_a is None else at_a
        return choose(at_a, at_b)

    return default


def _pilkey(fillet: Fillet) -> Expr:
    t = (fillet.D - fillet.d) / 2
    steep, slim = t / fillet.r, 2 * t / fillet.D
    root = steep**0.5
    rows = (
        (0.905, 0.783, -0.075),
        (-0.437, -1.969, 0.553),
        (1.557, 1.073, -0.578),
        (-1.061, 0.171, 0.086),
    )
    C = [a + b * root + c * steep for a, b, c in rows]
    return C[0] + slim * (C[1] + slim * (C[2] + slim * C[3]))


def _norton(fillet: Fillet) -> Expr:
    ratios = (1.09, 1.20, 1.33, 2.00)
    ratio = minimum(maximum(fillet.D / fillet.d, ratios[0]), ratios[-1])
    A = interpolate(ratio, ratios, (0.90337, 0.83425, 0.84897, 0.86331))
    b = interpolate(ratio, ratios, (-0.12692, -0.21649, -0.23161, -0.23865))
    return A * (fillet.r / fillet.d) ** b


FITS = {"pilkey": _pilkey, "norton": _norton}
"""Notch factors of a fillet by name."""


class Fillet(Notch):
    """Fillet at a step from `D` to `d`: ``notch_stress = K_ts stress``, stress = 16 tau/(pi d^3).

    In a `Shaft` the diameters are those of the sections beside it. `fit` chooses the notch factor:

    * ``"pilkey"``, ``t = (D - d)/2``: ``K_ts = C1 + C2 (2t/D) + C3 (2t/D)^2 + C4 (2t/D)^3``, each C
      linear in ``sqrt(t/r)`` and ``t/r``, for ``0.25 <= t/r <= 4``; outside it is refused. Pilkey,
      Formulas for Stress, Strain, and Structural Matrices, Table 6-1 III, after Peterson; the book
      was not read, the coefficients stand in a public calculator (amesweb.info) and in several
      public source files.
    * ``"norton"``: ``K_ts = A (r/d)^b``, A and b linear in ``D/d`` between 1.09 and 2, beyond these
      the end values. Norton, Machine Design, app. on stress concentration; not read, confirmed in
      three public source files.

    The two agree within 5 % for ``D/d`` from 1.2 to 2, and differ by up to 14 % below.
    """

    fit: str = "pilkey"
    r: Param = param(
        "m",
        "radius of the fillet; the fit holds for t/r up to 4",
        min=lambda f: (f.D - f.d) / 8 if f.fit == "pilkey" else 1e-6 * f.d,
    )
    d: Param = param("m", "smaller diameter", _beside(minimum), above=0)
    D: Param = param(
        "m",
        "larger diameter; the fit holds for t/r from 0.25",
        _beside(maximum),
        min=lambda f: f.d + f.r / 2 if f.fit == "pilkey" else f.d,
    )

    def factor(self) -> Expr:
        if self.fit not in FITS:
            raise UnknownNameError(
                f"{path_of(self)} (Fillet): fit = {shown(self.fit)} is not known. "
                f"{nearest(str(self.fit), FITS)}"
            )
        return FITS[self.fit](self)

    def modulus(self) -> Expr:
        return pi / 16 * self.d**3


class Keyway(Notch):
    """End of an end-milled keyway: ``notch_stress = K_ts stress``, ``stress = 16 tau / (pi d^3)``.

    ``K_ts`` is the largest principal stress over the nominal shear stress of the full diameter, the
    larger of 3.4 at the surface and ``1.953 + 0.1434 y - 0.0021 y^2`` in the fillet at the bottom,
    ``y = 0.1 d / r``, for ``0.005 <= r/d <= 0.07``; outside it is refused. The keyway is d/4 wide
    and d/8 deep, its end is round, and there is no key in it. Pilkey, Formulas for Stress, Strain,
    and Structural Matrices, Table 6-1 IV 1, after Peterson; not read, confirmed in one public
    source file.
    """

    r: Param = param(
        "m",
        "radius at the bottom of the keyway; the fit holds for r/d from 0.005",
        lambda k: 0.0208 * k.d,
        min=lambda k: 0.005 * k.d,
    )
    d: Param = param(
        "m",
        "diameter of the shaft; the fit holds for r/d up to 0.07",
        _beside(minimum),
        min=lambda k: k.r / 0.07,
    )

    def factor(self) -> Expr:
        y = 0.1 * self.d / self.r
        return maximum(3.4, 1.953 + 0.1434 * y - 0.0021 * y**2)

    def modulus(self) -> Expr:
        return pi / 16 * self.d**3


class RadialHole(Notch):
    """Small hole across a shaft: ``notch_stress = 4 stress``, ``stress = tau / W``.

    ``W = pi (d^4 - bore^4) / (16 d)``.

    4 is the largest stress over the shear stress at a round hole in a wide plate (Kirsch, Z. VDI 42
    (1898) 797: ``3 p + p`` for tension p one way and pressure p the other). It holds for a hole
    much smaller than the shaft; beyond a tenth of the diameter, a bound chosen here, it is refused.
    No fit for larger holes could be verified: give their `K_ts` to a section.
    """

    bore: Param = param("m", "diameter of the bore", 0.0, min=0)
    d_hole: Param = param("m", "diameter of the hole", above=0)
    d: Param = param(
        "m",
        "diameter of the shaft, ten times that of the hole or more",
        _beside(minimum),
        min=lambda h: maximum(10 * h.d_hole, 1.001 * h.bore),
    )

    def factor(self) -> float:
        return 4.0

    def modulus(self) -> Expr:
        return pi / 16 * (self.d**4 - self.bore**4) / self.d


def _root(notch: Component) -> Expr | None:
    """Default of the diameter: the root of the spline beside a notch."""
    for section in neighbours(notch):
        if isinstance(section, Splined):
            return section.d_root
    return None


PROFILES = {"straight": 1.0, "serrated": 1.0, "involute": 0.75}
"""Share of the notch effect by the profile of a spline."""


class SplineEnd(Notch):
    """End of a spline: ``notch_stress = K_ts stress``, ``stress = 16 tau / (pi d_root^3)``.

    ``K_ts`` is the fatigue notch factor for torsion: the endurance of smooth shafts over that of
    splined ones, by which the amplitude of a stress counts. With ``b = exp(4.2e-7 (R_m / MPa)^2)``
    it is ``b`` for `profile` ``"straight"`` (parallel flanks, Keilwelle) and ``"serrated"``
    (Kerbzahnwelle), and ``1 + 0.75 (b - 1)`` for ``"involute"`` (Zahnwelle), at a root of 29 mm.
    For other diameters it is multiplied by ``K3(29 mm) / K3(d_root)``,
    ``K3 = 1 - 0.2 lg(K_ts) lg(d / 7.5 mm) / lg(20)`` up to 150 mm and constant beyond.

    Source: DIN 743-2, experimentally found notch factors; not read, confirmed in one public project
    (ME_Wellennachweis by Huss and Schulz), which takes for K3 the factor of bending in one of its
    versions (below 1 % of difference). The bound of R_m was chosen here.
    """

    profile: str = "involute"
    R_m: Param = param("Pa", "tensile strength of the part at its diameter", above=0, max=1.2e9)
    d_root: Param = param("m", "diameter at the root of the teeth", _root, min=7.5e-3)

    def factor(self) -> Expr:
        if self.profile not in PROFILES:
            raise UnknownNameError(
                f"{path_of(self)} (SplineEnd): profile = {shown(self.profile)} is not known. "
                f"{nearest(str(self.profile), PROFILES)}"
            )
        at_29 = 1 + PROFILES[self.profile] * (exp(4.2e-7 * (self.R_m / 1e6) ** 2) - 1)

        def size(d: Expr | float) -> Expr:
            return 1 - 0.2 * log(at_29) / log(10.0) * log(minimum(d, 0.15) / 7.5e-3) / log(20.0)

        return at_29 * size(0.029) / size(self.d_root)

    def modulus(self) -> Expr:
        return pi / 16 * self.d_root**3
