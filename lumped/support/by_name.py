"""Results that answer to names."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any


class ByName:
    """Names what ``found[name]`` takes: ``name in found``, ``list(found)``, ``len(found)``.

    Notebooks complete the names after ``found["``.
    """

    def _names(self) -> Sequence[Any]:
        raise NotImplementedError

    def __contains__(self, name: Any) -> bool:
        return name in self._names()

    def __iter__(self) -> Iterator[Any]:
        return iter(self._names())

    def __len__(self) -> int:
        return len(self._names())

    def _ipython_key_completions_(self) -> list[Any]:
        return [*self._names()]
