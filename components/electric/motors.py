"""Motors of three phases, induction and synchronous, and the base class of all motors.

All have a rotor with inertia `J` on `flange`; the torque `tau` that drives it reacts on `support`,
which stands still if open. Losses in iron, brushes and bearings are not included; add a
`BearingFriction` or `Damper` where they matter.

Sources: Fischer, Elektrische Maschinen, 17th ed., ch. 5 (Kloss); Krause, Wasynczuk, Sudhoff and
Pekarek, Analysis of Electric Machinery and Drive Systems, 3rd ed., ch. 3, 4 and 6 (two axes).
"""

from __future__ import annotations

from collections.abc import Iterator

from lumped import (
    Component,
    Equation,
    Expr,
    Flange,
    Input,
    Output,
    Param,
    Var,
    der,
    param,
    var,
)
from lumped.ops import pi, sign, sqrt

__all__ = [
    "InductionMotor",
    "InverterInductionMotor",
    "SquirrelCageMotor",
    "SynchronousMotor",
]


class _Machine(Component):
    """Rotor and housing of a motor whose torque a subclass states."""

    symbol = "motor"
    flange = Flange(free=True)
    support = Flange(grounded=True)
    J: Param = param("kg.m2", "moment of inertia of the rotor", above=0)
    phi: Var = var("rad", "angle of the rotor")
    w: Var = var("rad/s", "angular velocity of the rotor")
    tau: Var = var("N.m", "driving torque")

    def equations(self) -> Iterator[Equation]:
        yield self.phi == self.flange.phi
        yield self.w == der(self.phi)
        yield self.J * der(self.w) == self.tau + self.flange.tau
        yield self.support.tau == self.tau

    @property
    def _speed(self) -> Expr:
        """Speed of the rotor in its housing, which induces the voltage."""
        return self.w - der(self.support.phi)


class InductionMotor(_Machine):
    """Induction motor on the mains by its torque curve, for motions slower than its currents.

    Kloss: ``tau = 2 tau_k (1 + a s_k) / (s / s_k + s_k / s + 2 a s_k)`` with the slip
    ``s = 1 - w / w_s``. The mains deliver ``tau w_s``, of which ``s`` heats the rotor.
    """

    w_s: Param = param("rad/s", "synchronous speed", nonzero=True)
    tau_k: Param = param("N.m", "breakdown torque", above=0)
    s_k: Param = param("1", "breakdown slip", above=0, below=1)
    a: Param = param("1", "stator over rotor resistance; 0: simple form", 0.0, min=0, max=1)
    s: Var = var("1", "slip")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        s, s_k, a = self.s, self.s_k, self.a
        yield s == 1 - self._speed / self.w_s
        # multiplied by s s_k, so that the formula is valid at s = 0 too
        curve = 2 * (1 + a * s_k) * s_k * s / (s**2 + s_k**2 + 2 * a * s_k**2 * s)
        # a field that turns backward drives backward
        yield self.tau == sign(self.w_s) * self.tau_k * curve

    def loss(self) -> Expr:
        """Heat in the rotor, W."""
        return self.tau * self.w_s * self.s


