"""Circuits of synchronous machines from per-unit data and from standard parameters.

Source: Kundur, Power System Stability and Control, ch. 3.4 (per unit) and 4.2 (standard
parameters, classical expressions).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from lumped.errors import ParameterError
from lumped.ops import pi

__all__ = ["PerUnit", "standard_parameters"]

Windings = Sequence[tuple[float, float]]


@dataclass(frozen=True)
class PerUnit:
    """Base values of a machine: amplitudes of a phase, referred to the stator.

    Parameters
    ----------
    S : float
        Rated apparent power, V.A.
    V : float
        Rated voltage from line to line, root mean square, V.
    f : float
        Rated frequency, Hz.
    pairs : int
        Pole pairs.

    Raises
    ------
    ParameterError
        If one of them is not positive.
    """

    S: float
    V: float
    f: float
    pairs: int = 1

    def __post_init__(self) -> None:
        for name, unit in (("S", "V.A"), ("V", "V"), ("f", "Hz"), ("pairs", "1")):
            _positive("PerUnit", name, getattr(self, name), unit)

    @property
    def w(self) -> float:
        """Electrical angular frequency, rad/s."""
        return 2 * pi * self.f

    @property
    def speed(self) -> float:
        """Synchronous speed of the shaft, rad/s."""
        return self.w / self.pairs

    @property
    def v(self) -> float:
        """Voltage of a phase, V."""
        return float(self.V * (2 / 3) ** 0.5)

    @property
    def i(self) -> float:
        """Current, A."""
        return self.S / (1.5 * self.v)

    @property
    def Z(self) -> float:  # noqa: N802 - the letter of the formulas
        """Impedance, Ohm."""
        return self.v / self.i

    @property
    def L(self) -> float:  # noqa: N802
        """Inductance, H."""
        return self.Z / self.w

    @property
    def psi(self) -> float:
        """Flux linkage, V.s."""
        return self.v / self.w

    @property
    def tau(self) -> float:
        """Torque, N.m."""
        return self.S / self.speed

    def J(self, H: float) -> float:  # noqa: N802
        """Moment of inertia of an inertia constant `H` in s, kg.m2: ``2 H S / speed^2``."""
        return 2 * H * self.S / self.speed**2

    def circuit(
        self,
        *,
        X_l: float,
        X_ad: float,
        X_aq: float,
        field: tuple[float, float],
        d: Windings = (),
        q: Windings = (),
        R_a: float = 0.0,
    ) -> dict[str, Any]:
        """Circuit of a `WoundFieldMachine` from per-unit values.

        Parameters
        ----------
        X_l, X_ad, X_aq : float
            Leakage and magnetising reactances, pu.
        field : (float, float)
            Leakage reactance and resistance of the field winding, pu.
        d, q : sequence of (float, float)
            The same of the dampers of each axis, at most two.
        R_a : float
            Resistance of the stator, pu.

        Returns
        -------
        dict
            Parameters by name, in Ohm and H, `pairs` among them, and the numbers of dampers.

        Raises
        ------
        ParameterError
            If a value is out of its range.
        """
        given = {"X_l": X_l, "X_ad": X_ad, "X_aq": X_aq}
        for axis, windings in (("d", d), ("q", q)):
            if len(windings) > 2:
                raise ParameterError(
                    f"circuit({axis}=...): {len(windings)} dampers; at most two for each axis."
                )
        named = [("f", field)]
        named += [(f"{k}d", winding) for k, winding in enumerate(d, 1)]
        named += [(f"{k}q", winding) for k, winding in enumerate(q, 1)]
        for name, (X, R) in named:
            given |= {f"X_{name}": X, f"R_{name}": R}
        for name, value in given.items():
            _positive("circuit", name, value, "pu")
        if not 0 <= R_a < float("inf"):
            raise ParameterError(f"circuit(R_a={R_a:g}): must be at least 0 pu and finite.")
        found: dict[str, Any] = {"pairs": self.pairs, "R_s": R_a * self.Z}
        found |= {"L_ls": X_l * self.L, "L_md": X_ad * self.L, "L_mq": X_aq * self.L}
        for name, (X, R) in named:
            found |= {f"R_{name}": R * self.Z, f"L_l{name}": X * self.L}
        return found | {"dampers_d": len(d), "dampers_q": len(q)}


def standard_parameters(
    base: PerUnit,
    *,
    X_d: Sequence[float],
    T_do: Sequence[float],
    X_q: Sequence[float],
    T_qo: Sequence[float] = (),
    X_l: float,
    R_a: float = 0.0,
) -> dict[str, Any]:
    """Circuit of a `WoundFieldMachine` from its standard parameters.

    Each axis has its synchronous reactance, and one reactance and one open-circuit time constant
    for each winding of its rotor, from the slowest on::

        X'd  = X_l + X_ad || X_f             T'do  = (X_ad + X_f) / (w_0 R_f)
        X''d = X_l + X_ad || X_f || X_1d     T''do = (X_1d + X_ad || X_f) / (w_0 R_1d)

    where ``a || b = a b / (a + b)``; in the q axis 1q and 2q take the places of f and 1d.

    Parameters
    ----------
    base : PerUnit
        Base values.
    X_d : sequence of float
        Xd, X'd, X''d, pu: of the field winding and up to two dampers.
    T_do : sequence of float
        T'do, T''do, s; one less than `X_d`.
    X_q, T_qo : sequence of float
        Those of the q axis: Xq, X''q and T''qo with one damper, Xq, X'q, X''q and T'qo, T''qo with
        two.
    X_l : float
        Leakage reactance of the stator, pu.
    R_a : float
        Resistance of the stator, pu.

    Returns
    -------
    dict
        As by `PerUnit.circuit`.

    Raises
    ------
    ParameterError
        If reactances do not fall from each to the next and stay above `X_l`, time constants are
        not positive or do not fall, or their numbers do not fit.
    """
    _positive("standard_parameters", "X_l", X_l, "pu")
    d = _windings(base, "d", X_d, T_do, X_l)
    q = _windings(base, "q", X_q, T_qo, X_l)
    if not d:
        raise ParameterError(
            "standard_parameters: X_d, T_do need X'd and T'do of the field winding, such as "
            "X_d=(1.8, 0.3), T_do=(5.0,)."
        )
    return base.circuit(
        X_l=X_l, X_ad=X_d[0] - X_l, X_aq=X_q[0] - X_l, field=d[0], d=d[1:], q=q, R_a=R_a
    )


def _windings(
    base: PerUnit, axis: str, reactances: Sequence[float], times: Sequence[float], leakage: float
) -> list[tuple[float, float]]:
    """Leakage reactance and resistance of each winding of the rotor, pu."""
    names = [f"X{'' if k == 0 else k * chr(39)}{axis}" for k in range(len(reactances))]
    clocks = [f"T{(k + 1) * chr(39)}{axis}o" for k in range(len(times))]
    if len(times) != len(reactances) - 1:
        raise ParameterError(
            f"standard_parameters: {len(reactances)} reactances X_{axis} need "
            f"{max(len(reactances) - 1, 0)} time constants T_{axis}o, not {len(times)}: one for "
            "each winding of the rotor."
        )
    for name, value, unit in (
        *((name, value, "pu") for name, value in zip(names, reactances, strict=True)),
        *((name, value, "s") for name, value in zip(clocks, times, strict=True)),
    ):
        _positive("standard_parameters", name, value, unit)
    _falling([*zip(names, reactances, strict=True), ("X_l", leakage)], "pu")
    _falling(list(zip(clocks, times, strict=True)), "s")
    found = []
    for (before, after), T in zip(pairwise(reactances), times, strict=True):
        # what the winding sees, and what it leaves of it
        seen, left = before - leakage, after - leakage
        X = seen * left / (seen - left)
        found.append((X, (X + seen) / (base.w * T)))
    return found


def _falling(named: Sequence[tuple[str, float]], unit: str) -> None:
    for (name, value), (next_name, next_value) in pairwise(named):
        if not value > next_value:
            raise ParameterError(
                f"standard_parameters: {next_name} = {next_value:g} {unit} must be less than "
                f"{name} = {value:g} {unit}; each winding further from the stator is slower."
            )


def _positive(where: str, name: str, value: float, unit: str) -> None:
    if not 0 < value < float("inf"):
        unit = "" if unit == "1" else f" {unit}"
        raise ParameterError(f"{where}: {name} = {value:g}{unit} must be positive and finite.")
