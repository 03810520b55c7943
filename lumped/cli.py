"""The ``lumped`` command: the published machines, printed beside what is computed."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from lumped.errors import UnknownNameError
from lumped.models import MACHINES, MARKS, Machine, Row, machine
from lumped.table import number, table
from lumped.whole import write_text

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; default is the command line.

    Returns
    -------
    int
        Exit code: 0, or 2 if a name is unknown or a file cannot be written.
    """
    arguments = _parser().parse_args(argv)
    if arguments.command == "list":
        width = max(map(len, MACHINES))
        for name, text in MACHINES.items():
            print(f"{name:{width}}  {text}")
        return 0
    try:
        if arguments.command == "report":
            _report(arguments.name, arguments.output)
        else:
            _run(arguments.name, arguments.json, arguments.plot)
    except (UnknownNameError, OSError) as error:
        print(f"lumped: {error}", file=sys.stderr)
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="lumped", description="Published machines: printed numbers beside computed ones."
    )
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("list", help="list the machines")
    run = commands.add_parser("run", help="compute a machine and compare it with its publication")
    run.add_argument("name", help="name of the machine, see 'lumped list'")
    run.add_argument("--json", metavar="FILE", type=Path, help="write the numbers to FILE")
    run.add_argument("--plot", metavar="DIR", type=Path, help="draw the figures as PNG into DIR")
    report = commands.add_parser(
        "report", help="write a page about a machine, to open in a browser"
    )
    report.add_argument("name", help="name of the machine, see 'lumped list'")
    report.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        type=Path,
        default=Path("report.html"),
        help="page to write; default is report.html",
    )
    return parser


_TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9)


def _report(name: str, file: Path) -> None:
    chosen = machine(name)
    from lumped.analysis.work_precision import work_precision
    from lumped.assemble import assemble
    from lumped.models.sources import constants
    from lumped.pictures.page import report_html

    run = chosen.scene(grid=1)
    accuracy = work_precision(
        run.system, until=float(run.t[-1]), start=run.point(0.0), tolerances=_TOLERANCES
    )
    written = report_html(
        assemble(chosen.model()),
        file,
        title=MACHINES[name],
        figures={text.replace("_", " "): figure for text, figure in chosen.plots().items()},
        compared=chosen.rows(),
        given=constants(name),
        accuracy=accuracy,
    )
    print(f"written: {written}")


def _run(name: str, json_file: Path | None, plot_folder: Path | None) -> None:
    chosen = machine(name)
    rows = chosen.rows()
    print(f"{MACHINES[name]}\n")
    print(_compared(rows))
    if json_file:
        keys = ("quantity", "unit", "published", "computed", "mark", "place", "remark")
        records = [{key: getattr(row, key) for key in keys} for row in rows]
        found = {"machine": name, "marks": MARKS, "rows": records}
        write_text(json_file, json.dumps(found, indent=2, ensure_ascii=False) + "\n")
    if plot_folder:
        print()
        _draw(chosen, name, plot_folder)


def _compared(rows: Sequence[Row]) -> str:
    """Table of the rows, and below it where the published numbers stand."""
    notes = list(dict.fromkeys((row.place, row.remark) for row in rows))
    lines = []
    for row in rows:
        published, deviation = "-", "-"
        if row.published is not None:
            published = number(row.published)
            deviation = f"{100 * (row.computed / row.published - 1):+.2f}"
        note = f"[{notes.index((row.place, row.remark)) + 1}]"
        lines.append((row.quantity, row.unit, published, number(row.computed), deviation, note))
    head = ("quantity", "unit", "published", "computed", "deviation, %", "note")
    listed = [f"[{i}] {place}: {remark}" for i, (place, remark) in enumerate(notes, 1)]
    marks = "; ".join(f"[{mark}] {text}" for mark, text in MARKS.items())
    return "\n".join([table(head, lines), "", *listed, "", marks])


def _draw(chosen: Machine, name: str, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for title, figure in chosen.plots().items():
        file = folder / f"{name}_{title}.png"
        figure.savefig(file, dpi=150)
        print(f"written: {file}")