class SquirrelCageMotor(_Machine):
    """Induction motor with its currents, fed by three voltages of amplitude `V` and frequency `f`.

    Flux linkages ``psi`` and currents ``i`` of stator (s) and rotor (r) as complex numbers in axes
    that turn with the supply at ``w_1 = 2 pi f``, the voltage along d::

        V = R_s i_s + der(psi_s) + j w_1 psi_s,               psi_s = L_m (i_s + i_r) + L_ls i_s
        0 = R_r i_r + der(psi_r) + j (w_1 - pairs w) psi_r,   psi_r = L_m (i_s + i_r) + L_lr i_r
        tau = 3/2 pairs (psi_sd i_sq - psi_sq i_sd)

    Voltages and currents are amplitudes of a phase (star); the rotor is referred to the stator. The
    phase of the voltage is continuous whatever `f` does; a negative one turns the field backward.
    Source: Krause, ch. 6.
    """

    V: Input = Input("V", "amplitude of the voltage of a phase")
    f: Input = Input("Hz", "frequency of the supply")
    pairs: Param = param("1", "pole pairs", min=1)
    R_s: Param = param("Ohm", "resistance of a phase of the stator", min=0)
    R_r: Param = param("Ohm", "resistance of a phase of the rotor, referred", above=0)
    L_m: Param = param("H", "magnetising inductance", above=0)
    L_ls: Param = param("H", "leakage inductance of the stator", above=0)
    L_lr: Param = param("H", "leakage inductance of the rotor, referred", above=0)
    psi_sd: Var = var("V.s", "flux linkage of the stator along the voltage", state="prefer")
    psi_sq: Var = var("V.s", "flux linkage of the stator across the voltage", state="prefer")
    psi_rd: Var = var("V.s", "flux linkage of the rotor along the voltage", state="prefer")
    psi_rq: Var = var("V.s", "flux linkage of the rotor across the voltage", state="prefer")
    i_sd: Var = var("A", "current of the stator along the voltage")
    i_sq: Var = var("A", "current of the stator across the voltage")
    i_rd: Var = var("A", "current of the rotor along the voltage")
    i_rq: Var = var("A", "current of the rotor across the voltage")
    i: Var = var("A", "amplitude of the current of a phase")
    P: Var = var("W", "electric power taken from the supply")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        w_1 = 2 * pi * self.f
        slip = w_1 - self.pairs * self._speed
        L_m, L_ls, L_lr = self.L_m, self.L_ls, self.L_lr
        yield self.V == self.R_s * self.i_sd + der(self.psi_sd) - w_1 * self.psi_sq
        yield self.R_s * self.i_sq + der(self.psi_sq) + w_1 * self.psi_sd == 0
        yield self.R_r * self.i_rd + der(self.psi_rd) - slip * self.psi_rq == 0
        yield self.R_r * self.i_rq + der(self.psi_rq) + slip * self.psi_rd == 0
        yield self.psi_sd == L_m * (self.i_sd + self.i_rd) + L_ls * self.i_sd
        yield self.psi_sq == L_m * (self.i_sq + self.i_rq) + L_ls * self.i_sq
        yield self.psi_rd == L_m * (self.i_sd + self.i_rd) + L_lr * self.i_rd
        yield self.psi_rq == L_m * (self.i_sq + self.i_rq) + L_lr * self.i_rq
        torque = self.psi_sd * self.i_sq - self.psi_sq * self.i_sd
        yield self.tau == 1.5 * self.pairs * torque
        yield self.i == sqrt(self.i_sd**2 + self.i_sq**2)
        yield self.P == 1.5 * self.V * self.i_sd

    def loss(self) -> Expr:
        """Heat in the windings and the cage, W."""
        stator = self.R_s * (self.i_sd**2 + self.i_sq**2)
        return 1.5 * (stator + self.R_r * (self.i_rd**2 + self.i_rq**2))


class SynchronousMotor(_Machine):
    """Motor of three phases with permanent magnets, in the axes of its rotor (d along the magnets).

    With ``w_e = pairs w``::

        v_d = R i_d + L_d der(i_d) - w_e L_q i_q
        v_q = R i_q + L_q der(i_q) + w_e (L_d i_d + psi)
        tau = 3/2 pairs (psi + (L_d - L_q) i_d) i_q

    Voltages, currents and flux are amplitudes of a phase (star). The voltages come from a field
    oriented control: one current controller for each axis, fed with the outputs. Source: Krause,
    ch. 4.
    """

    v_d: Input = Input("V", "voltage along the magnets")
    v_q: Input = Input("V", "voltage across the magnets")
    pairs: Param = param("1", "pole pairs", min=1)
    psi: Param = param("V.s", "flux linkage of the magnets, amplitude", above=0)
    R: Param = param("Ohm", "resistance of a phase", min=0)
    L_d: Param = param("H", "inductance along the magnets", above=0)
    L_q: Param = param("H", "inductance across the magnets", above=0)
    i_d: Var = var("A", "current along the magnets", state="prefer")
    i_q: Var = var("A", "current across the magnets", state="prefer")
    P: Var = var("W", "electric power taken")
    i_d_meas = Output("A", "current along the magnets as measured")
    i_q_meas = Output("A", "current across the magnets as measured")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        i_d, i_q, w_e = self.i_d, self.i_q, self.pairs * self._speed
        yield self.v_d == self.R * i_d + self.L_d * der(i_d) - w_e * self.L_q * i_q
        yield self.v_q == self.R * i_q + self.L_q * der(i_q) + w_e * (self.L_d * i_d + self.psi)
        yield self.tau == 1.5 * self.pairs * (self.psi + (self.L_d - self.L_q) * i_d) * i_q
        yield self.P == 1.5 * (self.v_d * i_d + self.v_q * i_q)
        yield self.i_d_meas == i_d
        yield self.i_q_meas == i_q

    def loss(self) -> Expr:
        """Heat in the windings, W."""
        return 1.5 * self.R * (self.i_d**2 + self.i_q**2)


class InverterInductionMotor(_Machine):
    """Induction motor on an inverter that keeps its flux: ``T der(tau) = kloss(w_s - w) - tau``.

    ``kloss(d) = 2 tau_k (d / d_k) / (1 + (d / d_k)^2)`` depends on the slip speed alone; the
    synchronous speed `w_s` is a signal. `T` is the time constant of the rotor's flux.
    """

    w_s: Input = Input("rad/s", "synchronous speed")
    tau_k: Param = param("N.m", "breakdown torque", above=0)
    d_k: Param = param("rad/s", "slip speed at the breakdown torque", above=0)
    T: Param = param("s", "time constant of the torque", above=0)
    tau: Var = var("N.m", "driving torque", state="prefer")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        d = (self.w_s - self._speed) / self.d_k
        yield self.T * der(self.tau) == 2 * self.tau_k * d / (1 + d**2) - self.tau
