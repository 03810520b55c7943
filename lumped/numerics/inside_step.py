"""States inside a step."""

from __future__ import annotations

from typing import Any, Literal

__all__ = ["Method", "interpolated"]

Method = Literal["explicit", "implicit"]


def interpolated(method: Method, fraction: Any, before: Any, after: Any, columns: list[Any]) -> Any:
    """The dense output of a step, in numbers or symbols."""
    rest = 1 - fraction
    if method == "implicit":
        inner = columns[0] + fraction * (columns[1] + fraction * columns[2])
        return rest * before + fraction * (after + rest * inner)
    y = 0.0 * before
    for i in range(7):
        y = (y + columns[6 - i]) * (fraction if i % 2 == 0 else rest)
    return before + y
