"""Dry friction, brakes, clutches and freewheels, with exact standstill.

All are made of one constraint that sticks and slides (`lumped.hold`): while the parts stand still
relative to each other, the torque is whatever keeps them at rest, up to `peak` times the kinetic
friction at standstill; beyond that they slide, and the torque follows the characteristic
(Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083; Otter, Elmqvist and
Mattsson, CACSD 1999, on friction elements that stick in any combination).
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Expr, Flange, Input, Param, Var, der, param, var
from lumped.components.characteristic import Characteristic, coulomb, dry_friction, friction_at
from lumped.language.switch import Item, hold
from lumped.ops import maximum

__all__ = [
    "BearingFriction",
    "Brake",
    "Clutch",
    "JournalFriction",
    "OneWayClutch",
    "SlipCoupling",
]


class _OnShaft(Component):
    """Between a shaft and its support: ``phi = phi_a - phi_support``, ``tau_a + tau_b = tau``."""

    flange_a = Flange(free=True)
    flange_b = Flange(free=True)
    support = Flange(grounded=True)
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    phi: Var = var("rad", "angle relative to the support", state="avoid")
    w: Var = var("rad/s", "sliding speed", state="prefer")
    tau: Var = var("N.m", "friction torque")
    position: Var = var("1", "1 forward, 0 stuck, -1 backward, 2 free")

    def equations(self) -> Iterator[Item]:
        yield self.flange_a.phi == self.support.phi + self.phi
        yield self.flange_b.phi == self.support.phi + self.phi
        yield self.w == der(self.phi)
        yield self.flange_a.tau + self.flange_b.tau == self.tau
        yield self.support.tau == -self.tau

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.tau * self.w


class _BetweenShafts(Component):
    """Between two shafts: ``phi_rel = phi_b - phi_a``, ``tau_b = -tau_a = tau``."""

    flange_a = Flange()
    flange_b = Flange()
    phi_rel: Var = var("rad", "relative angle", state="avoid")
    w_rel: Var = var("rad/s", "sliding speed", state="prefer")
    tau: Var = var("N.m", "torque on flange b")

    def equations(self) -> Iterator[Item]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.w_rel == der(self.phi_rel)
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.tau * self.w_rel


class _Pressed(_BetweenShafts):
    """Between two shafts, with friction faces pressed together by a command."""

    characteristic: Characteristic = ((0.0, 0.5),)
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    c_geo: Param = param("m", "friction torque over friction force", 1.0, min=0)
    u: Input = Input("1", "normal force over its greatest value")


class BearingFriction(_OnShaft):
    """Friction of a shaft in its bearings: ``tau = tau_k(w)``, against the motion.

    The shaft goes through from flange a to flange b. `characteristic` gives the friction torque
    in N.m over the sliding speed in rad/s: rows of both, or a function such as
    `lumped.components.Stribeck`.
    """

    symbol = "bearing"
    characteristic: Characteristic = ()

    def rating(self) -> tuple[str, Expr]:
        return "N.m", friction_at(self.characteristic, 0.0)

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield dry_friction(
            self.tau, self.w, self.characteristic, peak=self.peak, position=self.position
        )


class Brake(_OnShaft):
    """Brake on a shaft: ``tau = mu(w) c_geo f_n`` against the motion, ``f_n = f_max u``.

    The shaft goes through from flange a to flange b. `characteristic` gives the friction
    coefficient over the sliding speed in rad/s: rows of both, or a function such as
    `lumped.components.Stribeck`. Without normal force the shaft is free.
    """

    symbol = "brake"
    characteristic: Characteristic = ((0.0, 0.5),)
    c_geo: Param = param("m", "friction torque over friction force", 1.0, min=0)
    f_max: Param = param("N", "normal force at u = 1", min=0)
    u: Input = Input("1", "normal force over its greatest value")
    f_n: Var = var("N", "normal force")

    def rating(self) -> tuple[str, Expr]:
        return "N.m", friction_at(self.characteristic, 0.0) * self.c_geo * self.f_max

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield self.f_n == self.f_max * self.u
        yield dry_friction(
            self.tau,
            self.w,
            self.characteristic,
            grip=self.c_geo * self.f_n,
            engaged=self.f_n > 0,
            peak=self.peak,
            position=self.position,
        )


class JournalFriction(_OnShaft):
    """Friction of a journal under a load: ``tau = mu f_n d / 2`` against the motion.

    The shaft goes through from flange a to flange b. The load `f_n` on its journals may change
    during a run, for example when a body is picked up. At standstill the friction bears up to
    `peak` times that torque.
    """

    symbol = "bearing"
    mu: Param = param("1", "friction coefficient, with the factor of the bearing's play", min=0)
    d: Param = param("m", "diameter of the journal", above=0)
    f_n: Input = Input("N", "load on the journals, not negative", min=0)

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        grip = self.mu * self.f_n * self.d / 2
        yield coulomb(
            self.tau, self.w, grip, self.peak * grip, engaged=self.f_n > 0, position=self.position
        )


class Clutch(_Pressed):
    """Friction clutch between two shafts: ``tau = mu(w_rel) c_geo f_n``, ``f_n = f_max u``.

    `tau` acts on the clutch at flange b and, reversed, at flange a; `w_rel` is the speed of b
    relative to a. `characteristic` gives the friction coefficient over the sliding speed in rad/s:
    rows of both, or a function such as `lumped.components.Stribeck`. Without normal force it is
    open.
    """

    symbol = "clutch"
    f_max: Param = param("N", "normal force at u = 1", min=0)
    f_n: Var = var("N", "normal force")
    position: Var = var("1", "1 forward, 0 stuck, -1 backward, 2 free")

    def rating(self) -> tuple[str, Expr]:
        return "N.m", friction_at(self.characteristic, 0.0) * self.c_geo * self.f_max

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield self.f_n == self.f_max * self.u
        yield dry_friction(
            self.tau,
            self.w_rel,
            self.characteristic,
            grip=self.c_geo * self.f_n,
            engaged=self.f_n > 0,
            peak=self.peak,
            position=self.position,
        )


class OneWayClutch(_Pressed):
    """Freewheel with a friction clutch in parallel: ``w_rel >= 0``, ``tau = mu(w_rel) c_geo f_n``.

    Locked (``w_rel = 0``) it takes any torque that would make `w_rel` negative. It opens when the
    torque in the other direction exceeds `peak` times the friction at standstill, or at once if
    there is no normal force ``f_n = f_max max(u, 0)``. `characteristic` is that of `Clutch`.
    """

    symbol = "freewheel"
    f_max: Param = param("N", "normal force at u = 1", 0.0, min=0)
    f_n: Var = var("N", "normal force")
    position: Var = var("1", "1 sliding, 0 locked")

    def rating(self) -> tuple[str, Expr]:
        return "N.m", friction_at(self.characteristic, 0.0) * self.c_geo * self.f_max

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield self.f_n == self.f_max * maximum(self.u, 0.0)
        grip = self.c_geo * self.f_n
        yield hold(
            self.tau,
            self.w_rel,
            forward=grip * friction_at(self.characteristic, self.w_rel),
            upper=self.peak * grip * friction_at(self.characteristic, 0.0),
            position=self.position,
        )


class SlipCoupling(_BetweenShafts):
    """Coupling that slips above a torque: ``w_rel = 0`` while ``|tau| <= static``.

    Slipping, ``tau = kinetic sign(w_rel)``; it sticks again when `w_rel` comes to zero and
    `static` suffices. Disengaged, ``tau = 0``. `tau` acts on the coupling at flange b and,
    reversed, at flange a; `w_rel` is the speed of b relative to a. For safety couplings, belts,
    wheels and rolls whose limits are known as torques.
    """

    symbol = "clutch"
    kinetic: Param = param("N.m", "torque while it slips", min=0)
    static: Param = param("N.m", "greatest torque without slip", min=kinetic)
    u: Input = Input("1", "command: engaged above 0.5")
    position: Var = var("1", "1 forward, 0 stuck, -1 backward, 2 disengaged")

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield coulomb(
            self.tau,
            self.w_rel,
            self.kinetic,
            self.static,
            engaged=self.u > 0.5,
            position=self.position,
        )
