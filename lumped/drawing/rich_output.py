"""Models and results as notebooks show them: their text with tables, and small pictures."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterable, Sequence
from functools import singledispatch
from html import escape
from itertools import groupby
from typing import Any

import numpy as np

from lumped.compiler.system import System
from lumped.drawing import sparklines
from lumped.drawing.inline import as_svg
from lumped.drawing.netlist import netlist
from lumped.drawing.schematic import schematic
from lumped.ensembles.outcome import Ensemble
from lumped.errors import LumpedError
from lumped.gradients.gradient import Gradient
from lumped.gradients.sensitivity_result import Sensitivity
from lumped.language.component import Component
from lumped.life.duty_cycle import DutyCycle
from lumped.points.equilibrium_sensitivity import EquilibriumSensitivity
from lumped.support.display_units import time_unit
from lumped.support.ranking import rank
from lumped.timeloop.results.result_files import Saved
from lumped.timeloop.results.trajectory import Trajectory
from lumped.tolerances.scatter import Scatter
from lumped.vibration.inertias.holzer import Holzer
from lumped.vibration.natural.eigen_sensitivity import EigenSensitivity
from lumped.vibration.natural.modes import Modes
from lumped.vibration.ordered.order_amplitudes import OrderAmplitudes
from lumped.vibration.ordered.order_sensitivity import OrderSensitivity
from lumped.vibration.responses.response import FrequencyResponse
from lumped.vibration.rules.verdict import Verdict

_MOST_PARTS = 60
"""Parts of a model up to which its whole schematic is small; of more, the outermost are drawn."""
_MOST_EVENTS, _MOST_BARS = 50, 12
_RULE = re.compile(r"-+(?:  -+)+")
Column = tuple[str, Sequence[str]]


def html(shown: Any) -> str:
    """Text of a model or result as HTML, with pictures; no script, one element.

    Colours are those of the page, so that it reads on a light and on a dark one.
    """
    text = repr(shown).splitlines()
    parts, column = [], _column(shown)
    for is_table, lines in groupby(_with_kinds(text), key=lambda line: line[0]):
        body = [line for _, line in lines]
        if is_table:
            parts.append(_table(body, column))
            column = None
        else:
            parts.append(f'<pre style="margin:4px 0;white-space:pre-wrap">{_escape(body)}</pre>')
    return f'<div class="lumped">{"".join(parts)}{_below(shown)}</div>'


def _escape(lines: Sequence[str]) -> str:
    return escape("\n".join(lines))


def _with_kinds(lines: Sequence[str]) -> list[tuple[int, str]]:
    """Each line with the number of the table that it belongs to; zero for text."""
    found, tables = [0] * len(lines), 0
    for i, line in enumerate(lines):
        if i and _RULE.fullmatch(line):
            tables += 1
            end = i
            while end < len(lines) and lines[end].strip():
                end += 1
            found[i - 1 : end] = [tables] * (end - i + 1)
            width = len(line)
            for k in range(i + 1, end):  # texts below a table are longer, or have no second column
                if not _is_row(lines[k], line, width):
                    found[k:end] = [0] * (end - k)
                    break
    return list(zip(found, lines, strict=True))


def _is_row(line: str, rule: str, width: int) -> bool:
    """Whether there are spaces wherever the rule of the table has them."""
    gaps = [i for i, letter in enumerate(rule) if letter == " "]
    return len(line) <= width and all(line[i : i + 1] in (" ", "") for i in gaps)


def _table(lines: Sequence[str], column: Column | None) -> str:
    """A text table as one of HTML, with one more column of pictures."""
    head, rule, *rows = lines
    places = [match.span() for match in re.finditer("-+", rule)]
    texts = [[line[a:b].strip() for a, b in places] for line in (head, *rows)]
    more = ["" for _ in texts]
    if column is not None:
        pictures = [*column[1]][: len(rows)]
        more = [escape(column[0]), *pictures, *[""] * (len(rows) - len(pictures))]
    rows_of_cells = []
    for i, (cells, picture) in enumerate(zip(texts, more, strict=True)):
        tag = "td" if i else "th"
        told = [_cell(escape(cell), "right" if k else "left", tag) for k, cell in enumerate(cells)]
        rows_of_cells.append([*told, _cell(picture, tag=tag)] if column is not None else told)
    return _write_table(rows_of_cells)


def _cell(html: str, side: str = "left", tag: str = "td") -> str:
    return f'<{tag} style="padding:1px 8px;text-align:{side}">{html}</{tag}>'


def _write_table(rows: Iterable[Iterable[str]]) -> str:
    lines = "".join(f"<tr>{''.join(cells)}</tr>" for cells in rows)
    return f'<table style="color:inherit;border-collapse:collapse">{lines}</table>'


@singledispatch
def _column(_: Any) -> Column | None:
    """Title and pictures of one more column of the first table, line by line."""
    return None


@_column.register
def _(run: Trajectory | Saved) -> Column:
    instants = [event.time for event in run.events]
    names = run.main[:12] if isinstance(run, Saved) else run.system.state_names[:12]
    shown = [name for name in names if isinstance(run, Saved) or "(" not in name]
    return "course", [sparklines.curve(run.t, run[name], instants) for name in shown]


@_column.register
def _(modes: Modes) -> Column:
    shapes = [modes.shape(name).real for name in modes.angles[:40]]
    count = min(len(modes.hertz), 30)
    return "shape", [sparklines.stems([float(s[i]) for s in shapes]) for i in range(count)]


@_column.register
def _(found: Ensemble) -> Column:
    return "spread", [sparklines.spread(found[label]) for label in found.labels]


@_column.register
def _(found: Scatter) -> Column:
    return "spread", [sparklines.spread(own.sample()) for own in found.spreads.values()]


@_column.register
def _(found: DutyCycle) -> Column:
    damages = [*found.damages.tolist(), *[found.between] * (len(found.names) > 1)]
    return "damage", [sparklines.share(value, max(damages), max(damages)) for value in damages]


@_column.register
def _(found: Verdict) -> Column:
    used = [result.utilisation for result in found.results]
    most = max(1.2, min(3.0, max(used, default=0.0)))
    return "used", [sparklines.share(value, most, 1.0) for value in used]


@singledispatch
def _below(_: Any) -> str:
    """Pictures below the text."""
    return ""


@_below.register
def _(model: Component | System) -> str:
    try:
        parts = sum(1 for _ in netlist(model, None).top.all_items())
        figure = schematic(model, depth=1 if parts > _MOST_PARTS else None)
    except LumpedError:  # its text is shown all the same
        return ""
    key = f"s{zlib.crc32(repr(model).encode()):08x}"
    return (
        '<div style="background:#fff;display:inline-block;max-width:100%;overflow:auto">'
        f"{as_svg(figure, key)}</div>"
    )


@_below.register
def _(run: Trajectory | Saved) -> str:
    if not run.events:
        return ""
    to = time_unit()
    rows = [
        (
            _cell(f"{to.value(event.time):.6g} {escape(to.unit)}", "right"),
            _cell(escape(event.component)),
            _cell(f"{escape(event.before)} \u2192 {escape(event.after)}"),
        )
        for event in run.events[:_MOST_EVENTS]
    ]
    more = len(run.events) - len(rows)
    rest = f"<p>{more} more</p>" if more else ""
    return (
        f"<details><summary>{len(run.events)} events</summary>{_write_table(rows)}{rest}</details>"
    )


@_below.register
def _(found: FrequencyResponse) -> str:
    lines = []
    for output, input_ in found:
        size = np.abs(found[output, input_])
        with np.errstate(divide="ignore"):
            lines.append((f"{output} by {input_}", np.log10(size)))
    return _write_rows([(name, sparklines.curve(found.hertz, y)) for name, y in lines[:_MOST_BARS]])


@_below.register
def _(found: OrderAmplitudes) -> str:
    rows = []
    for output in found.of[:_MOST_BARS]:
        size = np.abs(found[output])
        largest = np.argsort(-size.max(axis=0, initial=0.0))
        rows.append((output, sparklines.curves(found.speeds, [*size[:, largest].T], output)))
    return _write_rows(rows)


@_below.register
def _(found: Holzer) -> str:
    angles = np.array([*found.ends.values()])
    places = np.arange(len(angles), dtype=float)
    return sparklines.curves(places, [angles], "angles along the drive", (320, 80))


@_below.register
def _(found: EigenSensitivity) -> str:
    hertz = found.modes.hertz
    most = [i for i in range(len(hertz)) if hertz[i] > 0][:3]
    return "".join(_tornado(f"frequency {i + 1}", found.ranked(i)) for i in most)


@_below.register
def _(found: Gradient | EquilibriumSensitivity) -> str:
    known = [name for name, value in zip(found.of, found.values, strict=True) if value]
    return "".join(_tornado(name, found.ranked(name)) for name in known[:3])


@_below.register
def _(found: OrderSensitivity) -> str:
    return _tornado(found.of, rank(found.by, found.relative))


@_below.register
def _(found: Sensitivity) -> str:
    t = found.run.t
    rows = [
        (f"{of} by {by}", sparklines.curve(t, found.derivatives[:, i, k]))
        for i, of in enumerate(found.of)
        for k, by in enumerate(found.by)
    ]
    return _write_rows(rows[:_MOST_BARS])


def _tornado(what: str, ranked: Sequence[tuple[str, float]]) -> str:
    """Bars of relative sensitivities, the largest first."""
    shown = ranked[:_MOST_BARS]
    most = max((abs(value) for _, value in shown), default=0.0)
    rows = [(f"{name} {value:+.3g}", sparklines.share(value, most)) for name, value in shown]
    return f"<p>relative change of {escape(what)}</p>{_write_rows(rows)}" if rows else ""


def _write_rows(rows: Sequence[tuple[str, str]]) -> str:
    """Names and their pictures."""
    return _write_table((_cell(escape(name)), f"<td>{picture}</td>") for name, picture in rows)
