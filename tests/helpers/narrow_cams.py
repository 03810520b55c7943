"""A shaft whose quantities change within a small part of a turn."""

import lumped as lp
from lumped.ops import cos, exp, maximum, minimum, sin, smooth, where


class Cam(lp.Component):
    """A shaft with a narrow cam, and a lever with kinks."""

    w: lp.Param = lp.param("rad/s", "speed", 30.0)
    b: lp.Param = lp.param("rad", "half width", 0.01)
    phi: lp.Var = lp.var("rad", "angle", 0.3, state="always")
    lift: lp.Var = lp.var("1", "lift")
    roof: lp.Var = lp.var("1", "edge that is met for an instant")
    saw: lp.Var = lp.var("1", "lower of two waves")
    jump: lp.Var = lp.var("1", "jumps down")
    still: lp.Var = lp.var("1", "what hardly changes")

    def equations(self):
        phi = self.phi
        yield lp.der(phi) == self.w
        yield self.lift == exp(-((sin(phi / 2) / self.b) ** 2)) * (1 + 0.1 * cos(phi / 7))
        yield self.roof == smooth(2 - abs(sin(phi - 1)) - 0.1 * abs(cos(phi)))
        yield self.saw == smooth(minimum(sin(phi), maximum(cos(phi), -0.9)))
        yield self.jump == smooth(where(phi < 4.0, phi, phi - 4.0))
        yield self.still == sin(phi) ** 2 + cos(phi) ** 2
