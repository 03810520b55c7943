"""What each picture of the page shows, as numbers and texts: nothing here knows the page."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from lumped.compiler.system import System
from lumped.drawing.part_values import part_texts
from lumped.errors import OptionError
from lumped.explorer.sliders import Slider
from lumped.explorer.study import Moment, Study, effects_on_run
from lumped.support.text_table import number
from lumped.timeloop.results.trajectory import Trajectory
from lumped.vibration.natural.eigen_sensitivity import eigen_sensitivity
from lumped.vibration.ordered.order_amplitudes import OrderAmplitudes
from lumped.vibration.responses.response import FrequencyResponse
from lumped.vibration.rules.verdict import verdict
from lumped.vibration.speeds.campbell import Campbell

Shown = dict[str, dict[str, Any]]
"""Tables by their names: equally long columns, or the texts of parts."""
_MODES = 4
"""Modes that are drawn."""
_FIRST = 0.1
"""Of the first part that moves so much the amplitude is positive, so that shapes do not flip."""
_EFFECTS = 3
"""Modes whose sensitivities are drawn."""
_EVENTS = 12
"""Events that are listed."""


@dataclass(frozen=True)
class View:
    """A picture.

    Attributes
    ----------
    kind : str
        How it is drawn: schematic, modes, effects, run, verdict, curves.
    title : str
        What stands above it.
    compute : callable
        Its tables, of a moment and the sliders.
    """

    kind: str
    title: str
    compute: Callable[[Moment, Sequence[Slider]], Shown]


def views(study: Study) -> tuple[View, ...]:
    """All pictures of a study, those that are made quickly first."""
    found = [
        View("schematic", "Schematic", _schematic),
        View("modes", "Natural frequencies and mode shapes", _modes),
        View("effects", "Sensitivities", _effects),
    ]
    if study.until is not None:
        found.append(View("run", "Run", _run))
    if study.limits:
        found.append(View("verdict", "Limits", _verdict))
    if study.inputs:
        title = f"Response to {', '.join(study.inputs)}"
        found.append(View("curves", title, lambda m, _: _response(m.response)))
    for title in study.analyses:
        found.append(View("curves", title, partial(_analysis, title)))
    return tuple(found)


# -- drive ---------------------------------------------------------------------------------------


def _schematic(moment: Moment, _: Sequence[Slider]) -> Shown:
    system = moment.study.system
    return {"texts": part_texts(system, system.theta(moment.parameters))}


# -- vibration -----------------------------------------------------------------------------------


def _modes(moment: Moment, _: Sequence[Slider]) -> Shown:
    found = moment.modes
    count = min(len(found.hertz), _MODES)
    if not count:
        raise OptionError(f"{found.system.name}: no oscillating mode.")
    names = found.angles
    # where parts have phases, amplitudes in the phase of the largest
    shapes = np.array([found.shape(name)[:count] for name in names]).real
    first = (np.abs(shapes) > _FIRST).argmax(axis=0)
    shapes *= np.sign(shapes[first, np.arange(count)])
    pairs = zip(found.hertz[:count].tolist(), found.damping[:count].tolist(), strict=True)
    labels = [f"{number(f, 5)} Hz, D = {number(d + 0.0, 3)}" for f, d in pairs]
    return {
        "shapes": {
            "x": [list(range(len(names)))] * count,
            "y": [column.tolist() for column in shapes.T],
            "label": labels,
            "number": [str(k + 1) for k in range(count)],
        },
        "parts": {"x": list(range(len(names))), "name": names},
        "hertz": {"hertz": found.hertz.tolist(), "damping": found.damping.tolist()},
    }


def _effects(moment: Moment, sliders: Sequence[Slider]) -> Shown:
    names = [each.name for each in sliders]
    count = min(len(moment.modes.hertz), _EFFECTS)
    if count:
        slopes = eigen_sensitivity(moment.modes, by=names)
        shares = [np.nan_to_num(slopes.relative[k]).tolist() for k in range(count)]
        kinds = {f"frequency {k + 1}": own for k, own in enumerate(shares)}
    elif moment.study.until is not None:
        effects = effects_on_run(moment, names)
        kinds = {"run": [effects[name] for name in names]}
    else:
        raise OptionError(f"{moment.study.system.name}: no oscillating mode and no run.")
    return {"effects": {"name": names, **kinds}}


def _curves(x: Any, y: Mapping[str, Any], labels: tuple[str, str], scale: str = "linear") -> Shown:
    """Curves over one axis by what they are, and what stands at both axes."""
    return {
        "curves": {"x": [x] * len(y), "y": [*y.values()], "label": [*y]},
        "axes": {"x": [labels[0]], "y": [labels[1]], "scale": [scale]},
    }


def _list_units(system: System, names: Sequence[str]) -> str:
    return " or ".join(sorted({system.quantity(name).unit for name in names}))


def _response(found: FrequencyResponse) -> Shown:
    several = len(found.inputs) > 1
    sizes = {
        f"{o} to {i}" if several else o: found.magnitude(o, i)
        for o in found.outputs
        for i in found.inputs
    }
    size = f"amplitude, {_list_units(found.system, found.outputs)} for each unit"
    return _curves(found.hertz, sizes, ("frequency, Hz", size), "log")


def _analysis(title: str, moment: Moment, _: Sequence[Slider]) -> Shown:
    found = moment.analysis(title)
    if isinstance(found, FrequencyResponse):
        return _response(found)
    if isinstance(found, Campbell):
        return _campbell(found)
    sizes = {name: found.synthesis(name).maximum for name in found.of}
    size = f"largest vibration, {_list_units(found.system, found.of)}"
    return _curves(found.rpm, sizes, ("speed, 1/min", size))


def _campbell(found: Campbell) -> Shown:
    rpm = found.speeds * 30 / np.pi
    reach = max(found.orders, default=0.0) * float(rpm[-1]) / 60
    above = np.nanmin(found.hertz, axis=0, initial=np.inf) > reach
    # of modes that no order reaches, the lowest
    modes = [*found.hertz.T[: np.append(np.flatnonzero(above), len(above))[0] + 1]]
    top = 1.15 * float(np.nanmax(modes, initial=0.0))
    ends = [_end(order, float(rpm[-1]), top) for order in found.orders]
    hertz = {f"mode {k + 1}": mode for k, mode in enumerate(modes)}
    return _curves(rpm, hertz, ("speed, 1/min", "frequency, Hz")) | {
        "rays": {
            "x": [[0.0, x] for x, _ in ends],
            "y": [[0.0, y] for _, y in ends],
            "label": [f"{order:g}" for order in found.orders],
            "end_x": [x for x, _ in ends],
            "end_y": [y for _, y in ends],
        },
        "critical": {
            "x": [c.rpm for c in found.critical],
            "y": [c.hertz for c in found.critical],
        },
    }


def _end(order: float, rpm: float, top: float) -> tuple[float, float]:
    """Where the ray of an order leaves a picture of some width and height."""
    high = order * rpm / 60
    return (rpm, high) if high <= top or not high else (rpm * top / high, top)


# -- run -----------------------------------------------------------------------------------------


def _run(moment: Moment, _: Sequence[Slider]) -> Shown:
    run, of = moment.run, moment.study.of
    table = run.table(of)
    events = [event for event in run.events if event.after]
    told = [
        f"{number(1e3 * e.time, 5)} ms {e.component}: {e.before} → {e.after}"
        for e in events[:_EVENTS]
    ]
    if len(events) > _EVENTS:
        told.append(f"and {len(events) - _EVENTS} more")
    return {
        "curves": {
            "t": run.t,
            **dict(zip(of, map(np.ascontiguousarray, table.T), strict=True)),
        },
        "events": {"t": [e.time for e in events]},
        "told": {"text": told or ["no events"]},
    }


def _verdict(moment: Moment, _: Sequence[Slider]) -> Shown:
    judged = verdict(_find_judged(moment), moment.study.limits)
    results = judged.results
    return {
        "limits": {
            "name": [r.name for r in results],
            "quantity": [r.quantity for r in results],
            "value": [f"{number(r.value, 4)} {r.unit}" for r in results],
            "permitted": [f"{number(r.permitted, 4)} {r.unit}" for r in results],
            "used": [r.utilisation for r in results],
        }
    }


def _find_judged(moment: Moment) -> Trajectory | OrderAmplitudes:
    """The run, or where there is none the first order response."""
    if moment.study.until is not None:
        return moment.run
    for title in moment.study.analyses:
        found = moment.analysis(title)
        if isinstance(found, OrderAmplitudes):
            return found
    raise OptionError(
        "explore: limits are those of a run or of an order response: give `until`, or one among "
        "`analyses`."
    )
