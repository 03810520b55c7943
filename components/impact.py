"""Rigid contact of shafts: stops, play with impacts, couplings that close, bodies picked up.

All are constraints that close and open (`lumped.hold`). If one closes at a speed, the speeds of
everything that is rigidly joined to it jump, so that momentum is kept; the energy lost is the
`loss` of the event. The speed after an impact is `restitution` times the speed before (Newton's
law; Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts, 1996, ch. 8).
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Flange, Input, Param, Var, der, hold, param, var
from lumped.language.switch import Item

__all__ = ["Backlash", "Coupling", "PickUp", "Stop"]


class Stop(Component):
    """Rigid stop on one side: ``gap = phi_b - phi_a - phi_min >= 0``, ``tau <= 0``, one being zero.

    An open flange a is a housing that stands still. `tau` acts on the stop at flange b and,
    reversed, at flange a.
    """

    symbol = "stop"
    flange_a = Flange(grounded=True)
    flange_b = Flange()
    phi_min: Param = param("rad", "least relative angle", 0.0)
    restitution: Param = param("1", "speed after an impact over that before", 0.0, min=0, max=1)
    gap: Var = var("rad", "angle to the stop", state="prefer")
    w_rel: Var = var("rad/s", "relative angular velocity", state="prefer")
    tau: Var = var("N.m", "torque on flange b")
    position: Var = var("1", "1 open, 0 closed")

    def equations(self) -> Iterator[Item]:
        yield self.gap == self.flange_b.phi - self.flange_a.phi - self.phi_min
        yield self.w_rel == der(self.gap)
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau
        yield hold(
            self.tau, self.w_rel, gap=self.gap, restitution=self.restitution, position=self.position
        )


class Backlash(Component):
    """Play with rigid flanks: ``|phi_rel| <= b / 2``; ``tau = 0`` between the flanks.

    The front flank (``phi_rel = b / 2``) transmits ``tau >= 0``, the back flank ``tau <= 0``; `tau`
    acts on the play at flange b and, reversed, at flange a.
    """

    symbol = "play"
    flange_a = Flange()
    flange_b = Flange()
    b: Param = param("rad", "whole play", above=0)
    restitution: Param = param("1", "speed after an impact over that before", 0.0, min=0, max=1)
    phi_rel: Var = var("rad", "relative angle", state="prefer")
    w_rel: Var = var("rad/s", "relative angular velocity", state="prefer")
    w_back: Var = var("rad/s", "speed away from the front flank", state="avoid")
    tau: Var = var("N.m", "torque on flange b")
    tau_back: Var = var("N.m", "torque of the back flank on flange b")
    tau_front: Var = var("N.m", "torque of the front flank, reversed")

    def equations(self) -> Iterator[Item]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.w_rel == der(self.phi_rel)
        yield self.w_back == -self.w_rel
        yield self.tau == self.tau_back - self.tau_front
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau
        back, front, e = self.b / 2 + self.phi_rel, self.b / 2 - self.phi_rel, self.restitution
        yield hold(self.tau_back, self.w_rel, gap=back, restitution=e)
        yield hold(self.tau_front, self.w_back, gap=front, restitution=e)


class Coupling(Component):
    """Dog clutch: ``w_rel = 0`` while closed, ``tau = 0`` while open.

    It closes when the command `u` rises above 0.5, at any angle and speed: the speeds then jump,
    with momentum kept. `tau` acts on the coupling at flange b and, reversed, at flange a.
    """

    symbol = "dog"
    flange_a = Flange()
    flange_b = Flange()
    u: Input = Input("1", "command: closed above 0.5")
    phi_rel: Var = var("rad", "relative angle", state="avoid")
    w_rel: Var = var("rad/s", "relative angular velocity", state="prefer")
    tau: Var = var("N.m", "torque on flange b")
    position: Var = var("1", "0 closed, 2 open")

    def equations(self) -> Iterator[Item]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.w_rel == der(self.phi_rel)
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau
        yield hold(self.tau, self.w_rel, engaged=self.u > 0.5, position=self.position)


class PickUp(Component):
    """Body that is carried or lies at rest: ``J der(w) = -tau - tau_rest``.

    While the command `u` is above 0.5 it turns with the flange, else it stands still. When it is
    picked up, the speeds of the flange and of the body jump to a common one, with momentum kept;
    when it is put down, its own speed drops to zero and that of the flange stays.
    """

    symbol = "pick_up"
    flange = Flange()
    J: Param = param("kg.m2", "moment of inertia", above=0)
    u: Input = Input("1", "command: carried above 0.5")
    phi: Var = var("rad", "angle", state="avoid")
    w: Var = var("rad/s", "angular velocity", state="prefer")
    w_rel: Var = var("rad/s", "speed relative to the flange", state="prefer")
    tau: Var = var("N.m", "torque of the body on what carries it")
    tau_rest: Var = var("N.m", "torque of the body on its rest")
    position: Var = var("1", "0 carried, 2 at rest")

    def equations(self) -> Iterator[Item]:
        yield self.w == der(self.phi)
        yield self.w_rel == self.w - der(self.flange.phi)
        yield self.flange.tau == -self.tau
        yield self.J * der(self.w) == -self.tau - self.tau_rest
        yield hold(self.tau, self.w_rel, engaged=self.u > 0.5, position=self.position)
        yield hold(self.tau_rest, self.w, engaged=self.u <= 0.5)
