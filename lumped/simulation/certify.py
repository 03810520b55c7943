"""How far two runs are apart without their jumps, and so how far one can be trusted."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.simulation.energy_audit import EnergyAudit
from lumped.support.arguments import checked
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.timeloop.results.event import Event
from lumped.timeloop.results.trajectory import Trajectory

_CLOSE = 1e-9
"""Part of a run around each event that does not count."""
_FURTHEST = 1e-3
"""Part of a run up to which two instants are taken for the same event."""
_STILL = 1e-9
_NOISE = 100.0
"""Tolerances of the reference within which a quantity only seems to vary."""
_INNER = np.array([0.2, 0.4, 0.6, 0.8])


@dataclass(frozen=True)
class Deviation:
    """Largest difference of one quantity.

    Attributes
    ----------
    name, unit : str
        The quantity.
    relative : float
        Largest difference over `range`.
    time : float
        Where it is, s.
    range : float
        Largest less smallest value of the reference. Of what stands still (less than 1e-9 of its
        size or of its nominal value) that size, or the nominal value if it is larger; of what
        varies by less than a hundred tolerances of the reference, its size.

    All are nan where no instant counts.
    """

    name: str
    unit: str
    relative: float
    time: float
    range: float


@dataclass(frozen=True, eq=False)
class Comparison(RichHtml):
    """Two runs of a system.

    Attributes
    ----------
    deviations : tuple of Deviation
        One for each quantity.
    t : ndarray, shape (k,)
        Instants that count, s.
    window : float
        Longest time around an event that does not count, s.
    excluded : int
        Times that do not count.
    missed : str
        Empty if both runs have the same events in the same order, else what differs.
    """

    deviations: tuple[Deviation, ...]
    t: np.ndarray
    window: float
    excluded: int
    missed: str

    @property
    def worst(self) -> Deviation:
        """The largest of the deviations."""
        return max(self.deviations, key=lambda d: d.relative)


def choose_names(system: System, names: Iterable[Name] | None) -> list[str]:
    """Names of quantities to compare; default is all states.

    Raises
    ------
    OptionError
        If there is none.
    """
    states = [n for n in system.state_names if "(" not in n]
    found = states if names is None else [system.key(name) for name in names]
    if not found:
        raise OptionError(f"{system.name}: no states to compare; name the quantities.")
    return found


def compare_runs(
    run: Trajectory, reference: Trajectory, rtol: float, names: Iterable[str]
) -> Comparison:
    """Compare two runs that give their quantities at the same times, the second made to `rtol`.

    An event is at slightly different instants in two runs, and between these they differ by the
    whole jump. So the time between the instants of an event does not count, nor 1e-9 of the run
    on both sides. Events that do not match, or are further apart than 1e-3 of the run, are no
    excuse: from there on everything counts.
    """
    t = reference.t
    span = float(t[-1] - t[0])
    mine, others = _events(run), _events(reference)
    matched = 0
    for a, b in zip(mine, others, strict=False):
        same = (a.component, a.after) == (b.component, b.after)
        if not same or abs(a.time - b.time) > _FURTHEST * span:
            break
        matched += 1
    counts = np.ones(len(t), dtype=bool)
    window, margin = 0.0, _CLOSE * span
    for a, b in zip(mine[:matched], others[:matched], strict=True):
        first, last = min(a.time, b.time) - margin, max(a.time, b.time) + margin
        window = max(window, last - first)
        counts[np.searchsorted(t, first) : np.searchsorted(t, last, "right")] = False
    missed = ""
    if matched < max(len(mine), len(others)):
        from_ = min(e.time for e in (*mine[matched:], *others[matched:]))
        missed = f"{len(mine)} events, {len(others)} in the reference; differ from t = {from_:g} s"
    found = tuple(_deviation(run, reference, rtol, name, counts) for name in names)
    return Comparison(found, t[counts], window, int((~counts).sum()), missed)


def between(run: Trajectory) -> np.ndarray:
    """Four instants in each stretch between events that has no output time inside.

    There a comparison at the output times would see nothing.
    """
    t = run.t
    margin = _CLOSE * float(t[-1] - t[0])
    edges = np.unique([t[0], *(event.time for event in _events(run)), t[-1]])
    inside = np.searchsorted(t, edges[1:] - margin) - np.searchsorted(t, edges[:-1] + margin)
    bare = (inside <= 0) & (np.diff(edges) > 10 * margin)
    found: np.ndarray = edges[:-1][bare, None] + np.diff(edges)[bare, None] * _INNER
    return found.ravel()


def _events(run: Trajectory) -> list[Event]:
    """Events that belong to the model; a change of leading states depends on the steps."""
    return [event for event in run.events if event.kind != "states"]


def _deviation(
    run: Trajectory, reference: Trajectory, rtol: float, name: str, counts: np.ndarray
) -> Deviation:
    quantity = reference.system.quantity(name)
    expected, t = reference[name][counts], reference.t[counts]
    if not len(t):
        return Deviation(name, quantity.unit, np.nan, np.nan, np.nan)
    largest, extent = float(np.abs(expected).max()), float(np.ptp(expected))
    if extent <= _STILL * max(largest, quantity.nominal):
        extent = max(largest, quantity.nominal)
    elif extent <= _NOISE * rtol * largest:
        extent = largest
    difference = np.abs(run[name][counts] - expected)
    place = int(difference.argmax())
    return Deviation(
        name, quantity.unit, float(difference[place]) / extent, float(t[place]), extent
    )


@dataclass(frozen=True, eq=False)
class Certificate(RichHtml):
    """Error estimate of a run; ``certificate[name]`` gives it for any quantity.

    The estimate is the difference from `tighter` at the run's own output times, and at inner ones
    between events that have no output time between them. It is that of the run itself as far as
    the second run is much more accurate.

    Attributes
    ----------
    run, tighter : Trajectory
        The run, and the second one, at the same times.
    inner : int
        How many of these times were added to those of the run.
    rtol : float
        Tolerance of the second run.
    states : Comparison
        The states of the system.
    energy : EnergyAudit or None
        Energy balance of the run, of the second one if the run is a closed form; None if no
        component says what it stores.
    """

    run: Trajectory
    tighter: Trajectory
    inner: int
    rtol: float
    states: Comparison
    energy: EnergyAudit | None

    @checked
    def __getitem__(self, name: Name) -> Deviation:
        found = compare_runs(self.run, self.tighter, self.rtol, [self.run.system.key(name)])
        return found.deviations[0]

    @property
    def error(self) -> float:
        """Largest deviation of a state, relative to its range; nan without states."""
        return self.states.worst.relative if self.states.deviations else float("nan")

    def __repr__(self) -> str:
        s, c = self.tighter.statistics, self.states
        lines = [
            f"{self.run.system.name}: {self.run.statistics.method} against {s.method} at rtol "
            f"{self.rtol:.1g} ({s.steps} steps, {s.evaluations} evaluations)"
        ]
        lines.append(_where(c.t, self.inner))
        if c.window:
            lines.append(f"up to {c.window:.1g} s around events not compared")
        if c.missed:
            lines.append(f"other events: {c.missed}")
        rows = [
            (
                *(d.name, number(d.relative, 2), number(d.time, 4)),
                *amounts(d.name, d.unit, d.range, digits=4, is_change=True),
            )
            for d in sorted(c.deviations, key=lambda d: -d.relative)[:12]
        ]
        lines.append(table(("state", "error / range", "at s", "range", ""), rows))
        if self.energy is not None:
            lines.append(repr(self.energy))
        return "\n".join(lines)


def _where(t: np.ndarray, inner: int) -> str:
    """At which instants two runs were compared."""
    if not len(t):
        return "compared at no instant: all are too close to events; give grid= others"
    text = f"compared at {len(t)} instants from {t[0]:.6g} to {t[-1]:.6g} s"
    if inner:
        text += f", {inner} of them between events that have no output time between them"
    return text
