"""Data of a drive in a report on torsional vibrations: what stands where, with units."""

from __future__ import annotations

import re
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from lumped.drawing.page_frame import prose, table
from lumped.support.display_units import Units, display
from lumped.support.text_table import list_names, number
from lumped.vibration.ordered.order_response import OrderResponse


class Datum(NamedTuple):
    """A parameter, with its least and greatest value over the speed as they are shown.

    One that is free follows from no other.
    """

    path: str
    name: str
    unit: str
    text: str
    low: float
    high: float
    shown: str
    is_free: bool

    def format_value(self, digits: int = 6) -> str:
        """The value, or its range."""
        return " to ".join(dict.fromkeys(number(x, digits) for x in (self.low, self.high)))


def data(response: OrderResponse, units: Units) -> list[Datum]:
    """All parameters of a drive, as the response took them, to show in some units."""
    parameters = response.system.structure.parameters
    theta = response.rotation.theta
    if (theta == theta[0]).all():
        theta = theta[:1]
    every = np.array([parameters.all(row) for row in theta])
    low, high = every.min(axis=0).tolist(), every.max(axis=0).tolist()
    free = set(parameters.free)
    every_one = zip(parameters.names, parameters.declared, low, high, strict=True)
    found = []
    for i, (name, quantity, a, b) in enumerate(every_one):
        path, _, own = name.rpartition(".")
        # an angular frequency is no speed to be shown in 1/min
        shown = display(name, quantity.unit, {} if quantity.vibrates else units)
        ends = shown.value(a), shown.value(b)
        found.append(Datum(path, own, quantity.unit, quantity.text, *ends, shown.unit, i in free))
    return found


def data_table(every: list[Datum]) -> str:
    """All parameters that follow from no other.

    Equal ones of parts that differ by their number only share a row.
    """
    groups: dict[tuple[str, ...], list[str]] = {}
    for datum in filter(attrgetter("is_free"), every):
        shape = re.sub(r"\[\d+\]", "[]", datum.path)
        key = (datum.text, shape, datum.name, datum.format_value(), datum.shown)
        groups.setdefault(key, []).append(datum.path)
    rows = [(key[0], _together(paths), *key[2:]) for key, paths in groups.items()]
    if not rows:
        return prose("None.")
    return table(("what it is", "of", "parameter", "value", "unit"), rows, (3,))


def _together(paths: list[str]) -> str:
    """Paths that differ by a number, such as "shaft[0 to 7]" or "shaft[0, 2]"."""
    counted = [re.findall(r"\[(\d+)\]", path) for path in paths]
    if len(paths) == 1 or any(len(numbers) != 1 for numbers in counted):
        return list_names(paths, 12)
    numbers = [int(own[0]) for own in counted]
    is_run = numbers == list(range(numbers[0], numbers[-1] + 1))
    told = f"{numbers[0]} to {numbers[-1]}" if is_run else ", ".join(map(str, numbers))
    return re.sub(r"\[\d+\]", f"[{told}]", paths[0])
