"""The ``lumped`` command: machines of the literature, printed beside what is computed."""

from __future__ import annotations

import argparse
import json
import runpy
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from lumped.errors import LumpedError, OptionError
from lumped.models import MACHINES, MARKS, Machine, Row, machine
from lumped.support.display_units import Units, display_units
from lumped.support.text_table import number, table
from lumped.support.whole_files import write_text

if TYPE_CHECKING:
    from lumped.explorer.explore import Explorer

Changes = Mapping[str, str | float]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments; default is the command line.

    Returns
    -------
    int
        Exit code: 0, or 2 if a name or value is not understood, a changed machine cannot run, or a
        file cannot be written.
    """
    arguments = _parser().parse_args(argv)
    if arguments.command == "list":
        width = max(map(len, MACHINES))
        for name, text in MACHINES.items():
            print(f"{name:{width}}  {text}")
        return 0
    try:
        changes = dict(arguments.set)
        if arguments.command == "report":
            with display_units(_units(arguments.units)):
                write = _live if arguments.live else _report
                print(f"written: {write(arguments.name, arguments.output, changes)}")
            return 0
        if arguments.command == "explore":
            page = _explored(arguments.name, changes)
            print(f"{page}; Ctrl-C ends it", flush=True)
            page.open()
            return 0
        chosen = machine(arguments.name)
        if changes:
            _run_changed(chosen, arguments.name, changes, arguments.json, arguments.plot)
        else:
            _run(chosen, arguments.name, arguments.json, arguments.plot)
    except (LumpedError, OSError) as error:
        print(f"lumped: {error}", file=sys.stderr)
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="lumped",
        description="Machines of the literature: printed numbers beside computed ones.",
    )
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("list", help="list the machines")
    run = commands.add_parser("run", help="compute a machine and compare it with its publication")
    run.add_argument("--json", metavar="FILE", type=Path, help="write the numbers to FILE")
    run.add_argument("--plot", metavar="DIR", type=Path, help="draw the figures as PNG into DIR")
    report = commands.add_parser(
        "report", help="write a page about a machine, to open in a browser"
    )
    report.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        type=Path,
        default=Path("report.html"),
        help="page to write; default is report.html",
    )
    report.add_argument(
        "--units",
        metavar="UNIT",
        action="append",
        default=[],
        help="show numbers in other units: engineering, or SI unit or quantity and unit, such as "
        "N.m=kN.m or motor.w=rpm; may be given several times",
    )
    report.add_argument(
        "--live",
        action="store_true",
        help="write a page that computes the machine's run in the browser while sliders are moved; "
        "a file .py has a function live(path, parameters) for it",
    )
    explore = commands.add_parser(
        "explore", help="open a page on which parameters of a machine are moved"
    )
    run.add_argument("name", help="name of the machine, see 'lumped list'")
    own = "or a file .py with a function report(path, parameters)"
    report.add_argument("name", help=f"name of the machine, see 'lumped list', {own}")
    own = "or a file .py with a function explore(parameters)"
    explore.add_argument("name", help=f"name of the machine, see 'lumped list', {own}")
    for command in (run, report, explore):
        command.add_argument(
            "--set",
            metavar="PATH=VALUE",
            type=_change,
            action="append",
            default=[],
            help="change a parameter of the machine's run, such as upper.motor.J=30 or "
            "upper.motor.J='30 kg.m2'; may be given several times",
        )
    return parser


def _change(text: str) -> tuple[str, str | float]:
    path, sign, value = text.partition("=")
    path, value = path.strip(), value.strip()
    if not (sign and path and value):
        raise argparse.ArgumentTypeError(
            f"'{text}': write PATH=VALUE, for example upper.motor.J=30"
        )
    try:
        return path, float(value)
    except ValueError:
        return path, value


def _units(given: Sequence[str]) -> Units:
    """Units to show, as they were written."""
    if not given:
        return None
    if len(given) == 1 and "=" not in given[0]:
        return given[0]
    found = {}
    for text in given:
        key, sign, unit = (part.strip() for part in text.partition("="))
        if not (sign and key and unit):
            raise OptionError(
                f"--units {text}: write a preset alone, or KEY=UNIT, for example N.m=kN.m."
            )
        found[key] = unit
    return found


_OWN = {
    "explore": "explore(parameters), which returns what lumped.explore does",
    "live": "live(path, parameters), which writes its page, as lumped.live_page does",
    "report": "report(path, parameters), which writes its page, as "
    "lumped.drawing.torsional_report and report_html do",
}
"""Functions that a user's module may have."""


