"""One planet of a planetary stage, in the plane of the gears."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, LinearFlange, Param, Var, der, param, var
from lumped.components.gearing.mesh_series import of_rows, positive, summed
from lumped.components.gearing.planetary_teeth import least_angle
from lumped.language.value_types import Rows
from lumped.ops import acos, cos, sin

__all__ = ["Planet", "PlanetOnBearing"]


class Planet(Component):
    """Planet that turns on a rigid pin of the carrier, in mesh with sun and ring.

    Its mesh with the sun has the deflection along the line of action, at the angle ``psi_s = psi -
    alpha``, and the force ``f_s = c_s (1 + share_s) s_s + d_s der(s_s)``::

        s_s = r_s (phi_sun - phi_c) + r_p (phi_p - phi_c) - x_s sin(psi_s) + y_s cos(psi_s)
              - radial sin(alpha) - tangential cos(alpha) - e_s

    and that with the ring, at ``psi_r = psi + alpha_r``, alike::

        s_r = r_r (phi_ring - phi_c) - r_p (phi_p - phi_c) - x_r sin(psi_r) + y_r cos(psi_r)
              + radial sin(alpha_r) - tangential cos(alpha_r) - e_r

    `radial` and `tangential` are displacements of its centre: those of the carrier at the pin and
    the errors `pin_r` and `pin_t` of the pin. Angles count from the carrier, x and y in the frame
    that turns with it; open flanges of x and y stand still. Base radii are in the ratio of the
    teeth, and ``(z_s + z_p) cos(alpha_r) = (z_r - z_p) cos(alpha)`` with shifted gears. For torques
    on the other flanks give ``flank=-1``, which reverses alpha.

    `stiffness_s` and `error_s` are rows of harmonic, amplitude and phase, rad, of share_s, 1, and
    of the transmission error e_s, m, over the angle ``z_s (phi_sun - phi_c) + gamma_s`` of the
    mesh, and those of the ring over ``z_r (phi_ring - phi_c) + gamma_r``. The phases gamma follow
    from psi. All torques and forces follow from virtual work. Teeth never part. Coriolis and
    centrifugal forces of the turning frame are left out.

    Source: Lin and Parker, J. Vibration and Acoustics 121 (1999) 316 (deflections); Parker and Lin,
    Mesh phasing relationships, J. Mechanical Design 126 (2004) 365 (phases).
    """

    symbol = "gear"
    sun = Flange()
    carrier = Flange()
    ring = Flange()
    sun_x = LinearFlange(grounded=True)
    sun_y = LinearFlange(grounded=True)
    carrier_x = LinearFlange(grounded=True)
    carrier_y = LinearFlange(grounded=True)
    ring_x = LinearFlange(grounded=True)
    ring_y = LinearFlange(grounded=True)
    z_s: int = 0
    z_p: int = 0
    z_r: int = 0
    flank: int = 1
    stiffness_s: Rows = ()
    stiffness_r: Rows = ()
    error_s: Rows = ()
    error_r: Rows = ()
    r_s: Param = param("m", "base radius of the sun", above=0)
    alpha: Param = param(
        "rad",
        "working pressure angle at the sun",
        above=lambda p: least_angle(p.z_s, p.z_p, p.z_r),
        below=0.8,
    )
    psi: Param = param("rad", "angle of its pin on the carrier", 0.0)
    m: Param = param("kg", "mass", min=0)
    J: Param = param("kg.m2", "moment of inertia about its pin", above=0)
    c_s: Param = param("N/m", "mean stiffness of the mesh with the sun", above=0)
    c_r: Param = param("N/m", "mean stiffness of the mesh with the ring", above=0)
    d_s: Param = param("N.s/m", "viscous damping of the mesh with the sun", 0.0, min=0)
    d_r: Param = param("N.s/m", "viscous damping of the mesh with the ring", 0.0, min=0)
    pin_t: Param = param("m", "error of its pin in the sense of rotation", 0.0)
    pin_r: Param = param("m", "error of its pin outwards", 0.0)
    gamma_s: Param = param("rad", "phase of the mesh with the sun", lambda p: -p.z_s * p.psi)
    gamma_r: Param = param("rad", "phase of the mesh with the ring", lambda p: -p.z_r * p.psi)
    s_s: Var = var("m", "deflection of the mesh with the sun", nominal=1e-5, state="prefer")
    s_r: Var = var("m", "deflection of the mesh with the ring", nominal=1e-5, state="prefer")
    v_s: Var = var("m/s", "rate of the deflection at the sun")
    v_r: Var = var("m/s", "rate of the deflection at the ring")
    f_s: Var = var("N", "force of the mesh with the sun")
    f_r: Var = var("N", "force of the mesh with the ring")
    tau: Var = var("N.m", "its share of the torque on the sun")
    phi_p: Var = var("rad", "angle", state="avoid")
    w_p: Var = var("rad/s", "angular velocity")
    s_radial: Var = var("m", "yield of its bearing outwards", nominal=1e-5, state="prefer")
    s_tangential: Var = var("m", "yield of its bearing along", nominal=1e-5, state="prefer")
    v_radial: Var = var("m/s", "velocity outwards")
    v_tangential: Var = var("m/s", "velocity in the sense of rotation")
    f_radial: Var = var("N", "force of the pin on it outwards")
    f_tangential: Var = var("N", "force of the pin on it in the sense of rotation")

    def equations(self) -> Iterator[Equation]:
        sun, carrier, ring, psi = self.sun, self.carrier, self.ring, self.psi
        r_s, r_p, r_r = self.r_s, self.r_p, self.r_r
        at_s, at_r = self._angles()
        to_s, to_r = psi - at_s, psi + at_r
        at_sun, at_ring = sun.phi - carrier.phi, ring.phi - carrier.phi
        spin = self.phi_p - carrier.phi
        x, y = self.carrier_x.s, self.carrier_y.s
        radial = x * cos(psi) + y * sin(psi) + self.pin_r + self.s_radial
        tangential = y * cos(psi) - x * sin(psi) + self.pin_t + self.s_tangential
        e_s, along_s = summed(of_rows("error_s", self.error_s), self._mesh_s())
        e_r, along_r = summed(of_rows("error_r", self.error_r), self._mesh_r())
        (share_s, slope_s), (share_r, slope_r) = self._shares()
        yield self.s_s == (
            r_s * at_sun + r_p * spin - self.sun_x.s * sin(to_s) + self.sun_y.s * cos(to_s)
            - radial * sin(at_s) - tangential * cos(at_s) - e_s
        )  # fmt: skip
        yield self.s_r == (
            r_r * at_ring - r_p * spin - self.ring_x.s * sin(to_r) + self.ring_y.s * cos(to_r)
            + radial * sin(at_r) - tangential * cos(at_r) - e_r
        )  # fmt: skip
        yield self.v_s == der(self.s_s)
        yield self.v_r == der(self.s_r)
        yield self.f_s == self.c_s * (1 + share_s) * self.s_s + self.d_s * self.v_s
        yield self.f_r == self.c_r * (1 + share_r) * self.s_r + self.d_r * self.v_r
        yield self.tau == r_s * self.f_s
        yield self.w_p == der(self.phi_p)
        yield self.J * der(self.w_p) == r_p * (self.f_r - self.f_s)
        yield from self._bearing()
        yield self.v_radial == der(radial)
        yield self.v_tangential == self.a * der(carrier.phi) + der(tangential)
        outwards = self.f_s * sin(at_s) - self.f_r * sin(at_r)
        along = self.f_s * cos(at_s) + self.f_r * cos(at_r)
        yield self.m * der(self.v_radial) == self.f_radial + outwards
        yield self.m * der(self.v_tangential) == self.f_tangential + along
        bend_s = self.z_s * (self.c_s * slope_s * self.s_s**2 / 2 - self.f_s * along_s)
        bend_r = self.z_r * (self.c_r * slope_r * self.s_r**2 / 2 - self.f_r * along_r)
        yield sun.tau == self.tau + bend_s
        yield ring.tau == r_r * self.f_r + bend_r
        yield carrier.tau == self.a * self.f_tangential - bend_s - bend_r
        yield self.sun_x.f == -self.f_s * sin(to_s)
        yield self.sun_y.f == self.f_s * cos(to_s)
        yield self.ring_x.f == -self.f_r * sin(to_r)
        yield self.ring_y.f == self.f_r * cos(to_r)
        yield self.carrier_x.f == self.f_radial * cos(psi) - self.f_tangential * sin(psi)
        yield self.carrier_y.f == self.f_radial * sin(psi) + self.f_tangential * cos(psi)

    @property
    def r_p(self) -> Expr:
        """Base radius, m."""
        return self.r_s * (self.z_p / self.z_s)

    @property
    def r_r(self) -> Expr:
        """Base radius of the ring, m."""
        return self.r_s * (self.z_r / self.z_s)

    @property
    def a(self) -> Expr:
        """Distance of the pin from the axis, m."""
        return (self.r_s + self.r_p) / cos(self.alpha)

    def _bearing(self) -> Iterator[Equation]:
        yield self.s_radial == 0
        yield self.s_tangential == 0

    def _angles(self) -> tuple[Expr, Expr]:
        """Pressure angles at sun and ring, with the sign of the flank."""
        at_s = self.flank * self.alpha
        if self.z_r == self.z_s + 2 * self.z_p:
            return at_s, at_s
        return at_s, self.flank * acos((self.z_r - self.z_p) / (self.z_s + self.z_p) * cos(at_s))

    def _mesh_s(self) -> Expr:
        return self.z_s * (self.sun.phi - self.carrier.phi) + self.gamma_s

    def _mesh_r(self) -> Expr:
        return self.z_r * (self.ring.phi - self.carrier.phi) + self.gamma_r

    def _shares(self) -> tuple[tuple[Expr, Expr], tuple[Expr, Expr]]:
        """What the stiffnesses vary by, relative to their means, and the slopes of that."""
        return (
            summed(positive(of_rows("stiffness_s", self.stiffness_s)), self._mesh_s()),
            summed(positive(of_rows("stiffness_r", self.stiffness_r)), self._mesh_r()),
        )

    def stored(self) -> Expr:
        """Elastic energy of the meshes and kinetic energy, J."""
        (share_s, _), (share_r, _) = self._shares()
        elastic = self.c_s * (1 + share_s) * self.s_s**2 + self.c_r * (1 + share_r) * self.s_r**2
        moving = self.m * (self.v_radial**2 + self.v_tangential**2) + self.J * self.w_p**2
        return 0.5 * (elastic + moving)

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.d_s * self.v_s**2 + self.d_r * self.v_r**2


class PlanetOnBearing(Planet):
    """Planet whose bearing yields on its pin: ``f = -c_b s - d_b der(s)``, outwards and along.

    All else is that of a `Planet`.
    """

    c_b: Param = param("N/m", "radial stiffness of its bearing", above=0)
    d_b: Param = param("N.s/m", "viscous damping of its bearing", 0.0, min=0)

    def _bearing(self) -> Iterator[Equation]:
        yield self.f_radial == -self.c_b * self.s_radial - self.d_b * der(self.s_radial)
        yield self.f_tangential == -self.c_b * self.s_tangential - self.d_b * der(self.s_tangential)

    def stored(self) -> Expr:
        """Elastic energy of meshes and bearing, and kinetic energy, J."""
        yielded = self.s_radial**2 + self.s_tangential**2
        return super().stored() + 0.5 * self.c_b * yielded

    def loss(self) -> Expr:
        """Dissipated power, W."""
        rates = der(self.s_radial) ** 2 + der(self.s_tangential) ** 2
        return super().loss() + self.d_b * rates
