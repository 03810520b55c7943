"""Planetary stages whose meshes are elastic."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Literal

from lumped import (
    Component,
    Connection,
    Equation,
    Expr,
    Flange,
    LinearFlange,
    Param,
    Var,
    connect,
    der,
    param,
    var,
)
from lumped.components.each import one_for_each
from lumped.components.gearing.planetary_teeth import (
    angles_of,
    refuse_counts,
    refuse_mesh,
    refuse_neighbours,
    waves,
)
from lumped.components.gearing.planets import Planet, PlanetOnBearing
from lumped.errors import DeclarationError, shown
from lumped.language.component import Made
from lumped.language.value_types import Numbers, Rows
from lumped.ops import maximum, smooth, where

if TYPE_CHECKING:
    from lumped.vibration.natural.modes import Modes

__all__ = ["ElasticPlanetary", "PlanarPlanetaryStage", "PlanetaryStage"]

ModeKind = Literal["rotational", "translational", "planet"]

_KINDS: tuple[ModeKind, ...] = ("rotational", "translational", "planet")
_MESHES = ("stiffness_s", "stiffness_r", "error_s", "error_r")
_OWN = ("c_s", "c_r", "d_s", "d_r", "pin_t", "pin_r")


class ElasticPlanetary(Component):
    """Planetary stage with springs in its meshes: ``f_s = c_s s_s + d_s der(s_s)`` at each planet.

    Deflections along the lines of action, with base radii ``r_p = (r_r - r_s) / 2`` of the planets
    and ``ratio = r_r / r_s``::

        s_s = r_s (phi_sun - phi_c) + r_p (phi_p - phi_c)
        s_r = r_r (phi_ring - phi_c) - r_p (phi_p - phi_c)
        J_p der(w_p) = r_p (f_r - f_s)

    The `n` planets move alike, so the stage has its rotational modes but none in which planets move
    against each other. The torques follow from virtual work. Add the mass of the planets as an
    `Inertia` on the carrier, ``n m r_c^2``. With rigid meshes it is a `Planetary`. One planet
    stands for all, so it has fewer states than a `PlanetaryStage`, and is faster, where planets do
    not differ.

    Source: Kahraman, Natural modes of planetary gear trains, J. Sound and Vibration 173 (1994) 125
    (purely torsional model).
    """

    symbol = "planetary"
    sun = Flange()
    carrier = Flange()
    ring = Flange(free=True)
    ratio: Param = param("1", "ring teeth over sun teeth", above=1)
    r_s: Param = param("m", "base radius of the sun", above=0)
    n: Param = param("1", "number of planets", min=1)
    J_p: Param = param("kg.m2", "moment of inertia of one planet about its pin", above=0)
    c_s: Param = param("N/m", "stiffness of a mesh with the sun", above=0)
    c_r: Param = param("N/m", "stiffness of a mesh with the ring", above=0)
    d_s: Param = param("N.s/m", "viscous damping of a mesh with the sun", 0.0, min=0)
    d_r: Param = param("N.s/m", "viscous damping of a mesh with the ring", 0.0, min=0)
    s_s: Var = var("m", "deflection of a mesh with the sun", nominal=1e-5, state="prefer")
    s_r: Var = var("m", "deflection of a mesh with the ring", nominal=1e-5, state="prefer")
    v_s: Var = var("m/s", "rate of the deflection at the sun")
    v_r: Var = var("m/s", "rate of the deflection at the ring")
    f_s: Var = var("N", "force of a mesh with the sun")
    f_r: Var = var("N", "force of a mesh with the ring")
    phi_p: Var = var("rad", "angle of the planets", state="avoid")
    w_p: Var = var("rad/s", "angular velocity of the planets")

    def equations(self) -> Iterator[Equation]:
        sun, carrier, ring = self.sun, self.carrier, self.ring
        r_s, r_r = self.r_s, self.ratio * self.r_s
        r_p = (r_r - r_s) / 2
        spin = self.phi_p - carrier.phi
        yield self.s_s == r_s * (sun.phi - carrier.phi) + r_p * spin
        yield self.s_r == r_r * (ring.phi - carrier.phi) - r_p * spin
        yield self.v_s == der(self.s_s)
        yield self.v_r == der(self.s_r)
        yield self.f_s == self.c_s * self.s_s + self.d_s * self.v_s
        yield self.f_r == self.c_r * self.s_r + self.d_r * self.v_r
        yield self.w_p == der(self.phi_p)
        yield self.J_p * der(self.w_p) == r_p * (self.f_r - self.f_s)
        yield sun.tau == self.n * r_s * self.f_s
        yield ring.tau == self.n * r_r * self.f_r
        yield carrier.tau == -self.n * (r_s + r_p) * (self.f_s + self.f_r)

    def stored(self) -> Expr:
        """Elastic energy of the meshes and energy of spin, J."""
        elastic = self.c_s * self.s_s**2 + self.c_r * self.s_r**2
        return 0.5 * self.n * (elastic + self.J_p * self.w_p**2)

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.n * (self.d_s * self.v_s**2 + self.d_r * self.v_r**2)


def _planets(stage: PlanetaryStage) -> list[Planet]:
    refuse_counts(stage, ("z_s", "z_p", "z_r", "n"))
    if stage.flank not in (1, -1):
        raise DeclarationError(
            f"{stage._label()}: flank = {shown(stage.flank)}: 1, or -1 for torques on the other "
            "flanks of the teeth."
        )
    n = stage.n
    if not stage.profile_shift:
        refuse_mesh(stage, "z_r", "z_s + 2 z_p", stage.z_s + 2 * stage.z_p)
    angles = angles_of(stage, "psi", n, stage.z_s + stage.z_r)
    refuse_neighbours(stage, angles, stage.z_s + stage.z_p, stage.z_p)
    shared = {name: getattr(PlanetaryStage, name) for name in ("r_s", "alpha")}
    shared |= {"m": PlanetaryStage.m_p, "J": PlanetaryStage.J_p}
    alike = {name: getattr(stage, name) for name in ("z_s", "z_p", "z_r", "flank", *_MESHES)}
    rigid = stage.c_b == () and not stage._needs_bearings
    if rigid and stage.d_b != 0.0:
        raise DeclarationError(
            f"{stage._label()}: d_b = {shown(stage.d_b)} damps bearings of planets; give their "
            "stiffness c_b too."
        )
    names = _OWN if rigid else (*_OWN, "c_b", "d_b")
    own = zip(*(one_for_each(stage, name, n) for name in names), strict=True)
    kind = Planet if rigid else PlanetOnBearing
    return [
        kind(**shared, **alike, psi=psi, **dict(zip(names, values, strict=True)))
        for psi, values in zip(angles, own, strict=True)
    ]


class PlanetaryStage(Component):
    """Planetary stage with planets one by one: ``tau_sun = sum(tau)`` over its `planets`.

    `planets` are `n` parts of the kind `Planet`, counted from 0, whose pins are rigid, or
    `PlanetOnBearing` if the stiffness `c_b` of their bearings is given. Stiffness and damping of
    the meshes and bearings and the errors `pin_t` and `pin_r` of the pins are one number for all
    planets or one for each, and so are the angles `psi` of the pins, which are equal ones if left
    out. Later they are the parameters ``planets[i].c_s`` and so forth of each planet. Sun, carrier
    and ring turn about the axis; in a `PlanarPlanetaryStage` they also move across it.

    `sharing` is the load sharing factor ``n max(tau) / sum(tau)``, 1 if all planets carry the same
    torque or none. The mass of the planets moves with the carrier. With rigid meshes it is a
    `Planetary`.

    Source: Kahraman, J. Sound and Vibration 173 (1994) 125 (torsional model); review of load
    sharing: Planet load-sharing and phasing, Machines 10 (2022) 634, doi 10.3390/machines10080634.
    """

    symbol = "planetary"
    sun = Flange()
    carrier = Flange()
    ring = Flange(free=True)
    n: int = 3
    z_s: int = 0
    z_p: int = 0
    z_r: int = 0
    profile_shift: bool = False
    flank: int = 1
    psi: Numbers = ()
    c_s: Any = ()
    c_r: Any = ()
    d_s: Any = 0.0
    d_r: Any = 0.0
    c_b: Any = ()
    d_b: Any = 0.0
    pin_t: Any = 0.0
    pin_r: Any = 0.0
    stiffness_s: Rows = ()
    stiffness_r: Rows = ()
    error_s: Rows = ()
    error_r: Rows = ()
    r_s: Param = param("m", "base radius of the sun", above=0)
    alpha: Param = param("rad", "working pressure angle at the sun", above=0, below=0.8)
    m_p: Param = param("kg", "mass of one planet", min=0)
    J_p: Param = param("kg.m2", "moment of inertia of one planet about its pin", above=0)
    sharing: Var = var("1", "load sharing factor, largest torque of a planet over the mean")
    planets: Any = Made(_planets)

    _needs_bearings = False

    def equations(self) -> Iterator[Equation]:
        torques = [planet.tau for planet in self.planets]
        total = sum(torques[1:], torques[0])
        loaded = total**2 > 0
        share = [torque / where(loaded, total, 1.0) for torque in torques]
        most = share[0]
        for other in share[1:]:
            most = maximum(most, other)
        yield self.sharing == smooth(where(loaded, len(torques) * most, 1.0))

    def connections(self) -> Iterator[Connection]:
        for name in ("sun", "carrier", "ring"):
            yield connect(getattr(self, name), *(getattr(p, name) for p in self.planets))

    def mode_kinds(self, modes: Modes) -> list[ModeKind]:
        """What each oscillating mode is, by the shape of its planets, which are at equal angles.

        In a rotational mode all planets move alike, and sun, carrier and ring turn. In a
        translational one they move with the cosine and sine of their angles, and sun, carrier and
        ring move across the axis; such modes come in pairs of one frequency. In a planet mode both
        sums over the planets are zero, and nothing but planets moves; each such frequency has ``n -
        3`` of them. If planets differ, it is the kind with the largest part in their motion.

        Source: Lin and Parker, J. Vibration and Acoustics 121 (1999) 316.

        Parameters
        ----------
        modes : Modes
            Of a system with this stage, such as ``system.model.stage``.

        Returns
        -------
        list of {"rotational", "translational", "planet"}
        """
        n = self.n
        alike: Any = 0.0
        once: Any = 0.0
        every: Any = 0.0
        for name in ("v_s", "v_r", "v_radial", "v_tangential"):
            rows: list[Any] = [modes.shape(getattr(planet, name)) for planet in self.planets]
            alike += abs(sum(rows)) ** 2 / n
            for wave in waves(n):
                part: Any = sum(row * share for row, share in zip(rows, wave, strict=True))
                once += abs(part) ** 2 * min(2, n - 1) / n
            every += sum(abs(row) ** 2 for row in rows)
        found: list[ModeKind] = []
        for parts in zip(alike, once, every - alike - once, strict=True):
            found.append(_KINDS[parts.index(max(parts))])
        return found

    def rating(self) -> tuple[str, Expr]:
        planet = self.planets[0]
        return "1", planet.r_r / planet.r_s


class _Centre(Component):
    """A body across the axis on its bearing: ``m der(v_x) = f_x - c x - d v_x``, y alike."""

    symbol = "mass"
    at_x = LinearFlange()
    at_y = LinearFlange()
    m: Param = param("kg", "mass", above=0)
    c: Param = param("N/m", "stiffness of its bearing", min=0)
    d: Param = param("N.s/m", "viscous damping of its bearing", 0.0, min=0)
    x: Var = var("m", "displacement along x", state="prefer", nominal=1e-5)
    y: Var = var("m", "displacement along y", state="prefer", nominal=1e-5)
    v_x: Var = var("m/s", "velocity along x")
    v_y: Var = var("m/s", "velocity along y")

    def equations(self) -> Iterator[Equation]:
        yield self.at_x.s == self.x
        yield self.at_y.s == self.y
        yield self.v_x == der(self.x)
        yield self.v_y == der(self.y)
        yield self.m * der(self.v_x) == self.at_x.f - self.c * self.x - self.d * self.v_x
        yield self.m * der(self.v_y) == self.at_y.f - self.c * self.y - self.d * self.v_y

    def stored(self) -> Expr:
        """Elastic and kinetic energy, J."""
        moving = self.m * (self.v_x**2 + self.v_y**2)
        return 0.5 * (moving + self.c * (self.x**2 + self.y**2))

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.d * (self.v_x**2 + self.v_y**2)


class PlanarPlanetaryStage(PlanetaryStage):
    """Planetary stage in a plane: also ``m der(v) = f - c x - d v`` of sun, carrier and ring.

    Each has a mass and an isotropic bearing, as parts `at_sun`, `at_carrier` and `at_ring` with the
    displacements x and y; a floating sun has ``c_sun = 0``. All planets are on bearings. Moments of
    inertia of sun, carrier and ring and what holds them against turning are joined to the flanges.

    x and y turn with the carrier. Coriolis and centrifugal forces of this frame are left out: they
    are small where ``w_carrier`` is small beside ``2 pi`` times the natural frequencies.

    Source: Lin and Parker, J. Vibration and Acoustics 121 (1999) 316.
    """

    m_sun: Param = param("kg", "mass of the sun", above=0)
    m_carrier: Param = param("kg", "mass of the carrier", above=0)
    m_ring: Param = param("kg", "mass of the ring", above=0)
    c_sun: Param = param("N/m", "radial stiffness of the bearing of the sun", min=0)
    c_carrier: Param = param("N/m", "radial stiffness of the bearing of the carrier", min=0)
    c_ring: Param = param("N/m", "radial stiffness of the bearing of the ring", min=0)
    d_sun: Param = param("N.s/m", "viscous damping of the bearing of the sun", 0.0, min=0)
    d_carrier: Param = param("N.s/m", "viscous damping of the bearing of the carrier", 0.0, min=0)
    d_ring: Param = param("N.s/m", "viscous damping of the bearing of the ring", 0.0, min=0)
    at_sun: Component = _Centre(m=m_sun, c=c_sun, d=d_sun)
    at_carrier: Component = _Centre(m=m_carrier, c=c_carrier, d=d_carrier)
    at_ring: Component = _Centre(m=m_ring, c=c_ring, d=d_ring)

    _needs_bearings = True

    def connections(self) -> Iterator[Connection]:
        yield from super().connections()
        for name in ("sun", "carrier", "ring"):
            body = getattr(self, f"at_{name}")
            for at in ("x", "y"):
                ports = (getattr(planet, f"{name}_{at}") for planet in self.planets)
                yield connect(getattr(body, f"at_{at}"), *ports)
