"""What happens at an instant of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


class Event(NamedTuple):
    """Something that happened during a run.

    Attributes
    ----------
    time : float
        When, s.
    component : str
        Where: a component that changed its mode, or those in which a function of time changes
        its piece.
    kind : {"time", "condition", "hold", "states"}
        What changed: a function of time, a condition on states, a constraint (friction, contact,
        a freewheel), or the choice of states.
    before, after : str
        The mode in words; for states the motion that led and the one that leads.
    loss : float
        Mechanical energy lost in an impact, J.
    """

    time: float
    component: str
    kind: str
    before: str
    after: str
    loss: float = 0.0


@dataclass(frozen=True)
class Change:
    """A component that changed its mode: words for before and after, energy lost in J."""

    component: str
    before: str
    after: str
    loss: float = 0.0
