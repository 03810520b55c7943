"""Limits of vibrations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from lumped.compiler.structure import Name
from lumped.errors import OptionError
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.units import convert_value, has_unit, plain
from lumped.vibration.ordered.order_amplitudes import OrderAmplitudes
from lumped.vibration.speeds.campbell import BarredRange

Measure = Literal["maximum", "half range", "sum", "with mean", "mean power"]
Permitted = float | str | Sequence[Sequence[float]] | Callable[[Real], ArrayLike]
"""A number, a value with a unit, rows of speed (rad/s) and value, or a function of the speeds."""


@dataclass(frozen=True, eq=False)
class Limit:
    """What a quantity may reach.

    Parameters
    ----------
    quantity : name
        The quantity.
    permitted : float, str, rows or callable
        Largest permitted value, in the unit of the quantity: a number, a value with a unit
        (``"40 MPa"``), rows of speed, rad/s, and value, between which lines are drawn, or a
        function of speeds, rad/s.
    name : str
        What the limit is called.
    measure : {"maximum", "half range", "sum", "with mean", "mean power"}
        Of the synthesis over a cycle (see `lumped.vibration.Synthesis`); "with mean" is the largest
        size of the whole, its mean included, "mean power" the mean of a dissipated power, all
        orders together (see `OrderResponse.mean_power`). Runs have their largest size, and for
        "mean power" the mean over the run.
    clause, source : str
        Where it stands.
    speeds : tuple of float or str, optional
        First and last speed at which it holds, rad/s or with a unit.
    barred : callable, optional
        The range that a rule bars about a speed, rad/s, at which the limit is exceeded.
    advice : str
        What a verdict says if it is exceeded.

    Raises
    ------
    OptionError
        If the measure is another, or a speed is none.
    UnitError
        If the unit of a speed is none of speed.
    """

    quantity: Name
    permitted: Permitted
    name: str = "limit"
    measure: Measure = "maximum"
    clause: str = ""
    source: str = ""
    speeds: tuple[float | str, float | str] | None = None
    barred: Callable[[float], BarredRange] | None = None
    advice: str = ""

    def __post_init__(self) -> None:
        if self.measure not in get_args(Measure):
            raise OptionError(
                f"limit '{self.name}': measure = {self.measure!r}; one of "
                f"{', '.join(get_args(Measure))} is needed."
            )
        if self.speeds is not None:
            what = f"limit '{self.name}': speeds ="
            ends = tuple(plain(speed, "rad/s", what, OptionError) for speed in self.speeds)
            object.__setattr__(self, "speeds", ends)

    @property
    def ends(self) -> tuple[float, float] | None:
        """First and last speed at which it holds, rad/s."""
        return cast(tuple[float, float] | None, self.speeds)

    def holding(self, speeds: Real) -> Real:
        """Those of some speeds, rad/s, at which it holds."""
        if self.ends is None:
            return speeds
        return speeds[(speeds >= self.ends[0]) & (speeds <= self.ends[1])]

    def at(self, speeds: Real, unit: str) -> Real:
        """Permitted values at speeds, rad/s, in a unit.

        Raises
        ------
        UnitError
            If the value has a unit of another dimension.
        OptionError
            If a value is no positive number, or a speed lies outside the rows.
        """
        what = f"limit '{self.name}' of {self.quantity}: permitted ="
        if callable(self.permitted):
            found = np.broadcast_to(np.asarray(self.permitted(speeds), dtype=float), speeds.shape)
        elif has_unit(self.permitted):
            found = np.full(speeds.shape, convert_value(self.permitted, unit, what))
        elif isinstance(self.permitted, str):
            raise OptionError(f"{what} {self.permitted!r}: a number in {unit} is needed.")
        elif isinstance(self.permitted, Sequence):
            places, values = _columns(self.permitted, what)
            outside = speeds[(speeds < places[0]) | (speeds > places[-1])]
            if len(outside):
                raise OptionError(
                    f"{what} rows from {places[0]:g} to {places[-1]:g} rad/s; at {outside[0]:g} "
                    "rad/s nothing is given. Add rows, or name the speeds at which it holds."
                )
            found = np.interp(speeds, places, values)
        else:
            found = np.full(speeds.shape, float(self.permitted))
        if not (np.isfinite(found).all() and (found > 0).all()):
            raise OptionError(f"{what} {found[~(found > 0)][:1]}: positive values are needed.")
        return found


def _columns(rows: Sequence[Sequence[float]] | str, what: str) -> tuple[Real, Real]:
    try:
        places, values = np.array([(float(row[0]), float(row[1])) for row in rows]).T
    except (TypeError, ValueError, IndexError):
        raise OptionError(f"{what} {rows!r}: rows of speed, rad/s, and value are needed.") from None
    if not (np.diff(places) > 0).all():
        raise OptionError(f"{what} rows: the speeds must increase.")
    return places, values


@checked
def torque_reversal(response: OrderAmplitudes, of: Name, *, share: float = 1.0) -> Limit:
    """Limit against hammering: the torque of a mesh must not change its sign.

    Parameters
    ----------
    response : OrderResponse or OrbitRange
        That has the means.
    of : name
        The torque; its vibration must stay below its mean.
    share : float
        Of the mean that is permitted.

    Returns
    -------
    Limit

    Raises
    ------
    UnknownNameError
        If the torque was not computed.
    """
    ascending = np.argsort(response.speeds)
    known, mean = response.speeds[ascending], share * np.abs(response.mean(of))[ascending]
    return Limit(
        of,
        lambda speeds: np.maximum(np.interp(speeds, known, mean), 1e-300),
        name="torque reversal",
        measure="maximum",
    )
