"""Elastic contact: play whose flanks are springs with dampers."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Flange, Param, Var, der, param, var
from lumped.components.unilateral import force_across_play

__all__ = ["ElastoBacklash"]


class ElastoBacklash(Component):
    """Play with elastic flanks: ``tau = c e + tau_d``, ``e`` the twist beyond ``b / 2``.

    Within the play, ``|phi_rel - phi_rel0| <= b / 2``, there is no torque; a flank pushes and never
    pulls. Its damping part is ``tau_d = d w_rel``. If `limited`, the damping part is never greater
    than the elastic part, so that the torque begins at zero; else it jumps to ``d w_rel`` where the
    flanks meet. Below a play of 1e-10 rad it is a spring and damper that also pulls.
    """

    symbol = "play"
    flange_a = Flange()
    flange_b = Flange()
    limited: bool = True
    c: Param = param("N.m/rad", "torsional stiffness of the flanks", above=0)
    d: Param = param("N.m.s/rad", "viscous damping of the flanks", 0.0, min=0)
    b: Param = param("rad", "whole play", min=0)
    phi_rel0: Param = param("rad", "middle of the play", 0.0)
    phi_rel: Var = var("rad", "relative angle", nominal=1e-4, state="prefer")
    w_rel: Var = var("rad/s", "relative angular velocity")
    tau: Var = var("N.m", "torque on flange b")

    def equations(self) -> Iterator[Equation]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.w_rel == der(self.phi_rel)
        yield self.tau == force_across_play(
            self.phi_rel - self.phi_rel0,
            self.b,
            self.c,
            self.d * self.w_rel,
            self.d,
            ("front flank", "back flank", "in the play"),
            limited=self.limited,
        )
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau
