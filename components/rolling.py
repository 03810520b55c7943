"""Load of a pair of rolls that roll strip or bar.

The law is the balance of both rolls and of the strip between them, for a small angle of contact:
the pressure on the arc of contact has the lever arm `a`, and the shear that pulls the strip through
carries the difference of the tensions as well (Bland and Ford, Proc. Inst. Mech. Eng. 159 (1948)
144; Ford, Ellis and Bland, J. Iron Steel Inst. 168 (1951) 57).
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Expr, Flange, Input, Param, Var, der, param, var
from lumped.components.characteristic import coulomb
from lumped.language.expression import Number
from lumped.language.switch import Item
from lumped.ops import sqrt, where

__all__ = ["RollingTorque", "StripPass"]


class RollingTorque(Component):
    """Load of a rolling pass on the drive of both rolls: ``tau = 2 F a + (T_back - T_front) R``.

    The torque of forming acts against the motion, ``tau_f = 2 F a``, at standstill up to this; its
    work becomes heat.
    The tensions pull on the strip towards negative (`T_back`) and positive motion (`T_front`),
    whichever way the rolls turn. The lever arm is ``a = lambda sqrt(R dh)`` with the reduction
    ``dh`` and ``lambda`` about 0.5 for hot and 0.4 for cold rolling. Without roll force the pair is
    open. Friction of the necks: `JournalFriction`.
    """

    symbol = "rolls"
    flange = Flange()
    support = Flange(grounded=True)
    F: Input = Input("N", "roll force, not negative", min=0)
    a: Input = Input("m", "lever arm of the roll force, not negative", min=0)
    T_back: Input = Input("N", "tension of the strip towards negative motion")
    T_front: Input = Input("N", "tension of the strip towards positive motion")
    R: Param = param("m", "radius of the rolls", above=0)
    phi: Var = var("rad", "angle of the rolls relative to the support", state="avoid")
    w: Var = var("rad/s", "speed of the rolls relative to the support", state="prefer")
    tau_f: Var = var("N.m", "torque of forming")
    tau: Var = var("N.m", "torque that the drive must give")
    position: Var = var("1", "1 forward, 0 stuck, -1 backward, 2 open")

    def equations(self) -> Iterator[Item]:
        yield self.phi == self.flange.phi - self.support.phi
        yield self.w == der(self.phi)
        yield self.tau == self.tau_f + (self.T_back - self.T_front) * self.R
        yield self.flange.tau == self.tau
        yield self.support.tau == -self.tau
        force = self.F * self.a
        touches = (self._inside(force) > 0).called("closed", "open")
        limit = where(touches, 2 * force * self._filled(), 0.0)
        yield coulomb(self.tau_f, self.w, limit, limit, engaged=touches, position=self.position)

    def _inside(self, force: Expr) -> Expr:
        """Positive while there is a force on strip between the rolls."""
        return force

    def _filled(self) -> Number:
        """Share of the arc of contact with strip in it, while there is."""
        return 1.0

    def loss(self) -> Expr:
        """Power of forming, W."""
        return self.tau_f * self.w


class StripPass(RollingTorque):
    """Load of one strip from its entry to its exit: ``tau_f = 2 F a x``.

    The arc of contact ``L = sqrt(R dh)`` fills from the angle `phi_in` of the rolls on, and empties
    once the length `l` has passed: ``x = clip(s / L) - clip((s - l) / L)`` between 0 and 1, with
    ``s = R (phi - phi_in)``. So the torque rises within ``L / (R w)`` s. Tensions act as given; let
    them begin with the strip. All else is as in `RollingTorque`.
    """

    dh: Param = param("m", "reduction of the thickness", above=0)
    phi_in: Param = param("rad", "angle of the rolls at which the strip enters", 0.0)
    l: Param = param("m", "length of the strip behind the rolls", above=0)  # noqa: E741

    def _inside(self, force: Expr) -> Expr:
        way, arc = self._way()
        return force * way * (self.l + arc - way)

    def _filled(self) -> Expr:
        way, arc = self._way()
        ended = (way >= arc).called("entry ended", "entry under way")
        leaves = (way > self.l).called("exit begun", "exit to come")
        return where(ended, 1.0, way / arc) - where(leaves, (way - self.l) / arc, 0.0)

    def _way(self) -> tuple[Expr, Expr]:
        """Way of the strip since its entry, and the length of the arc of contact."""
        return self.R * (self.phi - self.phi_in), sqrt(self.R * self.dh)
