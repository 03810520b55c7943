"""Results that answer to names."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from lumped.errors import UnknownNameError, nearest


def find_place(name: str, known: Sequence[str], fault: str) -> int:
    """Place of a name among those of a result.

    Parameters
    ----------
    fault : str
        What is said of a name that is none of them, such as ``"was not asked for"``.

    Raises
    ------
    UnknownNameError
        With the nearest name.
    """
    if name not in known:
        raise UnknownNameError(f"'{name}' {fault}. {nearest(name, known)}")
    return known.index(name)


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
