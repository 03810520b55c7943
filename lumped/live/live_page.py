"""`live_page`: a model, its time loop and its sliders in one file for a browser."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from lumped.compiler.assemble import assemble
from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError
from lumped.exchange.interface import uneven_clocks
from lumped.explorer.sliders import Ends, Slider
from lumped.explorer.sliders import sliders as sliders_of
from lumped.explorer.study import Start, Study, most_effective
from lumped.explorer.views import find_shown_parameters, format_parameter
from lumped.functionals.functional import Functional, watching
from lumped.language.component import Component
from lumped.live.numbers import find_numbers, rules
from lumped.live.run_code import run_code
from lumped.many_runs.watched import POSITIONS, Watched
from lumped.plots.over_time import over_time
from lumped.plots.picture import Curve
from lumped.simulation.simulate import simulate
from lumped.support.arguments import checked
from lumped.support.text_table import number
from lumped.support.units import read_time
from lumped.support.whole_files import write_text
from lumped.timeloop.holds import hold_words
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Trajectory

_CURVES = 5
"""States that are shown, if nothing is named."""
_MOST_ROWS = 20_000


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
    end = read_time(until, "until")
    if not end > 0:
        raise OptionError(f"live_page: until = {until!r} s: a positive, finite time is needed.")
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
    theta = system.theta(changed)
    base = {name: float(theta[system.places([name])[0]]) for name in changed}
    names = [
        system.key(name) for name in (system.state_names[:_CURVES] if plots is None else plots)
    ]
    if not names:
        raise OptionError(f"{system.name}: live_page: name quantities to draw, with `plots`.")
    if sliders is None:
        moved = most_effective(Study(system, base, end, _start_of(start), tuple(names), (), (), {}))
    else:
        moved = sliders_of(system, theta, sliders)
    wanted = find_numbers(system, names, numbers)
    system = watching(system, wanted.values())
    watched = Watched(system, wanted, 0.0, end)
    code = run_code(system, names, watched, start, rtol, grid)
    options: dict[str, Any] = {"until": end, "start": start, "rtol": rtol, "method": "steps"}
    first = simulate(system, parameters=parameters, grid=grid, **options)
    texts = _write_part_texts(system, theta)
    data = {
        "name": system.name,
        "until": end,
        "grid": grid,
        "parameters": _parameters(system, theta),
        "sliders": [_slider(system, each) for each in moved],
        "quantities": [_quantity(system, name) for name in names],
        "panels": _panels(first, names),
        "numbers": rules(system, watched),
        "ranges": _ranges(watched),
        "events": _event_words(system),
        "parts": texts,
    }
    from lumped.drawing.inline import inline
    from lumped.drawing.schematic import schematic

    told = {part: found["text"] for part, found in texts.items()}
    page = _page(
        title or system.name,
        text,
        inline(schematic(system.model, values=told), system.name, "s"),
        data,
        code,
    )
    path = Path(path)
    write_text(path, page)
    return path


def _start_of(start: Changes | OperatingPoint | None) -> Start:
    """The start as a study has it."""
    return (lambda _: start) if isinstance(start, OperatingPoint) else start or {}


def _parameters(system: System, theta: np.ndarray) -> list[dict[str, Any]]:
    p = system.structure.parameters
    return [
        {"name": p.names[i], "unit": p.declared[i].unit, "value": value}
        for i, value in zip(p.free, theta.tolist(), strict=True)
    ]


def _slider(system: System, each: Slider) -> dict[str, Any]:
    (place,) = system.places([each.name])
    return {
        "place": place,
        "text": each.text,
        "low": each.low,
        "high": each.high,
        "isRatio": each.is_ratio,
        "default": each.default,
    }


def _quantity(system: System, name: str) -> dict[str, str]:
    found = system.quantity(name)
    return {"name": name, "unit": found.unit, "text": found.text}


def _panels(run: Trajectory, names: Sequence[str]) -> list[list[int]]:
    """Which curves share a panel: those that `plot` draws together."""
    told = {name: (run.system.quantity(name).unit, "", run[name]) for name in names}
    picture = over_time("", (run.t, "s"), told, (), all_of_them=True)
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
    """Names of conditions and holds, and what each position means."""
    s = system.switching
    conditions = []
    for k, condition in enumerate(s.conditions):
        count = 2 if condition.pieces is None else condition.pieces.count
        words = {str(mode): s.relation_text(k, mode)[1] for mode in range(count)}
        conditions.append({"name": condition.name, "words": words})
    holds = [
        {"name": name, "words": dict(zip(map(str, POSITIONS), hold_words(s, h), strict=True))}
        for h, name in enumerate(s.names)
    ]
    return {"0": conditions, "1": holds}


def _write_part_texts(system: System, theta: np.ndarray) -> dict[str, dict[str, Any]]:
    """What the schematic says of each part: the place of a parameter that can move, and a text."""
    own = _parameters(system, theta)
    values = {entry["name"]: entry["value"] for entry in own}
    names = list(values)
    p = system.structure.parameters
    units = dict(zip(p.names, (declared.unit for declared in p.declared), strict=True))
    return {
        part: {
            "place": names.index(name) if name in values else None,
            "text": format_parameter(name, value, units[name]),
        }
        for part, (name, value) in find_shown_parameters(system, values).items()
    }


def _page(title: str, text: str, drawing: str, data: dict[str, Any], code: bytes) -> str:
    folder = files("lumped.live")
    parts = {
        "title": escape(title),
        "text": f"<p>{escape(text)}</p>" if text else "",
        "style": (folder / "page.css").read_text(),
        "schematic": drawing,
        "data": json.dumps(data, ensure_ascii=False).replace("</", "<\\/"),
        "code": base64.b64encode(code).decode(),
        "numbers": (folder / "numbers.js").read_text(),
        "pictures": (folder / "pictures.js").read_text(),
        "script": (folder / "page.js").read_text(),
    }
    page = (folder / "page.html").read_text()
    for name, part in parts.items():
        page = page.replace(f"<!--{name}-->", part, 1)
    return page
