"""Synchronous machine with field winding and dampers, with its currents; its start by torques.

Sources: Krause, Wasynczuk, Sudhoff and Pekarek, Analysis of Electric Machinery and Drive Systems,
3rd ed., ch. 5; Kundur, Power System Stability and Control, ch. 3; Corbo and Cook, Torsional
vibration analysis of synchronous motor-driven turbomachinery, 31st Turbomachinery Symposium
(pulsation at twice the slip frequency).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from lumped import Equation, Expr, Input, Output, Param, Pin, Var, der, param, var
from lumped.components.electric.drives import _at, _increasing
from lumped.components.electric.motors import _Machine
from lumped.errors import EquationError
from lumped.language.value_types import Rows
from lumped.ops import cos, pi, sin, sqrt

__all__ = ["SynchronousMotorStart", "WoundFieldMachine"]


_NO_END = float("-inf")


class _Damper(NamedTuple):
    """Shorted winding of the rotor; one that the machine does not have carries no current."""

    there: bool
    R: Expr
    L_l: Expr
    psi: Expr
    i: Expr
    psi_m: Expr

    def equations(self) -> Iterator[Equation]:
        if self.there:
            yield self.R * self.i + der(self.psi) == 0
            yield self.psi == self.psi_m + self.L_l * self.i
        else:
            yield self.i == 0
            yield self.psi == 0


def _if(axis: str, number: int) -> Callable[[WoundFieldMachine], float]:
    """Lower end of the parameters of a damper: zero if the machine has it, none otherwise."""
    return lambda machine: 0.0 if getattr(machine, f"dampers_{axis}") >= number else _NO_END


def _if_steady(machine: WoundFieldMachine) -> float:
    """Lower end of the voltage at the start: zero if it is needed, none otherwise."""
    return 0.0 if machine.steady else _NO_END


class WoundFieldMachine(_Machine):
    """Synchronous machine with field winding and dampers, on three wires `a`, `b`, `c`.

    In the axes of the rotor, d along the field and q a quarter of a pole pair ahead, with
    ``w_e = pairs w``, the field winding f and the dampers 1d, 2d, 1q, 2q referred to the stator::

        v_d = R_s i_d + der(psi_d) - w_e psi_q     psi_d = L_ls i_d + psi_md
        v_q = R_s i_q + der(psi_q) + w_e psi_d     psi_q = L_ls i_q + psi_mq
        v_f = R_f i_f + der(psi_f)                 psi_f = L_lf i_f + psi_md
        0 = R_1d i_1d + der(psi_1d)                psi_1d = L_l1d i_1d + psi_md; the others alike
        psi_md = L_md (i_d + i_f + i_1d + i_2d),   psi_mq = L_mq (i_q + i_1q + i_2q)
        tau = 3/2 pairs (psi_d i_q - psi_q i_d)

    The structural choices `dampers_d` and `dampers_q` are 0, 1 or 2. Voltages, currents and flux
    linkages are amplitudes of a phase; currents flow into the machine, so of a generator `tau`, `P`
    and `Q` (overexcited) are negative. The d axis lies on the axis of phase a at ``phi = 0``. The
    star point is isolated: the currents of the wires sum to zero. Source: Krause, ch. 5.

    With ``steady=True`` a run begins in steady state, with the voltage `V_0` and the powers `P_0`
    and `Q_0`: no flux linkage changes in the axes of the rotor. Set free what shall follow, such as
    ``free=["machine.v_f", "bus.V", "bus.phase", "turbine.tau"]``.
    """

    a = Pin()
    b = Pin()
    c = Pin()
    v_f: Input = Input("V", "voltage of the field winding, referred")
    steady: bool = False
    dampers_d: int = 1
    dampers_q: int = 1
    pairs: Param = param("1", "pole pairs", min=1)
    R_s: Param = param("Ohm", "resistance of a phase of the stator", min=0)
    L_ls: Param = param("H", "leakage inductance of the stator", above=0)
    L_md: Param = param("H", "magnetising inductance of the d axis", above=0)
    L_mq: Param = param("H", "magnetising inductance of the q axis", above=0)
    R_f: Param = param("Ohm", "resistance of the field winding, referred", above=0)
    L_lf: Param = param("H", "leakage inductance of the field winding, referred", above=0)
    R_1d: Param = param("Ohm", "resistance of the damper 1d, referred", 0.0, above=_if("d", 1))
    L_l1d: Param = param("H", "leakage inductance of the damper 1d", 0.0, above=_if("d", 1))
    R_2d: Param = param("Ohm", "resistance of the damper 2d, referred", 0.0, above=_if("d", 2))
    L_l2d: Param = param("H", "leakage inductance of the damper 2d", 0.0, above=_if("d", 2))
    R_1q: Param = param("Ohm", "resistance of the damper 1q, referred", 0.0, above=_if("q", 1))
    L_l1q: Param = param("H", "leakage inductance of the damper 1q", 0.0, above=_if("q", 1))
    R_2q: Param = param("Ohm", "resistance of the damper 2q, referred", 0.0, above=_if("q", 2))
    L_l2q: Param = param("H", "leakage inductance of the damper 2q", 0.0, above=_if("q", 2))
    P_0: Param = param("W", "electric power taken at a steady start", 0.0)
    Q_0: Param = param("W", "reactive power taken at a steady start, var", 0.0)
    V_0: Param = param("V", "amplitude of the voltage at a steady start", 0.0, above=_if_steady)
    theta: Var = var("rad", "electrical angle of the d axis from the axis of phase a")
    psi_d: Var = var("V.s", "flux linkage of the stator, d axis", state="prefer")
    psi_q: Var = var("V.s", "flux linkage of the stator, q axis", state="prefer")
    psi_f: Var = var("V.s", "flux linkage of the field winding", state="prefer")
    psi_1d: Var = var("V.s", "flux linkage of the damper 1d", state="prefer")
    psi_2d: Var = var("V.s", "flux linkage of the damper 2d", state="prefer")
    psi_1q: Var = var("V.s", "flux linkage of the damper 1q", state="prefer")
    psi_2q: Var = var("V.s", "flux linkage of the damper 2q", state="prefer")
    psi_md: Var = var("V.s", "flux linkage of the air gap, d axis")
    psi_mq: Var = var("V.s", "flux linkage of the air gap, q axis")
    v_d: Var = var("V", "voltage of the stator, d axis")
    v_q: Var = var("V", "voltage of the stator, q axis")
    i_d: Var = var("A", "current of the stator, d axis")
    i_q: Var = var("A", "current of the stator, q axis")
    i_f: Var = var("A", "current of the field winding, referred")
    i_1d: Var = var("A", "current of the damper 1d, referred")
    i_2d: Var = var("A", "current of the damper 2d, referred")
    i_1q: Var = var("A", "current of the damper 1q, referred")
    i_2q: Var = var("A", "current of the damper 2q, referred")
    V: Var = var("V", "amplitude of the voltage of a phase")
    i: Var = var("A", "amplitude of the current of a phase")
    P: Var = var("W", "electric power taken by the stator")
    Q: Var = var("W", "reactive power taken by the stator, var")
    V_meas = Output("V", "amplitude of the voltage of a phase as measured")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        v_d, v_q, i_d, i_q = self.v_d, self.v_q, self.i_d, self.i_q
        psi_d, psi_q, w_e = self.psi_d, self.psi_q, self.pairs * self._speed
        yield v_d == self.R_s * i_d + der(psi_d) - w_e * psi_q
        yield v_q == self.R_s * i_q + der(psi_q) + w_e * psi_d
        yield self.v_f == self.R_f * self.i_f + der(self.psi_f)
        yield psi_d == self.L_ls * i_d + self.psi_md
        yield psi_q == self.L_ls * i_q + self.psi_mq
        yield self.psi_f == self.L_lf * self.i_f + self.psi_md
        for damper in self._dampers():
            yield from damper.equations()
        yield self.psi_md == self.L_md * (i_d + self.i_f + self.i_1d + self.i_2d)
        yield self.psi_mq == self.L_mq * (i_q + self.i_1q + self.i_2q)
        yield self.tau == 1.5 * self.pairs * (psi_d * i_q - psi_q * i_d)
        yield from self._transform_to_rotor()
        yield self.V == sqrt(v_d**2 + v_q**2)
        yield self.V_meas == self.V
        yield self.i == sqrt(i_d**2 + i_q**2)
        yield self.P == 1.5 * (v_d * i_d + v_q * i_q)
        yield self.Q == 1.5 * (v_q * i_d - v_d * i_q)

    def _transform_to_rotor(self) -> Iterator[Equation]:
        """Park's transformation: alpha along the axis of phase a, beta a quarter ahead."""
        yield self.theta == self.pairs * (self.phi - self.support.phi)
        cosine, sine, root = cos(self.theta), sin(self.theta), 3**0.5
        v_alpha = (2 * self.a.v - self.b.v - self.c.v) / 3
        v_beta = (self.b.v - self.c.v) / root
        yield self.v_d == v_alpha * cosine + v_beta * sine
        yield self.v_q == v_beta * cosine - v_alpha * sine
        i_alpha = self.i_d * cosine - self.i_q * sine
        i_beta = self.i_d * sine + self.i_q * cosine
        yield self.a.i == i_alpha
        yield self.b.i == (root * i_beta - i_alpha) / 2
        yield self.c.i == -(root * i_beta + i_alpha) / 2

    def initial_equations(self) -> Iterator[Equation]:
        if not self.steady:
            return
        # current along and behind the voltage; the q axis lies along v - (R_s + j X_q) i
        active, reactive = (x / (1.5 * self.V_0) for x in (self.P_0, self.Q_0))
        w_e = self.pairs * self._speed
        X_q = w_e * (self.L_ls + self.L_mq)
        along = self.V_0 - self.R_s * active - X_q * reactive
        ahead = self.R_s * reactive - X_q * active
        size = sqrt(along**2 + ahead**2)
        cosine, sine = along / size, ahead / size
        yield self.i_d == active * sine + reactive * cosine
        yield self.i_q == active * cosine - reactive * sine
        yield w_e * self.psi_d == self.V_0 * cosine - self.R_s * self.i_q
        yield der(self.psi_f) == 0
        for damper in self._dampers():
            if damper.there:
                yield der(damper.psi) == 0
        yield der(self.psi_d) == 0
        yield der(self.psi_q) == 0

    def _dampers(self) -> Iterator[_Damper]:
        for axis in "dq":
            count: int = getattr(self, f"dampers_{axis}")
            if count not in (0, 1, 2):
                raise EquationError(f"dampers_{axis} = {count!r} must be 0, 1 or 2.")
            for number in (1, 2):
                names = (f"{quantity}{number}{axis}" for quantity in ("R_", "L_l", "psi_", "i_"))
                own = (getattr(self, name) for name in (*names, f"psi_m{axis}"))
                yield _Damper(number <= count, *own)

    def loss(self) -> Expr:
        """Heat in the windings of stator and rotor, W."""
        heat = self.R_s * (self.i_d**2 + self.i_q**2) + self.R_f * self.i_f**2
        return 1.5 * sum((x.R * x.i**2 for x in self._dampers()), heat)


