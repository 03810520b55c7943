"""Clutches that engage by wind-up, by speed and by pressure; with heat and in pairs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from lumped import (
    Component,
    Connection,
    Expr,
    Flange,
    HeatPort,
    Input,
    Param,
    Var,
    connect,
    der,
    param,
    var,
    when,
)
from lumped.components.characteristic import Characteristic, dry_friction
from lumped.components.couplings.stiffness_table import factor
from lumped.components.electric.thermal import HeatCapacitor, Heated, ThermalConductor
from lumped.components.friction import _BetweenShafts
from lumped.language.component import Made
from lumped.language.expression import Number, as_expr
from lumped.language.switch import Item
from lumped.language.validity import Range
from lumped.language.value_types import Rows
from lumped.ops import where

__all__ = ["CentrifugalClutch", "DualClutch", "HeatedClutch", "PressureClutch", "SpragClutch"]


class SpragClutch(_BetweenShafts):
    """Freewheel whose sprags wind up: ``tau = -c x`` while engaged, ``tau = d w_rel`` in overrun.

    Flange a drives flange b. The sprags engage as soon as `w_rel`, the speed of b relative to a, is
    negative, at any angle. Engaged, ``der(x) = -w_rel``; when the wind-up x has fallen to zero they
    let go. `tau` acts at flange b and, reversed, at flange a. `OneWayClutch` is the rigid limit.
    """

    symbol = "freewheel"
    c: Param = param("N.m/rad", "torsional stiffness of the engaged sprags", above=0)
    d: Param = param("N.m.s/rad", "viscous drag in overrun", 0.0, min=0)
    x: Var = var("rad", "wind-up", nominal=1e-3, state="always")

    def rating(self) -> tuple[str, Expr]:
        return "N.m/rad", self.c

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield der(self.x) == self._held(-self.w_rel, 0.0)
        yield self.tau == self._held(-self.c * self.x, self.d * self.w_rel)
        yield when((self.x <= 0).called("let go", "wound"), {self.x: 0.0})

    def _held(self, engaged: Expr, free: Number) -> Expr:
        """One of two values: the sprags hold while they are wound up, and while b is slower."""
        slower = (self.w_rel < 0).called("engaged", "overrunning")
        return where((self.x > 0).called("wound up", "free"), engaged, where(slower, engaged, free))

    def loss(self) -> Expr:
        """Heat by drag, W."""
        return self._held(as_expr(0.0), self.d * self.w_rel**2)

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return 0.5 * self.c * self.x**2


class CentrifugalClutch(_BetweenShafts):
    """Centrifugal clutch: ``tau = mu(w_rel) r n f``, ``f = max(m r_g w_a^2 - f_spring, 0)``.

    Shoes on the hub at flange a are thrown against the drum at flange b; below the speed
    ``sqrt(f_spring / (m r_g))`` their springs hold them back and it is open. `characteristic` gives
    the friction coefficient over the sliding speed in rad/s: rows of both, or a function such as
    `lumped.components.Stribeck`. Shoes that tighten themselves are left out.

    Source: Khurmi and Gupta, A Textbook of Machine Design, ch. 24.
    """

    symbol = "clutch"
    characteristic: Characteristic = ((0.0, 0.3),)
    m: Param = param("kg", "mass of one shoe", above=0)
    r_g: Param = param("m", "radius of the centre of gravity of a shoe", above=0)
    r: Param = param("m", "radius of the drum", above=0)
    n: Param = param("1", "number of shoes", min=1)
    f_spring: Param = param("N", "force of the spring of one shoe", 0.0, min=0)
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    w_a: Var = var("rad/s", "speed of the hub")
    f_n: Var = var("N", "normal force of one shoe")
    position: Var = var("1", "1 forward, 0 stuck, -1 backward, 2 free")

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield self.w_a == der(self.flange_a.phi)
        pressed = self.m * self.r_g * self.w_a**2 - self.f_spring
        touches = (pressed > 0).called("thrown out", "held back")
        yield self.f_n == where(touches, pressed, 0.0)
        yield dry_friction(
            self.tau,
            self.w_rel,
            self.characteristic,
            grip=self.r * self.n * self.f_n,
            engaged=touches,
            peak=self.peak,
            position=self.position,
        )


class PressureClutch(_BetweenShafts):
    """Clutch closed by a piston: ``tau = mu(w_rel) n r f_n``, ``f_n = max(A p - f_spring, 0)``.

    The pressure follows its command, ``T_p der(p) = p_wanted - p``, and first overcomes the return
    spring: the clutch begins to touch at ``p = f_spring / A`` (kiss point). `characteristic` gives
    the friction coefficient over the sliding speed in rad/s: rows of both, or a function such as
    `lumped.components.Stribeck`. `tau` acts at flange b and, reversed, at flange a. A brake is a
    clutch to a `Fixed`.
    """

    symbol = "clutch"
    characteristic: Characteristic = ((0.0, 0.12),)
    p_wanted: Input = Input("Pa", "wanted pressure, not negative", min=0)
    T_p: Param = param("s", "time constant of the pressure", above=0)
    A: Param = param("m2", "area of the piston", above=0)
    f_spring: Param = param("N", "force of the return spring", 0.0, min=0)
    n: Param = param("1", "number of friction faces", min=1)
    r: Param = param("m", "mean radius of the faces", above=0)
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    p: Var = var("Pa", "pressure", nominal=1e5, state="always")
    f_n: Var = var("N", "normal force")
    position: Var = var("1", "1 forward, 0 stuck, -1 backward, 2 free")

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield self.T_p * der(self.p) == self.p_wanted - self.p
        pressed = self.A * self.p - self.f_spring
        touches = (pressed > 0).called("touching", "released")
        yield self.f_n == where(touches, pressed, 0.0)
        yield dry_friction(
            self.tau,
            self.w_rel,
            self.characteristic,
            grip=self.n * self.r * self.f_n * self._warm(),
            engaged=touches,
            peak=self.peak,
            position=self.position,
        )

    def valid(self) -> Iterator[Range]:
        hint = "Let the command end at zero"
        yield Range(self.p_wanted, 0.0, float("inf"), "Pa", "wanted pressure", hint)

    def _warm(self) -> Expr | float:
        """Friction coefficient over that of the characteristic."""
        return 1.0


class _WarmClutch(Heated, PressureClutch):
    """Pressure clutch whose heat leaves at a port: ``mu = mu(w_rel) k(T)``."""

    over_temperature: Rows = ()

    def _warm(self) -> Expr | float:
        return factor("over_temperature", self.over_temperature, self.heat.T, "temperature (K)")


_PRESSED = ("T_p", "A", "f_spring", "n", "r", "peak")


def _friction(clutch: HeatedClutch) -> _WarmClutch:
    shared = {name: getattr(HeatedClutch, name) for name in _PRESSED}
    return _WarmClutch(
        characteristic=clutch.characteristic, over_temperature=clutch.over_temperature, **shared
    )


class HeatedClutch(Component):
    """`PressureClutch` that warms its linings: ``C_lining der(T) = tau w_rel - G (T - T_plate)``.

    The heat of the slip goes into the linings, from there through G into the mass of the plates,
    ``C_plate der(T_plate) = G (T - T_plate) + Q``, and on through the port `heat`; an open port is
    insulated. The friction coefficient is that of the characteristic times the factor of
    `over_temperature`, rows of temperature of the linings in K and factor; the first and last
    factor are kept. Its parts are `friction`, `lining`, `path` and `plate`.
    """

    symbol = "clutch"
    flange_a = Flange()
    flange_b = Flange()
    heat = HeatPort(free=True)
    p_wanted: Input = Input("Pa", "wanted pressure, not negative", min=0)
    characteristic: Characteristic = ((0.0, 0.12),)
    over_temperature: Rows = ()
    T_p: Param = param("s", "time constant of the pressure", above=0)
    A: Param = param("m2", "area of the piston", above=0)
    f_spring: Param = param("N", "force of the return spring", 0.0, min=0)
    n: Param = param("1", "number of friction faces", min=1)
    r: Param = param("m", "mean radius of the faces", above=0)
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    C_lining: Param = param("J/K", "heat capacity of the linings", above=0)
    C_plate: Param = param("J/K", "heat capacity of the plates", above=0)
    G: Param = param("W/K", "thermal conductance between linings and plates", above=0)
    friction: Any = Made(_friction)
    lining: HeatCapacitor = HeatCapacitor(C=C_lining)
    path: ThermalConductor = ThermalConductor(G=G)
    plate: HeatCapacitor = HeatCapacitor(C=C_plate)

    def connections(self) -> Iterator[Connection]:
        yield connect(self.flange_a, self.friction.flange_a)
        yield connect(self.flange_b, self.friction.flange_b)
        yield connect(self.p_wanted, self.friction.p_wanted)
        yield connect(self.friction.heat, self.lining.port, self.path.port_a)
        yield connect(self.path.port_b, self.plate.port, self.heat)


class DualClutch(Component):
    """Two clutches from one shaft to two: ``tau_a = -tau_1 - tau_2``, each by its own pressure.

    `clutch_1` joins flange a to `flange_1` by the pressure `p_1`, `clutch_2` to `flange_2` by
    `p_2`; both are `HeatedClutch`, whose plates have the ports `heat_1` and `heat_2`. Without heat
    put two `PressureClutch` on a shaft.
    """

    symbol = "clutch"
    flange_a = Flange()
    flange_1 = Flange()
    flange_2 = Flange()
    heat_1 = HeatPort(free=True)
    heat_2 = HeatPort(free=True)
    p_1: Input = Input("Pa", "wanted pressure of clutch 1, not negative", min=0)
    p_2: Input = Input("Pa", "wanted pressure of clutch 2, not negative", min=0)
    clutch_1: HeatedClutch = HeatedClutch()
    clutch_2: HeatedClutch = HeatedClutch()

    def connections(self) -> Iterator[Connection]:
        one, two = self.clutch_1, self.clutch_2
        yield connect(self.flange_a, one.flange_a, two.flange_a)
        for port, clutch in ((self.flange_1, one), (self.flange_2, two)):
            yield connect(port, clutch.flange_b)
        for pressure, clutch in ((self.p_1, one), (self.p_2, two)):
            yield connect(pressure, clutch.p_wanted)
        for plate, clutch in ((self.heat_1, one), (self.heat_2, two)):
            yield connect(plate, clutch.heat)
