"""Motors: direct current, induction, synchronous, and whole converter drives.

All have a rotor with inertia `J` on `flange`; the torque `tau` that drives it reacts on `support`,
an open one standing still. Losses in iron, brushes and bearings are not included; add a
`BearingFriction` or `Damper` where they matter. `p` is the pin at which a positive current drives
forward.

Sources: Fischer, Elektrische Maschinen, 17th ed., ch. 2 (direct current) and 5 (Kloss);
Leonhard, Control of Electrical Drives, 3rd ed., ch. 5 to 7; Krause, Wasynczuk, Sudhoff and
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
    Pin,
    Var,
    der,
    param,
    var,
)
from lumped.components.control import limited
from lumped.ops import maximum, pi, sign, sqrt

__all__ = [
    "ConverterDrive",
    "DCMotor",
    "InductionMotor",
    "InverterInductionMotor",
    "QuasiStaticDCMotor",
    "SeparatelyExcitedDCMotor",
    "SeriesDCMotor",
    "SpeedDrive",
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


class _DirectCurrent(_Machine):
    """Armature between the pins."""

    p = Pin()
    n = Pin()
    i: Var = var("A", "armature current", state="prefer")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self.p.i == self.i
        yield self.n.i == -self.i

    @property
    def _voltage(self) -> Expr:
        return self.p.v - self.n.v


class DCMotor(_DirectCurrent):
    """Direct-current motor with permanent magnets: ``v = R i + L der(i) + k w``, ``tau = k i``.

    `k` is the torque constant. From rated voltage, current and speed ``k = (V - R I) / w``.
    """

    k: Param = param("N.m/A", "torque over current, voltage over speed", nonzero=True)
    R: Param = param("Ohm", "resistance of the armature", min=0)
    L: Param = param("H", "inductance of the armature; for none, take QuasiStaticDCMotor", above=0)

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self._voltage == self.R * self.i + self.L * der(self.i) + self.k * self._speed
        yield self.tau == self.k * self.i

    def loss(self) -> Expr:
        """Heat in the armature, W."""
        return self.R * self.i**2


class QuasiStaticDCMotor(_DirectCurrent):
    """Direct-current motor whose current follows at once: ``v = R i + k w``, ``tau = k i``.

    For drives much slower than ``L / R``, where it saves a fast state.
    """

    k: Param = param("N.m/A", "torque over current, voltage over speed", nonzero=True)
    R: Param = param("Ohm", "resistance of the armature", above=0)
    i: Var = var("A", "armature current", state="avoid")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        yield self._voltage == self.R * self.i + self.k * self._speed
        yield self.tau == self.k * self.i

    def loss(self) -> Expr:
        """Heat in the armature, W."""
        return self.R * self.i**2


class SeriesDCMotor(_DirectCurrent):
    """Motor with its field in series: ``v = R i + L der(i) + k i w``, ``tau = k i^2``.

    From rated voltage, current and speed ``k = (V - R I) / (I w)``. Without load it runs away.
    """

    k: Param = param("N.m/A2", "torque over current squared", above=0)
    R: Param = param("Ohm", "resistance of armature and field", min=0)
    L: Param = param("H", "inductance of armature and field", above=0)

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        induced = self.k * self.i * self._speed
        yield self._voltage == self.R * self.i + self.L * der(self.i) + induced
        yield self.tau == self.k * self.i**2

    def loss(self) -> Expr:
        """Heat in armature and field, W."""
        return self.R * self.i**2


class SeparatelyExcitedDCMotor(_DirectCurrent):
    """Motor with a field of its own: ``v = R i + L der(i) + k i_f w``, ``tau = k i_f i``.

    The field between the pins `field_p` and `field_n`: ``v_f = R_f i_f + L_f der(i_f)``. With the
    field on the pins of the armature it is a shunt motor; a weaker field gives higher speeds.
    """

    field_p = Pin()
    field_n = Pin()
    k: Param = param("N.m/A2", "torque over the product of the currents", nonzero=True)
    R: Param = param("Ohm", "resistance of the armature", min=0)
    L: Param = param("H", "inductance of the armature", above=0)
    R_f: Param = param("Ohm", "resistance of the field", min=0)
    L_f: Param = param("H", "inductance of the field", above=0)
    i_f: Var = var("A", "field current", state="prefer")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        flux = self.k * self.i_f
        yield self._voltage == self.R * self.i + self.L * der(self.i) + flux * self._speed
        yield self.tau == flux * self.i
        yield self.field_p.i == self.i_f
        yield self.field_n.i == -self.i_f
        v_f = self.field_p.v - self.field_n.v
        yield v_f == self.R_f * self.i_f + self.L_f * der(self.i_f)

    def loss(self) -> Expr:
        """Heat in armature and field, W."""
        return self.R * self.i**2 + self.R_f * self.i_f**2


class InductionMotor(_Machine):
    """Induction motor on the mains by its torque curve, for runs that are slow to its currents.

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
        # multiplied by s s_k, so that it holds at s = 0 too
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

    V = Input("V", "amplitude of the voltage of a phase")
    f = Input("Hz", "frequency of the supply")
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

    v_d = Input("V", "voltage along the magnets")
    v_q = Input("V", "voltage across the magnets")
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

    ``kloss(d) = 2 tau_k (d / d_k) / (1 + (d / d_k)^2)`` depends on the slip speed alone, whatever
    the synchronous speed `w_s`, which is a signal. `T` is the time constant of the rotor's flux.
    """

    w_s = Input("rad/s", "synchronous speed")
    tau_k: Param = param("N.m", "breakdown torque", above=0)
    d_k: Param = param("rad/s", "slip speed at the breakdown torque", above=0)
    T: Param = param("s", "time constant of the torque", above=0)
    tau: Var = var("N.m", "driving torque", state="prefer")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        d = (self.w_s - self._speed) / self.d_k
        yield self.T * der(self.tau) == 2 * self.tau_k * d / (1 + d**2) - self.tau


class _Converter(_Machine):
    """Torque limit and torque loop of a motor on a converter."""

    tau_max: Param = param("N.m", "greatest torque, below the base speed", above=0)
    P_max: Param = param("W", "greatest power, above the base speed", above=0)
    T: Param = param("s", "time constant of the torque loop", above=0)
    limit: Var = var("N.m", "greatest torque at the present speed")
    tau: Var = var("N.m", "driving torque", state="prefer")
    tau_meas = Output("N.m", "driving torque as the converter reports it")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        w, base = self._speed, self.P_max / self.tau_max
        yield self.limit == self.P_max / maximum(maximum(w, -w), base)
        yield self.tau_meas == self.tau


class ConverterDrive(_Converter):
    """Torque-controlled motor: ``T der(tau) = clip(wanted, +-limit) - tau``.

    The limit is `tau_max` up to the base speed ``P_max / tau_max``, then ``P_max / |w|``: constant
    torque, constant power.
    """

    wanted = Input("N.m", "wanted torque")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        wanted = limited(self.wanted, -self.limit, self.limit)
        yield self.T * der(self.tau) == wanted - self.tau


class SpeedDrive(_Converter):
    """Speed-controlled motor: PI control with anti-windup on the torque loop of `ConverterDrive`.

    ``e = wanted - droop tau - w``, ``u = k (e + x)``, ``T_i der(x) = e + (y - u) / k`` where `y`
    is `u` within the torque limit, and ``T der(tau) = y - tau``. With droop, drives on one shaft
    share its load: ``tau = (wanted - w) / droop`` in steady state.
    """

    wanted = Input("rad/s", "wanted speed without load")
    k: Param = param("N.m.s/rad", "gain of the speed control", above=0)
    T_i: Param = param("s", "integral time of the speed control", above=0)
    droop: Param = param("rad/(s.N.m)", "loss of speed over torque", 0.0, min=0)
    x: Var = var("rad/s", "integral part over the gain", state="prefer")
    u: Var = var("N.m", "torque wanted by the speed control")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        error = self.wanted - self.droop * self.tau - self._speed
        y = limited(self.u, -self.limit, self.limit)
        yield self.u == self.k * (error + self.x)
        yield self.T_i * der(self.x) == error + (y - self.u) / self.k
        yield self.T * der(self.tau) == y - self.tau