class SynchronousMotorStart(_Machine):
    """Synchronous motor that starts on its dampers: ``tau = average + pulsating cos(angle)``.

    ``der(angle) = 2 (2 pi f - pairs w)``: unequal axes of the rotor let the torque pulsate with
    twice the slip frequency, which falls from 2 f to zero and so passes each natural frequency
    below. `torques` are rows of speed over synchronous speed, and of average and pulsating torque
    (amplitude) over `tau_n`; joined by straight lines, and kept beyond the first and the last.
    """

    torques: Rows = ()
    tau_n: Param = param("N.m", "torque to which the table refers", above=0)
    f: Param = param("Hz", "frequency of the supply", above=0)
    pairs: Param = param("1", "pole pairs", min=1)
    phase: Param = param("rad", "angle of the pulsation at the start", 0.0)
    angle: Var = var("rad", "angle of the pulsation", phase, state="prefer")
    average: Var = var("N.m", "average torque at the present speed")
    pulsating: Var = var("N.m", "amplitude of the pulsating torque at the present speed")
    f_p: Var = var("Hz", "frequency of the pulsation")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        shares, average, pulsating = _torques(self.torques)
        w_1 = 2 * pi * self.f
        share = self.pairs * self._speed / w_1
        yield self.average == self.tau_n * _at(share, shares, average)
        yield self.pulsating == self.tau_n * _at(share, shares, pulsating)
        yield der(self.angle) == 2 * (w_1 - self.pairs * self._speed)
        yield 2 * pi * self.f_p == 2 * (w_1 - self.pairs * self._speed)
        yield self.tau == self.average + self.pulsating * cos(self.angle)


def _torques(rows: Rows) -> tuple[list[float], list[float], list[float]]:
    """Speeds, average and pulsating torques that make sense.

    Raises
    ------
    EquationError
        If rows are missing, do not increase in speed from zero up, or hold a torque that is not
        finite or a negative amplitude.
    """
    try:
        found = [(float(w), float(mean), float(swing)) for w, mean, swing in rows]
    except (TypeError, ValueError):
        found = []
    if not found:
        raise EquationError(
            f"torques = {rows!r} has no rows of three numbers. Give rows of speed over synchronous "
            "speed, average and pulsating torque over tau_n, ((0, 0.8, 0.6), (1, 0, 0.3), ...)."
        )
    _increasing("torques: the speeds", [w for w, _, _ in found])
    for w, mean, swing in found:
        if not (abs(mean) < float("inf") and 0 <= swing < float("inf")):
            raise EquationError(
                f"torques: the average {mean:g} and the amplitude {swing:g} at the speed {w:g} "
                "must be finite, the amplitude not negative."
            )
    shares, average, pulsating = zip(*found, strict=True)
    return list(shares), list(average), list(pulsating)
