"""A report on a model as one page that needs nothing but a browser."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from lumped.pictures.inline import inline
from lumped.pictures.schematic import schematic
from lumped.system import System
from lumped.table import number
from lumped.whole import write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lumped.analysis.work_precision import WorkPrecision

__all__ = ["Compared", "Given", "report_html"]


class Compared(Protocol):
    """A published number beside the computed one."""

    @property
    def quantity(self) -> str:
        """What it is."""

    @property
    def unit(self) -> str:
        """Its unit."""

    @property
    def published(self) -> float | None:
        """Printed value."""

    @property
    def computed(self) -> float:
        """Value of the model."""

    @property
    def place(self) -> str:
        """Where the printed value stands."""

    @property
    def remark(self) -> str:
        """What explains a deviation."""


Given = tuple[str, float, str, str, str]
"""A number of the source: name, value, unit, mark ([P], [R], [I], [A]) and text."""

_MARKS = {
    "P": "printed",
    "R": "restored by derivation",
    "I": "inferred",
    "A": "assumed, as the source does not give it",
}


def report_html(
    system: System,
    path: str | Path,
    *,
    title: str | None = None,
    figures: Mapping[str, Figure] | None = None,
    compared: Iterable[Compared] = (),
    given: Iterable[Given] = (),
    accuracy: WorkPrecision | None = None,
) -> Path:
    """Write a report: model, schematic, parameters, figures that zoom, and what was left out.

    The page loads nothing. Without scripts it shows all but the zoom.

    Parameters
    ----------
    system : System
        From `lumped.assemble`.
    path : str or Path
        File to write.
    title : str, optional
        Title of the page; default is the name of the model.
    figures : mapping of str to Figure, optional
        Pictures to show, by their titles, such as ``{"run-up": run.plot()}``.
    compared : iterable of Compared, optional
        Published numbers beside computed ones.
    given : iterable of Given, optional
        Numbers of the source with their marks.
    accuracy : WorkPrecision, optional
        Error against run time, from `lumped.work_precision`.

    Returns
    -------
    Path
        The file.
    """
    name = title or system.name
    sections = [
        ("Model", _model(system)),
        ("Schematic", inline(schematic(system), f"{system.name}: schematic", "schematic")),
        ("Parameters", _parameters(system, list(given))),
    ]
    rows = list(compared)
    if rows:
        sections.append(("Published and computed", _comparison(rows)))
    if figures:
        drawn = [inline(f, text, f"figure-{i}") for i, (text, f) in enumerate(figures.items())]
        sections.append(("Figures", "\n".join(drawn)))
    if accuracy is not None:
        sections.append(("Error and run time", _accuracy(accuracy)))
    sections.append(("Left out", _left_out(system)))
    anchors = [text.lower().replace(" ", "-") for text, _ in sections]
    links = "".join(
        f'<li><a href="#{a}">{t}</a></li>' for a, (t, _) in zip(anchors, sections, strict=True)
    )
    body = "".join(
        f'<section aria-labelledby="{a}">\n<h2 id="{a}">{t}</h2>\n{content}\n</section>\n'
        for a, (t, content) in zip(anchors, sections, strict=True)
    )
    parts = files("lumped.pictures")
    text = (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<link rel="icon" href="data:,">\n'
        f"<title>{escape(name)}</title>\n<style>\n{(parts / 'page.css').read_text()}</style>\n"
        f"</head>\n<body>\n<h1>{escape(name)}</h1>\n<nav><ul>{links}</ul></nav>\n{body}"
        f"<script>\n{(parts / 'page.js').read_text()}</script>\n</body>\n</html>\n"
    )
    target = Path(path)
    write_text(target, text)
    return target


def _table(head: Sequence[str], rows: Iterable[Sequence[str]], numbers: Sequence[int] = ()) -> str:
    def line(cells: Sequence[str], tag: str) -> str:
        texts = (
            f'<{tag} class="number">{c}</{tag}>' if i in numbers else f"<{tag}>{c}</{tag}>"
            for i, c in enumerate(map(escape, cells))
        )
        return f"<tr>{''.join(texts)}</tr>"

    body = "\n".join(line(row, "td") for row in rows)
    return (
        f'<div class="wide"><table>\n<thead>{line(head, "th")}</thead>\n'
        f"<tbody>\n{body}\n</tbody>\n</table></div>"
    )


def _model(system: System) -> str:
    report = system.report()
    counts = _table(("", "count"), [(k, str(v)) for k, v in report.counts.items()], (1,))
    states = _table(
        ("state", "unit", "why it is one"),
        [(n, _unit(system, n), why) for n, why in report.states.items()],
    )
    return f"{counts}\n<h3>States</h3>\n{states}\n<h3>Components</h3>\n{_tree(system)}"


def _unit(system: System, name: str) -> str:
    return "" if name.startswith("der(") else system.quantity(name).unit


def _tree(system: System) -> str:
    """Components as nested lists, composites that can be folded."""
    nodes = system._tree.nodes
    texts: list[str] = []
    for node in nodes:
        cls = type(node.component)
        above = nodes[node.parent].path if node.parent >= 0 else ""
        own = node.path.removeprefix(above).lstrip(".") or cls.__name__
        first = (cls.__doc__ or "").strip().partition("\n")[0]
        texts.append(
            f"<b>{escape(own)}</b> <span class='kind'>{escape(cls.__name__)}</span> "
            f"{escape(first.replace('``', ''))}"
        )
    inner: dict[int, str] = {}
    for i in range(len(nodes) - 1, -1, -1):
        parts = nodes[i].children.values()
        if parts:
            below = "".join(inner.pop(p) for p in parts)
            fold = f"<details open><summary>{texts[i]}</summary><ul>{below}</ul></details>"
            inner[i] = f"<li>{fold}</li>"
        else:
            inner[i] = f"<li>{texts[i]}</li>"
    return f'<div class="tree"><ul>{inner[0]}</ul></div>'


def _parameters(system: System, given: list[Given]) -> str:
    parameters = system._flat.parameters
    free = set(parameters.free)
    rows = [
        (name, number(value), p.unit, p.text, "" if i in free else "follows from others")
        for i, (name, value, p) in enumerate(
            zip(parameters.names, parameters.numbers, parameters.declared, strict=True)
        )
    ]
    text = _table(("parameter", "value", "unit", "what it is", ""), rows, (1,))
    if not given:
        return text
    used = {mark for *_, mark, _ in given}
    key = "; ".join(f"[{mark}] {what}" for mark, what in _MARKS.items() if mark in used)
    numbers = _table(
        ("number", "value", "unit", "mark", "what it is"),
        [(name, number(value), unit, f"[{m}]", text) for name, value, unit, m, text in given],
        (1,),
    )
    return f"<h3>Numbers of the source</h3>\n<p>{key}</p>\n{numbers}\n<h3>Model</h3>\n{text}"


def _comparison(rows: list[Compared]) -> str:
    lines = []
    for row in rows:
        published, deviation = "", ""
        if row.published is not None:
            published = number(row.published)
            deviation = f"{100 * (row.computed / row.published - 1):+.2f}"
        cells = (row.quantity, row.unit, published, number(row.computed), deviation)
        lines.append((*cells, row.place, row.remark))
    head = ("quantity", "unit", "published", "computed", "deviation, %", "place", "remark")
    return _table(head, lines, (2, 3, 4))


def _left_out(system: System) -> str:
    if not system.left_out:
        return "<p>Nothing.</p>"
    return _table(("what", "why"), [(item.what, item.why) for item in system.left_out])


def _accuracy(found: WorkPrecision) -> str:
    rows = [
        (
            r.method,
            f"{r.rtol:g}",
            number(r.error, 2),
            number(1e3 * r.seconds, 3),
            *counts,
            r.outcome,
        )
        for r in found.rows
        for counts in [(str(r.steps), str(r.evaluations), str(r.events))]
    ]
    head = ("method", "rtol", "error", "ms", "steps", "evaluations", "events", "outcome")
    text = (
        f"<p>Largest difference from the reference ({escape(found.reference)}, whose own error is "
        f"{found.reference_error:.1g}) relative to the ranges of the quantities.</p>"
    )
    return f"{text}\n{_table(head, rows, range(1, 7))}\n" + inline(
        found.plot(), "run time over error", "accuracy"
    )
