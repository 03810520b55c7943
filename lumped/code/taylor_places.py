"""Where Taylor coefficients are kept between orders and between chunks of operations."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, TypeVar

from lumped.code.operations import RESULT, places_read
from lumped.code.taylor import Kind, Recurrence, Series

_CHUNK = 200
"""Operations in one LLVM function: the time to compile grows faster than linearly in them."""
TOGETHER, _FEW = 4, 6
"""Sums in a vector, and sums that are better taken one by one: a vector waits until the numbers in
it, which were written one by one, are in the cache."""
_T = TypeVar("_T")

Factor = tuple[bool, int]
"""A factor in a sum: a value, or (with True) its coefficients times their orders."""
Pair = tuple[Factor, Factor]


class Group(NamedTuple):
    """Sums that are taken together, and the columns of their factors."""

    pairs: list[Pair]
    left: list[int]
    right: list[int]
    is_vector: bool


def _chunks(rows: list[_T]) -> list[list[_T]]:
    return [rows[k : k + _CHUNK] for k in range(0, max(len(rows), 1), _CHUNK)]


def factors_of(r: Recurrence) -> Pair | None:
    """What is multiplied in the sum of a recurrence, if it has one."""
    if r.kind == Kind.PRODUCT:
        return (False, r.a), (False, r.b)
    if r.kind == Kind.QUOTIENT:
        return (False, r.b), (False, r.value)
    if r.kind == Kind.ROOT:
        return (False, r.value), (False, r.value)
    if r.kind == Kind.INTEGRAL:
        return (True, r.a), (False, r.b)
    return None


class Places:
    """Where values are kept between orders and between chunks.

    Attributes
    ----------
    first_chunks, later_chunks : list
        Operations for order zero, and recurrences, in parts.
    kept : dict
        Columns of each coefficient that is kept, of `width` in all; each order has a row.
    groups : list
        Sums of each part of the recurrences.
    fixed : dict of int to int
        Place of each value that is needed as it is at order zero only.
    """

    def __init__(self, series: Series, lanes: int) -> None:
        self.first_chunks, self.later_chunks = _chunks(series.first), _chunks(series.later)
        self.varying = {r.value for r in series.later if r.kind != Kind.WRITTEN}
        self.kept: dict[Factor, list[int]] = {}
        self.groups: list[list[Group]] = []
        self.fixed: dict[int, int] = {}
        self.width = 0
        for chunk in self.later_chunks:
            pairs = list(dict.fromkeys(f for r in chunk if (f := factors_of(r)) is not None))
            are_vectors = lanes == 1 and len(pairs) >= _FEW
            parts = [pairs[k : k + TOGETHER] for k in range(0, len(pairs), TOGETHER)]
            self.groups.append([self._group(part, are_vectors) for part in parts])
            own = set()
            for r in chunk:
                if r.kind == Kind.SCALED or r.kind == Kind.CHOSEN:
                    self._fix(r.b)
                if r.factor >= 0:
                    self._fix(r.factor)
                for value in _read(r):
                    if value not in own:
                        self._keep((False, value))
                own |= {r.value} if r.kind != Kind.WRITTEN else set()
        made: set[int] = set()
        for rows in self.first_chunks:
            own = {row[1] for row in rows if row[0] != RESULT}
            for row in rows:
                for value in places_read(row[0], *row[2:]):
                    if value in made:
                        self._keep((False, value)) if value in self.varying else self._fix(value)
            made |= own
        self.width = max(self.width, 1)

    def _group(self, pairs: list[Pair], is_vector: bool) -> Group:
        sides = pairs + ([pairs[-1]] * (TOGETHER - len(pairs)) if is_vector else [])
        left = [self._keep(a, again=is_vector) for a, _ in sides]
        right = [self._keep(b, again=is_vector) for _, b in sides]
        return Group(pairs, left, right, is_vector)

    def _keep(self, factor: Factor, again: bool = False) -> int:
        """A column of a coefficient, a new one if it is to be kept once more."""
        columns = self.kept.setdefault(factor, [])
        if again or not columns:
            columns.append(self.width)
            self.width += 1
        return columns[-1]

    def _fix(self, value: int) -> None:
        self.fixed.setdefault(value, len(self.fixed))


def _read(r: Recurrence) -> Iterable[int]:
    """Values whose coefficients of the same order a recurrence needs."""
    if r.kind in (Kind.SUM, Kind.DIFFERENCE, Kind.PRODUCT, Kind.QUOTIENT):
        return [v for v in (r.a, r.b) if v >= 0]
    return [r.a] if r.a >= 0 and r.kind not in (Kind.OF_STATE, Kind.OF_TIME) else []
