"""Load of a ship's propeller."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Param, Var, der, param, var
from lumped.components.rows import check_rows
from lumped.language.expression import ConstantExpression
from lumped.language.value_types import Rows
from lumped.ops import cos

__all__ = ["Propeller"]


class Propeller(Component):
    """Torque of the water against a propeller, of the mean law ``tau = k w abs(w)``.

    With the torque of `blades`, ``tau = k w abs(w) (1 + sum(share cos(n a + p)))``, where
    ``k = tau_nominal / w_nominal^2``.

    `blades` are rows of the order n, periods for each turn (a multiple of the number of blades),
    its share of the mean torque, and its phase p, rad; ``a = phi - phase`` is the angle of the
    propeller, and all count relative to the hull, `support`. A small vibration finds the damping
    ``2 k abs(w)`` of the mean law; entrained water is an `Inertia`, other damping a `Damper`.

    Source: Nestorides, A Handbook on Torsional Vibration (1958) (propeller excitation as a
    share of the mean torque).
    """

    symbol = "load"
    flange = Flange()
    support = Flange(grounded=True)
    blades: Rows = ()
    tau_nominal: Param = param("N.m", "mean torque at w_nominal", min=0)
    w_nominal: Param = param("rad/s", "speed of tau_nominal", above=0)
    phase: Param = param("rad", "angle of the flange at which a blade stands at the top", 0.0)
    a: Var = var("rad", "angle of the propeller", state="avoid")
    w: Var = var("rad/s", "angular velocity", state="avoid")
    tau: Var = var("N.m", "torque of the water against the motion")

    def equations(self) -> Iterator[Equation]:
        phi = self.flange.phi - self.support.phi
        yield self.a == phi - self.phase
        yield self.w == der(phi)
        factor: Expr = ConstantExpression(1.0)
        if self.blades:
            what = "order, share of the mean torque and phase (rad)"
            for n, part, p in check_rows("blades", self.blades, what, "((4, 0.1, 0.0),)", 3):
                factor = factor + part * cos(n * (phi - self.phase) + p)
        share = self.w / self.w_nominal
        yield self.tau == self.tau_nominal * share * abs(share) * factor
        yield self.flange.tau == self.tau
        yield self.support.tau == -self.tau

    def loss(self) -> Expr:
        """Power given to the water, W."""
        return self.tau * self.w
