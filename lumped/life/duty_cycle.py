"""Damage of a duty cycle: what happens, how often, and what breaks after how long."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.errors import OptionError, shown
from lumped.functionals.damage_law import MeanStress
from lumped.life.load_case import LoadCase, read_load
from lumped.life.rainflow import Cycles, damage_of
from lumped.life.sn_curve import SNCurve
from lumped.plots.draw import Canvas, draw
from lumped.plots.numbers import duty_picture
from lumped.support.arguments import checked
from lumped.support.arrays import Integer, Real
from lumped.support.display_units import Units, choose_units, display
from lumped.support.optional_packages import extra
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.timeloop.cycle_count import count_cycles

_BETWEEN = "between cases"
BETWEEN = -1
"""In place of the number of a load: a cycle that none of them makes alone."""


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
    case: Integer
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
        """Largest range of the cycles within a case, or between cases."""
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
    def plot(self, *, units: Units = None, **canvas: Unpack[Canvas]) -> Any:
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
        return draw(duty_picture(self._title(), shares, spectra, told.unit), **canvas)

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
            if not self._largest(i):
                largest = "none"
            told = number(duration, 4) if i < len(self.names) else "-"
            count = str(n) if i < len(self.names) else "-"
            rows.append((name, count, told, largest, unit or "-", number(damage, 4), share))
        head = ("case", "repetitions", "time, s", "largest cycle", "unit", "damage", "share")
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


class _Open(NamedTuple):
    """Turning points that close no cycle yet, and to which load each belongs."""

    values: Real
    load: Integer


class _Closed(NamedTuple):
    """Cycles: begins, ends, how many of each, and the loads of both ends."""

    begin: Real
    end: Real
    counts: Real
    begin_load: Integer
    end_load: Integer

    def times(self, count: int) -> _Closed:
        """The same so many times."""
        return self._replace(counts=count * self.counts)


def count_in_turn(loads: Sequence[Real], repetitions: Sequence[int]) -> tuple[Cycles, Integer]:
    """Cycles of a sequence of loads that is repeated for ever, in one turn of it.

    What a count by four points leaves open is joined to what follows and counted again, which gives
    the cycles of the whole sequence. It changes no more once a load was joined to itself, so the
    number of repetitions costs nothing.

    Parameters
    ----------
    loads : sequence of ndarray, shape (n,)
        In the order in which they happen.
    repetitions : sequence of int
        How often each happens, one right after the other.

    Returns
    -------
    cycles : Cycles
    load : ndarray of int, shape (k,)
        To which load each belongs: one in which it begins or ends, and that reaches both ends;
        else `BETWEEN`.
    """
    inside: list[_Closed] = []
    rests: list[_Open] = []
    for k, (load, count) in enumerate(zip(loads, repetitions, strict=True)):
        rest, closed = _count(_Open(load, np.full(len(load), k)))
        inside.append(closed.times(count))
        rests.append(rest)
    held = _Open(np.zeros(0), np.zeros(0, dtype=np.int64))
    while True:
        before, joined = held, list[_Closed]()
        for rest, count in zip(rests, repetitions, strict=True):
            held = _repeat(held, rest, count, joined)
        if np.array_equal(before.values, held.values):
            break
    every = _Closed(*(np.concatenate(parts) for parts in zip(*inside, *joined, strict=True)))
    cycles = Cycles(
        np.abs(every.end - every.begin),
        0.5 * (every.begin + every.end),
        every.counts,
        np.concatenate([rest.values for rest in rests]),
        np.zeros(0),
    )
    return cycles, _owners(every, loads)


def _count(given: _Open) -> tuple[_Open, _Closed]:
    """What is left open of turning points, and the cycles that they close."""
    found = count_cycles(given.values, rule="four")
    values, load = given.values[found.cycles.T], given.load[found.cycles.T]
    rest = _Open(given.values[found.residue], given.load[found.residue])
    return rest, _Closed(values[0], values[1], found.weights, load[0], load[1])


def _repeat(held: _Open, rest: _Open, count: int, joined: list[_Closed]) -> _Open:
    """What is left open after one load that happens so often; its cycles are added."""
    for left in range(count, 0, -1):
        before = held
        both = (np.concatenate(parts) for parts in zip(before, rest, strict=True))
        held, closed = _count(_Open(*both))
        if np.array_equal(before.values, held.values):
            joined.append(closed.times(left))
            return held
        joined.append(closed)
    return held


def _owners(every: _Closed, loads: Sequence[Real]) -> Integer:
    """To which load each cycle belongs."""
    low, high = (np.array([f(load) for load in loads]) for f in (np.min, np.max))
    least, most = np.minimum(every.begin, every.end), np.maximum(every.begin, every.end)
    found = np.full(len(least), BETWEEN)
    for load in (every.begin_load, every.end_load):
        reaches = (low[load] <= least) & (most <= high[load])
        found[reaches] = load[reaches]
    return found
