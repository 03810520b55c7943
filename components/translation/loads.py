"""Forces that depend on the velocity, twins of `lumped.components.loads.speed_torques`."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import (
    Component,
    Equation,
    Expr,
    HeatPort,
    Input,
    LinearFlange,
    Param,
    Var,
    der,
    param,
    var,
)
from lumped.components.loads.speed_torques import braking, inverse, linear, quadratic, sign

__all__ = ["EddyCurrentBrake", "InverseForce", "LinearForce", "QuadraticForce", "SignForce"]


class _SpeedForce(Component):
    """Force ``f`` that drives the flange, as a function of its velocity ``v``."""

    symbol = "force"
    flange = LinearFlange()
    support = LinearFlange(grounded=True)
    f_nominal: Param = param("N", "driving force at the nominal velocity")
    v: Var = var("m/s", "velocity relative to the support")
    f: Var = var("N", "driving force")

    def equations(self) -> Iterator[Equation]:
        yield self.v == der(self.flange.s - self.support.s)
        yield self.f == self._driving()
        yield self.flange.f == -self.f
        yield self.support.f == self.f

    def _driving(self) -> Expr:
        raise NotImplementedError


class LinearForce(_SpeedForce):
    """Force proportional to the velocity: ``f = f_nominal v / v_nominal``."""

    v_nominal: Param = param("m/s", "nominal velocity", above=0)
    same_direction: bool = False

    def _driving(self) -> Expr:
        return linear(self.v, self.f_nominal, self.v_nominal, self.same_direction)


class QuadraticForce(_SpeedForce):
    """Force of a drag: ``f = f_nominal (v / v_nominal)^2``, with the sign of `v`."""

    v_nominal: Param = param("m/s", "nominal velocity", above=0)
    same_direction: bool = False

    def _driving(self) -> Expr:
        return quadratic(self.v, self.f_nominal, self.v_nominal, self.same_direction)


class SignForce(_SpeedForce):
    """Force of constant magnitude, smoothed about standstill: ``f = f_nominal sign(v)``.

    With `smooth` it is ``f_nominal tanh(v / (0.02 v0))``, otherwise straight between -v0 and v0.
    """

    v0: Param = param("m/s", "velocity of smoothing", 0.1, above=0)
    smooth: bool = True

    def _driving(self) -> Expr:
        return sign(self.v, self.f_nominal, self.v0, self.smooth)


class InverseForce(_SpeedForce):
    """Force of constant power: ``f = f_nominal v_nominal / v``, bounded below `v0`.

    With `same_direction` it is constant there, otherwise ``f_nominal v / v0``.
    """

    v_nominal: Param = param("m/s", "nominal velocity", above=0)
    v0: Param = param("m/s", "velocity below which it is bounded", above=0)
    same_direction: bool = False

    def _driving(self) -> Expr:
        return inverse(self.v, self.f_nominal, self.v_nominal, self.v0, self.same_direction)


class EddyCurrentBrake(Component):
    """Eddy-current brake on a rail: ``f = 2 f_max e^2 x / (1 + x^2)``, ``x = v / v_critical``.

    ``v_critical = v_nominal (1 + alpha (T - T_ref))``; see the rotational twin. The heat ``f v``
    leaves at the port `heat`, where T is that of the brake.
    """

    symbol = "eddy"
    flange = LinearFlange()
    support = LinearFlange(grounded=True)
    heat = HeatPort()
    f_max: Param = param("N", "greatest braking force at full excitation", min=0)
    v_nominal: Param = param("m/s", "velocity of the greatest force at T_ref", above=0)
    alpha: Param = param("1/K", "temperature coefficient of the resistance at T_ref", 0.0)
    T_ref: Param = param("K", "reference temperature", 293.15, above=0)
    e: Input = Input("1", "excitation over its greatest value")
    v: Var = var("m/s", "velocity relative to the support")
    f: Var = var("N", "braking force")

    def equations(self) -> Iterator[Equation]:
        yield self.v == der(self.flange.s - self.support.s)
        critical = self.v_nominal * (1 + self.alpha * (self.heat.T - self.T_ref))
        yield self.f == braking(self.v, critical, self.f_max, self.e)
        yield self.flange.f == self.f
        yield self.support.f == -self.f
        yield self.heat.Q + self.f * self.v == 0
