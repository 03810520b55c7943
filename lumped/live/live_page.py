"""`live_page`: a model, its time loop and its sliders in one file for a browser."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from lumped.compiler.assemble import assemble
from lumped.compiler.condition import Condition
from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.drawing.part_values import find_part_values, find_powers, part_texts
from lumped.errors import OptionError
from lumped.exchange.c_compiler import Linked, compile_sources, zig_compiler
from lumped.exchange.c_tables import model_files
from lumped.exchange.interface import Interface, uneven_clocks
from lumped.explorer.sliders import Ends
from lumped.explorer.study import Start, Study, choose_quantities, choose_sliders, read_end
from lumped.functionals import Functional, highest, lowest
from lumped.functionals.functional import watching
from lumped.language.component import Component
from lumped.language.expression import Call, ConstantExpression, Expr
from lumped.many_runs.watched import POSITIONS, Watched
from lumped.plots.over_time import draw_over_time
from lumped.plots.picture import Curve
from lumped.simulation.simulate import simulate
from lumped.support.arguments import checked
from lumped.support.text_table import number
from lumped.support.whole_files import write_text
from lumped.timeloop.holds import hold_words
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Trajectory

_MOST_ROWS = 20_000
_SOURCES = ("clocks.c", "events.c", "faults.c", "start.c", "steps.c", "access.c", "live.c")
_MADE = Linked((), ("-mexec-model=reactor", "-s"), ".wasm")
_SCRIPTS = ("numbers", "pictures", "page")


@checked
def live_page(
    model: Component | System,
    path: str | Path,
    *,
    until: float | str,
    sliders: Iterable[Name] | Mapping[str, Ends] | Mapping[Name, Ends] | None = None,
    plots: Iterable[Name] | None = None,
    numbers: Iterable[Functional] | Mapping[str, Functional] = (),
    start: Changes | OperatingPoint | None = None,
    parameters: Changes | None = None,
    title: str | None = None,
    text: str = "",
    grid: int = 1000,
    rtol: float = 1e-6,
) -> Path:
    """Write a page that computes runs of a model in the browser while sliders are moved.

    The file holds the time loop and the functions of the model as WebAssembly, the schematic,
    sliders and pictures; it loads nothing, needs no server and works from a mail. A run on the page
    makes the steps of ``simulate(..., method="steps")`` at the same tolerance, and finds the same
    events.

    Parameters
    ----------
    model : Component or System
        The drive; a model is assembled.
    path : str or Path
        File to write, ``*.html``.
    until : float or str
        End of the run, s, or with a unit.
    sliders : iterable of names, or mapping of name to (low, high), optional
        Parameters to move, and the ends of their sliders; default is the ten
        that have most effect on the lowest modes, then on the run. The page's file of parameters
        holds all.
    plots : iterable of names, optional
        Quantities to draw; default is the first five states.
    numbers : functionals, or mapping of text to functional, optional
        Numbers of the run that the page shows, beside the highest and lowest values of what is
        drawn (see `lumped.functionals`).
    start : mapping of name to float, or OperatingPoint, optional
        Start values, as for `simulate`, or states and parameters of a point. They do not move with
        the sliders; what follows from start values does.
    parameters : mapping of name to float, optional
        Parameters that are changed from the model at first.
    title, text : str, optional
        Heading, and what stands below it.
    grid : int
        Intervals of the curves.
    rtol : float
        Relative tolerance.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    OptionError
        If Zig's compiler is not installed (``lumped[cross]``), a functional cannot be collected, or
        an option makes no sense.
    UnknownNameError
        If a name does not exist.
    ExportError
        If the compiler refuses the sources.
    """
    plots = None if plots is None else list(plots)
    system = model if isinstance(model, System) else assemble(model, keep=plots or ())
    end = read_end(until, "live_page")
    if not 1 <= grid <= _MOST_ROWS:
        raise OptionError(f"live_page: grid = {grid}: choose 1 to {_MOST_ROWS} intervals.")
    if isinstance(start, OperatingPoint):
        if start.system is not system or start.time:
            raise OptionError(
                f"{system.name}: live_page: start is a point of {start.system.name} at "
                f"{start.time:g} s; give one of this system at 0 s."
            )
        if parameters:
            raise OptionError(
                f"{system.name}: live_page: a start point brings its own parameters; give none "
                "beside it."
            )
        changed = start.parameters
    else:
        changed = {system.key(name): value for name, value in (parameters or {}).items()}
    if uneven_clocks(system):
        system = system.without_foresight()
    theta, p = system.theta(changed), system.structure.parameters
    base = {name: float(theta[system.places([name])[0]]) for name in changed}
    names = choose_quantities(system, plots)
    if not names:
        raise OptionError(f"{system.name}: live_page: name quantities to draw, with `plots`.")
    study = Study(system, base, end, _start_of(start), names)
    moved = choose_sliders(study, sliders)
    wanted = _find_numbers(system, names, numbers)
    system = watching(system, wanted.values())
    watched = Watched(system, wanted, 0.0, end)
    compiler = zig_compiler("wasm32-wasi", "live_page")
    interface = Interface(system, (), names, {} if start is None else start)
    sources, _ = model_files(interface, "", rtol, "auto", watched=watched)
    folder = files("lumped.exchange") / "c"
    sources |= {name: (folder / name).read_text() for name in (*_SOURCES, "lumped.h")}
    sources["shown.h"] = _write_shown(interface, names, watched, grid)
    code = compile_sources(sources, ("loop.c", "model.c", *_SOURCES), compiler, _MADE)
    options: dict[str, Any] = {"until": end, "start": start, "rtol": rtol, "method": "steps"}
    first = simulate(system, parameters=parameters, grid=grid, **options)
    values = dict(zip(system.parameters, theta.tolist(), strict=True))
    places = {name: place for place, name in enumerate(values)}
    declared = (p.declared[i] for i in p.free)
    data = {
        "name": system.name,
        "until": end,
        "grid": grid,
        "parameters": [
            {"name": name, "unit": own.unit, "value": values[name]}
            for name, own in zip(values, declared, strict=True)
        ],
        "sliders": [asdict(each) | {"place": places[each.name]} for each in moved],
        "quantities": [
            {"name": name, "unit": own.unit, "text": own.text}
            for name, own in zip(names, map(system.quantity, names), strict=True)
        ],
        "panels": _panels(first, names),
        "numbers": [_rule(system, watched, label) for label in wanted],
        "ranges": _ranges(watched),
        "events": _event_words(system),
        "parts": {
            part: told._asdict() | {"value": find_powers(system, told)}
            for part, told in find_part_values(system).items()
        },
    }
    from lumped.drawing.inline_schematic import inline_schematic
    from lumped.drawing.page_frame import fill_frame, prose

    texts = part_texts(system, theta, {})
    folder = files("lumped.live")
    body = Template((folder / "page.html").read_text()).substitute(
        text=prose(text) if text else "",
        schematic=inline_schematic(system.model, texts, system.name, "s"),
        data=json.dumps(data, ensure_ascii=False).replace("</", "<\\/"),
        code=base64.b64encode(code).decode(),
        script="\n".join((folder / f"{name}.js").read_text() for name in _SCRIPTS),
    )
    path = Path(path)
    write_text(path, fill_frame(title or system.name, (folder / "page.css").read_text(), body))
    return path


def _start_of(start: Changes | OperatingPoint | None) -> Start:
    """The start as a study has it."""
    return (lambda _: start) if isinstance(start, OperatingPoint) else start or {}


def _write_shown(interface: Interface, names: Sequence[str], watched: Watched, grid: int) -> str:
    """Sizes of the results, and where the values of the curves are found."""
    states = interface.system.state_names
    places = [
        f"FIRST_STATE + {states.index(name)}"
        if name in states
        else f"FIRST_OUTPUT + {interface.outputs.index(name)}"
        for name in names
    ]
    return (
        f"enum {{ N_SHOWN = {len(names)}, N_TAKEN = {watched.width}, N_ROWS = {grid + 1} }};\n"
        f"static const uint32_t shown_references[] = {{{', '.join(places)}}};\n"
    )


def _panels(run: Trajectory, names: Sequence[str]) -> list[list[int]]:
    """Which curves share a panel: those that `plot` draws together."""
    told = {name: (run.system.quantity(name).unit, "", run[name]) for name in names}
    picture = draw_over_time("", (run.t, "s"), told, (), all_of_them=True)
    return [
        [names.index(item.label) for item in panel.items if isinstance(item, Curve)]
        for panel in picture.panels
    ]


def _ranges(watched: Watched) -> list[dict[str, Any]]:
    """Where equations hold, and which functionals tell whether they did."""
    found = []
    for held, (high, low) in watched.extremes:
        own = held.range
        found.append(
            {
                "high": high,
                "low": low,
                "from": own.low,
                "to": own.high,
                "words": f"{held.label}: {own.name} lies outside {number(own.low, 6)} to "
                f"{number(own.high, 6)} {own.unit}, for which its equations hold. {own.advice}.",
            }
        )
    return found


def _event_words(system: System) -> dict[str, list[Any]]:
    """Names of conditions, holds and functions of time, and what each position means.

    What changes because another function of time does, one of its `needs`, is not told.
    """
    s = system.switching

    def words(condition: Condition) -> dict[str, Any]:
        pieces = condition.pieces
        numbers = np.arange(2 if pieces is None else pieces.count)
        if pieces is not None and pieces.period is not None:
            left, begins = condition.relation.sides[0], pieces.begin(numbers).tolist()
            found = {"left": left, "begins": begins, "period": pieces.period}
        else:
            texts = condition.texts(numbers)
            found = {"words": dict(zip(map(str, numbers.tolist()), texts, strict=True))}
        return {"name": condition.name} | found

    timed = [
        words(condition) | {"told": condition.relation.told, "needs": needs}
        for condition, needs in zip(s.timed, s.needs, strict=True)
    ]
    holds = [
        {"name": name, "words": dict(zip(map(str, POSITIONS), hold_words(s, h), strict=True))}
        for h, name in enumerate(s.names)
    ]
    return {"0": [*map(words, s.conditions)], "1": holds, "2": timed}


def _find_numbers(
    system: System, names: Sequence[str], wanted: Iterable[Functional] | Mapping[str, Functional]
) -> dict[str, Functional]:
    """Those that are wanted, then the highest and lowest values of what is drawn, by their texts.

    Raises
    ------
    OptionError
        If one is named twice.
    """
    found: dict[str, Functional] = {}
    if isinstance(wanted, Mapping):
        found |= wanted
    else:
        for each in wanted:
            if str(each) in found:
                raise OptionError(f"{system.name}: live_page: {each} is named twice.")
            found[str(each)] = each
    for name in names:
        for each in (highest(name), lowest(name)):
            found.setdefault(str(each), each)
    return found


def _rule(system: System, watched: Watched, label: str) -> dict[str, Any]:
    """Text and unit of a number, and how it follows from what the loop takes."""
    wanted = watched.of[label]
    return {
        "text": label,
        "unit": wanted.unit(system),
        "missing": watched.missing(label),
        "places": [watched.place(reading)._asdict() for reading in wanted.readings],
        "formula": _javascript(wanted),
    }


def _javascript(functional: Functional) -> str:
    """A functional in JavaScript, of readings ``r[0], r[1], ...``."""
    places = {reading: f"r[{i}]" for i, reading in enumerate(functional.readings)}
    return functional.fold(places.__getitem__, _of_node)


def _of_node(node: Expr, operands: list[str]) -> str:
    if isinstance(node, ConstantExpression):
        return f"({node.value!r})"
    assert isinstance(node, Call)
    if node.op in ("+", "-", "*", "/"):
        return f"({node.op.join(operands)})"
    if node.op == "neg":
        return f"(-{operands[0]})"
    return f"Math.{'pow' if node.op == '**' else node.op}({', '.join(operands)})"
