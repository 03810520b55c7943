"""Holzer's table of a mode: angles and torques of all inertias and shafts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Unpack

import numpy as np

from lumped.plots.draw import Canvas, draw
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.by_name import find_place
from lumped.support.display_units import Shown, Units, choose_units, display, frequency_unit
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.vibration.pictures import holzer_picture


@dataclass(frozen=True)
class InertialPart:
    """An inertia of a drive.

    Attributes
    ----------
    name : str
        Path of the component.
    ratio : float
        Turns of its shaft for each turn of the reference shaft; negative for the other sense.
    J : float
        Moment of inertia on its own shaft, kg.m2.
    station : int
        Place in the referred drive; parts that are joined rigidly, by gears too, share one.
    """

    name: str
    ratio: float
    J: float
    station: int

    @property
    def referred(self) -> float:
        """Moment of inertia on the reference shaft, ``J ratio^2``, kg.m2."""
        return self.J * self.ratio**2


@dataclass(frozen=True)
class ElasticPart:
    """A stiffness of a drive.

    Attributes
    ----------
    name : str
        Path of the component.
    ratio : float
        Turns of the shaft for each turn of the reference shaft.
    c : float
        Stiffness on its own shaft, N.m/rad.
    stations : tuple of int
        What it joins; -1 stands for the ground.
    """

    name: str
    ratio: float
    c: float
    stations: tuple[int, int]

    @property
    def referred(self) -> float:
        """Stiffness on the reference shaft, ``c ratio^2``, N.m/rad."""
        return self.c * self.ratio**2


Part = InertialPart | ElasticPart


def head_sizes(units: Units) -> tuple[str, str]:
    """Heads of the columns of inertias and stiffnesses."""
    inertia, stiffness = display("J", "kg.m2", units), display("c", "N.m/rad", units)
    return f"J, {inertia.unit}", f"c, {stiffness.unit}"


def measure(part: Part, units: Units) -> tuple[float, Shown]:
    """Inertia or stiffness of a part on its own shaft, and how it is shown."""
    if isinstance(part, InertialPart):
        return part.J, display("J", "kg.m2", units)
    return part.c, display("c", "N.m/rad", units)


def in_columns(part: Part, texts: Iterable[str]) -> list[str]:
    """Texts in pairs of columns, the first of an inertia and the second of a shaft."""
    pairs = ((text, "") if isinstance(part, InertialPart) else ("", text) for text in texts)
    return [cell for pair in pairs for cell in pair]


@dataclass(frozen=True, eq=False)
class Holzer(RichHtml):
    """Angles and torques of a mode without damping; the largest referred angle is 1 rad.

    Each part has them on its own shaft; `referred` has them on the reference shaft.

    Attributes
    ----------
    name, shaft : str
        The model, and the angle of the reference shaft.
    parts : tuple of InertialPart or ElasticPart
        In the order of the table: from the free ends to the last inertia.
    mode : int
        Number of the mode by natural frequency, from 0.
    hertz : float
        Natural frequency, Hz.
    angles : ndarray, shape (parts,)
        Angle of each inertia, twist of each shaft, rad.
    torques : ndarray, shape (parts,)
        Torque of inertia ``J (2 pi hertz)^2 angle`` and in each shaft ``c twist``, N.m.
    end : float
        Residual torque at the last inertia, N.m; zero but for rounding.
    ends : dict of int to float
        Referred angle of each station, rad, in the order of the table.
    residual : float
        Largest residual torque anywhere, over the largest torque.
    is_referred : bool
        Whether angles and torques are those on the reference shaft.
    """

    name: str
    shaft: str
    parts: tuple[Part, ...]
    mode: int
    hertz: float
    angles: Real
    torques: Real
    end: float
    ends: dict[int, float]
    residual: float
    is_referred: bool = False

    @cached_property
    def referred(self) -> Holzer:
        """The same on the reference shaft: angles over the ratio, torques times the ratio."""
        if self.is_referred:
            return self
        ratio = np.array([part.ratio for part in self.parts])
        end = self.end * [p.ratio for p in self.parts if isinstance(p, InertialPart)][-1]
        return replace(
            self,
            angles=self.angles / ratio,
            torques=self.torques * ratio,
            end=end,
            is_referred=True,
        )

    @checked
    def angle(self, part: str) -> float:
        """Angle of an inertia, or twist of a shaft, rad.

        Raises
        ------
        UnknownNameError
            If the table has no such part.
        """
        return float(self.angles[self._place(part)])

    @checked
    def torque(self, part: str) -> float:
        """Torque of an inertia or in a shaft, N.m.

        Raises
        ------
        UnknownNameError
            If the table has no such part.
        """
        return float(self.torques[self._place(part)])

    def _place(self, part: str) -> int:
        names = [each.name for each in self.parts]
        return find_place(part, names, "is no part of this table")

    @checked
    def plot(self, *, units: Units = None, **canvas: Unpack[Canvas]) -> Any:
        """Angles of the inertias, joined by the shafts, and torques in the shafts, all referred.

        Of inertias that are joined rigidly the heaviest gives the name.

        Parameters
        ----------
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        if not self.is_referred:
            return self.referred.plot(units=units, **canvas)
        choice = choose_units(units, ("frequency", "tau"))
        frequency, to_show = frequency_unit(choice), display("tau", "N.m", choice)
        title = f"{self.name}: mode {self.mode + 1}, {number(frequency.value(self.hertz))} "
        title += f"{frequency.unit}, referred to {self.shaft}"
        heaviest: dict[int, tuple[float, str, float]] = {}
        shafts = []
        for part, angle, torque in zip(self.parts, self.angles, self.torques, strict=True):
            if not isinstance(part, InertialPart):
                shafts.append((part.name, part.stations, to_show.value(float(torque))))
            elif part.station not in heaviest or part.referred > heaviest[part.station][0]:
                heaviest[part.station] = part.referred, part.name, float(angle)
        inertias = [(name, station, angle) for station, (_, name, angle) in heaviest.items()]
        picture = holzer_picture(title, inertias, shafts, self.ends, to_show.unit)
        return draw(picture, **canvas)

    def __repr__(self) -> str:
        where = f"referred to {self.shaft}" if self.is_referred else "each part on its own shaft"
        frequency = frequency_unit()
        head = f"{self.name}: mode {self.mode + 1}, {number(frequency.value(self.hertz), 9)} "
        head += f"{frequency.unit}, {where}\n"
        bound = 10.0 ** np.ceil(np.log10(max(self.residual, 1e-12)))
        told = table(*self.list_parts(display("phi", "rad")))
        return f"{head}{told}\nresidual torques below {bound:.0e} of the largest"

    def list_parts(
        self, turn: Shown, units: Units = None, digits: int = 6
    ) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Heads and rows of a table of all parts, with angles as `turn` shows them."""
        moment, rows = display("tau", "N.m", units), []
        for part, angle, torque in zip(self.parts, self.angles, self.torques, strict=True):
            own, shown = measure(part, units)
            size = shown.value(part.referred if self.is_referred else own)
            texts = (number(x, digits) for x in (size, turn.value(angle), moment.value(torque)))
            rows.append((part.name, *in_columns(part, texts)))
        loads = f"torque of inertia, {moment.unit}", f"torque in shaft, {moment.unit}"
        angles = f"angle, {turn.unit}", f"twist, {turn.unit}"
        return ("part", *head_sizes(units), *angles, *loads), rows
