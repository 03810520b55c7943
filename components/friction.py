"""Dry friction, brakes, clutches and freewheels, with standstill that is exact.

All are made of one constraint that sticks and slides (`lumped.hold`): while the parts stand still
relative to each other, the torque is whatever keeps them so, up to `peak` times the kinetic
friction at standstill; beyond that they slide, and the torque follows the characteristic
(Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083; Otter, Elmqvist and Mattsson,
CACSD 1999, on friction elements that stick in any combination).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from lumped import Component, Expr, Flange, Input, Param, Var, der, hold, param, var
from lumped.ops import interpolate, maximum
from lumped.switch import Item

__all__ = ["BearingFriction", "Brake", "Clutch", "OneWayClutch"]

Points = Sequence[Sequence[float]]


def characteristic(points: Points, speed: Expr | float) -> Expr:
    """Friction at a sliding speed that is not negative, from rows of speed and friction."""
    return interpolate(speed, [row[0] for row in points], [row[1] for row in points])


class BearingFriction(Component):
    """Coulomb friction of a shaft in its bearings: ``tau_a + tau_b = tau``, against the motion.

    `points` are rows of sliding speed in rad/s (from zero up) and friction torque in N.m, joined by
    straight lines and continued by the last one.
    """

    flange_a = Flange(free=True)
    flange_b = Flange(free=True)
    support = Flange(grounded=True)
    points: Points = ((0.0, 1.0),)
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    phi: Var = var("rad", "angle relative to the support", state="avoid")
    w: Var = var("rad/s", "sliding speed", state="prefer")
    tau: Var = var("N.m", "friction torque")
    mode: Var = var("1", "1 forward, 0 stuck, -1 backward")

    def equations(self) -> Iterator[Item]:
        yield self.flange_a.phi == self.support.phi + self.phi
        yield self.flange_b.phi == self.support.phi + self.phi
        yield self.w == der(self.phi)
        yield self.flange_a.tau + self.flange_b.tau == self.tau
        yield self.support.tau == -self.tau
        most = self.peak * characteristic(self.points, 0.0)
        yield hold(
            self.tau,
            self.w,
            forward=characteristic(self.points, self.w),
            backward=-characteristic(self.points, -self.w),
            upper=most,
            lower=-most,
            mode=self.mode,
        )


class Brake(Component):
    """Brake on a shaft: friction ``mu(w) c_geo f_n`` against the motion, ``f_n = f_max u``.

    `points` are rows of sliding speed in rad/s and friction coefficient. Without normal force the
    shaft is free.
    """

    flange_a = Flange(free=True)
    flange_b = Flange(free=True)
    support = Flange(grounded=True)
    points: Points = ((0.0, 0.5),)
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    c_geo: Param = param("m", "friction torque over friction force", 1.0, min=0)
    f_max: Param = param("N", "normal force at u = 1", min=0)
    u = Input("1", "normal force over its greatest value")
    phi: Var = var("rad", "angle relative to the support", state="avoid")
    w: Var = var("rad/s", "sliding speed", state="prefer")
    tau: Var = var("N.m", "friction torque")
    f_n: Var = var("N", "normal force")
    mode: Var = var("1", "1 forward, 0 stuck, -1 backward, 2 free")

    def equations(self) -> Iterator[Item]:
        yield self.flange_a.phi == self.support.phi + self.phi
        yield self.flange_b.phi == self.support.phi + self.phi
        yield self.w == der(self.phi)
        yield self.flange_a.tau + self.flange_b.tau == self.tau
        yield self.support.tau == -self.tau
        yield self.f_n == self.f_max * self.u
        grip = self.c_geo * self.f_n
        most = self.peak * grip * characteristic(self.points, 0.0)
        yield hold(
            self.tau,
            self.w,
            forward=grip * characteristic(self.points, self.w),
            backward=-grip * characteristic(self.points, -self.w),
            upper=most,
            lower=-most,
            engaged=self.f_n > 0,
            mode=self.mode,
        )


class Clutch(Component):
    """Friction clutch between two shafts: ``tau = mu(w_rel) c_geo f_n``, ``f_n = f_max u``.

    `tau` acts on the clutch at flange b and, reversed, at flange a; `w_rel` is the speed of b
    relative to a. `points` are rows of sliding speed in rad/s and friction coefficient.
    """

    flange_a = Flange()
    flange_b = Flange()
    points: Points = ((0.0, 0.5),)
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    c_geo: Param = param("m", "friction torque over friction force", 1.0, min=0)
    f_max: Param = param("N", "normal force at u = 1", min=0)
    u = Input("1", "normal force over its greatest value")
    phi_rel: Var = var("rad", "relative angle", state="avoid")
    w_rel: Var = var("rad/s", "sliding speed", state="prefer")
    tau: Var = var("N.m", "friction torque on flange b")
    f_n: Var = var("N", "normal force")
    mode: Var = var("1", "1 forward, 0 stuck, -1 backward, 2 free")

    def equations(self) -> Iterator[Item]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.w_rel == der(self.phi_rel)
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau
        yield self.f_n == self.f_max * self.u
        grip = self.c_geo * self.f_n
        most = self.peak * grip * characteristic(self.points, 0.0)
        yield hold(
            self.tau,
            self.w_rel,
            forward=grip * characteristic(self.points, self.w_rel),
            backward=-grip * characteristic(self.points, -self.w_rel),
            upper=most,
            lower=-most,
            engaged=self.f_n > 0,
            mode=self.mode,
        )


class OneWayClutch(Component):
    """Freewheel with a friction clutch in parallel: ``w_rel`` cannot become negative.

    While it slides, ``tau = mu(w_rel) c_geo f_n``; locked, it takes any torque that would make
    `w_rel` negative, and opens where the torque the other way exceeds `peak` times the friction
    at standstill. Without normal force it opens at the first such torque.
    """

    flange_a = Flange()
    flange_b = Flange()
    points: Points = ((0.0, 0.5),)
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    c_geo: Param = param("m", "friction torque over friction force", 1.0, min=0)
    f_max: Param = param("N", "normal force at u = 1", 0.0, min=0)
    u = Input("1", "normal force over its greatest value")
    phi_rel: Var = var("rad", "relative angle", state="avoid")
    w_rel: Var = var("rad/s", "sliding speed", state="prefer")
    tau: Var = var("N.m", "torque on flange b")
    mode: Var = var("1", "1 sliding, 0 locked")

    def equations(self) -> Iterator[Item]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.w_rel == der(self.phi_rel)
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau
        grip = self.c_geo * self.f_max * maximum(self.u, 0.0)
        yield hold(
            self.tau,
            self.w_rel,
            forward=grip * characteristic(self.points, self.w_rel),
            upper=self.peak * grip * characteristic(self.points, 0.0),
            mode=self.mode,
        )
