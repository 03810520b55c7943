"""Where the equations of a component hold."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from lumped.errors import EquationError, shown
from lumped.language.expression import Expr
from lumped.language.switch import When


class Range(NamedTuple):
    """Values for which the equations of a component hold; a component may yield a plain tuple.

    Analyses refuse points outside.

    Attributes
    ----------
    expression : Expr
        Of the component's own quantities and parameters.
    low, high : float
        Least and largest value.
    unit : str
        Unit of the three.
    name : str
        What the expression is, in words.
    advice : str
        What to do where a value lies outside: a sentence without its full stop.
    """

    expression: Expr
    low: float
    high: float
    unit: str
    name: str
    advice: str


def check_ranges(found: Iterable[tuple[Expr, float, float, str, str, str]]) -> Iterator[Range]:
    """What a component's method `valid` yields.

    Raises
    ------
    EquationError
        If it is no expression, ends, unit, name and advice.
    """
    for each in found:
        good = isinstance(each, tuple) and len(each) == len(Range._fields)
        if not good or not isinstance(each[0], Expr) or not each[1] <= each[2]:
            raise EquationError(
                f"valid() gave {shown(each)}: an expression, the least and the largest value, "
                "their unit, a name and an advice are needed."
            )
        yield Range(*each)


def borders(ranges: Iterable[Range]) -> Iterator[When]:
    """Instants at which ranges are left: a run stops there, and nothing changes."""
    for each in ranges:
        yield When(each.expression > each.high, ())
        yield When(each.expression < each.low, ())
