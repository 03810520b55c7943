"""Screws and worm gears: threads with friction, which may hold themselves.

A thread of the lead angle l whose flank has the angle of friction r has the efficiencies

    eta_a = tan(l) / tan(l + r),    eta_b = tan(l - r) / tan(l)

while the screw (a) and while its load (b) drives. With ``r >= l`` the load cannot: ``eta_b <= 0``.
A flank that is inclined by alpha presses more: ``tan(r) = mu / cos(alpha)``.

Source: Budynas and Nisbett, Shigley's Mechanical Engineering Design, ch. 8-2 (power screws) and
13-17 (worm gears).
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Expr, Flange, LinearFlange, Param, Port, der, param
from lumped.components.gearing.lossy_gear import Meshing
from lumped.language.switch import Item
from lumped.ops import cos, pi, tan

__all__ = ["BallScrew", "LeadScrew", "WormGear"]


class _Screw(Meshing):
    """Screw against a nut that is kept from turning: ``s = lead / (2 pi) phi``."""

    symbol = "screw"
    flange_b = LinearFlange()
    support_a = Flange(grounded=True)
    support = LinearFlange(grounded=True)
    lead: Param = param("m", "way in one turn, negative if left-handed", nonzero=True)
    eta_a: Param = param("1", "efficiency while the screw drives", above=0, max=1)
    eta_b: Param = param("1", "efficiency while the load drives", max=1)

    def equations(self) -> Iterator[Item]:
        yield from _mesh(self, 2 * pi / self.lead, self.flange_b, self.support)


class BallScrew(_Screw):
    """Screw of given efficiencies: ``s = lead / (2 pi) phi``, ``f = -(2 pi / lead) eta_a tau``.

    While the load drives, ``tau = -eta_b lead / (2 pi) f``. With `eta_b` at zero or below the screw
    holds itself. At standstill it is stuck between both laws.

    `s` counts from `support`, the thrust bearing, which takes ``-f``, and `phi` from `support_a`,
    which keeps the nut from turning and takes ``-tau``. Open supports stand still.
    """


class LeadScrew(_Screw):
    """Screw that slides: ``eta_a = tan(l) / tan(l + r)``, ``eta_b = tan(l - r) / tan(l)``.

    ``tan(l) = abs(lead) / (pi d)``, ``tan(r) = mu / cos(alpha)``; in all else a `BallScrew`. With
    ``r >= l`` its load cannot drive it.

    Source: Shigley's Mechanical Engineering Design, ch. 8-2.
    """

    d: Param = param("m", "mean diameter of the thread", above=0)
    mu: Param = param("1", "coefficient of friction", min=0)
    alpha: Param = param("rad", "half angle of the thread", 0.0, min=0, below=pi / 2)
    eta_a: Param = param(
        "1", "efficiency while the screw drives", lambda s: s.efficiencies()[0], above=0, max=1
    )
    eta_b: Param = param(
        "1", "efficiency while the load drives", lambda s: s.efficiencies()[1], max=1
    )

    def efficiencies(self) -> tuple[Expr, Expr]:
        """While the screw and while the load drives."""
        return thread_efficiencies(abs(self.lead) / (pi * self.d), self.mu / cos(self.alpha))


class WormGear(Meshing):
    """Worm at a, wheel at b: ``phi_a = ratio phi_b``, ``tau_b = -ratio eta_a tau_a``.

    While the wheel drives, ``tau_a = -eta_b tau_b / ratio``; ``eta_a = tan(l) / tan(l + r)`` and
    ``eta_b = tan(l - r) / tan(l)`` with ``l = gamma`` and ``tan(r) = mu / cos(alpha)``. With
    ``r >= gamma`` the wheel cannot drive the worm. Loss in the bearings is a part of its own.

    The shafts cross, so the housing takes the torque of each at a support of its own, as that of a
    `BevelGear`: ``tau_support_a = -tau_a``, ``tau_support_b = -tau_b``. Open supports stand still.

    Source: Shigley's Mechanical Engineering Design, ch. 13-17.
    """

    symbol = "worm"
    flange_b = Flange()
    support_a = Flange(grounded=True)
    support_b = Flange(grounded=True)
    ratio: Param = param("1", "teeth of the wheel over threads of the worm", nonzero=True)
    gamma: Param = param("rad", "lead angle of the worm", above=0, below=pi / 2)
    mu: Param = param("1", "coefficient of friction in the mesh", min=0)
    alpha: Param = param("rad", "normal pressure angle", min=0, below=pi / 2)
    eta_a: Param = param(
        "1", "efficiency while the worm drives", lambda s: s.efficiencies()[0], above=0, max=1
    )
    eta_b: Param = param(
        "1", "efficiency while the wheel drives", lambda s: s.efficiencies()[1], max=1
    )

    def efficiencies(self) -> tuple[Expr, Expr]:
        """While the worm and while the wheel drives."""
        return thread_efficiencies(tan(self.gamma), self.mu / cos(self.alpha))

    def equations(self) -> Iterator[Item]:
        yield from _mesh(self, self.ratio, self.flange_b, self.support_b)


def thread_efficiencies(slope: Expr, friction: Expr) -> tuple[Expr, Expr]:
    """Efficiencies of a thread while its screw and while its load drives.

    Parameters
    ----------
    slope : expression
        Tangent of the lead angle l.
    friction : expression
        Tangent of the angle of friction r on the flank.

    Returns
    -------
    tuple of Expr
        ``tan(l) / tan(l + r)`` and ``tan(l - r) / tan(l)``.
    """
    return (
        slope * (1 - slope * friction) / (slope + friction),
        (slope - friction) / (slope * (1 + slope * friction)),
    )


def _mesh(screw: _Screw | WormGear, ratio: Expr, b: Port, at_b: Port) -> Iterator[Item]:
    """Kinematics, balances and losses of a mesh, `ratio` the angle of a over the way of b."""
    a, at_a = screw.flange_a, screw.support_a
    yield screw.phi == a.phi - at_a.phi
    yield screw.phi == ratio * (b.across() - at_b.across())
    yield screw.w == der(screw.phi)
    yield b.through() == -ratio * (a.tau - screw.tau_loss)
    yield at_a.tau == -a.tau
    yield at_b.through() == -b.through()
    yield screw.mesh_loss(
        lambda speed: (screw.eta_a, screw.eta_b, 0.0, 0.0),
        border=0.0,
        engaged=screw.eta_a + screw.eta_b < 2,
        passed_on=-b.through() / ratio,
    )
