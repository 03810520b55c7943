"""What all notches of shafts have in common."""

from __future__ import annotations

from collections.abc import Iterator

from lumped import Component, Equation, Expr, Flange, Output, Param, Var, param, var

__all__ = ["Notch"]


class Notch(Component):
    """Place in a shaft, rigid and without mass, that tells the stress there: base of all notches.

    ``stress = tau / W``, ``notch_stress = K_ts stress``.
    """

    symbol = "notch"
    flange_a = Flange()
    flange_b = Flange()
    stress = Output("Pa", "nominal shear stress at the surface")
    notch_stress = Output("Pa", "largest stress, the notch factor times the nominal one")
    K_ts: Param = param("1", "notch factor", lambda notch: notch.factor(), above=0)
    tau: Var = var("N.m", "torque on flange b")

    def factor(self) -> Expr | float:
        """The notch factor by the fit."""
        raise NotImplementedError

    def modulus(self) -> Expr:
        """Polar section modulus for the nominal stress, m3."""
        raise NotImplementedError

    def equations(self) -> Iterator[Equation]:
        yield self.flange_a.phi == self.flange_b.phi
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau
        yield self.stress == self.tau / self.modulus()
        yield self.notch_stress == self.K_ts * self.stress
