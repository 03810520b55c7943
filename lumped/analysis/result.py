"""Results: frozen, answering to names and references, printing as tables."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from lumped.system import Name, System
from lumped.table import number, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Event", "OperatingPoint", "Statistics", "Trajectory"]


@dataclass(frozen=True)
class Event:
    """Something that happened during a run.

    Attributes
    ----------
    time : float
        When, s.
    what : str
        Components in which a function of time changes its piece.
    """

    time: float
    what: str


@dataclass(frozen=True)
class Statistics:
    """What a run cost.

    Attributes
    ----------
    method : str
        Methods used, in order.
    steps, rejected, evaluations, segments : int
        Accepted and rejected steps, evaluations of the right-hand side, restarts + 1.
    seconds : float
        Wall time of the stepping.
    small : tuple of str
        States that moved, but stayed so small that the absolute tolerance governs them.
    """

    method: str
    steps: int
    rejected: int
    evaluations: int
    segments: int
    seconds: float
    small: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """Values of all states at one instant.

    Attributes
    ----------
    system : System
        What it belongs to.
    time : float
        Instant, s.
    x : ndarray, shape (n,)
        States in the order of ``system.state_names``.
    theta, modes : ndarray
        Parameters; modes and values of implicit quantities.
    """

    system: System
    time: float
    x: np.ndarray
    theta: np.ndarray
    modes: np.ndarray

    def __getitem__(self, name: Name) -> float:
        function = self.system.function([name])
        return float(function(self.x, self.theta, self.time, self.modes))

    def __repr__(self) -> str:
        rows = [
            (name, number(value), self.system.quantity(name).unit)
            for name, value in zip(self.system.state_names[:20], self.x, strict=False)
            if "(" not in name
        ]
        return f"{self.system.name} at t = {self.time:g} s\n" + table(
            ("state", "value", "unit"), rows
        )


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A simulated run.

    ``run[name]`` gives any quantity of the system over `t`; it is computed when first asked for.

    Attributes
    ----------
    system : System
        What was simulated.
    t : ndarray, shape (k,)
        Times, s; on a jump the same time stands twice, before and after it.
    x : ndarray, shape (k, n)
        States.
    segment : ndarray of int, shape (k,)
        Number of the smooth segment of each row.
    theta : ndarray
        Parameters.
    modes : ndarray, shape (segments, m)
        Modes of each segment.
    guesses : ndarray, shape (k, g)
        Implicit quantities (of closed linkages) near each row.
    events : tuple of Event
        Jumps of functions of time.
    statistics : Statistics
        Cost of the run.
    """

    system: System
    t: np.ndarray
    x: np.ndarray
    segment: np.ndarray
    theta: np.ndarray
    modes: np.ndarray
    guesses: np.ndarray
    events: tuple[Event, ...]
    statistics: Statistics
    _known: dict[str, np.ndarray] = field(default_factory=dict, repr=False)

    @property
    def steps(self) -> int:
        """Accepted steps."""
        return self.statistics.steps

    def __getitem__(self, name: Name) -> np.ndarray:
        key = self.system.key(name)
        if key == "time":
            return self.t
        if key not in self._known:
            function = self.system.function([key])
            settings = np.hstack([self.modes[self.segment], self.guesses])
            found = function(self.x.T, self.theta, self.t[None, :], settings.T)
            self._known[key] = np.asarray(found, dtype=float).ravel()
        return self._known[key]

    def table(self, names: Iterable[Name]) -> np.ndarray:
        """Several quantities as columns, shape (k, len(names))."""
        return np.column_stack([self[name] for name in names])

    def plot(self, names: Iterable[Name] | None = None) -> Figure:
        """Curves over time, one panel for each unit (see `lumped.plot.trajectory`)."""
        from lumped.plot import trajectory

        return trajectory(self, names)

    def __repr__(self) -> str:
        s = self.statistics
        head = (
            f"{self.system.name}: {self.t[0]:g} to {self.t[-1]:g} s, {len(self.t)} points; "
            f"{s.method}, {s.steps} steps, {s.rejected} rejected, {s.evaluations} evaluations, "
            f"{len(self.events)} events"
        )
        rows = []
        for name in self.system.state_names[:12]:
            if "(" in name:
                continue
            y = self[name]
            unit = self.system.quantity(name).unit
            rows.append((name, *(number(v) for v in (y[0], y[-1], y.min(), y.max())), unit))
        if self.statistics.small:
            head += (
                f"\nsmall, so that the absolute tolerance governs their accuracy: "
                f"{', '.join(self.statistics.small)}"
            )
        return head + "\n" + table(("state", "start", "end", "min", "max", "unit"), rows)
