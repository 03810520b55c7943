"""Rows of numbers that are given to components."""

from __future__ import annotations

from itertools import pairwise

from lumped.errors import EquationError, shown
from lumped.language.value_types import Rows

__all__ = ["check_ascending", "check_rows"]


def check_rows(
    name: str, rows: Rows, meaning: str, example: str, width: int = 2, least: int = 1
) -> list[tuple[float, ...]]:
    """Rows of finite numbers.

    Parameters
    ----------
    name : str
        What messages call them.
    rows : rows
        What was given.
    meaning, example : str
        What a row holds, and rows that make sense.
    width, least : int
        Numbers in a row, and least number of rows.

    Returns
    -------
    list of tuple of float

    Raises
    ------
    EquationError
        If there are too few, or they are no such rows.
    """
    try:
        found = [tuple(float(x) for x in row) for row in rows]
    except (TypeError, ValueError):
        found = []
    finite = all(abs(x) < float("inf") for row in found for x in row)
    if len(found) < least or not finite or any(len(row) != width for row in found):
        count = "rows" if least == 1 else f"{least} rows or more"
        raise EquationError(
            f"{name} = {shown(rows)}: {count} of {meaning} are needed, finite numbers, such as "
            f"{example}."
        )
    return found


def check_ascending(name: str, what: str, values: list[float], unit: str = "") -> None:
    """Refuse values that do not increase.

    Parameters
    ----------
    name, what, unit : str
        What messages call the rows and the values, and the unit of these.
    values : list of float
        One after the other.

    Raises
    ------
    EquationError
        If one is not above that before it.
    """
    for before, after in pairwise(values):
        if not after > before:
            raise EquationError(
                f"{name}: the {what} must increase, but {before:g} -> {after:g}"
                f"{unit and ' ' + unit}."
            )
