"""Torques that depend on the speed: machines, fans, drag, brakes.

As for `Torque`, positive values drive: a negative nominal torque is a load. With `same_direction`
the torque keeps its direction when the speed changes sign; otherwise it reverses with the speed.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import (
    Component,
    Equation,
    Expr,
    Flange,
    HeatPort,
    Input,
    Param,
    Var,
    der,
    param,
    var,
)
from lumped.ops import maximum, tanh, where

__all__ = ["EddyCurrentBrake", "InverseTorque", "LinearTorque", "QuadraticTorque", "SignTorque"]


class _SpeedTorque(Component):
    """Torque ``tau`` that drives the flange, as a function of its speed ``w``."""

    symbol = "load"
    flange = Flange()
    support = Flange(grounded=True)
    tau_nominal: Param = param("N.m", "driving torque at the nominal speed")
    w: Var = var("rad/s", "speed relative to the support")
    tau: Var = var("N.m", "driving torque")

    def equations(self) -> Iterator[Equation]:
        yield self.w == der(self.flange.phi - self.support.phi)
        yield self.tau == self._driving()
        yield self.flange.tau == -self.tau
        yield self.support.tau == self.tau

    def _driving(self) -> Expr:
        raise NotImplementedError


class LinearTorque(_SpeedTorque):
    """Torque proportional to the speed: ``tau = tau_nominal w / w_nominal``."""

    w_nominal: Param = param("rad/s", "nominal speed", above=0)
    same_direction: bool = False

    def _driving(self) -> Expr:
        return linear(self.w, self.tau_nominal, self.w_nominal, self.same_direction)


class QuadraticTorque(_SpeedTorque):
    """Torque of a fan or pump: ``tau = tau_nominal (w / w_nominal)^2``, with the sign of `w`."""

    w_nominal: Param = param("rad/s", "nominal speed", above=0)
    same_direction: bool = False

    def _driving(self) -> Expr:
        return quadratic(self.w, self.tau_nominal, self.w_nominal, self.same_direction)


class SignTorque(_SpeedTorque):
    """Torque of constant magnitude, smoothed about standstill: ``tau = tau_nominal sign(w)``.

    It cannot hold anything still; for that use `BearingFriction`. With `smooth` the torque is
    ``tau_nominal tanh(w / (0.02 w0))``, otherwise straight between -w0 and w0.
    """

    w0: Param = param("rad/s", "speed of smoothing", 0.1, above=0)
    smooth: bool = True

    def _driving(self) -> Expr:
        return sign(self.w, self.tau_nominal, self.w0, self.smooth)


class InverseTorque(_SpeedTorque):
    """Torque of constant power: ``tau = tau_nominal w_nominal / w``, bounded below `w0`.

    With `same_direction` it is constant there, otherwise ``tau_nominal w / w0``.
    """

    w_nominal: Param = param("rad/s", "nominal speed", above=0)
    w0: Param = param("rad/s", "speed below which it is bounded", above=0)
    same_direction: bool = False

    def _driving(self) -> Expr:
        return inverse(self.w, self.tau_nominal, self.w_nominal, self.w0, self.same_direction)


class EddyCurrentBrake(Component):
    """Eddy-current brake: ``tau = 2 tau_max e^2 x / (1 + x^2)``, ``x = w / w_critical``.

    ``w_critical = w_nominal (1 + alpha (T - T_ref))`` grows with the resistance of the disc, so a
    hot disc brakes less at low speed (Wouterse, Critical torque and speed of eddy current brake
    with widely separated soft iron poles, IEE Proc. B 138 (1991) 153). The heat ``tau w`` leaves
    at the port `heat`, where T is that of the brake.
    """

    symbol = "eddy"
    flange = Flange()
    support = Flange(grounded=True)
    heat = HeatPort()
    tau_max: Param = param("N.m", "greatest braking torque at full excitation", min=0)
    w_nominal: Param = param("rad/s", "speed of the greatest torque at T_ref", above=0)
    alpha: Param = param("1/K", "temperature coefficient of the resistance at T_ref", 0.0)
    T_ref: Param = param("K", "reference temperature", 293.15, above=0)
    e: Input = Input("1", "excitation over its greatest value")
    w: Var = var("rad/s", "speed relative to the support")
    tau: Var = var("N.m", "braking torque")

    def equations(self) -> Iterator[Equation]:
        yield self.w == der(self.flange.phi - self.support.phi)
        critical = self.w_nominal * (1 + self.alpha * (self.heat.T - self.T_ref))
        yield self.tau == braking(self.w, critical, self.tau_max, self.e)
        yield self.flange.tau == self.tau
        yield self.support.tau == -self.tau
        yield self.heat.Q + self.tau * self.w == 0


def linear(v: Expr, nominal: Expr, v_nominal: Expr, same_direction: bool) -> Expr:
    """Proportional to the speed."""
    return nominal * (abs(v) if same_direction else v) / v_nominal


def quadratic(v: Expr, nominal: Expr, v_nominal: Expr, same_direction: bool) -> Expr:
    """Proportional to the square of the speed."""
    return nominal * (v * v if same_direction else v * abs(v)) / v_nominal**2


def sign(v: Expr, nominal: Expr, v0: Expr, smooth: bool) -> Expr:
    """Constant magnitude."""
    return nominal * (tanh(v / (0.02 * v0)) if smooth else saturate(v, v0))


def saturate(v: Expr, v0: Expr) -> Expr:
    """``v / v0`` between -1 and 1; a run stops at both kinks."""
    return where(v >= v0, 1.0, where(v <= -v0, -1.0, v / v0))


def inverse(v: Expr, nominal: Expr, v_nominal: Expr, v0: Expr, same_direction: bool) -> Expr:
    """Constant power; bounded below v0."""
    bounded = maximum(abs(v), v0)
    if same_direction:
        return nominal * v_nominal / bounded
    return where(abs(v) >= v0, nominal * v_nominal * v / bounded**2, nominal * v / v0)


def braking(v: Expr, critical: Expr, greatest: Expr, excitation: Expr) -> Expr:
    """Eddy-current brake; greatest at the critical speed."""
    return 2 * greatest * excitation**2 * v * critical / (critical**2 + v**2)
