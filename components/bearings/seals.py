"""Friction of shaft seals."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Param, param
from lumped.components.characteristic import coulomb
from lumped.components.friction import _OnShaft
from lumped.language.switch import Item
from lumped.ops import pi

__all__ = ["ShaftSeal"]


class ShaftSeal(_OnShaft):
    """Friction of a radial lip seal: ``tau = k d^2`` against the motion, ``peak`` times at rest.

    ``k = 73.4 N/m`` is that of ISO/TR 14179-2 as a public program has it, a loss of
    ``7.69e-6 d^2 n`` W at d in mm and n in 1/min. The shaft goes through from flange a to flange b.
    """

    symbol = "bearing"
    d: Param = param("m", "diameter of the shaft", above=0)
    k: Param = param("N/m", "friction torque over ``d^2``", 7.69 * 30 / pi, min=0)

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        slides = self.k * self.d**2
        yield coulomb(self.tau, self.w, slides, self.peak * slides, position=self.position)
