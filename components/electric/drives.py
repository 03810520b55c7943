"""Motors on a converter that controls their torque or speed.

Sources: Leonhard, Control of Electrical Drives, 3rd ed., ch. 7, 12 and 15; Kim and Sul, Maximum
torque control of an induction machine in the field weakening region, IEEE Trans. Industry
Applications 31 (1995) 787.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

from lumped import Equation, Expr, Input, Output, Param, Var, der, param, var
from lumped.components.control.controllers import limit_between
from lumped.components.electric.motors import _Machine
from lumped.errors import EquationError
from lumped.language.value_types import Rows
from lumped.ops import interpolate, maximum, minimum, sqrt, where

__all__ = ["ConverterDrive", "FieldOrientedMotor", "MappedMotor", "SpeedDrive"]


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

    wanted: Input = Input("N.m", "wanted torque")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        wanted = limit_between(self.wanted, -self.limit, self.limit)
        yield self.T * der(self.tau) == wanted - self.tau


class SpeedDrive(_Converter):
    """Speed-controlled motor: PI control with anti-windup on the torque loop of `ConverterDrive`.

    ``e = wanted - droop tau - w``, ``u = k (e + x)``, ``T_i der(x) = e + (y - u) / k`` where `y`
    is `u` within the torque limit, and ``T der(tau) = y - tau``. With droop, drives on one shaft
    share its load: ``tau = (wanted - w) / droop`` in steady state.
    """

    wanted: Input = Input("rad/s", "wanted speed without load")
    k: Param = param("N.m.s/rad", "gain of the speed control", above=0)
    T_i: Param = param("s", "integral time of the speed control", above=0)
    droop: Param = param("rad/(s.N.m)", "loss of speed over torque", 0.0, min=0)
    x: Var = var("rad/s", "integral part over the gain", state="prefer")
    u: Var = var("N.m", "torque wanted by the speed control")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        error = self.wanted - self.droop * self.tau - self._speed
        y = limit_between(self.u, -self.limit, self.limit)
        yield self.u == self.k * (error + self.x)
        yield self.T_i * der(self.x) == error + (y - self.u) / self.k
        yield self.T * der(self.tau) == y - self.tau


class FieldOrientedMotor(_Machine):
    """Induction motor under field-oriented control: ``tau = 3/2 pairs (L_m / L_r) psi i_q``.

    Its currents along (d) and across (q) the flux of the rotor follow their commands with the time
    constant `T` of the current control; the flux follows the current along it::

        T der(i_d) = i_d* - i_d,   T der(i_q) = clip(i_q*, +-i_most) - i_q
        (L_r / R_r) der(psi) = L_m i_d - psi

    ``i_q*`` gives the torque `wanted`. Up to the speed at which the voltage is used up the flux is
    `psi_n`; beyond it the flux is weakened to give the greatest torque that `V_max` and `I_max`
    allow (Kim and Sul): about constant power first, then the torque falls with the square of the
    speed. The voltage limit leaves out resistance and slip, so that `V` may exceed `V_max` by their
    share. Voltages, currents and fluxes are amplitudes of a phase (star), as in
    `SquirrelCageMotor`. The motor is excited at the start.
    """

    wanted: Input = Input("N.m", "wanted torque")
    pairs: Param = param("1", "pole pairs", min=1)
    R_s: Param = param("Ohm", "resistance of a phase of the stator", min=0)
    R_r: Param = param("Ohm", "resistance of a phase of the rotor, referred", above=0)
    L_m: Param = param("H", "magnetising inductance", above=0)
    L_ls: Param = param("H", "leakage inductance of the stator", above=0)
    L_lr: Param = param("H", "leakage inductance of the rotor, referred", above=0)
    psi_n: Param = param("V.s", "flux linkage of the rotor below the weakening", above=0)
    V_max: Param = param("V", "greatest amplitude of the voltage of a phase", above=0)
    I_max: Param = param("A", "greatest amplitude of the current", above=psi_n / L_m)
    T: Param = param("s", "time constant of the current control", above=0)
    psi: Var = var("V.s", "flux linkage of the rotor", psi_n, state="prefer")
    i_d: Var = var("A", "current along the flux", psi_n / L_m, state="prefer")
    i_q: Var = var("A", "current across the flux", state="prefer")
    i_most: Var = var("A", "greatest current across the flux at the present speed")
    limit: Var = var("N.m", "greatest torque at the present speed and flux")
    w_1: Var = var("rad/s", "angular frequency of the stator")
    i: Var = var("A", "amplitude of the current of a phase")
    V: Var = var("V", "amplitude of the voltage of a phase, in steady state")
    P: Var = var("W", "electric power, in steady state")
    tau_meas = Output("N.m", "driving torque as the converter reports it")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        L_m, L_s, L_r = self.L_m, self.L_m + self.L_ls, self.L_m + self.L_lr
        leakage = 1 - L_m**2 / (L_s * L_r)  # Blondel's coefficient
        turn = self.pairs * self._speed
        # squares of currents; `reach` is the flux that the voltage allows, over L_s
        most, full = self.I_max**2, (self.psi_n / L_m) ** 2
        used_up = full + leakage**2 * (most - full)
        base = self.V_max / (L_s * sqrt(used_up))
        reach = used_up * (base / maximum(abs(turn), base)) ** 2
        both = (reach - leakage**2 * most) / (1 - leakage**2)
        along = minimum(maximum(both, reach / 2), full)
        across = minimum(most - along, (reach - along) / leakage**2)
        per_ampere = 1.5 * self.pairs * L_m / L_r * self.psi
        wanted = limit_between(self.wanted / per_ampere, -self.i_most, self.i_most)
        yield self.i_most == sqrt(across)
        yield self.limit == per_ampere * self.i_most
        yield self.T * der(self.i_d) == sqrt(along) - self.i_d
        yield self.T * der(self.i_q) == wanted - self.i_q
        yield L_r / self.R_r * der(self.psi) == L_m * self.i_d - self.psi
        yield self.tau == per_ampere * self.i_q
        yield self.tau_meas == self.tau
        yield self.w_1 == turn + L_m * self.R_r / L_r * self.i_q / self.psi
        v_d = self.R_s * self.i_d - self.w_1 * leakage * L_s * self.i_q
        v_q = self.R_s * self.i_q + self.w_1 * (leakage * L_s * self.i_d + L_m / L_r * self.psi)
        yield self.i == sqrt(self.i_d**2 + self.i_q**2)
        yield self.V == sqrt(v_d**2 + v_q**2)
        yield self.P == 1.5 * (v_d * self.i_d + v_q * self.i_q)

    def loss(self) -> Expr:
        """Heat in the windings and the cage, W."""
        L_m, L_r = self.L_m, self.L_m + self.L_lr
        rotor = (L_m * self.i_q / L_r) ** 2 + ((self.psi - L_m * self.i_d) / L_r) ** 2
        return 1.5 * (self.R_s * (self.i_d**2 + self.i_q**2) + self.R_r * rotor)


class MappedMotor(_Machine):
    """Motor by its maps: ``T der(tau) = clip(wanted, +-limit(w)) - tau``, ``P = tau w + lost``.

    `limits` are rows of speed in rad/s, from zero up, and greatest torque in N.m: joined by
    straight lines, the last torque kept beyond its speed. `efficiency` is a table: its first row
    holds a corner (ignored) and torques in N.m from zero up, each further row a speed in rad/s and
    the efficiencies at these torques; between the points it is bilinear, outside it is that of the
    nearest point. Only magnitudes of speed and torque count, so all four quadrants are alike. With
    the power ``p = tau w`` at the shaft, ``lost = (1 / eta - 1) p`` while it drives and
    ``(eta - 1) p`` while it generates: an efficiency says nothing of the heat at standstill.
    """

    wanted: Input = Input("N.m", "wanted torque")
    limits: Rows = ()
    efficiency: Rows = ()
    T: Param = param("s", "time constant of the torque loop", above=0)
    tau: Var = var("N.m", "driving torque", state="prefer")
    limit: Var = var("N.m", "greatest torque at the present speed")
    eta: Var = var("1", "efficiency at the present speed and torque")
    lost: Var = var("W", "power lost in motor and converter")
    P: Var = var("W", "electric power, positive where it drives")
    tau_meas = Output("N.m", "driving torque as the converter reports it")

    def equations(self) -> Iterator[Equation]:
        yield from super().equations()
        places, torques, table = _efficiencies(self.efficiency)
        w = abs(self._speed)
        yield self.limit == _at(w, *_limits(self.limits))
        wanted = limit_between(self.wanted, -self.limit, self.limit)
        yield self.T * der(self.tau) == wanted - self.tau
        yield self.tau_meas == self.tau
        columns = [_at(w, places, column) for column in zip(*table, strict=True)]
        yield self.eta == _between(abs(self.tau), torques, columns)
        power = self.tau * self._speed
        yield self.lost == where(power >= 0, (1 / self.eta - 1) * power, (self.eta - 1) * power)
        yield self.P == power + self.lost

    def loss(self) -> Expr:
        """Heat in motor and converter, W."""
        return self.lost


def _at(x: Expr, places: Sequence[float], values: Sequence[float]) -> Expr:
    """Straight lines through points, the first and last value kept outside of them."""
    ends = [places[0] - 1, *places, places[-1] + 1]
    return interpolate(x, ends, [values[0], *values, values[-1]])


def _between(x: Expr, places: Sequence[float], values: Sequence[Expr]) -> Expr:
    """Straight lines through values that are expressions: their sum with piecewise weights."""
    total: Expr | None = None
    for i, value in enumerate(values):
        weight = _at(x, places, [float(i == j) for j in range(len(places))])
        total = value * weight if total is None else total + value * weight
    assert total is not None
    return total


def _limits(rows: Rows) -> tuple[list[float], list[float]]:
    """Speeds and torques that make sense.

    Raises
    ------
    EquationError
        If rows are missing, do not begin at zero, do not increase, or hold a negative torque.
    """
    hint = "Give rows of speed in rad/s and greatest torque in N.m, ((0, 200), (300, 200), ...)."
    try:
        found = [(float(w), float(tau)) for w, tau in rows]
    except (TypeError, ValueError):
        found = []
    if not found:
        raise EquationError(f"limits = {rows!r} has no rows of two numbers. {hint}")
    _increasing("limits: the speeds", [w for w, _ in found])
    for w, tau in found:
        if not 0 <= tau < float("inf"):
            raise EquationError(
                f"limits: the torque {tau:g} N.m at {w:g} rad/s must be a finite number that is "
                "not negative; it counts in both directions."
            )
    return [w for w, _ in found], [tau for _, tau in found]


def _efficiencies(rows: Rows) -> tuple[list[float], list[float], list[list[float]]]:
    """Speeds, torques and efficiencies that make sense.

    Raises
    ------
    EquationError
        If rows are missing or of different lengths, speeds or torques do not increase from zero,
        or an efficiency is not above 0 and at most 1.
    """
    hint = (
        "Give a first row (0, tau_1, tau_2, ...) and rows (w, eta_1, eta_2, ...) such as "
        "((0, 0, 100), (0, 0.7, 0.8), (300, 0.8, 0.95))."
    )
    try:
        found = [[float(value) for value in row] for row in rows]
    except (TypeError, ValueError):
        found = []
    if len(found) < 2 or len(found[0]) < 2 or len({len(row) for row in found}) > 1:
        raise EquationError(
            f"efficiency = {rows!r} has no head and rows of the same length. {hint}"
        )
    torques, speeds = found[0][1:], [row[0] for row in found[1:]]
    _increasing("efficiency: the torques", torques)
    _increasing("efficiency: the speeds", speeds)
    for row in found[1:]:
        for tau, eta in zip(torques, row[1:], strict=True):
            if not 0 < eta <= 1:
                raise EquationError(
                    f"efficiency: {eta:g} at {row[0]:g} rad/s and {tau:g} N.m must be greater than "
                    "0 and at most 1."
                )
    return speeds, torques, [row[1:] for row in found[1:]]


def _increasing(what: str, places: Sequence[float]) -> None:
    """Refuse places that do not increase from zero up."""
    if not 0 <= places[0]:
        raise EquationError(f"{what} begin at {places[0]:g}; magnitudes count, from zero up.")
    for before, after in pairwise(places):
        if not before < after < float("inf"):
            raise EquationError(f"{what} must increase, but {before:g} -> {after:g}.")
