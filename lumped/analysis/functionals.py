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


@dataclass(frozen=True)
class frequency:  # noqa: N801
    """Natural frequency of a mode, Hz; modes count from 0, the lowest first."""

    mode: int

    def __str__(self) -> str:
        return f"frequency({self.mode})"


@dataclass(frozen=True)
class damping:  # noqa: N801
    """Damping ratio of a mode."""

    mode: int

    def __str__(self) -> str:
        return f"damping({self.mode})"


@dataclass(frozen=True)
class clearance:  # noqa: N801
    """Least relative distance ``|f / excitation - 1|`` of all modes from excitations, Hz.

    Each frequency stays on the side of each excitation on which the search begins.
    """

    excitations: tuple[float, ...]

    def __str__(self) -> str:
        return f"clearance({', '.join(f'{f:g}' for f in self.excitations)})"
