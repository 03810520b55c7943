"""Results on a report's page: published and computed numbers, events, energies, motors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import groupby
from typing import Protocol

from lumped.drawing.page_frame import prose, table
from lumped.simulation.sizing import Sizing
from lumped.support.display_units import Units, display, time_unit
from lumped.support.text_table import amounts, number
from lumped.timeloop.results.event import Event
from lumped.timeloop.results.trajectory import Trajectory

_MOST = 200
"""Rows of a table of events."""


class Told(Protocol):
    """A number of the model, with a published one if there is one."""

    @property
    def quantity(self) -> str:
        """Its name."""

    @property
    def unit(self) -> str:
        """Its unit."""

    @property
    def printed(self) -> bool:
        """Whether the source gives a value or a range."""

    @property
    def texts(self) -> tuple[str, str, str]:
        """Published value, computed value, and the deviation."""

    @property
    def place(self) -> str:
        """Place of the published value, or basis of the computed one."""

    @property
    def remark(self) -> str:
        """Explanation of a deviation."""


def comparison(rows: list[Told], marks: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """A section with published numbers, and one with those of the model alone."""
    printed, own = [r for r in rows if r.printed], [r for r in rows if not r.printed]
    used = {
        m: text for m, text in marks.items() if any(f"[{m}]" in r.place + r.remark for r in rows)
    }
    key = "; ".join(f"[{m}] {text}" for m, text in used.items())
    key = f"{prose(key)}\n" if key else ""
    if printed:
        head = ("quantity", "unit", "published", "computed", "deviation, %", "place", "remark")
        cells = [(r.quantity, r.unit, *r.texts, r.place, r.remark) for r in printed]
        yield "Published and computed", key + table(head, cells, (2, 3, 4))
    if own:
        columns = ("quantity", "unit", "computed", "rests on", "found otherwise, or remark")
        alone = [(r.quantity, r.unit, r.texts[1], r.place, r.remark) for r in own]
        yield "Computed besides", ("" if printed else key) + table(columns, alone, (2,))


def events(runs: Mapping[str, Trajectory], units: Units) -> str:
    """Tables of events, a row for each instant."""
    found, instant, joule = [], time_unit(units), display("energy", "J", units)
    for what, run in runs.items():
        rows = []
        for time, group in groupby(run.events, lambda event: event.time):
            same = list(group)
            loss = sum(event.loss for event in same)
            lost = number(joule.value(loss)) if loss else ""
            rows.append((number(instant.value(time), 7), _changes(same), lost))
        lead = f"{prose(what)}\n" if what else ""
        more = f"<p>{len(rows) - _MOST} more.</p>" if len(rows) > _MOST else ""
        head = (f"time, {instant.unit}", "what changes", f"energy lost, {joule.unit}")
        found.append(lead + (table(head, rows[:_MOST], (0, 2)) if rows else "<p>None.</p>") + more)
    return "\n".join(found)


def _changes(same: list[Event]) -> str:
    """Changes at an instant: each once, with the components that it concerns.

    If a component changes a named mode, the condition behind it is left out.
    """
    named = {event.component for event in same if event.kind == "hold"}
    found: dict[str, list[str]] = {}
    for event in same:
        if event.component in named and event.kind == "condition":
            continue
        change = f"{event.before} \u2192 {event.after}"
        where = found.setdefault(change, [])
        if event.component not in where:
            where.append(event.component)
    return "; ".join(f"{', '.join(where)}: {change}" for change, where in found.items())


def energy(runs: Mapping[str, Trajectory], units: Units) -> str:
    """Energy balances of certified runs."""
    found, joule = [], display("energy", "J", units)
    for what, run in runs.items():
        audit = run.certificate.energy if run.certificate else None
        if audit is None:
            continue
        most = max((abs(work) for _, work in audit.works), default=0.0)
        large = [(path, work) for path, work in audit.works if abs(work) > 1e-6 * most]
        works = [(f"work of {path}", work) for path, work in large]
        if len(large) < len(audit.works):
            rest = audit.supplied - sum(work for _, work in large)
            works.append((f"work of {len(audit.works) - len(large)} others", rest))
        works += [
            ("sum of these works", audit.supplied),
            ("stored at the end, less that at the begin", audit.change),
            ("dissipated", audit.dissipated),
            ("lost by them in impacts", audit.impacts),
        ]
        rows = [(what, number(joule.value(work))) for what, work in works]
        gap = joule.value(audit.error * audit.turnover)
        rows.append(("gap of the balance, at most", number(gap, 2)))
        text = (
            f"Energy of the {len(audit.components)} components that say what they store "
            f"({', '.join(audit.components)}). Work is positive where a component gives energy, "
            "negative where it takes it, apart from what it dissipates; what it stores without "
            "saying so counts in its work, heat that goes on through a thermal port too. "
        )
        if audit.uncounted:
            rest = audit.missing
            text += f"{rest[0].upper()}{rest[1:]}; the gap holds what flows there."
        else:
            text += "The gap is the error of the run and of its integrals."
        lead = f"{prose(what)}\n" if what else ""
        found.append(f"{lead}{prose(text)}\n" + table(("energy", joule.unit), rows, (1,)))
    return "\n".join(found)


def sizes(sizing: Mapping[str, Sizing], units: Units) -> str:
    """One table with a column for each motor."""
    names = list(sizing)
    torque, speed = sizing[names[0]].units
    rows: list[tuple[str, ...]] = []
    for what, own, name in (
        ("peak torque", torque, "peak_torque"),
        ("RMS torque", torque, "rms_torque"),
        ("peak speed", speed, "peak_speed"),
        ("mean speed", speed, "mean_speed"),
        ("peak power", "W", "peak_power"),
        ("peak power taken back", "W", "peak_regeneration"),
        ("mean power", "W", "mean_power"),
    ):
        values = (getattr(motor, name) for motor in sizing.values())
        *texts, unit = amounts(what, own, *values, units=units)
        rows.append((what, unit, *texts))
    loads = (
        ("RMS torque over rated torque", [s.thermal for s in sizing.values()]),
        ("torque over greatest torque", [s.peak for s in sizing.values()]),
    )
    for what, found in loads:
        if any(load is not None for load in found):
            texts = ["" if load is None else number(100 * load.ratio, 4) for load in found]
            rows.append((what, "%", *texts))
    return table(("what the run asks", "unit", *names), rows, range(2, 2 + len(names)))
