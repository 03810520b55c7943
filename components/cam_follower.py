"""Cams with followers that may lift off.

Source: Norton, Cam Design and Manufacturing Handbook, ch. 2 to 4 (motion laws), 8 (follower jump).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Literal

from lumped import (
    Component,
    Connection,
    Equation,
    Expr,
    Flange,
    LinearFlange,
    Param,
    chain,
    connect,
    lossless,
    param,
)
from lumped.components.cams import within
from lumped.components.rows import check_rows
from lumped.components.translation import ElastoGap, Fixed, Mass, Spring, Stop
from lumped.errors import EquationError
from lumped.language.expression import Datum, Number, as_expr
from lumped.language.value_types import Rows
from lumped.ops import atan2, cos, pi, sin, where

__all__ = ["Cam", "CamFollower", "cam_motion"]

Motion = Callable[[Expr], Number]


class Cam(Component):
    """Cam that lifts a surface: ``s = profile(phi)``, ``tau = -profile'(phi) f``.

    `profile` takes the angle of the cam and returns the lift in m of a follower that stays on it,
    written with `lumped.ops`, such as ``lambda x: 0.005 * (1 - lp.ops.cos(x))``; `cam_motion` makes
    one of rises, returns and dwells. `flange_b` is what the follower touches: joined to a mass, the
    cam drives it both ways (grooved cam); a `translation.Stop` between them lets it lift off.

    Angles count from `support_a`, on which the drive reacts, lifts from `support`, which guides the
    follower; open supports stand still.
    """

    symbol = "cam"
    flange_a = Flange()
    flange_b = LinearFlange()
    support_a = Flange(grounded=True)
    support = LinearFlange(grounded=True)
    profile: Motion | None = None

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        if not callable(self.profile):
            raise EquationError(
                f"profile = {self.profile!r}: a function of the angle of the cam is needed, for "
                "example profile=lambda x: 0.005 * (1 - lp.ops.cos(x)), or cam_motion(points)."
            )
        a, b, at_a, base = self.flange_a, self.flange_b, self.support_a, self.support
        lift = as_expr(self.profile(a.phi - at_a.phi))
        yield lossless(b.s == base.s + lift, a, b, at_a, base)


class CamFollower(Component):
    """Follower on a cam: ``m s'' = f - F_0 - c s``, with ``f >= 0``, ``s >= profile``, one equal.

    `s` is the lift of the `mass`, ``f = -contact.f`` the force of the cam on it, `F_0` the preload
    of the spring at no lift. Where the force would become negative, at an even speed where ``m
    profile'' w^2 < -F_0 - c profile``, it lifts off, flies as a free oscillator, and comes back by
    an impact with the given `restitution`. Both are events. Further parts join it at `follower`;
    `contact` may be replaced by a `translation.ElastoGap`.
    """

    symbol = "cam"
    flange = Flange()
    follower = LinearFlange(free=True)
    m: Param = param("kg", "mass of the follower", above=0)
    c: Param = param("N/m", "stiffness of the spring", above=0)
    F_0: Param = param("N", "preload of the spring at no lift", min=0)
    restitution: Param = param("1", "speed after an impact over that before", 0.0, min=0, max=1)
    cam: Cam = Cam()
    contact: Stop | ElastoGap = Stop(restitution=restitution)
    mass: Mass = Mass(m=m)
    spring: Spring = Spring(c=c, s_rel0=F_0 / c)
    frame: Fixed = Fixed()

    def connections(self) -> Iterator[Connection]:
        yield connect(self.flange, self.cam.flange_a)
        yield from chain(self.cam, self.contact, self.mass, self.spring, self.frame)
        yield connect(self.mass.flange_b, self.follower)


def cam_motion(
    points: Rows, law: Literal["cycloidal", "harmonic", "polynomial"] = "cycloidal"
) -> Motion:
    """Profile of a `Cam` by rises, returns and dwells, in any number of turns.

    With ``u`` from 0 to 1 between two points, the lift grows by the share ``u - sin(2 pi u) / (2
    pi)`` (cycloidal), ``(1 - cos(pi u)) / 2`` (harmonic, whose acceleration jumps at both ends) or
    ``10 u^3 - 15 u^4 + 6 u^5`` (polynomial 3-4-5). A run stops at the points.

    Parameters
    ----------
    points : rows
        Angle, rad, and lift, m, within one turn; the first point also ends the turn. Between points
        of the same lift the follower rests.
    law : str
        How the lift goes from one point to the next.

    Returns
    -------
    function
        Lift, m, over the angle, rad.

    Raises
    ------
    EquationError
        If there are less than two points, or their angles do not increase within a turn.
    """
    rows = check_rows("points", points, "angle (rad) and lift (m)", "((0, 0), (1, 0.01))")
    if law not in _LAWS:
        raise EquationError(f"law = {law!r}: {', '.join(map(repr, _LAWS))} are known.")
    first, last = rows[0][0], rows[-1][0]
    if any(not a < b for (a, _), (b, _) in pairwise(rows)) or not first < last < first + 2 * pi:
        raise EquationError(
            f"points = {points!r}: at least two angles that increase within one turn are needed, "
            f"here below {first + 2 * pi:g} rad, where the first point returns. Angles are in rad."
        )
    *middle, end = pairwise([*rows, (first + 2 * pi, rows[0][1])])
    before = (last - 2 * pi + first) / 2

    def profile(phi: Expr) -> Expr:
        lift = _section(phi, *middle[-1], law)
        # each condition changes alone, those after it hold there for certain
        for section in reversed(middle[:-1]):
            until = section[1][0]
            near = within(phi, (before + until) / 2, until - before)
            lift = where(near, _section(phi, *section, law), lift)
        at_end = within(phi, (end[0][0] + end[1][0]) / 2, end[1][0] - end[0][0])
        return where(at_end, _section(phi, *end, law), lift)

    return profile


def _section(phi: Expr, begin: tuple[float, ...], end: tuple[float, ...], law: str) -> Expr:
    """Lift between two points."""
    (a, low), (b, high) = begin, end
    x = phi - (a + b) / 2
    u = atan2(sin(x), cos(x)) / (b - a) + 0.5
    return Datum(low) + Datum(high - low) * _LAWS[law](u)


_LAWS: dict[str, Callable[[Expr], Expr]] = {
    "cycloidal": lambda u: u - sin(2 * pi * u) / (2 * pi),
    "harmonic": lambda u: (1 - cos(pi * u)) / 2,
    "polynomial": lambda u: u**3 * (10 - 15 * u + 6 * u**2),
}
