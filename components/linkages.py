"""Plane linkages of arms and rods: kinematics only, bodies and supports are joined to the ports.

Points have a horizontal position `x` and a vertical one `y`, each a translational port, in fixed
axes. Angles count from the vertical. Masses are joined to both ports of a point; a centre of mass
between two joints is the pin of a further `Eccentric` on the same flange.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Flange, LinearFlange, Param, param
from lumped.component import Outline
from lumped.ops import asin, cos, sin

__all__ = ["Eccentric", "GuidedRod"]


class Eccentric(Component):
    """Arm between two points: ``x_pin = x_hub + radius sin(phi)``, ``y_pin = y_hub + radius cos``.

    A crank or eccentric whose hub may stand still or move as well: either point may be held. The
    torques and forces follow from virtual work:
    ``tau = -radius (f_x cos(phi) - f_y sin(phi))`` with the forces on the pin, and the hub takes
    their reverse. Open points are free; hold a point with `translation.Fixed`.
    """

    symbol = "arm"
    flange = Flange()
    hub_x = LinearFlange(free=True)
    hub_y = LinearFlange(free=True)
    pin_x = LinearFlange(free=True)
    pin_y = LinearFlange(free=True)
    radius: Param = param("m", "distance of the pin from the hub", nonzero=True)

    def equations(self) -> Iterator[Equation]:
        side, height = self.radius * sin(self.flange.phi), self.radius * cos(self.flange.phi)
        yield self.pin_x.s == self.hub_x.s + side
        yield self.pin_y.s == self.hub_y.s + height
        yield self.hub_x.f == -self.pin_x.f
        yield self.hub_y.f == -self.pin_y.f
        yield self.flange.tau == side * self.pin_y.f - height * self.pin_x.f

    def outline(self) -> Iterator[Outline]:
        yield "arm", ((self.hub_x.s, self.hub_y.s), (self.pin_x.s, self.pin_y.s))


class GuidedRod(Component):
    """Rod that hangs on a pin, its foot in a vertical guide: ``length sin(phi) = x_pin - x_guide``.

    ``y_foot = y_pin - length cos(phi)``; `phi` is the angle at `flange`. The pin must stay within
    the length of the rod to both sides of the guide. An open guide stands at ``x = 0``, an open
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
        yield phi == asin((self.pin_x.s - self.guide_x.s) / self.length)
        yield self.foot_y.s == self.pin_y.s - height
        yield self.pin_y.f == -pull
        yield self.pin_x.f == -(self.flange.tau + side * pull) / height
        yield self.guide_x.f == -self.pin_x.f

    def outline(self) -> Iterator[Outline]:
        foot = (self.guide_x.s, self.foot_y.s)
        yield "rod", ((self.pin_x.s, self.pin_y.s), foot)
        yield "foot", (foot,)
