"""Sprockets: chains that lie on a wheel as a polygon.

Source: Niemann and Winter, Maschinenelemente, vol. 3, ch. 26 (polygon effect).
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Flange, LinearFlange, Param, lossless, param
from lumped.errors import EquationError
from lumped.ops import atan2, cos, pi, sin, where

__all__ = ["Sprocket"]


class Sprocket(Component):
    """Sprocket that pulls a straight strand: ``v = r cos(y) w``, ``f = -tau / (r cos(y))``.

    The chain lies on the sprocket of `z` teeth as a polygon of radius ``r = pitch / (2 sin(pi /
    z))``. ``y`` is the angle of the joint that pulls from the right angle to the strand; it runs
    from ``-pi / z`` to ``pi / z`` and begins again when the next joint takes over, which is an
    event. At an even speed that of the chain falls by the share ``1 - cos(pi / z)`` in every pitch,
    and its acceleration jumps by ``pitch w^2``. A turn takes z pitches. `phase` is that angle at
    ``phi = 0``.

    The direction of the strand is taken as constant. `s` counts from `support` and `phi` from
    `support_a`, as in a `RackAndPinion`; open supports stand still. Two sprockets joined by a
    strand that only pulls are a chain drive.
    """

    symbol = "rack"
    flange_a = Flange()
    flange_b = LinearFlange()
    support_a = Flange(grounded=True)
    support = LinearFlange(grounded=True)
    z: int = 17
    pitch: Param = param("m", "pitch of the chain", above=0)
    phase: Param = param("rad", "angle of the joint that pulls at phi = 0", 0.0)

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        if not isinstance(self.z, int) or self.z < 3:
            raise EquationError(f"z = {self.z!r}: a whole number of at least 3 teeth is needed.")
        a, b, at_a, base, z = self.flange_a, self.flange_b, self.support_a, self.support, self.z
        x = a.phi - at_a.phi + self.phase
        # from the middle of even and of odd pitches, each smooth at the ends of its own
        half = z * x / 2
        even, odd = (2 / z * atan2(k * sin(half), k * cos(half)) for k in (1, -1))
        y = where((cos(half) > 0).called("even joint pulls", "odd joint pulls"), even, odd)
        r = self.pitch / (2 * sin(pi / z))
        way = z * self.pitch / (2 * pi) * (x - y) + r * sin(y)
        yield lossless(b.s == base.s + way, a, b, at_a, base)
