"""Values of all states at one instant, and how they were found."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, overload

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import UnknownNameError
from lumped.support.by_name import ByName
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, table
from lumped.timeloop.programs import ProgramInputs
from lumped.timeloop.results.event import Change
from lumped.timeloop.results.result_files import list_computable

_NEAR = 1e-5
"""How far apart instants of the same jump may be in two runs, relative to their length."""


def with_left_out(
    system: System, x: np.ndarray, left_out: Callable[[str], np.ndarray]
) -> tuple[System, np.ndarray]:
    """The system with all its states, and their values.

    Parameters
    ----------
    x : ndarray, shape (points, n)
        States of the system.
    left_out : callable
        Gives a state that was left out by its name, shape (points,).
    """
    whole, column = system.whole, {i: k for k, i in enumerate(system.structure.in_use)}
    columns = [
        x[:, column[place]] if place in column else left_out(name)
        for place, name in zip(whole.structure.in_use, whole.state_names, strict=True)
    ]
    return whole, np.column_stack(columns)


def on_both_sides(t: np.ndarray, y: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Values of one run at the times of another, which jumps where it does.

    Parameters
    ----------
    t, y : ndarray, shape (k,)
        Times, among them all `times`, and values; a time that occurs twice is a jump.
    times : ndarray, shape (points,)
        Times of the other run, s, in the same way. What jumps a little later or earlier in `y`
        is moved to these instants.
    """
    found: np.ndarray = y[np.searchsorted(t, times, "right") - 1].copy()
    near, twice = _NEAR * (times[-1] - times[0]), np.flatnonzero(np.diff(times) == 0)
    jumps = np.flatnonzero((np.diff(t) == 0) & (np.diff(y) != 0))
    instants, heights = t[jumps], np.diff(y)[jumps]
    for before in twice if len(jumps) else ():
        instant = times[before]
        close = np.abs(instants - instant) <= near
        found[before] -= heights[close & (instants <= instant)].sum()
        found[before + 1] += heights[close & (instants > instant)].sum()
    return found


@dataclass(frozen=True, eq=False)
class PointOfRun:
    """Makes a point of a run again, with the states that were left out.

    Attributes
    ----------
    run : callable
        Makes the run again at some times.
    time : float
        Instant, s.
    """

    run: Any
    time: float

    def __call__(self, _: System) -> Any:
        """The point."""
        return self.run(np.array([self.time])).point(self.time)


@dataclass(frozen=True)
class Convergence:
    """How Newton's method found a point.

    Attributes
    ----------
    iterations, evaluations : int
        Newton steps, and evaluations of the derivatives of all states.
    residual : float
        Largest derivative that is left, relative to the terms that cancel in it.
    condition : float
        Condition number of the equations, their rows scaled by these terms; infinite where an
        equilibrium is one of many, such as the speed of a free drive.
    growth : float
        Fastest growth of small deviations, 1/s: zero at a stable equilibrium, nan if unknown.
    """

    iterations: int
    evaluations: int
    residual: float
    condition: float
    growth: float

    def __str__(self) -> str:
        condition = f"{self.condition:.3g}" if np.isfinite(self.condition) else "none: one of many"
        text = (
            f"found in {self.iterations} iterations, {self.evaluations} evaluations; residual "
            f"{self.residual:.1e}, condition {condition}"
        )
        return text + (f"; unstable, grows as exp({self.growth:.4g} t)" if self.growth > 0 else "")


@dataclass(frozen=True)
class Kept:
    """What the search for an equilibrium kept as it was given.

    Attributes
    ----------
    free : tuple of int
        Places of the parameters that the equilibrium determines.
    nodes : tuple of int
        Quantities that keep their values, as numbers of the reduced system.
    initial : bool
        Initial equations hold.
    rest : bool
        Nothing moves.
    start : mapping of str to float
        Start values with which it began.
    """

    free: tuple[int, ...] = ()
    nodes: tuple[int, ...] = ()
    initial: bool = False
    rest: bool = False
    start: Mapping[str, float] = field(default_factory=dict)


