"""Rounds in which what is wrong changes, until nothing is.

All that is wrong changes at once while that helps, then the first alone, until there is less than
ever before. That ends for any inertias (Judice and Pires, Computers and Operations Research 21
(1994) 587; Murty's rule).
"""

from __future__ import annotations

from lumped.code.records import Record
from lumped.code.words import kernel

__all__ = ["Rounds", "begin_rounds", "may_change"]

_PATIENCE = 6
"""Rounds in which all that is wrong changes at once although it has not become less."""
_MANY = 1 << 40


class Rounds(Record):
    """How much was wrong at best, and the rounds left in which all of it changes."""

    fewest: int
    patience: int


@kernel
def begin_rounds(rounds: Rounds) -> None:
    """Nothing has been tried yet."""
    rounds.fewest, rounds.patience = _MANY, _PATIENCE


@kernel
def may_change(rounds: Rounds, wrong: int) -> int:
    """How many of those that are wrong change in this round; the first of them do."""
    if wrong < rounds.fewest:
        rounds.fewest, rounds.patience = wrong, _PATIENCE
        return wrong
    if rounds.patience > 0:
        rounds.patience -= 1
        return wrong
    return 1
