"""Plane linkages: arms, rods and springs between points, bars with mass.

Points have a horizontal position `x` (to the right) and a vertical one `y` (up), each a
translational port, in fixed axes. Angles count counter-clockwise from the x axis, as in
`lumped.components.engines.crank` and `lumped.components.gravity`. Masses are joined to both ports
of a point; a centre of mass between two joints is the pin of a further `Eccentric` on the same
flange.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, LinearFlange, Param, Var, der, param, var
from lumped.language.component import Outline
from lumped.ops import asin, cos, sin, sqrt

__all__ = ["Bar", "Eccentric", "GuidedRod", "PlaneSpring"]


class Eccentric(Component):
    """Arm between two points: ``x_pin = x_hub + radius cos(q)``, ``y_pin = y_hub + radius sin(q)``.

    ``q = phi + phase`` is its angle against the horizontal. It is a crank or eccentric; hub or pin
    may be held, and the other moves. The torques and forces follow from virtual work:
    ``tau = radius (f_x sin(q) - f_y cos(q))`` with the forces on the pin, and the hub takes their
    reverse. Open points are free; hold a point with `translation.Fixed`.
    """

    symbol = "arm"
    flange = Flange()
    hub_x = LinearFlange(free=True)
    hub_y = LinearFlange(free=True)
    pin_x = LinearFlange(free=True)
    pin_y = LinearFlange(free=True)
    radius: Param = param("m", "distance of the pin from the hub", nonzero=True)
    phase: Param = param("rad", "angle of the pin at phi = 0", 0.0)

    def equations(self) -> Iterator[Equation]:
        angle = self.flange.phi + self.phase
        side, height = self.radius * cos(angle), self.radius * sin(angle)
        yield self.pin_x.s == self.hub_x.s + side
        yield self.pin_y.s == self.hub_y.s + height
        yield self.hub_x.f == -self.pin_x.f
        yield self.hub_y.f == -self.pin_y.f
        yield self.flange.tau == height * self.pin_x.f - side * self.pin_y.f

    def outline(self) -> Iterator[Outline]:
        yield "arm", ((self.hub_x.s, self.hub_y.s), (self.pin_x.s, self.pin_y.s))


class GuidedRod(Component):
    """Rod that hangs on a pin, its foot in a vertical guide: ``length sin(phi) = x_guide - x_pin``.

    ``y_foot = y_pin - length cos(phi)``; `phi` is the angle at `flange`, counter-clockwise from
    hanging straight down. The horizontal distance of the pin from the guide must stay below the
    length of the rod. An open guide stands at ``x = 0``, an open
    foot is free. The forces follow from virtual work.
    """

    symbol = "rod"
    flange = Flange(free=True)
    pin_x = LinearFlange()
    pin_y = LinearFlange()
    guide_x = LinearFlange(grounded=True)
    foot_y = LinearFlange(free=True)
    length: Param = param("m", "length of the rod", above=0)

    def equations(self) -> Iterator[Equation]:
        phi, pull = self.flange.phi, self.foot_y.f
        side, height = self.length * sin(phi), self.length * cos(phi)
        yield phi == asin((self.guide_x.s - self.pin_x.s) / self.length)
        yield self.foot_y.s == self.pin_y.s - height
        yield self.pin_y.f == -pull
        yield self.pin_x.f == (self.flange.tau + side * pull) / height
        yield self.guide_x.f == -self.pin_x.f

    def outline(self) -> Iterator[Outline]:
        foot = (self.guide_x.s, self.foot_y.s)
        yield "rod", ((self.pin_x.s, self.pin_y.s), foot)
        yield "foot", (foot,)


class PlaneSpring(Component):
    """Spring and damper between two points: ``f = c (length - length0) + d der(length)``.

    ``length = sqrt((x_b - x_a)^2 + (y_b - y_a)^2)``; `f` is positive in tension and acts along the
    line between the points, which must not meet.
    """

    symbol = "spring_damper"
    a_x = LinearFlange()
    a_y = LinearFlange()
    b_x = LinearFlange()
    b_y = LinearFlange()
    c: Param = param("N/m", "stiffness", min=0)
    d: Param = param("N.s/m", "viscous damping", 0.0, min=0)
    length0: Param = param("m", "length without spring force", min=0)
    length: Var = var("m", "distance of the points", state="avoid")
    v: Var = var("m/s", "speed at which it becomes longer")
    f: Var = var("N", "force transmitted")

    def equations(self) -> Iterator[Equation]:
        x, y = self.b_x.s - self.a_x.s, self.b_y.s - self.a_y.s
        yield self.length == sqrt(x**2 + y**2)
        yield self.v == der(self.length)
        yield self.f == self.c * (self.length - self.length0) + self.d * self.v
        yield self.b_x.f == self.f * x / self.length
        yield self.b_y.f == self.f * y / self.length
        yield self.a_x.f == -self.b_x.f
        yield self.a_y.f == -self.b_y.f

    def stored(self) -> Expr:
        """Elastic energy, J."""
        return 0.5 * self.c * (self.length - self.length0) ** 2

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.d * self.v**2

    def outline(self) -> Iterator[Outline]:
        yield "spring", ((self.a_x.s, self.a_y.s), (self.b_x.s, self.b_y.s))


class Bar(Component):
    """Rigid bar with mass between two points: ``x_b = x_a + length cos(phi)``, ``y_b`` with sin.

    Newton's and Euler's laws for its centre of gravity at ``k length`` from a::

        m der(v_x) = f_ax + f_bx,   m (der(v_y) + g) = f_ay + f_by
        J der(w) = tau + moments of the four forces about the centre

    `phi` is the angle at `flange`, where a motor may turn it. Open points and an open flange are
    free; hold a point with `translation.Fixed`.
    """

    symbol = "arm"
    flange = Flange(free=True)
    a_x = LinearFlange(free=True)
    a_y = LinearFlange(free=True)
    b_x = LinearFlange(free=True)
    b_y = LinearFlange(free=True)
    length: Param = param("m", "distance of the points", above=0)
    m: Param = param("kg", "mass", above=0)
    J: Param = param("kg.m2", "moment of inertia about the centre of gravity", min=0)
    k: Param = param("1", "centre of gravity, from a over the length", 0.5)
    g: Param = param("m/s2", "acceleration of free fall, downward", 0.0)
    phi: Var = var("rad", "angle against the horizontal")
    x: Var = var("m", "horizontal position of the centre of gravity")
    y: Var = var("m", "vertical position of the centre of gravity")
    w: Var = var("rad/s", "angular velocity")
    v_x: Var = var("m/s", "horizontal velocity of the centre of gravity")
    v_y: Var = var("m/s", "vertical velocity of the centre of gravity")

    def equations(self) -> Iterator[Equation]:
        side, height = self.length * cos(self.phi), self.length * sin(self.phi)
        before, behind = self.k, 1 - self.k
        f_x, f_y = self.a_x.f + self.b_x.f, self.a_y.f + self.b_y.f
        turning_y = behind * self.b_y.f - before * self.a_y.f
        turning_x = behind * self.b_x.f - before * self.a_x.f
        yield self.flange.phi == self.phi
        yield self.a_x.s == self.x - before * side
        yield self.a_y.s == self.y - before * height
        yield self.b_x.s == self.x + behind * side
        yield self.b_y.s == self.y + behind * height
        yield self.w == der(self.phi)
        yield self.v_x == der(self.x)
        yield self.v_y == der(self.y)
        yield self.m * der(self.v_x) == f_x
        yield self.m * (der(self.v_y) + self.g) == f_y
        yield self.J * der(self.w) == self.flange.tau + side * turning_y - height * turning_x

    def stored(self) -> Expr:
        """Kinetic energy and height, J."""
        moving = self.m * (self.v_x**2 + self.v_y**2) + self.J * self.w**2
        return 0.5 * moving + self.m * self.g * self.y

    def outline(self) -> Iterator[Outline]:
        yield "bar", ((self.a_x.s, self.a_y.s), (self.b_x.s, self.b_y.s))
