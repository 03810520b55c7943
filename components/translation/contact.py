"""Contact along a line: elastic gaps, rigid stops, play, couplings that close, bodies picked up.

The names are those of the rotational twins (`lumped.components.impact`), and so are the laws.
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Input, LinearFlange, Param, Var, der, hold, param, var
from lumped.components.unilateral import one_sided
from lumped.language.switch import Item
from lumped.ops import where

__all__ = ["Backlash", "Coupling", "ElastoGap", "MassWithStops", "PickUp", "Stop"]


class ElastoGap(Component):
    """Elastic contact of two bodies: ``f = c (s_rel - s_rel0) + f_d`` while ``s_rel < s_rel0``.

    It pushes and never pulls; `f` is positive in tension, so ``f <= 0``. Its damping part is
    ``f_d = d v_rel``. If `limited`, it is never greater than the elastic part, so that the force
    begins at zero; else the force jumps to ``d v_rel`` where the bodies meet.
    """

    symbol = "stop"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    limited: bool = True
    c: Param = param("N/m", "stiffness", above=0)
    d: Param = param("N.s/m", "viscous damping", 0.0, min=0)
    s_rel0: Param = param("m", "distance of the flanges where contact begins", 0.0)
    s_rel: Var = var("m", "distance of the flanges", nominal=1e-4, state="prefer")
    v_rel: Var = var("m/s", "relative velocity")
    f: Var = var("N", "force transmitted")

    def equations(self) -> Iterator[Equation]:
        yield self.s_rel == self.flange_b.s - self.flange_a.s
        yield self.v_rel == der(self.s_rel)
        elastic, damping = self.c * (self.s_rel0 - self.s_rel), -self.d * self.v_rel
        if self.limited:
            push = one_sided(elastic, damping, self.d, "contact")
        else:
            pushes = (elastic + damping > 0).called("contact pushes", "contact has let go")
            push = where(pushes, elastic + damping, 0)
        touching = (self.s_rel < self.s_rel0).called("in contact", "apart")
        yield self.f == where(touching, -push, 0)
        yield self.flange_b.f == self.f
        yield self.flange_a.f == -self.f


class MassWithStops(Component):
    """Sliding body between two rigid stops: ``s_min <= s <= s_max``, ``m a = f_a + f_b + f_stop``.

    `s` is the position of its middle; the flanges are `length` apart.
    """

    symbol = "mass_stops"
    flange_a = LinearFlange(free=True)
    flange_b = LinearFlange(free=True)
    m: Param = param("kg", "mass", above=0)
    length: Param = param("m", "distance of the flanges", 0.0, min=0)
    s_min: Param = param("m", "least position")
    s_max: Param = param("m", "greatest position")
    restitution: Param = param("1", "speed after an impact over that before", 0.0, min=0, max=1)
    s: Var = var("m", "position of the middle", state="prefer")
    v: Var = var("m/s", "velocity", state="prefer")
    v_back: Var = var("m/s", "velocity away from the upper stop", state="avoid")
    a: Var = var("m/s2", "acceleration")
    f_lower: Var = var("N", "force on the lower stop, reversed")
    f_upper: Var = var("N", "force on the upper stop, reversed")

    def equations(self) -> Iterator[Item]:
        yield self.flange_a.s == self.s - self.length / 2
        yield self.flange_b.s == self.s + self.length / 2
        yield self.v == der(self.s)
        yield self.v_back == -self.v
        yield self.a == der(self.v)
        stops = self.f_upper - self.f_lower
        yield self.m * self.a == self.flange_a.f + self.flange_b.f + stops
        below, above = self.s - self.s_min, self.s_max - self.s
        yield hold(self.f_lower, self.v, gap=below, restitution=self.restitution)
        yield hold(self.f_upper, self.v_back, gap=above, restitution=self.restitution)


class Stop(Component):
    """Rigid stop on one side: ``gap = s_b - s_a - s_min >= 0``, ``f <= 0``, one being zero.

    An open flange a is a housing that stands still. `f` acts on the stop at flange b and,
    reversed, at flange a.
    """

    symbol = "stop"
    flange_a = LinearFlange(grounded=True)
    flange_b = LinearFlange()
    s_min: Param = param("m", "least distance of the flanges", 0.0)
    restitution: Param = param("1", "speed after an impact over that before", 0.0, min=0, max=1)
    gap: Var = var("m", "distance to the stop", state="prefer")
    v_rel: Var = var("m/s", "relative velocity", state="prefer")
    f: Var = var("N", "force on flange b")
    position: Var = var("1", "1 open, 0 closed")

    def equations(self) -> Iterator[Item]:
        yield self.gap == self.flange_b.s - self.flange_a.s - self.s_min
        yield self.v_rel == der(self.gap)
        yield self.flange_b.f == self.f
        yield self.flange_a.f == -self.f
        yield hold(
            self.f, self.v_rel, gap=self.gap, restitution=self.restitution, position=self.position
        )


class Backlash(Component):
    """Play with rigid flanks: ``|s_rel| <= b / 2``; ``f = 0`` between the flanks.

    The front flank (``s_rel = b / 2``) transmits ``f >= 0``, the back flank ``f <= 0``; `f`
    acts on the play at flange b and, reversed, at flange a.
    """

    symbol = "play"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    b: Param = param("m", "whole play", above=0)
    restitution: Param = param("1", "speed after an impact over that before", 0.0, min=0, max=1)
    s_rel: Var = var("m", "distance of the flanges", state="prefer")
    v_rel: Var = var("m/s", "relative velocity", state="prefer")
    v_back: Var = var("m/s", "speed away from the front flank", state="avoid")
    f: Var = var("N", "force on flange b")
    f_back: Var = var("N", "force of the back flank on flange b")
    f_front: Var = var("N", "force of the front flank, reversed")

    def equations(self) -> Iterator[Item]:
        yield self.s_rel == self.flange_b.s - self.flange_a.s
        yield self.v_rel == der(self.s_rel)
        yield self.v_back == -self.v_rel
        yield self.f == self.f_back - self.f_front
        yield self.flange_b.f == self.f
        yield self.flange_a.f == -self.f
        back, front, e = self.b / 2 + self.s_rel, self.b / 2 - self.s_rel, self.restitution
        yield hold(self.f_back, self.v_rel, gap=back, restitution=e)
        yield hold(self.f_front, self.v_back, gap=front, restitution=e)


class Coupling(Component):
    """Dog clutch: ``v_rel = 0`` while closed, ``f = 0`` while open.

    It closes when the command `u` rises above 0.5, at any position and speed: the speeds then jump,
    with momentum kept. `f` acts on the coupling at flange b and, reversed, at flange a.
    """

    symbol = "dog"
    flange_a = LinearFlange()
    flange_b = LinearFlange()
    u: Input = Input("1", "command: closed above 0.5")
    s_rel: Var = var("m", "distance of the flanges", state="avoid")
    v_rel: Var = var("m/s", "relative velocity", state="prefer")
    f: Var = var("N", "force on flange b")
    position: Var = var("1", "0 closed, 2 open")

    def equations(self) -> Iterator[Item]:
        yield self.s_rel == self.flange_b.s - self.flange_a.s
        yield self.v_rel == der(self.s_rel)
        yield self.flange_b.f == self.f
        yield self.flange_a.f == -self.f
        yield hold(self.f, self.v_rel, engaged=self.u > 0.5, position=self.position)


class PickUp(Component):
    """Body that is carried or lies at rest: ``m der(v) = -f - f_rest``.

    While the command `u` is above 0.5 it moves with the flange, else it stands still. When it is
    picked up, the speeds of the flange and of the body jump to a common one, with momentum kept;
    when it is put down, its own speed drops to zero and that of the flange stays.
    """

    symbol = "pick_up"
    flange = LinearFlange()
    m: Param = param("kg", "mass", above=0)
    u: Input = Input("1", "command: carried above 0.5")
    s: Var = var("m", "position", state="avoid")
    v: Var = var("m/s", "velocity", state="prefer")
    v_rel: Var = var("m/s", "speed relative to the flange", state="prefer")
    f: Var = var("N", "force of the body on what carries it")
    f_rest: Var = var("N", "force of the body on its rest")
    position: Var = var("1", "0 carried, 2 at rest")

    def equations(self) -> Iterator[Item]:
        yield self.v == der(self.s)
        yield self.v_rel == self.v - der(self.flange.s)
        yield self.flange.f == -self.f
        yield self.m * der(self.v) == -self.f - self.f_rest
        yield hold(self.f, self.v_rel, engaged=self.u > 0.5, position=self.position)
        yield hold(self.f_rest, self.v, engaged=self.u <= 0.5)
