"""What is known of a function whose results are enclosed: the record."""

from __future__ import annotations

from typing import Annotated

from lumped.code.records import Record
from lumped.code.words import Integers, Numbers


class Enclosed(Record):
    """A function whose results are enclosed (see `enclosure`).

    Attributes
    ----------
    results : int
        How many may be enclosed.
    is_still : int
        Whether states stay at the begin of the step, and only the time moves.
    is_surveyed : int
        Whether what is known of operations holds in the present positions.
    moves, fixed : Integers, Numbers
        Which operations give what moves (below zero: not known yet), and the values of all others.
    needed : Integers
        Numbers of the work vector that are still to be found; zero but in a search.
    rows, row_next : Integers, int
        Operations that results need, the last first, one result after the other; the end of all.
    row_begin, row_number : Integers
        Where those of each result begin (below zero: not found yet), and how many there are; then
        those of all that are open.
    row_first, row_count : int
        Those that are selected.
    is_open, open_count : Integers, int
        Which results are open, and how many.
    models, model : Numbers
        Models of all values, and of the results.
    """

    results: int
    is_still: int
    is_surveyed: int
    moves: Annotated[Integers, "enclosed_rows"]
    fixed: Annotated[Numbers, "enclosed_rows"]
    needed: Annotated[Integers, "enclosed_work"]
    rows: Annotated[Integers, "4 * enclosed_rows"]
    row_next: int
    row_begin: Annotated[Integers, "enclosed_results + 1"]
    row_number: Annotated[Integers, "enclosed_results + 1"]
    row_first: int
    row_count: int
    is_open: Annotated[Integers, "enclosed_results"]
    open_count: int
    models: Annotated[Numbers, "10 * (12 + enclosed_work)"]
    model: Annotated[Numbers, "10 * enclosed_results"]
