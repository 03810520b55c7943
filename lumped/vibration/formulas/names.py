"""Symbols for parts of formulas."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from lumped.vibration.formulas.to_sympy import load_sympy

_SHORT = 12
"""Characters up to which a part needs no name."""


class Names:
    """Symbols that are counted, and what they stand for.

    Parameters
    ----------
    taken : collection of str
        Names of parameters, which no symbol has.
    """

    def __init__(self, taken: Collection[str] = ()) -> None:
        self._taken = taken
        self._known: dict[Any, Any] = {}
        self._count: dict[str, int] = {}

    def new(self, letter: str, value: Any) -> Any:
        """A symbol for a value; the value itself if it is short, and the same one for the same."""
        if value.is_Atom or len(str(value)) < _SHORT:
            return value
        if value not in self._known:
            self._count[letter] = self._count.get(letter, 0) + 1
            symbol = load_sympy().Symbol(free_name(f"{letter}{self._count[letter]}", self._taken))
            self._known[value] = symbol
        return self._known[value]

    @property
    def parts(self) -> list[tuple[Any, Any]]:
        """Symbols and what they stand for, in order."""
        return [(symbol, value) for value, symbol in self._known.items()]

    def count_anew(self, symbols: list[Any]) -> dict[Any, Any]:
        """Symbols with new numbers, without gaps."""
        count: dict[str, int] = {}
        found = {}
        for symbol in symbols:
            letter = str(symbol)[0]
            count[letter] = count.get(letter, 0) + 1
            new = free_name(f"{letter}{count[letter]}", self._taken)
            found[symbol] = load_sympy().Symbol(new)
        return found

    def values(self) -> list[Any]:
        """What the symbols stand for."""
        return [*self._known]


def free_name(name: str, taken: Collection[str]) -> str:
    """A name that no parameter has: with underscores behind it if need be."""
    return free_name(f"{name}_", taken) if name in taken else name
