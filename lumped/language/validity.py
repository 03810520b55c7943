"""Where the equations of a component hold."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from lumped.language.expression import Expr
from lumped.language.switch import When

__all__ = ["Range", "borders"]


class Range(NamedTuple):
    """Values for which the equations of a component hold.

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


def borders(ranges: Iterable[Range]) -> Iterator[When]:
    """Instants at which ranges are left: a run stops there, and nothing changes."""
    for each in ranges:
        yield When(each.expression > each.high, ())
        yield When(each.expression < each.low, ())
