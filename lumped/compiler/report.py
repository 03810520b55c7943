"""What the reduction of a model did, stage by stage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from lumped.support.text_table import table

__all__ = ["LeftOut", "Report"]


@dataclass(frozen=True)
class LeftOut:
    """Something the system does not compute.

    Attributes
    ----------
    what, why : str
        Name or count, and reason.
    """

    what: str
    why: str

    def __repr__(self) -> str:
        return f"{self.what}: {self.why}"


@dataclass(frozen=True)
class Report:
    """Counts, states and times of a reduction; ``report["states"]`` gives a count.

    Attributes
    ----------
    counts : dict of str to int
        Sizes before and after each stage.
    states : dict of str to str
        Each state, and why it is one.
    blocks : tuple of str
        Unknowns of each block that is solved together.
    implicit : tuple of str
        Unknowns that Newton's method finds.
    left_out : tuple of LeftOut
        What is not computed, and why.
    still : tuple of str
        Ports that are left open and stand still, such as the supports of gears.
    seconds : dict of str to float
        Time of each stage.
    """

    counts: dict[str, int]
    states: dict[str, str]
    blocks: tuple[str, ...]
    implicit: tuple[str, ...]
    left_out: tuple[LeftOut, ...]
    still: tuple[str, ...]
    seconds: dict[str, float]

    def __getitem__(self, name: str) -> int:
        return self.counts[name]

    def __repr__(self) -> str:
        parts = [
            table(("count", ""), [(name, str(n)) for name, n in self.counts.items()]),
            table(("stage", "ms"), [(n, f"{1e3 * s:.1f}") for n, s in self.seconds.items()]),
            _listed("states", [f"{name}: {why}" for name, why in self.states.items()]),
        ]
        if self.blocks:
            parts.append(_listed("solved together", self.blocks))
        if self.implicit:
            parts.append(_listed("found by Newton's method", self.implicit))
        if self.still:
            parts.append(_listed("left open and held still", self.still))
        if self.left_out:
            parts.append(_listed("left out", [repr(item) for item in self.left_out]))
        return "\n\n".join(parts)


def _listed(title: str, items: Sequence[str], most: int = 20) -> str:
    lines = [title, *(f"  {item}" for item in items[:most])]
    if len(items) > most:
        lines.append(f"  ... and {len(items) - most} more")
    return "\n".join(lines)
