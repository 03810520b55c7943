"""Gear shifting while turning: friction cones bring the speeds together, then dogs lock."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Expr, Flange, Input, Param, Var, der, hold, param, var, when
from lumped.components.characteristic import coulomb
from lumped.language.switch import Item
from lumped.ops import sin, where

__all__ = ["Synchroniser"]


class Synchroniser(Component):
    """Cones and dogs between a gear wheel and its shaft: ``tau_cones = mu n R f / sin(alpha)``.

    The shift force ``f = f_max u`` presses the cones until both sides turn at one speed; then the
    dogs lock without an impact and carry any torque. They open when `u` comes to zero. If the
    torque in the shaft is more than that of the cones, the speeds do not come together and the dogs
    do not lock. It starts open; ``locked=1.0`` starts it locked. `tau` acts at flange b
    and, reversed, at flange a; `w_rel` is the speed of b relative to a.

    Source: Naunheimer, Bertsche, Ryborz and Novak, Automotive Transmissions, 2nd ed. 2011, ch. 9.2.
    """

    symbol = "synchroniser"
    flange_a = Flange()
    flange_b = Flange()
    u: Input = Input("1", "shift force over its greatest value, not negative", min=0)
    f_max: Param = param("N", "shift force at u = 1", above=0)
    mu: Param = param("1", "friction coefficient of the cones", above=0)
    R: Param = param("m", "mean radius of the cones", above=0)
    alpha: Param = param("rad", "angle of the cones against the axis", above=0, max=1.5)
    n: Param = param("1", "number of friction faces", 1.0, min=1)
    peak: Param = param("1", "greatest static over kinetic friction", 1.0, min=1)
    phi_rel: Var = var("rad", "relative angle", state="avoid")
    w_rel: Var = var("rad/s", "speed of b relative to a", state="prefer")
    tau: Var = var("N.m", "torque on flange b")
    tau_cones: Var = var("N.m", "torque of the cones")
    tau_dogs: Var = var("N.m", "torque of the dogs")
    locked: Var = var("1", "1 while the dogs are in, else 0", state="always")
    position: Var = var("1", "of the cones: 1 forward, 0 stuck, -1 backward, 2 not pressed")

    def equations(self) -> Iterator[Item]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.w_rel == der(self.phi_rel)
        yield self.tau == self.tau_cones + self.tau_dogs
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau
        force = self.f_max * where(self.locked > 0.5, 0.0, self.u)
        grip = self.mu * self.n * self.R / sin(self.alpha) * force
        yield coulomb(
            self.tau_cones,
            self.w_rel,
            grip,
            self.peak * grip,
            engaged=force > 0,
            position=self.position,
        )
        yield hold(self.tau_dogs, self.w_rel, engaged=self.locked > 0.5)
        yield der(self.locked) == 0
        yield when(self.position**2 < 0.5, {self.locked: 1.0})
        # only what is locked opens, so that it ends open where both happen at once
        opens = self.locked * self.u <= self.locked - 1
        yield when(opens.called("u <= 0", "u > 0"), {self.locked: 0.0})

    def loss(self) -> Expr:
        """Heat in the cones, W."""
        return self.tau_cones * self.w_rel
