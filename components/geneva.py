"""Geneva mechanism: a pin that turns a slotted wheel by one slot in every turn.

Source: Bickford, Mechanisms for Intermittent Motion, 1972, ch. 9.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Flange, Param, lossless, param
from lumped.components.seen_angle import seen_angle
from lumped.errors import EquationError
from lumped.ops import atan2, cos, pi, sin, where

__all__ = ["Geneva"]


class Geneva(Component):
    """External Geneva wheel of n slots: ``y = atan2(e sin(x), 1 - e cos(x))``, ``e = sin(pi / n)``.

    The pin at the driver (flange a) is in a slot while ``cos(x) > e``, ``x = phi_a + phase`` from
    the line between the axes, modulo a turn. Meanwhile the wheel (flange b) turns by ``2 pi / n``
    against the driver, fastest at ``x = 0`` by ``-w_b / w_a = e / (1 - e)``. It begins and ends
    without a jump of its speed, but its acceleration jumps by ``tan(pi / n) w_a^2``. In the rest of
    the turn the wheel is locked: it stands still, whatever its torque, and the driver turns freely.
    A run stops where the pin enters and leaves, in both directions.

    Torques follow from virtual work; the frame, `support`, takes ``-tau_a - tau_b``. The pin enters
    along the slot, so its radius is ``e`` times the distance of the axes.
    """

    symbol = "geneva"
    flange_a = Flange()
    flange_b = Flange()
    support = Flange(grounded=True)
    slots: int = 4
    phase: Param = param("rad", "angle of the pin from the wheel's axis at phi_a = 0", 0.0)

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        if not isinstance(self.slots, int) or self.slots < 3:
            raise EquationError(
                f"slots = {self.slots!r}: a whole number of at least 3 is needed, as the pin of a "
                "wheel of two slots would have to reach its axis."
            )
        a, b, frame = self.flange_a, self.flange_b, self.support
        x = a.phi - frame.phi + self.phase
        e: float = sin(pi / self.slots)
        # angles from the line between the axes and from its reverse, each smooth in its own range
        near, far = atan2(sin(x), cos(x)), atan2(-sin(x), -cos(x))
        in_slot = (cos(x) > e).called("pin in a slot", "wheel locked")
        ahead = where(in_slot, near / self.slots - seen_angle(x, e), far / self.slots)
        yield lossless(b.phi == frame.phi - x / self.slots + ahead, a, b, frame)
