"""Data of a drive in a report on torsional vibrations: what stands where, with units."""

from __future__ import annotations

import re
from collections.abc import Sequence
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from lumped.compiler.system import System
from lumped.drawing.page_frame import prose, table
from lumped.language.declared import fields_of, values_of
from lumped.support.display_units import Units, display
from lumped.support.text_table import list_names, number
from lumped.vibration.ordered.order_response import OrderResponse

_ROWS = 40
"""Rows of a table that are told."""


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


def choices_table(system: System) -> str:
    """What components were given that is no parameter: tables, orders, kinds; empty without any.

    What a component only hands on to its parts stands once.
    """
    groups: dict[tuple[str, str, str], list[str]] = {}
    known: set[tuple[str, str, str]] = set()
    for node in system.structure.tree.instances:
        given = values_of(node.component)
        for name in fields_of(type(node.component)):
            text = _write(given[name]) if name in given else ""
            known.add((node.path, name, text))
            if text and (node.path.rpartition(".")[0], name, text) not in known:
                shape = re.sub(r"\[\d+\]", "[]", node.path)
                groups.setdefault((shape, name, text), []).append(node.path)
    rows = [(_together(paths), name, text) for (_, name, text), paths in groups.items()]
    return table(("of", "choice", "as given, in SI units"), rows) if rows else ""


def _write(value: object) -> str:
    """A choice in words; tables row by row."""
    if not isinstance(value, Sequence) or isinstance(value, str):
        return str(value)
    rows = [
        " ".join(number(x) if isinstance(x, float) else str(x) for x in row)
        if isinstance(row, Sequence) and not isinstance(row, str)
        else str(row)
        for row in value
    ]
    return "; ".join(rows[:_ROWS]) + f"; and {len(rows) - _ROWS} more rows" * (len(rows) > _ROWS)


def _together(paths: list[str]) -> str:
    """Paths that differ by a number, such as "shaft[0 to 7]" or "shaft[0, 2]"."""
    counted = [re.findall(r"\[(\d+)\]", path) for path in paths]
    if len(paths) == 1 or any(len(numbers) != 1 for numbers in counted):
        return list_names(paths, 12)
    numbers = [int(own[0]) for own in counted]
    is_run = numbers == list(range(numbers[0], numbers[-1] + 1))
    told = f"{numbers[0]} to {numbers[-1]}" if is_run else ", ".join(map(str, numbers))
    return re.sub(r"\[\d+\]", f"[{told}]", paths[0])