class Named(ByName, RichHtml):
    """Answers to the names of a system's quantities: ``name in run``, ``list(run)``."""

    system: System
    again: Any = None

    def __contains__(self, name: Name) -> bool:
        return self.system.key(name) in ("time", *self._names())

    def _ipython_key_completions_(self) -> list[str]:
        return ["time", *self._names()]

    def _names(self) -> list[str]:
        return list_computable(self.system) if self.again is None else self.system.names()


@dataclass(frozen=True, eq=False)
class OperatingPoint(Named):
    """Values of all states at one instant.

    Attributes
    ----------
    system : System
        What it belongs to.
    time : float
        Instant, s.
    x : ndarray, shape (n,)
        States in the order of ``system.state_names``.
    theta, settings : ndarray
        Parameters; modes and values of implicit quantities.
    collisions : tuple of Change
        Impacts at this very instant; the states are those after them.
    before : OperatingPoint or None
        The point before these impacts.
    search : Convergence or None
        How an equilibrium was found.
    kept : Kept or None
        What it kept.
    residual : float or None
        How far the worst of the initial equations and given values that are no states is missed at
        a start, relative to what is wanted if that is above one; None where there are none.
    lost : tuple of str
        Given start values and initial equations that an equilibrium does not keep, in words; of a
        start, declared values, and those of closed linkages that only choose the assembly.
    again : callable or None
        Makes the same point of the system with the states that were left out; None where there are
        none, or nobody knows them.
    program_inputs : dict of int to ndarray
        What programs were given on the way (see `Trajectory`).
    """

    system: System
    time: float
    x: np.ndarray
    theta: np.ndarray
    settings: np.ndarray
    collisions: tuple[Change, ...] = ()
    before: OperatingPoint | None = None
    search: Convergence | None = None
    kept: Kept | None = None
    residual: float | None = None
    lost: tuple[str, ...] = ()
    again: Callable[[System], OperatingPoint] | None = None
    program_inputs: ProgramInputs = field(default_factory=dict)

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters that can be changed, and their values here."""
        names = self.system.structure.parameters.free_names
        return dict(zip(names, self.theta.tolist(), strict=True))

    @property
    def inputs(self) -> tuple[np.ndarray, np.ndarray, float, np.ndarray]:
        """States, parameters, time and settings: values of the inputs of the system's functions."""
        return self.x, self.theta, self.time, self.settings

    @cached_property
    def whole(self) -> OperatingPoint:
        """The same with the states that were left out, if they are known."""
        if self.again is None:
            return self
        found = self.again(self.system.whole)

        def read_left_out(name: str) -> np.ndarray:
            return np.array([found[name]])

        system, x = with_left_out(self.system, self.x[None, :], read_left_out)
        return replace(self, system=system, x=x[0], again=None)

    @overload
    def __getitem__(self, name: Name) -> float: ...
    @overload
    def __getitem__(self, name: list[Name]) -> np.ndarray: ...
    def __getitem__(self, name: Name | list[Name]) -> float | np.ndarray:
        if isinstance(name, list):
            return np.array([self[one] for one in name])
        if self.system.key(name) == "time":
            return self.time
        try:
            function = self.system.function([name])
        except UnknownNameError:
            if self.again is None:
                raise
            return self.whole[name]
        return float(function(*self.inputs))

    def __repr__(self) -> str:
        rows = [
            (name, *amounts(name, self.system.quantity(name).unit, value))
            for name, value in zip(self.system.state_names[:20], self.x, strict=False)
            if "(" not in name
        ]
        head = f"{self.system.name} at t = {self.time:g} s"
        if self.search is not None:
            head += f"; {self.search}"
        if self.residual is not None:
            head += f"; what was demanded is met to {self.residual:.1e}"
        if self.lost:
            why = "" if self.search is None else ", as no equilibrium near the start does"
            head += f"\nnot kept{why}: {', '.join(self.lost[:12])}"
        return f"{head}\n" + table(("state", "value", "unit"), rows)
