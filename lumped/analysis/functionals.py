"""Numbers that a run has for a quantity: what is minimised, bounded or differentiated."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Functional", "final", "mean", "peak", "rms", "swing"]


@dataclass(frozen=True)
class Functional:
    """A number of one quantity over a run.

    Attributes
    ----------
    name : str
        The quantity.
    """

    name: str

    def __str__(self) -> str:
        return f"{type(self).__name__}({self.name})"


class peak(Functional):  # noqa: N801
    """Greatest magnitude ``max |y|``."""


class swing(Functional):  # noqa: N801
    """From trough to crest, ``max y - min y``."""


class rms(Functional):  # noqa: N801
    """Root mean square ``sqrt(1/T integral y^2 dt)``."""


class mean(Functional):  # noqa: N801
    """Mean ``1/T integral y dt``."""


class final(Functional):  # noqa: N801
    """Value at the end."""