def _own(file: str, name: str) -> Callable[..., Any] | None:
    """A function of a user's module; None for the name of a machine."""
    if not file.endswith(".py"):
        return None
    module = Path(file)
    if not module.is_file():
        raise OptionError(f"{name}: there is no file '{module}'.")
    sys.path.insert(0, str(module.parent))  # as Python does for a script
    found = runpy.run_path(str(module), run_name=module.stem).get(name)
    if not callable(found):
        raise OptionError(f"{name}: '{module}' has no function {_OWN[name]}.")
    return cast("Callable[..., Any]", found)


def _written(found: Any, file: Path, name: str) -> Path:
    """Where a user's function wrote its page: what it returns, or else the path that it was given.

    Raises
    ------
    OptionError
        If there is no such file.
    """
    if not isinstance(found, str | Path | None):
        raise OptionError(
            f"report: the function of '{name}' returns a {type(found).__name__}; return the path "
            "of the page, as lumped.live_page and report_html do, or nothing."
        )
    path = Path(file if found is None else found)
    if not path.is_file():
        raise OptionError(f"report: the function of '{name}' writes no page to '{path}'.")
    return path


def _explored(name: str, changes: Changes) -> Explorer:
    """The page of a machine's run, or that of a user's module."""
    from lumped.explorer.explore import Explorer, explore
    from lumped.vibration.rules.limits import Limit

    if own := _own(name, "explore"):
        found = own(changes)
        if not isinstance(found, Explorer):
            raise OptionError(
                f"explore: the function of '{name}' returns a {type(found).__name__}; return what "
                "lumped.explore does."
            )
        return found
    chosen = machine(name)
    about = chosen.ABOUT
    run = chosen.scene(about.until, parameters=changes, grid=1)
    system = run.system
    limits = [
        Limit(motor.torque, float(motor.maximum), name=f"{motor.name}, greatest torque")
        for motor in about.motors
        if isinstance(motor.maximum, float | int)
    ]
    return explore(
        system,
        until=float(run.t[-1]),
        start=lambda parameters: chosen.begin(system, parameters),
        parameters=_find_changed(run),
        of=list(about.watched.values()),
        inputs=about.varied,
        limits=limits,
    )


def _find_changed(run: Any) -> dict[str, float]:
    """Parameters of a run that are not those of its model."""
    values = zip(run.system.parameters.items(), run.theta.tolist(), strict=True)
    return {name: value for (name, model), value in values if value != model}


def _live(name: str, file: Path, changes: Changes) -> Path:
    """The page that computes a machine's run, or that of a user's module."""
    from lumped.live.live_page import live_page

    if own := _own(name, "live"):
        return _written(own(file, changes), file, name)
    chosen = machine(name)
    about = chosen.ABOUT
    run = chosen.scene(about.until, parameters=changes, grid=1)
    start = chosen.start_values(run.system, changes)
    return live_page(
        run.system,
        file,
        until=float(run.t[-1]),
        plots=list(about.watched.values()),
        start=chosen.begin(run.system, changes) if start is None else start,
        parameters=None if start is None else _find_changed(run),
        title=MACHINES[name],
        text=about.scene,
    )


_TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9)


def _report(name: str, file: Path, changes: Changes) -> Path:
    """The page about a machine, or that of a user's module."""
    from lumped.compiler.assemble import assemble
    from lumped.drawing.page import report_html
    from lumped.models.about import size_motor
    from lumped.models.sources import constants

    if own := _own(name, "report"):
        return _written(own(file, changes), file, name)
    chosen = machine(name)
    about = chosen.ABOUT
    run = chosen.scene(about.until, parameters=changes, grid=4000, certify=True)
    model, _, kept = run.system.origin
    text: dict[str, str | Sequence[str]] = {"Introduction": about.introduction}
    if changes:
        text["Changed here"] = [f"{path} = {value}" for path, value in changes.items()]
    text |= {"Source": about.source, "Findings": about.findings, "Assumptions": about.assumptions}
    if changes:
        figures = {"What is watched in the run": run.plot(list(about.watched.values()))}
    else:
        figures = {about.captions[key]: figure for key, figure in chosen.plots().items()}
    return report_html(
        assemble(model.with_(changes), keep=kept),
        file,
        title=MACHINES[name] + (", changed" if changes else ""),
        text=text,
        compared=_changed(chosen, changes) if changes else chosen.rows(),
        given=constants(name),
        marks=MARKS,
        figures=figures,
        runs={about.scene: run},
        sizing={motor.name: size_motor(run, motor) for motor in about.motors},
        accuracy=chosen.accuracy(changes, tolerances=_TOLERANCES),
    )


