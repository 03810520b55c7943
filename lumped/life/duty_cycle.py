"""Damage of a duty cycle: what happens, how often, and what breaks after how long."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lumped.compiler.structure import Name
from lumped.errors import OptionError, shown
from lumped.functionals.damage_law import MeanStress
from lumped.life.load_case import LoadCase, read_load
from lumped.life.rainflow import Cycles, damage_of
from lumped.life.repeated_count import BETWEEN, count_in_turn
from lumped.life.sn_curve import SNCurve
from lumped.plots.draw import Backend, draw
from lumped.plots.numbers import duty_picture
from lumped.support.arguments import checked
from lumped.support.display_units import Units, choose_units, display
from lumped.support.optional_packages import extra
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table

Real = NDArray[np.float64]
_BETWEEN = "between cases"


@dataclass(frozen=True, eq=False)
class DutyCycle(RichHtml):
    """Damage of a duty cycle that repeats until the part breaks.

    Attributes
    ----------
    names : tuple of str
        Its cases, in the order in which they happen.
    repetitions : tuple of int
        How often each happens, one right after the other.
    durations : ndarray, shape (k,)
        Of each case once, s.
    damages : ndarray, shape (k,)
        Of each case in a duty cycle, all its repetitions together.
    between : float
        Damage of the cycles from a turning point of one case to one of another.
    cycles : Cycles
        All cycles of a duty cycle.
    case : ndarray of int, shape (len(cycles.ranges),)
        To which case each cycle belongs; -1 for one between cases.
    unit : str
        Unit of the load; empty if it is not known.
    """

    names: tuple[str, ...]
    repetitions: tuple[int, ...]
    durations: Real
    damages: Real
    between: float
    cycles: Cycles
    case: NDArray[np.int64]
    unit: str

    @property
    def damage(self) -> float:
        """Share of the life that a duty cycle takes (Palmgren and Miner)."""
        return float(self.damages.sum() + self.between)

    @property
    def life(self) -> float:
        """Duty cycles until the sum of damage is 1; infinite without damage."""
        return 1 / self.damage if self.damage else math.inf

    @property
    def duration(self) -> float:
        """Of a duty cycle, s."""
        return float(np.dot(self.repetitions, self.durations))

    @property
    def hours(self) -> float:
        """Life, h."""
        return self.life * self.duration / 3600

    @property
    def worst(self) -> str:
        """Case that does most damage, or ``"between cases"``."""
        return max(self._rows(), key=lambda row: row[3])[0]

    def _rows(self) -> list[tuple[str, int, float, float]]:
        """Name, repetitions, duration and damage; at the end what is between cases."""
        own = zip(self.names, self.repetitions, self.durations, self.damages, strict=True)
        rows = [(name, n, float(n * t), float(d)) for name, n, t, d in own]
        return [*rows, (_BETWEEN, 1, 0.0, self.between)] if len(rows) > 1 else rows

    def _largest(self, row: int) -> float:
        """Largest range of a case, or between cases."""
        own = self.case == (row if row < len(self.names) else BETWEEN)
        return float(self.cycles.ranges[own].max(initial=0.0))

    @checked
    def to_pandas(self, *, units: Units = None) -> Any:
        """A DataFrame, one row for each case and one for cycles between cases.

        Parameters
        ----------
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.

        Raises
        ------
        OptionError
            If pandas is not installed.
        UnitError
            If a unit does not fit.
        """
        pandas = extra("pandas", "data", "to_pandas")
        told = display("range", self.unit, choose_units(units), is_change=True)
        rows = self._rows()
        frame = pandas.DataFrame(
            {
                "case": [row[0] for row in rows],
                "repetitions": [row[1] for row in rows],
                "duration": [row[2] for row in rows],
                "largest range": [told.value(self._largest(i)) for i in range(len(rows))],
                "damage": [row[3] for row in rows],
            }
        )
        frame.attrs = {"units": {"duration": "s", "largest range": told.unit, "damage": "1"}}
        return frame

    @checked
    def plot(self, *, units: Units = None, backend: Backend = "matplotlib", ax: Any = None) -> Any:
        """Damage by case, and how many cycles exceed a range.

        Parameters
        ----------
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        OptionError
            If plotly is not installed, or `ax` does not fit.
        UnitError
            If a unit does not fit.
        """
        told = display("range", self.unit, choose_units(units), is_change=True)
        shares = [(row[0], row[3] / self.damage if self.damage else 0.0) for row in self._rows()]
        spectra = {"all": (told.value(self.cycles.ranges), self.cycles.counts)}
        for i, (name, _) in enumerate(shares if len(self.names) > 1 else []):
            own = self.case == (i if i < len(self.names) else BETWEEN)
            spectra[name] = told.value(self.cycles.ranges[own]), self.cycles.counts[own]
        return draw(duty_picture(self._title(), shares, spectra, told.unit), backend, ax)

    def _title(self) -> str:
        if not self.damage:
            return "a duty cycle does no damage"
        return (
            f"damage {number(self.damage, 4)} in {number(self.duration, 4)} s: "
            f"life {number(self.life, 4)} duty cycles, {number(self.hours, 4)} h"
        )

    def __repr__(self) -> str:
        rows = []
        for i, (name, n, duration, damage) in enumerate(self._rows()):
            share = f"{damage / self.damage:.1%}" if self.damage else "-"
            largest, unit = amounts("range", self.unit, self._largest(i), is_change=True)
            told = number(duration, 4) if i < len(self.names) else "-"
            count = str(n) if i < len(self.names) else "-"
            rows.append((name, count, told, largest, unit or "-", number(damage, 4), share))
        head = ("case", "repetitions", "time, s", "largest range", "unit", "damage", "share")
        return f"{self._title()}\n" + table(head, rows)


@checked
def duty_cycle(
    cases: Mapping[str, LoadCase],
    *,
    curve: SNCurve,
    of: Name | None = None,
    scale: float = 1.0,
    mean_stress: MeanStress | None = None,
    rtol: float = 1e-6,
) -> DutyCycle:
    """Damage of load cases that follow each other, and the life of a part under them.

    The cases happen in the order given, each as often as stated, and then all again. Cycles are
    those of this sequence: closed cycles of each case by four points; what they leave open is
    joined in the order of time and counted again, so the cycle from the lowest valley of one case
    to the highest peak of another counts as often as it happens.

    Parameters
    ----------
    cases : mapping of str to LoadCase
        What happens, by name.
    curve : SNCurve
        Life over the amplitude.
    of : name or expression, optional
        The load in runs and systems.
    scale : float
        Stress for each unit of the load, such as ``16 / (pi d^3)`` for the torque of a shaft.
    mean_stress : MeanStress, optional
        How the mean of a cycle counts; it has no effect by default.
    rtol : float
        Accuracy of the runs that are made here; swings that are smaller than this part of the range
        of a load are left out.

    Returns
    -------
    DutyCycle

    Raises
    ------
    OptionError
        If there is no case, one lacks what belongs to its load, or see `Cycles.damage`.
    UnknownNameError
        If the load does not exist in a system.
    SolverError
        If a run cannot be completed, or its output times are too far apart.

    Notes
    -----
    Joining what is left open to itself, and counting again: Amzallag and others, Standardization of
    the rainflow counting method for fatigue analysis, Int. J. Fatigue 16 (1994) 287.
    """
    if not cases:
        raise OptionError("duty_cycle: cases: at least one load case is needed.")
    for name, case in cases.items():
        if not isinstance(case, LoadCase):
            raise OptionError(
                f"duty_cycle: cases['{name}'] = {shown(case)}: a lumped.life.LoadCase is needed."
            )
    loads = [read_load(case, f"duty_cycle: '{name}'", of, rtol) for name, case in cases.items()]
    units = dict.fromkeys(load.unit for load in loads if load.unit)
    if len(units) > 1:
        raise OptionError(f"duty_cycle: the loads have different units: {', '.join(units)}.")
    repetitions = tuple(int(case.repetitions) for case in cases.values())
    cycles, owners = count_in_turn([load.values for load in loads], repetitions)
    _, each = damage_of(cycles, curve, scale, mean_stress)
    place = np.where(owners == BETWEEN, len(loads), owners)
    damages = np.bincount(place, each, len(loads) + 1).astype(float)
    return DutyCycle(
        tuple(cases),
        repetitions,
        np.array([load.duration for load in loads]),
        damages[:-1],
        float(damages[-1]),
        cycles,
        owners,
        next(iter(units), ""),
    )
