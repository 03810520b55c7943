"""Bodies, springs, dampers and sensors of straight-line motion."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import (
    Component,
    Equation,
    Expr,
    LinearFlange,
    Output,
    Param,
    Var,
    der,
    lossless,
    param,
    var,
)
from lumped.components.couplings.elastic import ElasticLaw, elastic_energy, elastic_force

__all__ = [
    "AccelerationSensor",
    "Damper",
    "ForceSensor",
    "Mass",
    "MassWithLength",
    "NonlinearSpring",
    "PositionSensor",
    "PowerSensor",
    "RelativePositionSensor",
    "RelativeSpeedSensor",
    "Rod",
    "SpeedSensor",
    "Spring",
    "SpringDamper",
]


class Mass(Component):
    """Rigid body without length, sliding along the axis between two flanges.

    ``m a = f_a + f_b`` with ``v = der(s)``, ``a = der(v)``. Either flange may stay open.
    """

    symbol = "mass"
    flange_a = LinearFlange(free=True)
    flange_b = LinearFlange(free=True)
    m: Param = param("kg", "mass", above=0)
    s: Var = var("m", "position")
    v: Var = var("m/s", "velocity")
    a: Var = var("m/s2", "acceleration")

    def equations(self) -> Iterator[Equation]:
        yield self.flange_a.s == self.s
        yield self.flange_b.s == self.s
        yield self.v == der(self.s)
        yield self.a == der(self.v)
        yield self.m * self.a == self.flange_a.f + self.flange_b.f

    def stored(self) -> Expr:
        """Kinetic energy, J."""
        return 0.5 * self.m * self.v**2


class MassWithLength(Component):
    """Rigid body of some length, sliding along the axis: ``m a = f_a + f_b``, ``v = der(s)``.

    `s` is the position of its middle, ``s_a = s - length / 2`` and ``s_b = s + length / 2``.
    """

    symbol = "mass"
    flange_a = LinearFlange(free=True)
    flange_b = LinearFlange(free=True)
    m: Param = param("kg", "mass", above=0)
    length: Param = param("m", "position of flange b less that of flange a")
    s: Var = var("m", "position of the middle")
    v: Var = var("m/s", "velocity")
    a: Var = var("m/s2", "acceleration")

    def equations(self) -> Iterator[Equation]:
        yield self.flange_a.s == self.s - self.length / 2
        yield self.flange_b.s == self.s + self.length / 2
        yield self.v == der(self.s)
        yield self.a == der(self.v)
        yield self.m * self.a == self.flange_a.f + self.flange_b.f

    def stored(self) -> Expr:
        """Kinetic energy, J."""
        return 0.5 * self.m * self.v**2


class Rod(Component):
    """Rigid rod without mass: ``s_b = s_a + length``, ``f_a + f_b = 0``."""

    symbol = "strut"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    length: Param = param("m", "position of flange b less that of flange a")

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        a, b = self.flange_a, self.flange_b
        yield lossless(b.s == a.s + self.length, a, b)


class Spring(Component):
    """Linear spring: ``f = c (s_rel - s_rel0)``, ``s_rel = s_b - s_a``.

    `f` is the force transmitted, positive in tension: it acts on flange b and, reversed, on
    flange a.
    """

    symbol = "spring"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    c: Param = param("N/m", "stiffness", above=0)
    s_rel0: Param = param("m", "distance of the flanges without force", 0.0)
    s_rel: Var = var("m", "distance of the flanges", nominal=1e-4, state="prefer")
    f: Var = var("N", "force transmitted")

    def equations(self) -> Iterator[Equation]:
        yield self.s_rel == self.flange_b.s - self.flange_a.s
        yield self.f == self.c * (self.s_rel - self.s_rel0)
        yield self.flange_b.f == self.f
        yield self.flange_a.f == -self.f

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return 0.5 * self.c * (self.s_rel - self.s_rel0) ** 2


class NonlinearSpring(Component):
    """Spring with a characteristic: ``f = F(s_rel - s_rel0)``, ``s_rel = s_b - s_a``.

    `characteristic` is F, force in N over stretch in m: rows of both, joined by straight lines, the
    first and last continued; rows that begin at zero hold for both directions. Or a function of the
    stretch in `lumped.ops`.
    """

    symbol = "spring"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    characteristic: ElasticLaw = ()
    s_rel0: Param = param("m", "distance at which the characteristic has its zero", 0.0)
    s_rel: Var = var("m", "distance of the flanges", nominal=1e-4, state="prefer")
    f: Var = var("N", "force transmitted")

    def equations(self) -> Iterator[Equation]:
        yield self.s_rel == self.flange_b.s - self.flange_a.s
        yield self.f == elastic_force(self.characteristic, self.s_rel - self.s_rel0)
        yield self.flange_b.f == self.f
        yield self.flange_a.f == -self.f

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return elastic_energy(self.characteristic, self.s_rel - self.s_rel0)


class Damper(Component):
    """Linear viscous damper: ``f = d v_rel``, ``v_rel = der(s_b - s_a)``."""

    symbol = "damper"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    d: Param = param("N.s/m", "viscous damping", min=0)
    s_rel: Var = var("m", "distance of the flanges")
    v_rel: Var = var("m/s", "relative velocity")
    f: Var = var("N", "force transmitted")

    def equations(self) -> Iterator[Equation]:
        yield self.s_rel == self.flange_b.s - self.flange_a.s
        yield self.v_rel == der(self.s_rel)
        yield self.f == self.d * self.v_rel
        yield self.flange_b.f == self.f
        yield self.flange_a.f == -self.f

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.d * self.v_rel**2


class SpringDamper(Component):
    """Spring and damper in parallel: ``f = c (s_rel - s_rel0) + d v_rel``."""

    symbol = "spring_damper"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    c: Param = param("N/m", "stiffness", above=0)
    d: Param = param("N.s/m", "viscous damping", 0.0, min=0)
    s_rel0: Param = param("m", "distance of the flanges without spring force", 0.0)
    s_rel: Var = var("m", "distance of the flanges", nominal=1e-4, state="prefer")
    v_rel: Var = var("m/s", "relative velocity")
    f: Var = var("N", "force transmitted")

    def equations(self) -> Iterator[Equation]:
        yield self.s_rel == self.flange_b.s - self.flange_a.s
        yield self.v_rel == der(self.s_rel)
        yield self.f == self.c * (self.s_rel - self.s_rel0) + self.d * self.v_rel
        yield self.flange_b.f == self.f
        yield self.flange_a.f == -self.f

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.d * self.v_rel**2

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return 0.5 * self.c * (self.s_rel - self.s_rel0) ** 2


class PositionSensor(Component):
    """Ideal sensor of a position: ``s = s_flange``; takes no force."""

    symbol = "sensor"
    flange = LinearFlange()
    s = Output("m", "position")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.f == 0
        yield self.s == self.flange.s


class SpeedSensor(Component):
    """Ideal sensor of a velocity: ``v = der(s_flange)``; takes no force."""

    symbol = "sensor"
    flange = LinearFlange()
    v = Output("m/s", "velocity")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.f == 0
        yield self.v == der(self.flange.s)


class AccelerationSensor(Component):
    """Ideal sensor of an acceleration: ``a = der(der(s_flange))``; takes no force."""

    symbol = "sensor"
    flange = LinearFlange()
    a = Output("m/s2", "acceleration")

    def equations(self) -> Iterator[Equation]:
        yield self.flange.f == 0
        yield self.a == der(der(self.flange.s))


class RelativePositionSensor(Component):
    """Ideal sensor of a distance: ``s_rel = s_b - s_a``; takes no force."""

    symbol = "sensor"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    s_rel = Output("m", "distance of the flanges")

    def equations(self) -> Iterator[Equation]:
        yield self.flange_a.f == 0
        yield self.flange_b.f == 0
        yield self.s_rel == self.flange_b.s - self.flange_a.s


class RelativeSpeedSensor(Component):
    """Ideal sensor of a relative velocity: ``v_rel = der(s_b - s_a)``; takes no force."""

    symbol = "sensor"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    v_rel = Output("m/s", "relative velocity")

    def equations(self) -> Iterator[Equation]:
        yield self.flange_a.f == 0
        yield self.flange_b.f == 0
        yield self.v_rel == der(self.flange_b.s - self.flange_a.s)


class ForceSensor(Component):
    """Ideal sensor in a rigid rod: ``f = f_a``, the force flowing from a to b."""

    symbol = "sensor"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    f = Output("N", "force from a to b")

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        a, b = self.flange_a, self.flange_b
        yield lossless(b.s == a.s, a, b)
        yield self.f == a.f


class PowerSensor(Component):
    """Ideal sensor in a rigid rod: ``power = f_a der(s_a)``, power flowing from a to b."""

    symbol = "sensor"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    power = Output("W", "power from a to b")

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        a, b = self.flange_a, self.flange_b
        yield lossless(b.s == a.s, a, b)
        yield self.power == a.f * der(a.s)
