"""Data of a drive in a report on torsional vibrations: what stands where, with units."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from lumped.drawing.page_run import table
from lumped.support.display_units import Shown, Units, display
from lumped.support.text_table import listed, number
from lumped.vibration.order_response import OrderResponse

__all__ = ["Datum", "data", "mass_elastic_table", "others_table", "values"]

_COLUMNS = {"kg.m2": "inertia", "N.m/rad": "stiffness", "N.m.s/rad": "damping", "": "ratio"}
"""Units of the parameters that a table of inertias and stiffnesses has; ratios have none."""


class Datum(NamedTuple):
    """A parameter, with its least and greatest value over the speed."""

    path: str
    name: str
    unit: str
    text: str
    low: float
    high: float
    vibrates: bool
    units: Units

    @property
    def column(self) -> str | None:
        """Unit in the table of inertias and stiffnesses, or None if it does not belong there."""
        if self.unit in _COLUMNS:
            return self.unit
        return "" if self.unit == "1" and self.name.startswith("ratio") else None

    @property
    def shown(self) -> Shown:
        """How it is shown: frequencies of vibrations as such, columns of a table in one unit."""
        name = "" if self.column else f"{self.path}.{self.name}".lstrip(".")
        if self.vibrates:
            hertz = display(name, "Hz", self.units)
            return Shown(hertz.unit, 0.5 / np.pi * hertz.factor)
        return display(name, self.unit, self.units)

    def told(self, digits: int = 6) -> str:
        """The value, or its range."""
        ends = dict.fromkeys(number(self.shown.value(x), digits) for x in (self.low, self.high))
        return " to ".join(ends)


def data(response: OrderResponse, units: Units) -> list[Datum]:
    """All parameters of a drive, as the response took them, to show in some units."""
    parameters = response.system.structure.parameters
    theta = response.rotation.theta
    if (theta == theta[0]).all():
        theta = theta[:1]
    every = np.array([parameters.all(row) for row in theta])
    low, high = every.min(axis=0).tolist(), every.max(axis=0).tolist()
    found = []
    for name, quantity, a, b in zip(parameters.names, parameters.declared, low, high, strict=True):
        path, _, own = name.rpartition(".")
        kind = quantity.unit, quantity.text
        found.append(Datum(path, own, *kind, a, b, quantity.vibrates, units))
    return found


def mass_elastic_table(every: list[Datum], units: Units) -> str:
    """Inertias, stiffnesses, dampings and ratios, a row for each component."""
    rows: dict[str, dict[str, list[Datum]]] = {}
    for datum in every:
        if datum.column is not None:
            rows.setdefault(datum.path, {}).setdefault(datum.column, []).append(datum)
    used = {unit: text for unit, text in _COLUMNS.items() if any(unit in r for r in rows.values())}
    head = ["component"]
    shown = {unit: display("", unit, units).unit for unit in used}
    head += [f"{text}, {shown[unit]}" if unit else text for unit, text in used.items()]
    cells = [(path, *(_cell(row.get(unit, [])) for unit in used)) for path, row in rows.items()]
    return table(head, cells, range(1, len(head)))


def _cell(found: list[Datum]) -> str:
    if len(found) == 1:
        return found[0].told()
    return "; ".join(f"{datum.name} {datum.told()}" for datum in found)


def values(every: list[Datum]) -> dict[str, str]:
    """Inertia and stiffness of each component, in a few characters."""
    found: dict[str, list[str]] = {}
    for datum in every:
        if datum.column == "":
            text = f"i = {datum.told(4)}"
        elif datum.unit in ("kg.m2", "N.m/rad"):
            text = f"{datum.told(4)} {datum.shown[0]}"
        else:
            continue
        found.setdefault(datum.path, []).append(text)
    return {path: texts[0] for path, texts in found.items() if len(texts) == 1}


def others_table(every: list[Datum]) -> str:
    """All other parameters; equal ones of parts that differ by their number only share a row."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for datum in every:
        if datum.column is None:
            shape = re.sub(r"\[\d+\]", "[]", datum.path)
            key = (datum.text, shape, datum.name, datum.told(), datum.shown[0])
            groups.setdefault(key, []).append(datum.path)
    rows = [(key[0], _together(paths), *key[2:]) for key, paths in groups.items()]
    if not rows:
        return "<p>None.</p>"
    return table(("what it is", "of", "parameter", "value", "unit"), rows, (3,))


def _together(paths: list[str]) -> str:
    """Paths that differ by a number, such as "shaft[0 to 7]" or "shaft[0, 2]"."""
    counted = [re.findall(r"\[(\d+)\]", path) for path in paths]
    if len(paths) == 1 or any(len(numbers) != 1 for numbers in counted):
        return listed(paths, 12)
    numbers = [int(own[0]) for own in counted]
    is_run = numbers == list(range(numbers[0], numbers[-1] + 1))
    told = f"{numbers[0]} to {numbers[-1]}" if is_run else ", ".join(map(str, numbers))
    return re.sub(r"\[\d+\]", f"[{told}]", paths[0])
