"""Records: the data that kernels share, in fields with names, types and lengths.

A record is declared like a dataclass::

    class Step(Record):
        h: float
        x: Annotated[Numbers, "states"]
        plant: Plant

A field is an integer, a number, numbers or integers of a length, or another record. The length is
an expression of the sizes with which the record is made; without a length the field points to a
given array. A second length says how far a function may write beyond the field, into those after
it. In memory a record is a block of 64-bit words: its fields in their order. A field with a length
holds the address of its place further on.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, ClassVar, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np

from lumped.code.words import Integers, Numbers, Wide, Wides

_KINDS = {int: "int", float: "float", Integers: "ints", Numbers: "numbers"}
_KINDS |= {Wide: "wide", Wides: "wides"}


class Field(NamedTuple):
    """A field of a record.

    Attributes
    ----------
    name : str
        Its name.
    place : int
        Number of its word.
    kind : str or type
        "int", "float", "ints", "numbers", "wide", "wides", or a class of records.
    length : str
        Expression of sizes; empty if there is none.
    reach : str
        Length including later fields that one function writes together with it.
    """

    name: str
    place: int
    kind: Any
    length: str
    reach: str


class _Integer:
    """An integer field as an attribute in Python."""

    def __init__(self, field: Field) -> None:
        self._place = field.place

    def __get__(self, record: Record | None, _: type | None = None) -> Any:
        return self if record is None else int(record._words[self._place])

    def __set__(self, record: Record, value: int) -> None:
        record._words[self._place] = value


class _Number(_Integer):
    """A field that holds a number."""

    def __get__(self, record: Record | None, _: type | None = None) -> Any:
        return self if record is None else record._numbers[self._place]

    def __set__(self, record: Record, value: float) -> None:
        record._numbers[self._place] = value


class _Held(_Integer):
    """A field that holds an array or a record."""

    def __init__(self, field: Field) -> None:
        self._name, self._place = field.name, field.place

    def __get__(self, record: Record | None, _: type | None = None) -> Any:
        return self if record is None else record._held[self._name]

    def __set__(self, record: Record, value: Any) -> None:
        record._held[self._name] = value
        record._words[self._place] = address(value)


def address(held: Any) -> int:
    """Address of an array or a record."""
    if isinstance(held, Record):
        return held._address
    found: int = held.__array_interface__["data"][0]
    return found


_ATTRIBUTES: dict[Any, type[_Integer]] = {"int": _Integer, "float": _Number}


class _Layout(NamedTuple):
    """Places of the fields with a length: their words, offsets, and views by name."""

    words: np.ndarray
    offsets: np.ndarray
    views: dict[str, tuple[bool, int, int]]
    size: int


class _Kind(type):
    """Records have no attributes but their fields, so that a wrong name is an error."""

    def __new__(cls, name: str, bases: tuple[type, ...], space: dict[str, Any]) -> _Kind:
        return super().__new__(cls, name, bases, {"__slots__": (), **space})


class Record(metaclass=_Kind):
    """A record that kernels read and write.

    Parameters
    ----------
    sizes : mapping of str to int
        Values of the names in the lengths of its fields.
    memory : ndarray of int64, optional
        Where it is, as many words as `words` tells, all zero.
    **given
        Values of fields.
    """

    __slots__ = ("_address", "_first", "_held", "_numbers", "_words")
    fields: ClassVar[dict[str, Field]] = {}

    def __init_subclass__(cls) -> None:
        hints = get_type_hints(cls, include_extras=True)
        cls.fields = {}
        for place, name in enumerate(n for n in cls.__annotations__ if n != "fields"):
            hint, lengths = hints[name], [""]
            if get_origin(hint) is Annotated:
                hint, *lengths = get_args(hint)
            field = Field(name, place, _KINDS.get(hint, hint), lengths[0], lengths[-1])
            cls.fields[name] = field
            setattr(cls, name, _ATTRIBUTES.get(field.kind, _Held)(field))

    def __init__(
        self,
        sizes: Mapping[str, int] | None = None,
        memory: np.ndarray | None = None,
        **given: Any,
    ) -> None:
        own: Any = type(self)
        layout = _lay_out(own, tuple((sizes or {}).items()))
        self._words = np.zeros(layout.size, dtype=np.int64) if memory is None else memory
        self._numbers = self._words.view(np.float64)
        self._address = address(self._words)
        self._words[layout.words] = self._address + 8 * layout.offsets
        self._held: Any = _Views(self, layout)
        for name, value in given.items():
            setattr(self, name, value)

    def remember(self) -> None:
        """Note the arrays and records that it points to."""
        self._first = dict(self._held)

    def begin_again(self) -> None:
        """Hold those noted by `remember` again, without the memory with their addresses."""
        self._held.clear()
        self._held.update(self._first)

    @classmethod
    def words(cls, sizes: Mapping[str, int]) -> int:
        """Length of a record in words."""
        own: Any = cls
        return _lay_out(own, tuple(sizes.items())).size

    @classmethod
    def lengths(cls) -> set[str]:
        """Names of sizes in the lengths of its fields."""
        texts = " ".join(field.length for field in cls.fields.values())
        return set(re.findall(r"[a-z_]+", texts)) - {"max"}


class _Views(dict[str, Any]):
    """Arrays and records that a record points to; views of its own memory are made when used."""

    def __init__(self, record: Record, layout: _Layout) -> None:
        super().__init__()
        self._words, self._numbers = record._words, record._numbers
        self._views = layout.views

    def __missing__(self, name: str) -> Any:
        if name not in self._views:
            return None
        is_number, first, count = self._views[name]
        base = self._numbers if is_number else self._words
        self[name] = base[first : first + count]
        return self[name]


@cache
def _lay_out(kind: type[Record], sizes: tuple[tuple[str, int], ...]) -> _Layout:
    known = dict(sizes)
    end = len(kind.fields)
    words, offsets, views = [], [], {}
    for field in kind.fields.values():
        if field.length:
            count, reach = (int(eval(e, {"max": max}, known)) for e in (field.length, field.reach))
            words.append(field.place)
            offsets.append(end)
            views[field.name] = field.kind != "ints", end, reach
            end += count
    return _Layout(
        np.array(words, dtype=int), np.array(offsets, dtype=np.int64), views, max(end, 1)
    )
