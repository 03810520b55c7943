"""A branch of periodic motions as a result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.orbits.orbit import ON_CIRCLE, PeriodicOrbit
from lumped.orbits.smooth_curves import Curve, course, curves_by, extreme, find_harmonics
from lumped.plots.draw import Canvas, draw
from lumped.plots.picture import Axis, Item, Panel, Picture, label_axis
from lumped.plots.picture import Curve as Line
from lumped.plots.style import COLOURS, LINES, MARKS, Look
from lumped.support.arguments import checked
from lumped.support.arrays import Boolean, Real
from lumped.support.by_name import ByName
from lumped.support.display_units import Units, choose_units, display
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.timeloop.results.trajectory import Trajectory


@dataclass(frozen=True)
class BranchPoint:
    """What is passed on a branch.

    Attributes
    ----------
    kind : str
        "fold", "branch point", "period doubling", "Neimark-Sacker", or a border: "grazing",
        "opening", "sticking", "slipping", "switching"; "change of stability" where a point is
        passed that was not located.
    value : float
        The parameter there.
    period : float
        Period there, s.
    number : int
        Of the motion on the branch.
    multiplier : complex
        The Floquet multiplier that decides; at a border the largest.
    component : str
        What changes, at a border.
    words : str
        More about it.
    """

    kind: str
    value: float
    period: float
    number: int
    multiplier: complex
    component: str = ""
    words: str = ""


@dataclass(frozen=True, eq=False)
class Range:
    """Values of a quantity along a branch, shape (k,): greatest, least, and half their distance."""

    highest: Real
    lowest: Real

    @property
    def amplitude(self) -> Real:
        """Half the distance of both."""
        return 0.5 * (self.highest - self.lowest)


@dataclass(frozen=True, eq=False)
class Branch(ByName, RichHtml):
    """Motions in order along a branch; ``found["x"].amplitude`` tells a quantity along it.

    Attributes
    ----------
    system : System
        What moves.
    along : str
        The parameter.
    values, periods : ndarray, shape (k,)
        The parameter and the period, s, of each motion.
    multipliers : ndarray of complex, shape (k, m)
        Floquet multipliers, the largest first; of a motion of unknown period without that of a
        shift in time.
    points : tuple of BranchPoint
        What is passed, in order; each is one of the motions.
    ends : tuple of str
        Why the branch has no more motions before the first and after the last.
    """

    system: System
    along: str
    values: Real
    periods: Real
    multipliers: np.ndarray
    points: tuple[BranchPoint, ...]
    ends: tuple[str, str]
    runs: tuple[Trajectory, ...] = field(repr=False)
    make: Callable[[int], PeriodicOrbit] = field(repr=False)
    find: Callable[[float], list[PeriodicOrbit]] = field(repr=False)
    turn_off: Callable[[int, str], Branch] = field(repr=False)
    _known: dict[str, list[list[Curve]]] = field(default_factory=dict, init=False, repr=False)

    @property
    def stable(self) -> Boolean:
        """Whether small disturbances do not grow, shape (k,)."""
        return self.largest <= 1 + ON_CIRCLE

    @property
    def largest(self) -> Real:
        """Magnitude of the largest multiplier, shape (k,)."""
        found: Real = np.abs(self.multipliers).max(axis=1, initial=0.0)
        return found

    @checked
    def __getitem__(self, name: Name) -> Range:
        pieces = self._courses(name)
        high, low = ([extreme(each, s).value for each in pieces] for s in (1, -1))
        return Range(np.array(high), np.array(low))

    @checked
    def harmonics(self, name: Name, count: int) -> np.ndarray:
        """Complex Fourier coefficients ``c_0`` to ``c_count``, shape (k, count + 1).

        As `PeriodicOrbit.harmonics` for each motion.
        """
        every = zip(self._courses(name), self.periods.tolist(), strict=True)
        return np.array([find_harmonics(pieces, period, count) for pieces, period in every])

    def named(self, kind: str) -> tuple[BranchPoint, ...]:
        """The points of one kind, such as "fold"."""
        return tuple(point for point in self.points if point.kind == kind)

    @checked
    def orbit(self, number: int) -> PeriodicOrbit:
        """One of the motions, with all that `periodic` tells.

        Raises
        ------
        OptionError
            If there is no such motion.
        """
        count = len(self.values)
        if not -count <= number < count:
            raise OptionError(
                f"{self.system.name}: motion {number} of a branch of {count}; count from 0."
            )
        return self.make(number % count)

    @checked
    def at(self, value: float) -> list[PeriodicOrbit]:
        """The motions at a value of the parameter, in the order of the branch."""
        if not self.values.min() <= value <= self.values.max():
            raise OptionError(
                f"{self.system.name}: {self.along} = {value:.9g} "
                f"{self.system.parameter_unit(self.along)} is not on this branch, which reaches "
                f"from {self.values.min():.9g} to {self.values.max():.9g}."
            )
        return self.find(float(value))

    def switch(self, point: BranchPoint) -> Branch:
        """The branch that crosses this one at a period doubling or a branch point.

        Raises
        ------
        OptionError
            If no branch crosses there, or the point is none of this branch.
        SolverError
            If no motion is found on it.
        """
        if point not in self.points:
            raise OptionError(
                f"{self.system.name}: switch takes one of the points of this branch, .points."
            )
        if point.kind not in ("period doubling", "branch point"):
            raise OptionError(
                f"{self.system.name}: no other branch of periodic motions crosses at a "
                f"{point.kind} ({self.along} = {point.value:.9g}); switch takes a period doubling "
                "or a branch point."
            )
        return self.turn_off(point.number, point.kind)

    def plot(self, name: Name, *, units: Units = None, **canvas: Unpack[Canvas]) -> Any:
        """Highest value of a quantity over the parameter, with what is passed.

        Stable motions are solid, unstable ones dashed.

        Parameters
        ----------
        name : name
            Quantity.
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).
        """
        key = self.system.key(name)
        choice = choose_units(units, (self.along, *self.system.names()))
        own_units = self.system.parameter_unit(self.along), self.system.quantity(key).unit
        names = self.along, key
        shown = [display(n, u, choice) for n, u in zip(names, own_units, strict=True)]
        x, y = shown[0].value(self.values), shown[1].value(self[key].highest)
        items: list[Item] = []
        for wanted, dash, label in ((True, LINES[0], "stable"), (False, LINES[1], "unstable")):
            own = self.stable == wanted
            if own.any():
                drawn = own.copy()
                if not wanted:  # up to the stable ones, without a hole
                    drawn[1:] |= own[:-1]
                    drawn[:-1] |= own[1:]
                line = np.where(drawn, y, np.nan)
                items.append(Line(x, line, label, Look(COLOURS["blue"], dash)))
        kinds = list(dict.fromkeys(self._label(point) for point in self.points))
        for i, kind in enumerate(kinds):
            own_points = [p.number for p in self.points if self._label(p) == kind]
            colour = list(COLOURS.values())[1 + i % (len(COLOURS) - 1)]
            mark = Look(colour, "", mark=MARKS[i % len(MARKS)], size=6.0)
            items.append(Line(x[own_points], y[own_points], kind, mark))
        axes = [Axis(label_axis(n, s.unit)) for n, s in zip(names, shown, strict=True)]
        panel = Panel(tuple(items), axes[0], axes[1], height=3.2)
        return draw(Picture(f"{self.system.name}: {key}, highest", (panel,)), **canvas)

    def _label(self, point: BranchPoint) -> str:
        return f"{point.kind} of {point.component}" if point.component else point.kind

    def _names(self) -> list[str]:
        return self.system.names()

    def _courses(self, name: Name) -> list[list[Curve]]:
        key = self.system.key(name)
        if key not in self._known:
            function = course(self.system, self.system.expressions([key]))
            self._known[key] = [curves_by(function, run) for run in self.runs]
        return self._known[key]

    def __repr__(self) -> str:
        unit = self.system.parameter_unit(self.along)
        low, high, told = amounts(self.along, unit, self.values.min(), self.values.max())
        unstable = int((~self.stable).sum())
        lines = [
            f"{self.system.name}: {len(self.values)} periodic motions over {self.along} from {low} "
            f"to {high} {told}, {unstable} of them unstable",
            f"before the first: {self.ends[0]}; after the last: {self.ends[1]}",
        ]
        rows = []
        last = len(self.values) - 1
        marks = [(0, "begin", ""), (last, "end", "")]
        marks[1:1] = [(p.number, self._label(p), p.words) for p in self.points]
        for i, label, words in marks:
            value = amounts(self.along, unit, self.values[i], digits=10)
            largest = number(float(self.largest[i]))
            state = "stable" if self.stable[i] else "unstable"
            rows.append((label, *value, number(float(self.periods[i]), 9), largest, state, words))
        head = ("point", self.along, "unit", "period, s", "largest multiplier", "", "")
        return "\n".join(lines) + "\n" + table(head, rows)
