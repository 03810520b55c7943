"""Friction of rolling bearings by loads, speed and temperature of the oil.

Source: SKF, Rolling bearings, 2018 (the SKF model for calculating the frictional moment);
Morales-Espejel, Evolution 2006-2, p. 27. The formulas have N.mm, mm, mm2/s and 1/min.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Expr, Input, Param, Var, param, var
from lumped.components.bearings.fluid import magnitude, viscosity
from lumped.components.bearings.geometry import BearingType
from lumped.components.friction import _OnShaft
from lumped.errors import EquationError
from lumped.language.expression import Datum
from lumped.language.switch import Item, hold
from lumped.language.validity import Range
from lumped.ops import acos, exp, minimum, pi, sin, sqrt, where

__all__ = ["BallBearingInBath", "RollingBearing"]

_CREEP = 1e-3
"""Speed, 1/min, below which roots of the speed become straight lines."""


class RollingBearing(_OnShaft):
    """Friction of a rolling bearing: ``tau = M_rr + M_sl + M_seal`` against the motion.

    ``M_rr = phi_ish phi_rs G_rr (nu n)^0.6`` of rolling, with the reduction by shear heating at
    the inlet, ``phi_ish = 1 / (1 + 1.84e-9 (n d_m)^1.28 nu^0.64)``, and by starvation,
    ``phi_rs = exp(-K_rs nu n (d + D) sqrt(K_Z / (2 (D - d))))``. ``M_sl = G_sl mu_sl`` of sliding,
    ``mu_sl = phi_bl mu_bl + (1 - phi_bl) mu_film``, ``phi_bl = exp(-2.6e-8 (n nu)^1.4 d_m)``.
    `kind` gives the variables G_rr and G_sl of the loads. At standstill the bearing holds up to
    ``peak G_sl mu_bl + M_seal``.

    The shaft goes through from flange a to flange b; n is its speed relative to the support,
    ``d_m = (d + D) / 2``, and nu the viscosity at the temperature T of the oil.
    """

    symbol = "bearing"
    kind: BearingType | None = None
    d: Param = param("m", "bore", above=0)
    D: Param = param("m", "outer diameter", above=d)
    nu_100: Param = param("m2/s", "viscosity of the oil at 100 degrees Celsius", above=2e-7)
    nu_40: Param = param("m2/s", "viscosity of the oil at 40 degrees Celsius", above=nu_100)
    K_rs: Param = param("1", "starvation: 3e-8 oil bath or jet, 6e-8 grease or oil-air", min=0)
    K_Z: Param = param("1", "geometry: 3.1 deep groove, 4.4 angular contact", 3.1, above=0)
    mu_film: Param = param("1", "friction of the full film: 0.05 mineral, 0.04 synthetic", min=0)
    mu_bl: Param = param("1", "friction of the boundary layer in motion", 0.12, min=mu_film)
    peak: Param = param("1", "greatest static over kinetic sliding friction", 1.25, min=1)
    M_seal: Param = param("N.m", "friction of the seals of the bearing", 0.0, min=0)
    F_r: Input = Input("N", "radial load, not negative", min=0)
    F_a: Input = Input("N", "axial load, not negative", min=0)
    T: Input = Input("K", "temperature of the oil in kelvin", min=200)
    nu: Var = var("m2/s", "viscosity of the oil")

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield self.nu == viscosity(self.T, self.nu_40, self.nu_100)
        start = self._starting()
        yield hold(
            self.tau,
            self.w,
            forward=self._moment(self.w),
            backward=-self._moment(-self.w),
            upper=start,
            lower=-start,
            position=self.position,
        )

    def valid(self) -> Iterator[Range]:
        least = "Give its magnitude"
        yield Range(self.F_r, 0, float("inf"), "N", "radial load", least)
        yield Range(self.F_a, 0, float("inf"), "N", "axial load", least)

    def _loads(self, n: Expr) -> tuple[Expr, Expr]:
        """G_rr and G_sl at a speed, 1/min."""
        number = Datum(1.0)
        if not callable(self.kind):
            raise EquationError(
                f"kind = {self.kind!r}: the type of the bearing is needed, such as "
                'DeepGroove(23200.0, *DEEP_GROOVE["62"]) with the static load rating in N.'
            )
        return self.kind(number * self.F_r, number * self.F_a, self._d_m, n)

    @property
    def _d_m(self) -> Expr:
        """Mean diameter, mm."""
        return Datum(500.0) * (self.d + self.D)

    def _starting(self) -> Expr:
        """Greatest torque at standstill, N.m."""
        _, G_sl = self._loads(Datum(0.0))
        return Datum(1e-3) * G_sl * self.peak * self.mu_bl + self.M_seal

    def _moment(self, w: Expr) -> Expr:
        """Torque of friction, N.m, at a speed that is not negative."""
        n, nu, d_m = Datum(30 / pi) * w, Datum(1e6) * self.nu, self._d_m
        span, both = Datum(1e3) * (self.D - self.d), Datum(1e3) * (self.D + self.d)
        G_rr, G_sl = self._loads(n)
        size = magnitude(n, _CREEP)
        shear = 1 / (1 + 1.84e-9 * (size * d_m) ** 1.28 * nu**0.64)
        starved = exp(-self.K_rs * nu * n * both * sqrt(self.K_Z / (2 * span)))
        rolling = shear * starved * G_rr * nu**0.6 * n * size**-0.4
        boundary = exp(-2.6e-8 * (size * nu) ** 1.4 * d_m)
        sliding = G_sl * (boundary * self.mu_bl + (1 - boundary) * self.mu_film)
        return Datum(1e-3) * (rolling + sliding) + self.M_seal


class BallBearingInBath(RollingBearing):
    """Ball bearing that runs in an oil bath: ``tau = M_rr + M_sl + M_seal + M_drag``.

    ``M_drag = 0.4 V_M K_ball d_m^5 n^2 + 1.093e-7 n^2 d_m^3 (n d_m^2 f_t / nu)^-1.379 R_s``, with
    ``K_ball = rows K_Z (d + D) / (D - d) 1e-12``,
    ``R_s = 0.018 K_Z (d + D) / (D - d) d_m^2 (t - sin(t))``,
    ``t = 2 acos(1 - H / (0.6 d_m))`` for the level H, at most ``1.2 d_m``, and
    ``f_t = sin(t / 2)`` up to ``t = pi``, then 1. The variable V_M of drag is that of the
    catalogue's diagram over ``H / d_m``. All else is as in `RollingBearing`.
    """

    H: Param = param("m", "level of the oil above the lowest contact at the outer ring", above=0)
    V_M: Param = param("1", "variable of drag loss, by the catalogue over H / d_m", min=0)
    rows: int = 1

    def _moment(self, w: Expr) -> Expr:
        n, nu, d_m = Datum(30 / pi) * w, Datum(1e6) * self.nu, self._d_m
        slender = self.K_Z * (self.D + self.d) / (self.D - self.d)
        level: Expr = minimum(Datum(1e3) * self.H / (0.6 * d_m), 2.0)
        t = 2 * acos(1 - level)
        wetted = where(level <= 1, sin(t / 2), 1.0)
        churned = 0.4 * self.V_M * self.rows * 1e-12 * slender * d_m**5 * n**2
        R_s = 0.018 * slender * d_m**2 * (t - sin(t))
        ring = 1.093e-7 * d_m**3 * (d_m**2 * wetted / nu) ** -1.379 * R_s
        drag = churned + ring * n * magnitude(n, _CREEP) ** -0.379
        return super()._moment(w) + Datum(1e-3) * drag
