"""Sections of a report on torsional vibrations, as HTML."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape

import numpy as np

from lumped.drawing.inline import inline
from lumped.drawing.inline_schematic import inline_schematic
from lumped.drawing.page_frame import Section, prose, table
from lumped.drawing.page_run import events
from lumped.drawing.part_values import part_texts
from lumped.drawing.torsional_assumptions import assumptions
from lumped.drawing.torsional_data import choices_table, data, data_table
from lumped.drawing.torsional_figures import (
    campbell_figure,
    heat_figure,
    order_figure,
    run_figures,
    synthesis_figure,
)
from lumped.drawing.torsional_modes import holzer_tables, mass_elastic_table, natural_frequencies
from lumped.drawing.torsional_study import Study
from lumped.support.display_units import display, time_unit
from lumped.support.text_table import count_words, number

_SMALL = 0.01
"""Amplitude over that of the largest order, from which on an order is listed."""


def lead(study: Study, about: Mapping[str, str | Sequence[str]]) -> str:
    """Data of the title, and the verdict in a line."""
    rows = [(k, v if isinstance(v, str) else "; ".join(v)) for k, v in about.items()]
    title = table(("", ""), rows) if rows else ""
    results = [result for found in study.verdicts.values() for result in found.results]
    if not results:
        return f"{title}\n{prose('No limit was given.')}\n"
    kept = sum(result.passed for result in results)
    word = "Passed" if kept == len(results) else "FAILED"
    return f"{title}\n<p><b>{word}: {kept} of {len(results)} limits kept.</b></p>\n"


def sections(study: Study, stated: Iterable[str]) -> Iterator[Section]:
    """All sections in order."""
    every = data(study.first, study.units)
    yield "Verdict", _verdict(study) if study.verdicts else ""
    name = f"Schematic of {study.system.name}"
    texts = part_texts(study.system, study.first.rotation.theta, study.units)
    yield "Schematic", inline_schematic(study.system, texts, name, "schematic")
    yield "Inertias and stiffnesses", mass_elastic_table(study)
    yield "Natural frequencies and mode shapes", natural_frequencies(study)
    yield "Holzer tables", holzer_tables(study)
    yield "Critical speeds", _critical(study)
    for i, output in enumerate(study.outputs):
        yield f"Order response: {output}", _response(study, output, f"response-{i}")
    yield "Dissipated power", _heat(study) if study.heat else ""
    yield "Transients", _runs(study)
    yield "Data", "\n".join((data_table(every), choices_table(study.system)))
    yield "Assumptions and accuracy", assumptions(study, stated)


def _verdict(study: Study) -> str:
    rows = [
        (
            *(caption or "response", result.name, result.quantity, result.measure),
            *result.format_values(study.units, 5),
            f"{100 * result.utilisation:.1f}",
            "" if np.isnan(result.speed) else number(study.speed.value(result.speed), 5),
            "yes" if result.passed else "NO",
            " ".join(part for part in (result.clause, result.source) if part),
        )
        for caption, found in study.verdicts.items()
        for result in found.results
    ]
    head = (
        *("case", "limit", "quantity", "measure", "value", "permitted", "unit", "used, %"),
        *(f"at, {study.speed.unit}", "kept", "where it stands"),
    )
    lines = [table(head, rows, (4, 5, 7, 8))]
    for caption, found in study.verdicts.items():
        if found.barred:
            ranges = "; ".join(each.format_range(study.speed) for each in found.barred)
            lines.append(prose(f"Speeds to bar, {caption or 'response'}: {ranges}."))
        lines += [prose(f"{caption or 'response'}: {note}.") for note in found.notes]
    return "\n".join(lines)


def _critical(study: Study) -> str:
    found = study.campbell
    parts = [inline(campbell_figure(study), "Natural frequencies and orders", "campbell")]
    speed, frequency = study.speed, study.frequency
    head = [f"speed, {speed.unit}", "order", "mode", f"natural frequency, {frequency.unit}"]
    rows = []
    for each in found.critical:
        row = [number(speed.value(each.speed)), number(each.order), str(each.mode + 1)]
        rows.append([*row, number(frequency.value(each.hertz))])
    if study.operation is not None:
        head.append("distance from operation, %")
        for row, each in zip(rows, found.critical, strict=True):
            row.append(f"{100 * study.distance(each):.1f}")
    listed = table(head, rows, range(len(head)))
    parts.append(listed if rows else prose("There is no critical speed of these orders."))
    low, high = speed.value(found.speeds[[0, -1]])
    between = f"from {number(low)} to {number(high)} {speed.unit}"
    left_out = ", ".join(map(number, study.orders_left_out))
    parts.append(
        prose(
            f"These are all critical speeds {between} of "
            f"{count_words(len(found.orders), 'order')}: {', '.join(map(number, found.orders))}."
            + f" Left out of those of the responses: {left_out}."
            * bool(left_out)
        )
    )
    return "\n".join(parts)


def _response(study: Study, output: str, key: str) -> str:
    shown, speed = study.choose_unit(output), study.speed
    rows = []
    for caption, response in study.having(output).items():
        both, mean = response.synthesis(output), response.mean(output)
        row = [caption or "response"]
        for size in (both.maximum, both.half_range, both.sum):
            at = speed.value(response.speeds[size.argmax()])
            row += [number(shown.value(size.max()), 5), number(at, 5)]
        low, high = shown.value(mean.min()), shown.value(mean.max())
        rows.append([*row, *(number(end if abs(end) > 1e-9 else 0.0, 5) for end in (low, high))])
    where = f"at, {speed.unit}"
    sizes = f"maximum, {shown.unit}", where, "half range", where, "sum of amplitudes", where
    head = ("case", *sizes, "least mean", "greatest mean")
    return "\n".join(
        (
            inline(order_figure(study, output), f"{output}: largest orders", f"{key}-orders"),
            inline(synthesis_figure(study, output), f"{output}: all orders", f"{key}-all"),
            table(head, rows, range(1, len(head))),
            _orders(study, output),
        )
    )


def _orders(study: Study, output: str) -> str:
    """Largest amplitude of each order, the responses side by side."""
    shown, speed = study.choose_unit(output), study.speed
    sizes = study.measure_orders(output)
    top = max(size for own in sizes.values() for size, _ in own.values())
    every = sorted({order for own in sizes.values() for order in own})
    listed = [x for x in every if any(o.get(x, (0.0,))[0] >= _SMALL * top for o in sizes.values())]
    head = ["order"]
    for caption in sizes:
        head.append(f"{caption}: {shown.unit}" if caption else f"amplitude, {shown.unit}")
        head.append(f"at, {speed.unit}")
    rows = []
    for order in listed if top else []:
        row = [f"{order:g}"]
        for own in sizes.values():
            size, at = own.get(order, (0.0, 0.0))
            texts = number(shown.value(size), 5), number(speed.value(at))
            row += texts if order in own else ("", "")
        rows.append(row)
    left = len(every) - len(rows)
    note = (
        prose(f"{count_words(left, 'more order')} below {_SMALL:.0%} of the largest.")
        if left
        else ""
    )
    return table(head, rows, range(len(head))) + note


def _heat(study: Study) -> str:
    rows = []
    for caption, parts in study.heat.items():
        for part, power in parts.items():
            k = int(power.argmax())
            at = number(study.speed.value(study.responses[caption].speeds[k]))
            largest = number(study.power.value(power[k]), 5)
            rows.append((caption or "response", part, largest, at))
    head = ("case", "part", f"largest mean power, {study.power.unit}", f"at, {study.speed.unit}")
    picture = inline(heat_figure(study), "Mean dissipated power", "heat")
    return f"{picture}\n{table(head, rows, (2, 3))}"


def _runs(study: Study) -> str:
    parts, time = [], time_unit(study.units)
    for i, (caption, run) in enumerate(study.runs.items()):
        names = {name: run.system.quantity(name).unit for name in study.find_watched(caption)}
        rows = []
        for name, unit in names.items():
            shown = display(name, unit, study.units)
            row = [name, shown.unit]
            for k in (int(run[name].argmax()), int(run[name].argmin())):
                row += [number(shown.value(run[name][k]), 5), number(time.value(run.t[k]), 5)]
            rows.append(row)
        where = f"at, {time.unit}"
        head = ("quantity", "unit", "greatest", where, "least", where)
        limits = study.limits.get(caption, ())
        figures = enumerate(run_figures(run, names, limits, study.units))
        drawn = "\n".join(inline(figure, caption, f"run-{i}-{k}") for k, figure in figures)
        told = table(head, rows, range(2, 6))
        parts.append(f"<h3>{escape(caption)}</h3>\n{drawn}{told}")
        if run.events:
            parts.append(events({"Events": run}, study.units))
    return "\n".join(parts)
