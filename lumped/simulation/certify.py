"""How far a run can be trusted: the same run once more, much more accurately."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lumped.compiler.structure import Name
from lumped.simulation.compare import Comparison, Deviation, compare_runs
from lumped.simulation.energy_audit import EnergyAudit
from lumped.support.arguments import checked
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.timeloop.results.trajectory import Trajectory


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
        found = compare_runs(self.run, self.tighter, [self.run.system.key(name)])
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
        return (
            "\n".join(lines) + "\n" + table(("state", "error / range", "at s", "range", ""), rows)
        )


def _where(t: np.ndarray, inner: int) -> str:
    """At which instants two runs were compared."""
    if not len(t):
        return "compared at no instant: all are too close to events; give grid= others"
    text = f"compared at {len(t)} instants from {t[0]:.6g} to {t[-1]:.6g} s"
    if inner:
        text += f", {inner} of them between events that have no output time between them"
    return text
