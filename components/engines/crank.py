"""Cranks: crank-slider with a heavy rod, rotating masses, and the load of a working stroke.

All of them lie in one plane, x to the right and y up, on a frame that may move along x and y but
not turn. The flanges `frame_x` and `frame_y` transmit the inertia forces to the foundation, with
the weights if `g` is given.

Source: Dresig and Holzweissig, Dynamics of Machinery, ch. 2.4 and 2.6 (reduced inertia, two
masses in place of a rod, balancing).
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import (
    Component,
    Equation,
    Expr,
    Flange,
    LinearFlange,
    Output,
    Param,
    Var,
    der,
    param,
    var,
)
from lumped.errors import EquationError
from lumped.language.component import Outline
from lumped.language.expression import ConstantExpression
from lumped.ops import atan2, cos, maximum, minimum, pi, sin, smooth, sqrt

__all__ = ["CrankSlider", "RotatingMass", "StrokeLoad"]


def _shortest(crank: CrankSlider) -> Expr:
    """Length that the rod must exceed: for whole turns, or for start values to choose an assembly.

    A rod of just ``r + |e|`` turns at once at a dead centre, and a longer one within an angle that
    steps must meet.
    """
    r, e = CrankSlider.r, abs(CrankSlider.e)
    return maximum(0.0, e - r) if crank.assembly == 0 else r + e + _LONGER * (r + e)


_LONGER = 1e-8
_NOTHING = 1e-300


class CrankSlider(Component):
    """Crank, heavy rod, slider: ``s = r cos(q) + L cos(psi)``, ``L sin(psi) = e - r sin(q)``.

    ``q = phi + phase - axis`` is the angle of the crank against the slide, which has the direction
    `axis` in the plane and passes the crank's centre at the distance `e` to its left. The slider's
    flange counts along the slide. `assembly` 1 puts it ahead of the crank pin, -1 behind it, for a
    crank that can turn round: ``L > r + |e|``, by 1e-8 of it. With 0 the start values choose
    (``psi=0.0``, ``psi=3.1``), and a shorter rod, whose crank swings to and fro, may pass from one
    to the other, at the cost of an iteration in each step.

    With the rod's centre of gravity at ``k L`` from the crank pin, exactly (J is about the centre
    of gravity)::

        kinetic energy = (1 - k) m_rod v_pin^2 / 2 + (m + k m_rod) v_slider^2 / 2 + J' w_psi^2 / 2,
        J' = J_rod - m_rod k (1 - k) L^2

    and the crank torque follows by virtual work. J' is negative for a slender rod. `two_mass`
    leaves it out: the usual replacement by two masses, exact for the force on the foundation but
    not for the torque. Rod and slider may be without mass.
    """

    symbol = "crank"
    flange = Flange()
    slider = LinearFlange(free=True)
    frame_x = LinearFlange(grounded=True)
    frame_y = LinearFlange(grounded=True)
    guide = Output("N", "force of the guide on the slider, to the left")
    bearing_x = Output("N", "force on the crank bearing along x, without parts that only rotate")
    bearing_y = Output("N", "force on the crank bearing along y, without parts that only rotate")
    r: Param = param("m", "crank radius", min=0)
    e: Param = param("m", "offset of the slide, to the left of its direction", 0.0)
    L: Param = param("m", "length of the rod", above=_shortest)
    m: Param = param("kg", "mass of the slider", 0.0, min=0)
    m_rod: Param = param("kg", "mass of the rod", 0.0, min=0)
    J_rod: Param = param("kg.m2", "moment of inertia of the rod about its centre", 0.0, min=0)
    k: Param = param("1", "centre of gravity of the rod, from the crank pin over L", 0.5)
    axis: Param = param("rad", "direction of the slide", 0.0)
    phase: Param = param("rad", "angle of the crank pin at phi = 0", 0.0)
    g: Param = param("m/s2", "acceleration of free fall", 0.0)
    down: Param = param("rad", "direction of the weight", -pi / 2)
    assembly: int = 1
    two_mass: bool = False
    s: Var = var("m", "position of the slider from the crank's centre", state="avoid")
    v: Var = var("m/s", "velocity of the slider", state="avoid")
    a: Var = var("m/s2", "acceleration of the slider")
    psi: Var = var("rad", "angle of the rod against the slide", state="avoid")
    w_rod: Var = var("rad/s", "angular velocity of the rod", state="avoid")
    a_rod: Var = var("rad/s2", "angular acceleration of the rod")

    def equations(self) -> Iterator[Equation]:
        a, b, x, y = self.flange, self.slider, self.frame_x, self.frame_y
        angle, r, L, psi = a.phi + self.phase, self.r, self.L, self.psi
        q = angle - self.axis
        rise = self.e - r * sin(q)
        run = self._run(rise)
        yield self.s == r * cos(q) + run
        yield L * sin(psi) == rise if self.assembly == 0 else psi == atan2(rise, run)
        along = cos(self.axis), sin(self.axis)
        yield b.s == self.s + x.s * along[0] + y.s * along[1]
        yield self.v == der(self.s)
        yield self.a == der(self.v)
        yield self.w_rod == der(psi)
        yield self.a_rod == der(self.w_rod)

        at_pin, at_slider = (1 - self.k) * self.m_rod, self.m + self.k * self.m_rod
        fall = _fall(self)
        spare = self.J_rod - self.m_rod * self.k * (1 - self.k) * L**2
        spin = ConstantExpression(0.0) if self.two_mass else spare * self.a_rod
        push = at_slider * (self.a + fall[0] * along[0] + fall[1] * along[1]) - b.f
        # virtual work; psi turns by -r cos(q) / (L cos(psi)) for each radian of the crank
        turn = -r * cos(q) / run
        pin = -fall[0] * sin(angle) + fall[1] * cos(angle)
        yield a.tau == (
            at_pin * r * (r * der(der(a.phi)) + pin)
            - push * (r * sin(q) + rise * turn)
            + spin * turn
        )
        across = at_slider * (fall[1] * along[0] - fall[0] * along[1])
        yield self.guide == across + (spin - rise * push) / run
        for f, u, bearing, w, n, side in (
            (x.f, cos(angle), self.bearing_x, along[0], fall[0], -along[1]),
            (y.f, sin(angle), self.bearing_y, along[1], fall[1], along[0]),
        ):
            yield f == (at_pin * (r * der(der(u)) + n) + at_slider * (self.a * w + n) - b.f * w)
            yield bearing == self.guide * side - f

    def stored(self) -> Expr:
        """Kinetic energy of rod and slider, and what their weights store, J."""
        x, y, angle = self.frame_x.s, self.frame_y.s, self.flange.phi + self.phase
        c, s, k, w = cos(self.axis), sin(self.axis), self.k, der(self.flange.phi)
        at_pin, at_slider = (1 - k) * self.m_rod, self.m + k * self.m_rod
        pin = _energy(
            self,
            at_pin,
            (x + self.r * cos(angle), y + self.r * sin(angle)),
            (der(x) - self.r * w * sin(angle), der(y) + self.r * w * cos(angle)),
        )
        slider = _energy(
            self,
            at_slider,
            (x + self.s * c - self.e * s, y + self.s * s + self.e * c),
            (der(x) + self.v * c, der(y) + self.v * s),
        )
        if self.two_mass:
            return pin + slider
        spare = self.J_rod - self.m_rod * k * (1 - k) * self.L**2
        return pin + slider + 0.5 * spare * self.w_rod**2

    def outline(self) -> Iterator[Outline]:
        x, y, angle = self.frame_x.s, self.frame_y.s, self.flange.phi + self.phase
        c, s = cos(self.axis), sin(self.axis)
        pin = (x + self.r * cos(angle), y + self.r * sin(angle))
        slider = (x + self.s * c - self.e * s, y + self.s * s + self.e * c)
        yield "crank", ((x, y), pin)
        yield "rod", (pin, slider)
        yield "slider", (slider,)

    def _run(self, rise: Expr) -> Expr:
        """Length of the rod along the slide."""
        if self.assembly == 0:
            return self.L * cos(self.psi)
        if self.assembly not in (1, -1):
            raise EquationError(
                f"assembly = {self.assembly!r} must be 1 (slider ahead of the crank pin), -1 "
                "(behind it), or 0 (the start values choose)."
            )
        return self.assembly * sqrt(self.L**2 - rise**2)


class RotatingMass(Component):
    """Mass point on a shaft at the radius `r`: ``tau = (m r^2 + J) a``, ``f = m r w^2`` outward.

    A crank pin, a counterweight, an unbalance; `m r` is its mass moment. At ``phi = 0`` it lies at
    the angle `phase` in the plane. Weight and motion of the frame act on the torque too.
    """

    symbol = "arm"
    flange = Flange()
    frame_x = LinearFlange(grounded=True)
    frame_y = LinearFlange(grounded=True)
    m: Param = param("kg", "mass", min=0)
    r: Param = param("m", "distance of its centre from the axis", min=0)
    J: Param = param("kg.m2", "moment of inertia about its own centre", 0.0, min=0)
    phase: Param = param("rad", "angle of the mass at phi = 0", 0.0)
    g: Param = param("m/s2", "acceleration of free fall", 0.0)
    down: Param = param("rad", "direction of the weight", -pi / 2)

    def equations(self) -> Iterator[Equation]:
        a, r = self.flange, self.r
        angle, fall = a.phi + self.phase, _fall(self)
        pull = -fall[0] * sin(angle) + fall[1] * cos(angle)
        yield a.tau == self.m * r * (r * der(der(a.phi)) + pull) + self.J * der(der(a.phi))
        yield self.frame_x.f == self.m * (r * der(der(cos(angle))) + fall[0])
        yield self.frame_y.f == self.m * (r * der(der(sin(angle))) + fall[1])

    def stored(self) -> Expr:
        """Kinetic energy, and what the weight stores, J."""
        x, y, w = self.frame_x.s, self.frame_y.s, der(self.flange.phi)
        angle, r = self.flange.phi + self.phase, self.r
        place = x + r * cos(angle), y + r * sin(angle)
        speed = der(x) - r * w * sin(angle), der(y) + r * w * cos(angle)
        return _energy(self, self.m, place, speed) + 0.5 * self.J * w**2

    def outline(self) -> Iterator[Outline]:
        x, y, angle = self.frame_x.s, self.frame_y.s, self.flange.phi + self.phase
        centre = (x + self.r * cos(angle), y + self.r * sin(angle))
        yield "arm", ((x, y), centre)
        yield "mass", (centre,)


class StrokeLoad(Component):
    """Force against the motion that depends on the position: ``f = -sign(v) F g(z)``.

    ``z = (s - s_0) / (s_1 - s_0)`` and ``g = (z/z_m)^p ((1 - z)/(1 - z_m))^q`` with its greatest
    value 1 at ``z_m = p / (p + q)``: none at the ends of the stroke and beyond. `F` is `forward`
    from s_0 to s_1 and `backward` on the way back. The sign is straight between ``-v_0`` and
    ``v_0``, so the load slows a standstill but does not hold it. With an exponent below 1 the force
    begins or ends infinitely steeply: runs pass there slowly, and derivatives may not exist.
    """

    symbol = "force"
    flange = LinearFlange()
    support = LinearFlange(grounded=True)
    forward: Param = param("N", "greatest force on the way from s_0 to s_1", min=0)
    backward: Param = param("N", "greatest force on the way back", min=0)
    s_0: Param = param("m", "begin of the stroke, relative to the support")
    s_1: Param = param("m", "end of the stroke, relative to the support", above=s_0)
    p: Param = param("1", "exponent at the begin", above=0)
    q: Param = param("1", "exponent at the end", above=0)
    v_0: Param = param("m/s", "speed up to which the force grows", 1e-3, above=0)
    v: Var = var("m/s", "velocity relative to the support")
    f: Var = var("N", "driving force")

    def equations(self) -> Iterator[Equation]:
        p, q = self.p, self.q
        s = self.flange.s - self.support.s
        yield self.v == der(s)
        # not quite zero outside the stroke: at zero a power has no derivative by its exponent
        begin = smooth(maximum((s - self.s_0) * (p + q) / (p * (self.s_1 - self.s_0)), _NOTHING))
        end = smooth(maximum((self.s_1 - s) * (p + q) / (q * (self.s_1 - self.s_0)), _NOTHING))
        back, forth = (smooth(minimum(maximum(u / self.v_0, 0), 1)) for u in (-self.v, self.v))
        yield self.f == (self.backward * back - self.forward * forth) * begin**p * end**q
        yield self.flange.f == -self.f
        yield self.support.f == self.f

    def loss(self) -> Expr:
        """Power of the working process, W."""
        return -self.f * self.v


def _energy(
    part: CrankSlider | RotatingMass,
    m: Expr,
    place: tuple[Expr, Expr],
    speed: tuple[Expr, Expr],
) -> Expr:
    """Kinetic energy of a mass, and what its weight stores, J."""
    low = place[0] * cos(part.down) + place[1] * sin(part.down)
    return m * (0.5 * (speed[0] ** 2 + speed[1] ** 2) - part.g * low)


def _fall(part: CrankSlider | RotatingMass) -> tuple[Expr, Expr]:
    """Acceleration of the frame minus that of free fall, along x and y."""
    return (
        der(der(part.frame_x.s)) - part.g * cos(part.down),
        der(der(part.frame_y.s)) - part.g * sin(part.down),
    )
