"""Rounds in which wrong items change, until none is wrong.

All wrong items change at once while their number falls, then only the first one, until fewer are
wrong than ever before. This ends for any inertias (Judice and Pires, Computers and Operations
Research 21 (1994) 587; Murty's rule).
"""

from __future__ import annotations

from lumped.code.records import Record
from lumped.code.words import kernel

_PATIENCE = 6
"""Rounds in which all wrong items change at once although their number has not fallen."""
_MANY = 1 << 40


class Rounds(Record):
    """The least number of wrong items so far, and the rounds left in which all change."""

    fewest: int
    patience: int


@kernel
def begin_rounds(rounds: Rounds) -> None:
    """Nothing has been tried yet."""
    rounds.fewest, rounds.patience = _MANY, _PATIENCE


@kernel
def may_change(rounds: Rounds, wrong: int) -> int:
    """How many of the wrong items change in this round, beginning with the first."""
    if wrong < rounds.fewest:
        rounds.fewest, rounds.patience = wrong, _PATIENCE
        return wrong
    if rounds.patience > 0:
        rounds.patience -= 1
        return wrong
    return 1
