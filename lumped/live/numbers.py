"""Numbers of a run that the page shows, and how it finds them in what the loop takes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from lumped.compiler.system import System
from lumped.ensembles.watched import Collected, Watched
from lumped.errors import OptionError
from lumped.simulation.functional_kinds import Peak

__all__ = ["rules", "watched_numbers"]


def watched_numbers(
    system: System, names: Sequence[str], wanted: Iterable[Collected] | Mapping[str, Collected]
) -> dict[str, Collected]:
    """Those that are wanted, then the highest and lowest values of what is drawn, by their texts.

    Raises
    ------
    OptionError
        If one is named twice.
    """
    found: dict[str, Collected] = {}
    if isinstance(wanted, Mapping):
        found |= wanted
    else:
        for each in wanted:
            if str(each) in found:
                raise OptionError(f"{system.name}: live_page: {each} is named twice.")
            found[str(each)] = each
    for name in names:
        for kind in ("highest", "lowest"):
            found.setdefault(f"{kind}({name})", Peak(name, kind))
    return found


def rules(system: System, watched: Watched) -> list[dict[str, Any]]:
    """Text and unit of each number, and how it follows from what the loop takes."""
    return [
        {
            "text": label,
            "unit": wanted.unit(system),
            "missing": watched.missing(label),
            **watched.reading(label)._asdict(),
        }
        for label, wanted in watched.of.items()
    ]
