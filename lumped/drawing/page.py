"""A report on a model as one page for any browser."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from lumped.compiler.system import System
from lumped.drawing.inline import inline
from lumped.drawing.inline_schematic import inline_schematic
from lumped.drawing.page_frame import prose, report_page, table
from lumped.drawing.page_print import find_printer, write_page
from lumped.drawing.page_run import Told, comparison, energy, events, sizes
from lumped.drawing.part_values import part_texts
from lumped.language.declared import text_of
from lumped.simulation.sizing import Sizing
from lumped.simulation.work_precision import WorkPrecision
from lumped.support.arguments import checked
from lumped.support.display_units import Units, choose_units
from lumped.support.text_table import amounts, number
from lumped.timeloop.results.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class SourceNumber(Protocol):
    """A number of a source; `float` gives its value."""

    @property
    def unit(self) -> str:
        """Its unit."""

    @property
    def mark(self) -> str:
        """Letter for its origin."""

    @property
    def text(self) -> str:
        """Its meaning, in words."""

    def __float__(self) -> float:
        """Its value."""


@checked
def report_html(
    system: System,
    path: str | Path,
    *,
    title: str | None = None,
    text: Mapping[str, str | Sequence[str]] | None = None,
    compared: Iterable[Told] = (),
    given: Iterable[SourceNumber] = (),
    marks: Mapping[str, str] | None = None,
    figures: Mapping[str, Figure] | None = None,
    runs: Mapping[str, Trajectory] | None = None,
    sizing: Mapping[str, Sizing] | None = None,
    accuracy: WorkPrecision | None = None,
    units: Units = None,
) -> Path:
    """Write a report on a model, and on given runs of it.

    It begins with the texts, goes on with results, and ends with the model, its parameters and
    the quantities left out. The page loads no other files. Without scripts it only lacks the zoom.

    Parameters
    ----------
    system : System
        From `lumped.assemble`.
    path : str or Path
        File to write: .html, or .pdf where Chromium, Chrome or Edge is on the PATH, or its path in
        the environment variable LUMPED_CHROMIUM.
    title : str, optional
        Title of the page; default is the name of the model.
    text : mapping of str to str or sequence of str, optional
        Sections to begin with, by their headings: a paragraph, or items of a list.
    compared : iterable of Told, optional
        Numbers of the model, beside published ones if there are any.
    given : iterable of Given, optional
        Numbers of the source.
    marks : mapping of str to str, optional
        Meanings of the letters in brackets behind places and numbers.
    figures : mapping of str to Figure, optional
        Pictures to show, by their captions, such as ``{"Run-up": run.plot()}``.
    runs : mapping of str to Trajectory, optional
        Runs whose events are listed, by their captions; with ``certify=True`` their energy balance
        too.
    sizing : mapping of str to Sizing, optional
        Demands of runs on motors, by their names, from `lumped.simulation.sizing`.
    accuracy : WorkPrecision, optional
        Error against run time, from `lumped.simulation.work_precision`.
    units : mapping of str to str or str, optional
        Units of the numbers of the model and its runs, see `lumped.display_units`; default is what
        the session shows. Figures, and numbers beside published ones, stay as they are given.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    OptionError
        If a PDF cannot be printed.
    UnitError
        If a unit does not fit.
    UnknownNameError
        If a unit is given for a name that does not exist.
    """
    target = Path(path)
    printer = find_printer(target)
    parameters = system.structure.parameters.names
    choice = choose_units(units, ("time", "energy", *system.names(), *parameters))
    name = title or system.name
    pictures = enumerate((figures or {}).items())
    drawn = [inline(figure, caption, f"figure-{i}") for i, (caption, figure) in pictures]
    sections = (
        *((head, prose(body)) for head, body in (text or {}).items()),
        *comparison(list(compared), marks or {}),
        ("Schematic", _draw_schematic(system)),
        ("Figures", "\n".join(drawn)),
        ("Events", events(runs or {}, choice)),
        ("Energy balance", energy(runs or {}, choice)),
        ("Sizing of motors", sizes(sizing, choice) if sizing else ""),
        ("Numbers of the source", _numbers(list(given), marks or {})),
        ("Model", _model(system)),
        ("Parameters", _parameters(system, choice)),
        ("Error and run time", "" if accuracy is None else _accuracy(accuracy)),
        ("Left out", _list_left_out(system)),
    )
    write_page(target, report_page(name, sections), printer)
    return target


def _draw_schematic(system: System) -> str:
    texts = part_texts(system, system.theta({}))
    return inline_schematic(system, texts, f"Schematic of {system.name}", "schematic")


def _model(system: System) -> str:
    report = system.report()
    counts = table(("", "count"), [(k, str(v)) for k, v in report.counts.items()], (1,))
    states = table(
        ("state", "unit", "why it is one"),
        [(n, _unit(system, n), why) for n, why in report.states.items()],
    )
    return f"{counts}\n<h3>States</h3>\n{states}\n<h3>Components</h3>\n{_tree(system)}"


def _unit(system: System, name: str) -> str:
    return "" if name.startswith("der(") else system.quantity(name).unit


def _tree(system: System) -> str:
    """Components as nested lists, whose composites fold."""
    nodes = system.structure.tree.instances
    inner: dict[int, str] = {}
    for i in range(len(nodes) - 1, -1, -1):
        node = nodes[i]
        cls = type(node.component)
        above = nodes[node.parent].path if node.parent >= 0 else ""
        own = node.path.removeprefix(above).lstrip(".") or cls.__name__
        first = text_of(cls).partition("\n")[0].replace("``", "")
        text = (
            f"<b>{escape(own)}</b> <span class='kind'>{escape(cls.__name__)}</span> {escape(first)}"
        )
        if node.children:
            below = "".join(inner.pop(part) for part in node.children.values())
            text = f"<details open><summary>{text}</summary><ul>{below}</ul></details>"
        inner[i] = f"<li>{text}</li>"
    return f'<div class="tree"><ul>{inner[0]}</ul></div>'


def _parameters(system: System, units: Units) -> str:
    parameters = system.structure.parameters
    free = set(parameters.free)
    every = zip(parameters.names, parameters.numbers, parameters.declared, strict=True)
    rows = []
    for i, (name, value, p) in enumerate(every):
        shown = amounts(name, p.unit, value, units=units)
        rows.append((p.text, name, *shown, "" if i in free else "follows from others"))
    return table(("what it is", "parameter", "value", "unit", ""), rows, (2,))


def _numbers(given: list[SourceNumber], marks: Mapping[str, str]) -> str:
    rows = [(n.text, number(float(n)), n.unit, marks.get(n.mark, n.mark)) for n in given]
    return table(("what it is", "value", "unit", "how it is known"), rows, (1,)) if rows else ""


def _list_left_out(system: System) -> str:
    rows = [(item.what, item.why) for item in system.left_out]
    return table(("what", "why"), rows) if rows else prose("Nothing.")


def _accuracy(found: WorkPrecision) -> str:
    rows = []
    for r in found.rows:
        sizes = f"{r.rtol:g}", number(r.error, 2), number(1e3 * r.seconds, 3)
        rows.append((r.method, *sizes, *map(str, (r.steps, r.evaluations, r.events)), r.outcome))
    head = ("method", "rtol", "error", "ms", "steps", "evaluations", "events", "outcome")
    text = prose(
        f"Largest difference from the reference ({found.reference}, whose own error is "
        f"{found.reference_error:.1g}) relative to the ranges of the quantities."
    )
    return f"{text}\n{table(head, rows, range(1, 7))}\n" + inline(
        found.plot(), "Run time over error", "accuracy"
    )
