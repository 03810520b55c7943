"""Windage: the drag of a fluid on discs and gears."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Input, Param, Var, der, param, var
from lumped.components.bearings.fluid import magnitude
from lumped.language.expression import Datum
from lumped.language.validity import Range
from lumped.ops import maximum, pi, smooth

__all__ = ["DiscWindage", "GearWindage"]

_CREEP = 1e-4
"""Speed, rad/s, below which roots of the speed become straight lines."""


class _Drag(Component):
    """Torque ``tau`` against the speed ``w`` of a flange."""

    symbol = "load"
    flange = Flange()
    support = Flange(grounded=True)
    w: Var = var("rad/s", "speed relative to the support")
    tau: Var = var("N.m", "torque against the motion")

    def equations(self) -> Iterator[Equation]:
        yield self.w == der(self.flange.phi - self.support.phi)
        yield self.tau == self._torque()
        yield self.flange.tau == self.tau
        yield self.support.tau == -self.tau

    def _torque(self) -> Expr:
        raise NotImplementedError

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.tau * self.w


class DiscWindage(_Drag):
    """Drag on both faces of a disc in a fluid without walls: ``tau = C_M rho R^5 w^2 / 2``.

    ``C_M = max(3.87 Re^-0.5, 0.146 Re^-0.2)`` with ``Re = w R^2 / nu``: laminar below 55 600, then
    turbulent. A smooth disc may stay laminar up to Re of 3e5, and loses less then. Walls beside the
    disc lower the drag. (Bird, Stewart and Lightfoot, Transport Phenomena, ch. 6: laminar
    ``0.616 pi rho R^4 (nu w^3)^0.5``, turbulent ``0.073 rho w^2 R^5 Re^-0.2``.)
    """

    R: Param = param("m", "radius of the disc", above=0)
    rho: Input = Input("kg/m3", "density of the fluid", min=0)
    nu: Input = Input("m2/s", "kinematic viscosity of the fluid", min=0)

    def valid(self) -> Iterator[Range]:
        most, hint = float("inf"), "Let the signal end at zero"
        yield Range(self.rho, 0.0, most, "kg/m3", "density", hint)
        yield Range(self.nu, 0.0, most, "m2/s", "viscosity", hint)

    def _torque(self) -> Expr:
        number = Datum(1.0)
        nu: Expr = smooth(maximum(number * self.nu, 0.0))
        R, w = number * self.R, magnitude(number * self.w, _CREEP)
        laminar = 0.616 * pi * R**4 * (nu * w) ** 0.5
        turbulent = 0.073 * R**4.6 * nu**0.2 * w**0.8
        greater: Expr = maximum(laminar, turbulent)
        return self.rho * greater * self.w


class GearWindage(_Drag):
    """Drag of the air on a gear: ``tau = 1.37e-9 v^1.9 d^1.6 b^0.52 m^0.69`` at the pitch circle.

    With the speed ``v = w d / 2`` in m/s and diameter, width and module in mm, as a public program
    for losses of gears has it; for air of the surroundings, without oil.
    """

    d: Param = param("m", "diameter of the pitch circle", above=0)
    b: Param = param("m", "width of the teeth", above=0)
    m: Param = param("m", "module", above=0)

    def _torque(self) -> Expr:
        mm = Datum(1e3)
        size = (mm * self.d) ** 1.6 * (mm * self.b) ** 0.52 * (mm * self.m) ** 0.69
        v = Datum(0.5) * self.d * self.w
        return Datum(1.37e-9) * size * v * magnitude(v, _CREEP) ** 0.9
