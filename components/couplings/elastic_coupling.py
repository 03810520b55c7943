"""Elastic couplings as catalogues state them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from lumped import Component, Equation, Expr, Flange, Param, Var, der, param, var
from lumped.components.couplings.stiffness_table import (
    Elasticity,
    ends,
    factor,
    from_stiffness,
    from_twist,
)
from lumped.errors import EquationError
from lumped.language.component import path_of
from lumped.language.declared import values_of
from lumped.language.validity import Range
from lumped.language.value_types import Rows
from lumped.ops import pi

if TYPE_CHECKING:
    from lumped.vibration import Limit

__all__ = ["ElasticCoupling"]


class _Coupling(Component):
    """What elastic couplings have in common: flanges, rows, limits of the catalogue."""

    symbol = "spring_damper"
    flange_a = Flange()
    flange_b = Flange()
    stiffness: Rows = ()
    extrapolate: bool = False
    tau_max: Param = param("N.m", "permitted largest torque; 0 if not stated", 0.0, min=0)
    tau_vibratory: Param = param(
        "N.m", "permitted amplitude of a vibrating torque; 0 if not stated", 0.0, min=0
    )
    power_max: Param = param("W", "permitted mean of the heat; 0 if not stated", 0.0, min=0)
    phi_rel: Var = var("rad", "twist", nominal=1e-4, state="prefer")
    w_rel: Var = var("rad/s", "relative angular velocity")
    c: Var = var("N.m/rad", "dynamic stiffness", nominal=1e4)
    tau_c: Var = var("N.m", "torque of the stiffness on flange b")
    tau: Var = var("N.m", "torque on flange b")
    power: Var = var("W", "dissipated power")

    def equations(self) -> Iterator[Equation]:
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        yield self.w_rel == der(self.phi_rel)

    def limits(self) -> list[Limit]:
        """Limits of the torque, the vibrating torque and the heat, as far as they are stated.

        Their numbers are those given to the instance.

        Raises
        ------
        EquationError
            If none is stated, or one is bound to an expression.
        """
        from lumped.vibration import Limit

        path, given = path_of(self), values_of(self)
        before, name = (f"{path}.", path) if path else ("", type(self).__name__)
        found = [
            Limit(f"{before}tau", given.get("tau_max", 0.0), f"{name} largest torque", "with mean"),
            Limit(
                f"{before}tau", given.get("tau_vibratory", 0.0), f"{name} vibration", "half range"
            ),
            Limit(f"{before}power", given.get("power_max", 0.0), f"{name} heat", "mean power"),
        ]
        for limit in found:
            if isinstance(limit.permitted, Expr):
                raise EquationError(
                    f"{limit.name} = {limit.permitted!r} is bound to an expression; write "
                    "its lumped.vibration.Limit by hand."
                )
        found = [limit for limit in found if limit.permitted]
        if not found:
            raise EquationError(
                f"{name}: no limit is stated; give tau_max=, tau_vibratory= or power_max=."
            )
        return found


class ElasticCoupling(_Coupling):
    """Elastic coupling by its catalogue: ``d tau_c / d phi_rel = c(tau_c)``, relative damping psi.

    `stiffness` are rows of mean torque and dynamic stiffness there, between which it is linear. The
    static law follows by integration, so that a vibration about any mean torque has the stiffness
    stated, and a run has the same law. Or `twist` gives rows of twist and torque, joined by
    straight lines. Both hold for both directions.

    psi is the energy lost in a vibration over its largest elastic energy. The damper
    ``psi c / (2 pi w_loss)`` loses as much at `w_loss`, which a run is given; responses to a
    vibration put its own frequency there, which makes the stiffness ``c (1 + j psi / (2 pi))``.

    `damping` are rows of torque, from zero on, and factor of psi; `over_frequency` (rad/s),
    `over_amplitude` (N.m, from zero on) and `over_temperature` (K) are rows of that, factor of
    stiffness and factor of psi. The amplitude is half the range of the vibrating torque, which an
    order response finds at each speed; runs and other responses take the parameter `amplitude`.
    With ``k_w``, ``k_A`` and ``k_T`` for the factors of stiffness the law is
    ``tau_c = k_w k_A F(k_T phi_rel)``, F that of the rows, so that `stiffness` is read at the
    torque ``tau_c / (k_w k_A)``: for a mean torque state a `w_loss` and an `amplitude` at which
    they are 1. The law holds up to the last torque, frequency, amplitude and temperature of the
    rows; beyond is an error, unless `extrapolate` continues the last stiffness, line and factors.

    `size` is that of a series: all torques and stiffnesses of the rows are multiplied by it, as if
    as many couplings were side by side. The permitted values below are not.

    Source: DIN 740-2 (1986), relative damping and dynamic stiffness of couplings.
    """

    twist: Rows = ()
    damping: Rows = ()
    over_frequency: Rows = ()
    over_temperature: Rows = ()
    over_amplitude: Rows = ()
    size: Param = param("1", "torques and stiffnesses over those of the rows", 1.0, above=0)
    psi: Param = param("1", "relative damping; where `damping` has rows, they multiply it", min=0)
    w_loss: Param = param(
        "rad/s", "angular frequency of vibration to which psi applies", above=0, vibrates=True
    )
    T: Param = param("K", "temperature", 293.15, above=0)
    amplitude: Param = param(
        "N.m",
        "amplitude of the vibrating torque to which over_amplitude applies",
        0.0,
        min=0,
        amplitude_of="tau",
    )

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        law = self._law()
        stiff, loss = self._factors()
        warm = self._warm()
        yield self.tau_c == stiff * law.torque(warm * self.phi_rel)
        yield self.c == stiff * warm * law.slope(warm * self.phi_rel)
        damper = loss * self.c / (2 * pi * self.w_loss)
        yield self.tau == self.tau_c + damper * self.w_rel
        yield self.power == damper * self.w_rel**2
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau

    def loss(self) -> Expr:
        """Dissipated power, W."""
        return self.power

    def stored(self) -> Expr:
        """Elastic energy, J."""
        warm = self._warm()
        return self._factors()[0] / warm * self._law().energy(warm * self.phi_rel)

    def valid(self) -> Iterator[Range]:
        """Torques, frequencies, amplitudes and temperatures of the rows."""
        if self.extrapolate:
            return
        hint = "Give rows up to there, or extrapolate=True"
        most = self._law().highest
        if self.damping:
            most = min(most, ends(self.damping)[1])
        yield Range(self.tau_c / self._factors()[0], -most, most, "N.m", "torque", hint)
        if self.over_frequency:
            hint = "Give rows of over_frequency up to there, or extrapolate=True"
            yield Range(
                self.w_loss, *ends(self.over_frequency), "rad/s", "frequency of vibration", hint
            )
        if self.over_temperature:
            hint = "Give rows of over_temperature up to there, or extrapolate=True"
            yield Range(self.T, *ends(self.over_temperature), "K", "temperature", hint)
        if self.over_amplitude:
            hint = "Give rows of over_amplitude up to there, or extrapolate=True"
            least, most = ends(self.over_amplitude)
            yield Range(
                self.amplitude / self.size, least, most, "N.m", "amplitude of vibration", hint
            )

    def _law(self) -> Elasticity:
        if bool(self.stiffness) == bool(self.twist):
            raise EquationError(
                "give either stiffness=, rows of torque (N.m) and dynamic stiffness (N.m/rad), or "
                "twist=, rows of twist (rad) and torque (N.m)."
            )
        return from_stiffness(self.stiffness) if self.stiffness else from_twist(self.twist)

    def _factors(self) -> tuple[Expr, Expr]:
        """Size times the factors of stiffness by frequency and amplitude; psi with its factors."""
        fast, psi = self._pair("over_frequency", "frequency (rad/s)", self.w_loss)
        wide, loss = self._pair("over_amplitude", "amplitude (N.m)", self.amplitude / self.size)
        if self.over_amplitude and ends(self.over_amplitude)[0] != 0:
            raise EquationError(
                f"over_amplitude begins at {ends(self.over_amplitude)[0]:g} N.m; it must begin at "
                "zero, as vibrations may be small at some speeds: repeat the first factors there."
            )
        stiff = self.size * fast * wide
        _, cold = self._pair("over_temperature", "temperature (K)", self.T)
        mean = factor("damping", self.damping, self.tau_c / stiff, "torque (N.m)", both=True)
        return stiff, self.psi * psi * loss * cold * mean

    def _warm(self) -> Expr:
        """Factor of the stiffness by the temperature."""
        return self._pair("over_temperature", "temperature (K)", self.T)[0]

    def _pair(self, name: str, what: str, at: Expr) -> tuple[Expr, Expr]:
        """Factors of stiffness and of psi from rows of three numbers."""
        rows: Rows = getattr(self, name)
        try:
            stiff, psi = ([(row[0], row[i]) for row in rows] for i in (1, 2))
        except (TypeError, IndexError):
            raise EquationError(
                f"{name} = {rows!r}: rows of {what}, factor of stiffness and factor of psi are "
                "needed."
            ) from None
        for place, value in stiff:
            if not value > 0:
                raise EquationError(
                    f"{name}: the factor {value!r} of stiffness at {place!r} must be above zero."
                )
        return factor(name, stiff, at, what), factor(name, psi, at, what)