def _run(chosen: Machine, name: str, json_file: Path | None, plot_folder: Path | None) -> None:
    rows = chosen.rows()
    print(f"{MACHINES[name]}\n")
    print(_compared(rows))
    found = chosen.accuracy(methods=["auto"], tolerances=(1e-4, 1e-6, 1e-8))
    told = "; ".join(
        f"{1e3 * row.seconds:.2g} ms, {max(row.error, found.reference_error):.0e} "
        f"(rtol {row.rtol:.0e})"
        for row in found.rows
    )
    print(f"\nrun time of {chosen.short:g} s and error, largest of a state over its range: {told}")
    if json_file:
        keys = ("quantity", "unit", "published", "bounds", "fitted", "computed", "mark", "place")
        records = [{key: getattr(row, key) for key in (*keys, "remark")} for row in rows]
        _write(json_file, {"machine": name, "marks": MARKS, "rows": records})
    if plot_folder:
        print()
        _draw(chosen, name, plot_folder)


def _changed(chosen: Machine, changes: Changes) -> list[Row]:
    """What is measured of a changed machine, beside the same of the published one."""
    return [
        Row(old.quantity, old.unit, None, new.value, "changed", f"{number(old.value)} unchanged")
        for old, new in zip(chosen.measures(), chosen.measures(changes), strict=True)
    ]


def _run_changed(
    chosen: Machine,
    name: str,
    changes: Changes,
    json_file: Path | None,
    plot_folder: Path | None,
) -> None:
    pairs = list(zip(chosen.measures(), chosen.measures(changes), strict=True))
    told = ", ".join(f"{path} = {value}" for path, value in changes.items())
    print(f"{MACHINES[name]}, changed: {told}\n{chosen.ABOUT.scene}\n")
    lines = []
    for old, new in pairs:
        off = f"{100 * (new.value / old.value - 1):+.2f}" if old.value else "-"
        lines.append((old.quantity, old.unit, number(old.value), number(new.value), off))
    print(table(("quantity", "unit", "as published", "changed", "change, %"), lines))
    if json_file:
        records = [
            {"quantity": a.quantity, "unit": a.unit, "unchanged": a.value, "changed": b.value}
            for a, b in pairs
        ]
        _write(json_file, {"machine": name, "set": dict(changes), "measures": records})
    if plot_folder:
        about = chosen.ABOUT
        run = chosen.scene(about.until, parameters=changes, grid=4000)
        plot_folder.mkdir(parents=True, exist_ok=True)
        file = plot_folder / f"{name}_changed.png"
        run.plot(list(about.watched.values())).savefig(file, dpi=150)
        print(f"\nwritten: {file}")


def _write(file: Path, found: Mapping[str, object]) -> None:
    write_text(file, json.dumps(found, indent=2, ensure_ascii=False) + "\n")


def _compared(rows: Sequence[Row]) -> str:
    """Published numbers, apart from them those of the model alone, and where each stands."""
    notes = list(dict.fromkeys((row.place, row.remark) for row in rows))
    printed, own = [], []
    for row in rows:
        published, computed, deviation = row.texts
        note = f"[{notes.index((row.place, row.remark)) + 1}]"
        if row.printed:
            printed.append((row.quantity, row.unit, published, computed, deviation, note))
        else:
            own.append((row.quantity, row.unit, computed, note))
    head = ("quantity", "unit", "published", "computed", "deviation, %", "note")
    tables = [table(head, printed)]
    if own:
        tables.append("Not published:\n\n" + table(("quantity", "unit", "computed", "note"), own))
    listed = [f"[{i}] {place}: {remark}" for i, (place, remark) in enumerate(notes, 1)]
    marks = "; ".join(f"[{mark}] {text}" for mark, text in MARKS.items())
    fitted = "fitted: something unknown was chosen so that this row agrees; it proves nothing"
    return "\n".join(["\n\n".join(tables), "", *listed, "", marks, fitted])


def _draw(chosen: Machine, name: str, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for title, figure in chosen.plots().items():
        file = folder / f"{name}_{title}.png"
        figure.savefig(file, dpi=150)
        print(f"written: {file}")
