"""State selection: which quantities stay states when constraints tie them together.

After index reduction every derivative below the highest is a candidate. The hidden constraints
(every equation that is differentiated, and its lower derivatives) tie candidates together; as
many candidates as there are constraints become dependent. The dependent ones are found by
sparse elimination that takes the least wanted candidates first (a greedy choice in a linear
matroid is optimal), and with constant pivots before varying ones, so that a quantity is never
solved for where its factor can pass zero. Balances come between: where some factors vanish without
load, one that does not is the pivot. That of torques at a joint between two springs tells a twist,
but the joint's angle only under load.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lumped.flattening.residual import VARYING
from lumped.reduction.incidence import Entries

RANK = {"never": 0, "avoid": 1, "default": 2, "prefer": 3, "always": 4}
"""Order in which wishes are honoured: the lower, the sooner dependent."""

_LEFT = 0.1
"""Share of a pivot that is left under a small load if it does not vanish without load."""

Row = dict[int, tuple[float, int]]


def select_dependent(
    rows: list[Row],
    rank: np.ndarray,
    unloaded: Callable[[], list[Row]] | None = None,
    *,
    explicit_only: bool = False,
) -> tuple[list[int], int, list[int]]:
    """Choose one dependent column for each constraint.

    Parameters
    ----------
    rows : list of dict of int to (float, int)
        Coefficient and its kind for each column of each constraint; used up.
    rank : ndarray of int, shape (columns,)
        Wish of each column to stay a state; of equal ones the later is the sooner dependent.
    unloaded : callable, optional
        Gives the same rows under a small load.
    explicit_only : bool
        Only pivots that do not vary are used.

    Returns
    -------
    dependent : list of int
        Columns that the constraints determine, first those with pivots that do not vary, and
        those that balances tell.
    explicit : int
        Number of these.
    unused : list of int
        Constraint rows that determine none.
    """
    constraints = _Constraints(rows)
    open_rows = set(range(len(rows)))
    dependent: list[int] = []
    explicit = 0
    columns = sorted(constraints.holders, key=lambda c: (rank[c], -c))
    first = [c for c in columns if rank[c] < RANK["always"]]
    passes = [("constant", first), ("balance", first), ("varying", first), ("varying", columns)]
    for kind, group in passes[:1] if explicit_only else passes:
        if kind == "balance":
            if not open_rows or unloaded is None:
                continue
            constraints.unloaded = constraints.repeat(unloaded())
        for column in group:
            if not open_rows:
                break
            pivot = constraints.find_pivot(column, allow_varying=kind != "constant")
            if pivot is not None:
                dependent.append(column)
                explicit += kind != "varying"
                open_rows.discard(pivot)
                constraints.eliminate(pivot, column)
        constraints.unloaded = None
    return dependent, explicit, sorted(open_rows)


class _Constraints:
    """Rows of an elimination, and those not yet used up that hold each column.

    Attributes
    ----------
    unloaded : _Constraints or None
        The same under a small load; as long as it is given, pivots are those of balances.
    """

    def __init__(self, rows: list[Row]) -> None:
        self.rows = rows
        self.unloaded: _Constraints | None = None
        self._used: list[tuple[int, int]] = []
        self.holders: dict[int, set[int]] = {}
        for i, row in enumerate(rows):
            for column in row:
                self.holders.setdefault(column, set()).add(i)
        self._largest = [max((abs(v) for v, _ in row.values()), default=0.0) for row in rows]
        self._stale: set[int] = set()  # rows whose largest entry may be smaller by now

    def repeat(self, rows: list[Row]) -> _Constraints:
        """The same elimination of other rows."""
        other = _Constraints(rows)
        for pivot, column in self._used:
            other.eliminate(pivot, column)
        return other

    def _may_tell(self, i: int, column: int) -> bool:
        """Whether an entry, if only balances are wanted, does not vanish without load as others."""
        if self.unloaded is None:
            return True
        unloaded = self.unloaded.rows[i]
        lasting = {
            c
            for c, (v, _) in self.rows[i].items()
            if unloaded.get(c, (0.0, 0))[0] * v > _LEFT * v * v
        }
        return column in lasting and len(lasting) < len(self.rows[i])

    def find_pivot(self, column: int, *, allow_varying: bool) -> int | None:
        """The shortest row in which a column has an entry that is not small."""
        rows, largest = self.rows, self._largest
        best, length = None, 0
        for i in sorted(self.holders[column]):
            value, kind = rows[i][column]
            if kind == VARYING and not allow_varying:
                continue
            if i in self._stale and not abs(value) > 1e-9 * largest[i]:
                largest[i] = max(abs(v) for v, _ in rows[i].values())
                self._stale.discard(i)
            if not (abs(value) > 1e-9 * largest[i] and self._may_tell(i, column)):
                continue
            if best is None or len(rows[i]) < length:
                best, length = i, len(rows[i])
        return best

    def eliminate(self, pivot: int, column: int) -> None:
        """Use a row up to remove a column from the others."""
        self._used.append((pivot, column))
        if self.unloaded is not None:
            self.unloaded.eliminate(pivot, column)
        pivot_row, largest = self.rows[pivot], self._largest
        value, kind = pivot_row[column]
        for c in pivot_row:
            self.holders[c].discard(pivot)
        for i in list(self.holders[column]):
            row = self.rows[i]
            factor, factor_kind = row[column]
            for c, (v, k) in pivot_row.items():
                change = factor / value * v
                old, old_kind = row.get(c, (0.0, 0))
                new = old - change
                if c == column or abs(new) <= 1e-12 * max(abs(old), abs(change)):
                    if c in row:
                        del row[c]
                        self.holders[c].discard(i)
                else:
                    row[c] = (new, max(old_kind, k, kind, factor_kind))
                    self.holders[c].add(i)
                    largest[i] = max(largest[i], abs(new))
                if abs(old) >= largest[i]:
                    self._stale.add(i)


def constraint_rows(
    entries: list[Entries], column: np.ndarray
) -> tuple[list[Row], list[tuple[int, int]]]:
    """Constraints as dictionaries, from the entries of each order of differentiation.

    Parameters
    ----------
    entries : list of Entries
        Entries of the constraints that are differentiated 0, 1, ... times.
    column : ndarray of int, shape (classes, orders)
        Number of each candidate, -1 where there is none.

    Returns
    -------
    rows : list of dict
        Coefficient and kind by column.
    labels : list of (int, int)
        Equation and order of differentiation of each row.
    """
    rows: list[Row] = []
    labels: list[tuple[int, int]] = []
    for order, e in enumerate(entries):
        columns = column[e.classes, e.orders].tolist()
        values, kinds = e.values.tolist(), e.kinds.tolist()
        previous = -1
        for i, row in enumerate(e.rows.tolist()):
            if row != previous:
                rows.append({})
                labels.append((row, order))
                previous = row
            rows[-1][columns[i]] = (values[i], kinds[i])
    return rows, labels
