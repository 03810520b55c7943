"""Motor with permanent magnets on an inverter, from standstill to deep field weakening.

Sources: Morimoto, Takeda, Hirasa and Taniguchi, Expansion of operating limits for permanent magnet
motor by current vector control considering inverter capacity, IEEE Trans. Industry Applications 26
(1990) 866 (limits of current and voltage); Harnefors and Nee, Model-based current control of AC
machines using the internal model control method, IEEE Trans. Industry Applications 34 (1998) 133.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from lumped import Equation, Expr, Input, Output, Param, Pin, Var, der, param, var
from lumped.components.control.controllers import limit_between
from lumped.components.electric.motors import SynchronousMotor
from lumped.language.validity import Range
from lumped.ops import cos, maximum, minimum, sin, smooth, sqrt

__all__ = ["MagnetMotor"]

_LEAST = 1e-15
"""Share of the greatest torque below which a distance from it is rounding."""


class _Ellipse(NamedTuple):
    """Where the flux linkage of the stator has the amplitude `X`; torques over ``3/2 pairs``.

    At the angle `a` of the flux from the magnets the torque is ``A sin(a) - B/2 sin(2 a)``. It is
    greatest at ``a_m``, where ``A cos(a_m) = B cos(2 a_m)``.
    """

    A: Expr
    B: Expr
    cosine: Expr
    sine: Expr

    @property
    def most(self) -> Expr:
        """Greatest torque."""
        return self.sine * (self.A - self.B * self.cosine)

    def root(self, back: Expr) -> Expr:
        """Root of what the torque at ``a_m - back`` misses of the greatest: without a kink at 0."""
        curve = self.A * (self.sine + self.cosine * sin(back))
        curve -= 4 * self.B * self.sine * self.cosine * cos(back / 2) ** 2
        return sin(back / 2) * sqrt(2 * curve)

    def share(self, back: Expr) -> Expr:
        """Part of the flux along the magnets at ``a_m - back``."""
        return self.cosine * cos(back) + self.sine * sin(back)


class MagnetMotor(SynchronousMotor):
    """`SynchronousMotor` on an inverter with field-oriented control: ``T der(i) = i* - i``.

    The references `i_d_ref`, `i_q_ref` give the torque `wanted` with the least current. With
    ``L = L_q - L_d``, the flux linkages ``psi_d = psi + L_d i_d`` and ``psi_q = L_q i_q``, and
    ``X = (V_max - R I_max) / |w_e|``, what the voltage ``V_max = v_dc / sqrt(3)`` allows of them::

        most torque over current (MTPA)      psi i_d = L (i_d^2 - i_q^2)
        where this needs more voltage        psi_d^2 + psi_q^2 = X^2
        greatest torque: on one of these     i_d^2 + i_q^2 = I_max^2
        or, at high speeds (MTPV)            L (psi_d^2 - psi_q^2) = L_q psi psi_d

    Currents follow by one PI control for each axis with the induced voltages fed forward::

        u = (L_s / T) (i* - i) + x + j w_e (psi + L_d i_d + j L_q i_q)
        v = u min(1, V_max / |u|),   T der(x) = R (i* - i) + T R / L_s (v - u)

    with ``L_s`` that of the axis: within the voltage the currents are lags of `T`. The inverter,
    averaged and without loss, takes ``psi_dc der(i_dc) = P - v_dc i_dc`` at `p`, so the power is
    balanced within ``psi_dc / v_dc``. Voltages, currents and fluxes are amplitudes of a phase.
    """

    p = Pin()
    n = Pin()
    wanted: Input = Input("N.m", "wanted torque")
    v_d: Var = var("V", "voltage along the magnets")
    v_q: Var = var("V", "voltage across the magnets")
    L_q: Param = param("H", "inductance across the magnets", min=SynchronousMotor.L_d)
    I_max: Param = param("A", "greatest amplitude of the current", above=0)
    T: Param = param("s", "time constant of the current control", above=0)
    psi_dc: Param = param("V.s", "direct voltage times time to the power balance", 1e-3, above=0)
    x_d: Var = var("V", "integral part of the current control, d", state="prefer")
    x_q: Var = var("V", "integral part of the current control, q", state="prefer")
    i_m: Var = var("A", "current across the magnets on MTPA")
    back: Var = var("rad", "angle of the flux to that of the greatest torque")
    i_d_ref: Var = var("A", "wanted current along the magnets")
    i_q_ref: Var = var("A", "wanted current across the magnets")
    limit: Var = var("N.m", "greatest torque at the present speed and voltage")
    V_max: Var = var("V", "greatest amplitude of the voltage of a phase")
    i_dc: Var = var("A", "current taken at p", state="prefer")
    tau_meas = Output("N.m", "driving torque as the converter reports it")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        direct = self.p.v - self.n.v
        yield self.p.i == self.i_dc
        yield self.n.i == -self.i_dc
        yield self.psi_dc * der(self.i_dc) == self.P - direct * self.i_dc
        yield self.V_max == direct / 3**0.5
        yield self.tau_meas == self.tau
        yield from self._find_references()
        yield from self._control_currents()

    def _find_references(self) -> Iterator[Equation]:
        L, psi, per_flux = self.L_q - self.L_d, self.psi, 1.5 * self.pairs
        X = self._flux()
        ellipse = self._ellipse(X)
        i_d, i_q = self._greatest(X, ellipse)
        yield self.limit == per_flux * (psi - L * i_d) * i_q
        wanted = limit_between(self.wanted, -self.limit, self.limit) / per_flux
        root = sqrt(psi**2 + 4 * L**2 * self.i_m**2)
        yield wanted == self.i_m * (psi + root) / 2
        missing = ellipse.most - smooth(abs(wanted))
        yield ellipse.root(self.back) == sqrt(smooth(maximum(missing, _LEAST * ellipse.most)))
        weakened = (X * ellipse.share(self.back) - psi) / self.L_d
        yield self.i_d_ref == smooth(minimum(-2 * L * self.i_m**2 / (psi + root), weakened))
        yield self.i_q_ref == wanted / (psi - L * self.i_d_ref)

    def _flux(self) -> Expr:
        """Flux linkage that the voltage allows, at most that on MTPA at `I_max`."""
        L, psi, most = self.L_q - self.L_d, self.psi, self.I_max**2
        i_d = -2 * L * most / (psi + sqrt(psi**2 + 8 * L**2 * most))
        full = sqrt((psi + self.L_d * i_d) ** 2 + self.L_q**2 * (most - i_d**2))
        drop = self.R * self.I_max
        voltage = smooth(maximum(self.V_max - drop, 1e-3 * drop))
        return voltage / smooth(maximum(abs(self.pairs * self._speed), voltage / full))

    def _ellipse(self, X: Expr) -> _Ellipse:
        L, psi = self.L_q - self.L_d, self.psi
        straight = self.L_q * psi
        cosine = -2 * L * X / (straight + sqrt(straight**2 + 8 * L**2 * X**2))
        B = L * X**2 / (self.L_d * self.L_q)
        return _Ellipse(psi * X / self.L_d, B, cosine, sqrt(1 - cosine**2))

    def _greatest(self, X: Expr, ellipse: _Ellipse) -> tuple[Expr, Expr]:
        """Currents of the greatest torque: where ellipse and circle meet, or on MTPV."""
        L_d, L_q, psi, most = self.L_d, self.L_q, self.psi, self.I_max**2
        short = psi**2 + L_q**2 * most - X**2
        meets = -short / (L_d * psi + sqrt((L_d * psi) ** 2 + (L_q**2 - L_d**2) * short))
        i_d = smooth(maximum(meets, (X * ellipse.cosine - psi) / L_d))
        return i_d, sqrt(smooth(maximum(X**2 - (psi + L_d * i_d) ** 2, 0.0))) / L_q

    def _control_currents(self) -> Iterator[Equation]:
        w_e = self.pairs * self._speed
        error_d, error_q = self.i_d_ref - self.i_d, self.i_q_ref - self.i_q
        u_d = self.L_d / self.T * error_d + self.x_d - w_e * self.L_q * self.i_q
        u_q = self.L_q / self.T * error_q + self.x_q + w_e * (self.psi + self.L_d * self.i_d)
        size = sqrt(u_d**2 + u_q**2)
        share = self.V_max / smooth(maximum(size, self.V_max))
        yield self.v_d == share * u_d
        yield self.v_q == share * u_q
        yield der(self.x_d) == self.R * (error_d / self.T + (self.v_d - u_d) / self.L_d)
        yield der(self.x_q) == self.R * (error_q / self.T + (self.v_q - u_q) / self.L_q)

    def valid(self) -> Iterator[Range]:
        """Voltages that hold the current, and the flux of the magnets at the present speed."""
        left = smooth(maximum(self.psi - self.L_d * self.I_max, 0.0))
        needed = self.R * self.I_max + smooth(abs(self.pairs * self._speed)) * left
        advice = "Raise the direct voltage, or lower the speed or R I_max"
        yield Range(needed / self.V_max, 0.0, 1.0, "1", "needed share of the voltage", advice)
