"""Rope of a hoist, from its drum to the load."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Expr, Flange, LinearFlange, Param, Var, der, param, var
from lumped.components.unilateral import one_sided
from lumped.language.switch import Item
from lumped.language.validity import Range
from lumped.ops import where

__all__ = ["HoistRope"]


class HoistRope(Component):
    """Elastic rope of a drum with a hanging load: ``T = EA e / l + D der(e) / l`` while ``e > 0``.

    ``e = r phi - s`` is its stretch and ``l = l_0 - r phi`` its free length; the drum hoists with
    positive phi, the load rises with positive s. The stiffness grows as the rope is wound. The
    torque on the drum follows by virtual work of the energy ``EA e^2 / (2 l)``,
    ``tau = r (T + EA e^2 / (2 l^2)) + r m_l g l``: beside T its second term is half the strain.
    The rope takes no pressure; losing the tension and finding it again are events, and damping is
    at most as strong as the spring.

    ``m_l g l`` is the weight of the hanging rope, which the drum bears. Its inertia is
    ``m_l l_t r^2`` for the whole length l_t: add it to that of the drum. For several falls of rope
    use the EA, D and m_l of them together, and a gear between drum and rope.
    """

    symbol = "strip"
    drum = Flange()
    load = LinearFlange()
    r: Param = param("m", "radius of the drum, to the centre of the rope", above=0)
    EA: Param = param("N", "modulus of elasticity times cross-section", above=0)
    D: Param = param("N.s", "viscous damping of a metre of rope", 0.0, min=0)
    l_0: Param = param("m", "free length at the angle zero of the drum", above=0)
    l_min: Param = param("m", "least free length, where the load reaches the drum", 0.1, above=0)
    m_l: Param = param("kg/m", "mass of a metre of rope", 0.0, min=0)
    g: Param = param("m/s2", "acceleration of gravity", 9.80665, min=0)
    l: Var = var("m", "free length")  # noqa: E741
    e: Var = var("m", "stretch", nominal=1e-3, state="prefer")
    v_e: Var = var("m/s", "rate of stretch")
    T: Var = var("N", "tension")

    def equations(self) -> Iterator[Item]:
        wound = self.r * self.drum.phi
        yield self.l == self.l_0 - wound
        yield self.e == wound - self.load.s
        yield self.v_e == der(self.e)
        elastic, damping = self.EA * self.e / self.l, self.D * self.v_e / self.l
        yield self.T == self._tight(one_sided(elastic, damping, self.D, "tension"))
        yield self.load.f == -self.T
        shortened = self._tight(self.EA * self.e**2 / (2 * self.l**2))
        yield self.drum.tau == self.r * (self.T + shortened + self.m_l * self.g * self.l)

    def valid(self) -> Iterator[Range]:
        advice = "Stop the drum before, or give a longer l_0"
        yield Range(self.l - self.l_min, 0.0, float("inf"), "m", "free length above l_min", advice)

    def stored(self) -> Expr:
        """Energy of the stretch and of the weight of the rope, J."""
        hanging = self.m_l * self.g * self.l**2 / 2
        return self._tight(self.EA * self.e**2 / (2 * self.l)) - hanging

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self._tight((self.T - self.EA * self.e / self.l) * self.v_e)

    def _tight(self, value: Expr) -> Expr:
        return where((self.e > 0).called("tight", "slack"), value, 0.0)
