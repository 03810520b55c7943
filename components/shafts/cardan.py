"""Cardan (Hooke) joints, alone and as a shaft between two of them."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Connection, Equation, Flange, Output, Param, chain, lossless, param
from lumped.components.compliance import Spring
from lumped.components.seen_angle import seen_angle
from lumped.ops import cos, pi, sin, tan

__all__ = ["CardanJoint", "CardanShaft"]


class CardanJoint(Component):
    """Cardan (Hooke) joint of shafts that bend by `beta`: ``tan(y) = tan(x) / cos(beta)``.

    ``x = phi_a + phase`` is the angle of the fork of shaft a from the plane of both shafts, and
    ``y = phi_b + phase`` that of the fork of shaft b from the normal of this plane. Over any number
    of turns this is ``phi_b = phi_a + atan2(k sin(2 x), 1 - k cos(2 x))``, ``k = tan^2(beta / 2)``,
    with the series ``k sin(2 x) + k^2 sin(4 x) / 2 + ...`` of even orders. The ratio
    ``w_b / w_a = cos(beta) / (1 - sin^2(beta) cos^2(x))`` lies between ``cos(beta)`` and its
    inverse; ``tau_a = -(w_b / w_a) tau_b`` follows from virtual work.

    The cross passes only a moment at right angles to both of its axes. Beside the torque, each
    shaft takes the bending moments `M_a` and `M_b`, which turn with its fork, at right angles to
    the fork's axis; their bearings take them, and no torque about the shafts' axes.

    Source: Seherr-Thoss, Schmelz and Aucktor, Universal Joints and Driveshafts, 2006, ch. 1 and 4.
    """

    symbol = "cardan"
    flange_a = Flange()
    flange_b = Flange()
    M_a = Output("N.m", "bending moment on shaft a, tau_a tan(beta) sin(x)")
    M_b = Output("N.m", "bending moment on shaft b, tau_b tan(beta) cos(y)")
    beta: Param = param("rad", "bend angle of the shafts", min=0, below=pi / 2)
    phase: Param = param("rad", "angle of fork a from the plane of the shafts at phi_a = 0", 0.0)

    def equations(self) -> Iterator[Equation | tuple[Equation, ...]]:
        a, b, beta, x = self.flange_a, self.flange_b, self.beta, self.flange_a.phi + self.phase
        lead = seen_angle(2 * x, tan(beta / 2) ** 2)
        yield lossless(b.phi == a.phi + lead, a, b)
        yield self.M_a == a.tau * tan(beta) * sin(x)
        yield self.M_b == b.tau * tan(beta) * cos(b.phi + self.phase)


class CardanShaft(Component):
    """Elastic shaft between two Cardan joints: ``tau = c phi_rel`` behind and before `CardanJoint`.

    The bends of both joints lie in one plane (W or Z arrangement). With `psi` = 0 both forks of the
    intermediate shaft are parallel; then ``tan(y) = tan(x) cos(beta_b) / cos(beta_a)`` while the
    shaft is not twisted, and with equal bend angles both ends turn alike. `psi` is the angle of its
    fork at joint b before that at joint a; if the planes of the bends differ, their angle counts to
    it. A shaft with bodies is a row between two `CardanJoint`, the second of the phase
    ``phase + psi + pi / 2``.

    Source: Seherr-Thoss, Schmelz and Aucktor, Universal Joints and Driveshafts, 2006, ch. 1.
    """

    symbol = "cardan"
    flange_a = Flange()
    flange_b = Flange()
    beta_a: Param = param("rad", "bend angle of joint a", min=0, below=pi / 2)
    beta_b: Param = param("rad", "bend angle of joint b", min=0, below=pi / 2)
    psi: Param = param("rad", "angle of the shaft's fork at b before that at a", 0.0)
    phase: Param = param("rad", "angle of the first fork from the plane at phi_a = 0", 0.0)
    c: Param = param("N.m/rad", "torsional stiffness of the intermediate shaft", above=0)
    joint_a: CardanJoint = CardanJoint(beta=beta_a, phase=phase)
    shaft: Spring = Spring(c=c)
    joint_b: CardanJoint = CardanJoint(beta=beta_b, phase=phase + psi + pi / 2)

    def connections(self) -> Iterator[Connection]:
        yield from chain(self.flange_a, self.joint_a, self.shaft, self.joint_b, self.flange_b)
