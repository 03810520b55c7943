"""Choice of a coupling by service factor and speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lumped.errors import OptionError
from lumped.support.arguments import checked
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.support.units import plain


@dataclass(frozen=True)
class Coupling:
    """Size of a coupling in a catalogue.

    Parameters
    ----------
    name : str
        Its name.
    torque : float or str
        Nominal torque, N.m, or with a unit, such as ``"100 kN.m"``.
    speed : float or str
        Permitted speed, rad/s, or with a unit, such as ``"2000 rpm"``.
    """

    name: str
    torque: float | str
    speed: float | str

    def __post_init__(self) -> None:
        for key, unit in (("torque", "N.m"), ("speed", "rad/s")):
            value = plain(getattr(self, key), unit, f"Coupling: {key} =", OptionError)
            if not 0 < value < math.inf:
                raise OptionError(f"Coupling: {key} = {value:g} {unit} must be positive.")
            object.__setattr__(self, key, value)


@dataclass(frozen=True)
class CouplingChoice(RichHtml):
    """The least coupling that carries a torque.

    Attributes
    ----------
    coupling : Coupling
        What is chosen.
    needed : float
        Torque of calculation, ``K T``, N.m.
    permitted : float
        Nominal torque at the speed of work, ``K_n T_n``, N.m.
    """

    coupling: Coupling
    needed: float
    permitted: float

    @property
    def margin(self) -> float:
        """Permitted over needed torque, at least 1."""
        return self.permitted / self.needed

    def __repr__(self) -> str:
        row = (
            self.coupling.name,
            number(self.needed),
            number(self.permitted),
            f"{self.margin:.2f}",
        )
        return table(("coupling", "needed, N.m", "permitted, N.m", "margin"), [row])


@checked
def choose_coupling(
    couplings: Sequence[Coupling],
    *,
    torque: float,
    speed: float,
    service: float = 1.0,
    correction: Sequence[tuple[float, float]] = (),
) -> CouplingChoice:
    """The least of several couplings that carries a torque at a speed.

    It keeps ``K T <= K_n T_n`` and turns no faster than permitted.

    Parameters
    ----------
    couplings : sequence of Coupling
        Sizes to choose from.
    torque : float
        T, N.m.
    speed : float
        Greatest speed of work, rad/s.
    service : float
        K, how much worse the torque is than an even one.
    correction : sequence of (float, float)
        K_n over the speed of work as a share of the permitted one, straight between these points;
        default is 1 at all speeds.

    Returns
    -------
    CouplingChoice

    Raises
    ------
    OptionError
        If a number is not positive, or no coupling suffices.
    """
    if not (torque > 0 and speed > 0 and service > 0):
        raise OptionError("choose_coupling: torque, speed and service must be positive.")
    needed = service * torque
    shares, factors = zip(*correction, strict=True) if correction else ((0.0,), (1.0,))
    for coupling in sorted(couplings, key=lambda each: float(each.torque)):
        share = speed / float(coupling.speed)
        permitted = float(np.interp(share, shares, factors)) * float(coupling.torque)
        if share <= 1 and needed <= permitted:
            return CouplingChoice(coupling, needed, permitted)
    raise OptionError(
        f"choose_coupling: no coupling carries {needed:.6g} N.m at {speed:.6g} rad/s; "
        f"{len(couplings)} were given."
    )
