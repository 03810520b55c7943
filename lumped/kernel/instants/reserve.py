"""The largest reserve of constraints that share a load: a linear programme.

Self-stresses (distributions of reactions that move nothing) are chosen such that the smallest
reserve is largest: largest s with ``l + w s <= r <= u - w s``, where w are the sizes of the limits,
or, where the load changes, mostly how fast each comes near: then the shares last longest. As long
as s is positive the set holds (static theorem of plastic analysis; as a linear programme Charnes
and Greenberg, Bulletin of the American Mathematical Society 57 (1951) 480). At the optimum some
limits block each other; without reserve these constraints let go together. The programme is solved
by exchange steps (Stiefel, An Introduction to Numerical Mathematics, Academic Press 1963, ch. 2).
"""

from __future__ import annotations

from lumped.code.words import kernel
from lumped.kernel.instant_search import Reserve

_MOST = 1.0
"""Largest reserve that is sought: that of a constraint without load."""
_STEADY = 0.01
"""Weight of the sizes of the limits where the load changes."""
_NO_PRICE, _NO_PIVOT = 1e-6, 1e-6
"""Change of the reserve, relative to the largest, and of a room, per unit of a variable, that is
rounding."""
_LEAST_PRICE = 1e-5
"""Least price of a limit that blocks the reserve, relative to the highest; less is rounding."""
_INFINITE = float("inf")
_NOTHING = -1


@kernel
def _add_room(programme: Reserve, limit: int, room: float, weight: float) -> None:
    """Add a row for the room up to a limit, which falls as the reserve grows."""
    row = programme.table[programme.rows * (programme.stresses + 2) :]
    for k in range(programme.stresses):
        row[k] = 0.0
    row[programme.stresses], row[programme.stresses + 1] = -weight, room
    programme.row_owner[programme.rows] = programme.rows
    programme.limit[programme.rows] = limit
    programme.rows += 1


@kernel
def _weight(programme: Reserve, limit: int, size: float) -> float:
    """Weight of a limit."""
    i, is_lower = limit // 2, limit % 2 == 1
    at = abs(programme.lower[i] if is_lower else programme.upper[i])
    weight = at / size if at != 0.0 else 1.0
    if programme.changes:
        nears = programme.nears_lower[i] if is_lower else programme.nears_upper[i]
        weight = _STEADY * weight + nears
    return weight


@kernel
def _add_limit(programme: Reserve, i: int, limit: int, size: float) -> None:
    """Add a row for the upper (even) or lower (odd) limit of a constraint, if it has one."""
    r, sign, at = programme.stresses, 1.0, programme.upper[i]
    if limit % 2 == 1:
        sign, at = -1.0, programme.lower[i]
    if not abs(at) < _INFINITE:
        return
    weight = _weight(programme, limit, size)
    row = programme.table[programme.rows * (r + 2) :]
    _add_room(programme, limit, sign * (at - programme.carried[i]) / size, weight)
    for k in range(r):
        # the reaction, and the limit that depends on it
        own = programme.stress[3 * programme.size * k + i :]
        follows = own[2 * programme.size] if limit % 2 == 1 else own[programme.size]
        row[k] = sign * (follows - own[0])


@kernel
def _exchange(programme: Reserve, p: int, q: int) -> None:
    """Exchange the variable of row p with that of column q."""
    n, table = programme.stresses + 2, programme.table
    pivot_row = table[p * n :]
    inverse = 1.0 / pivot_row[q]
    for j in range(n):
        pivot_row[j] = -pivot_row[j] * inverse
    pivot_row[q] = inverse
    for i in range(programme.rows):
        row = table[i * n :]
        factor = row[q]
        if i != p and factor != 0.0:
            row[q] = 0.0
            for j in range(n):
                row[j] += factor * pivot_row[j]
    owner = programme.row_owner[p]
    programme.row_owner[p] = programme.column_owner[q]
    programme.column_owner[q] = owner


@kernel
def _next_column(programme: Reserve, goal: int) -> int:
    """A variable that would raise the reserve: the first free one, else the first room."""
    n = programme.stresses + 2
    price = programme.table[goal * n :]
    found, largest = _NOTHING, 0.0
    for j in range(n - 1):
        largest = max(largest, abs(price[j]))
    for j in range(n - 1):
        owner, share = programme.column_owner[j], price[j] / largest
        gains = share > _NO_PRICE or (owner < 0 and share < -_NO_PRICE)
        if gains and (found == _NOTHING or owner < programme.column_owner[found]):
            found = j
    return found


@kernel
def _next_row(programme: Reserve, q: int, sign: float) -> int:
    """The room that is used up first if the variable of a column grows or falls."""
    n, table = programme.stresses + 2, programme.table
    found, least = _NOTHING, _INFINITE
    for i in range(programme.rows):
        change, owner = sign * table[i * n + q], programme.row_owner[i]
        if owner < 0 or change > -_NO_PIVOT:
            continue
        reach = max(table[i * n + n - 1], 0.0) / -change
        if reach < least or (reach == least and owner < programme.row_owner[found]):
            found, least = i, reach
    return found


@kernel
def _solve(programme: Reserve) -> int:
    """Make the reserve as large as possible; gives its row."""
    r, table = programme.stresses, programme.table
    n, goal = r + 2, 0
    for i in range(programme.rows):
        # the reserve that this room allows, and the one that all before it allow
        own, least = table[i * n + r + 1] / -table[i * n + r], table[goal * n + r + 1]
        if own < least / -table[goal * n + r]:
            goal = i
    _exchange(programme, goal, r)
    for _ in range(50 + 20 * programme.rows):
        q = _next_column(programme, goal)
        if q == _NOTHING:
            break
        p = _next_row(programme, q, 1.0 if table[goal * n + q] > 0.0 else -1.0)
        if p == _NOTHING:
            break
        _exchange(programme, p, q)
    return goal


@kernel
def largest_reserve(programme: Reserve, count: int) -> float:
    """Find the largest reserve of a group, its reactions, and the limits that block more."""
    r, size = programme.stresses, programme.least_size
    for i in range(count):
        programme.blocks[i] = 0
        size = max(size, abs(programme.carried[i]))
        size = max(size, abs(programme.upper[i]) if abs(programme.upper[i]) < _INFINITE else 0.0)
        size = max(size, abs(programme.lower[i]) if abs(programme.lower[i]) < _INFINITE else 0.0)
    programme.rows = 0
    for j in range(r + 1):
        programme.column_owner[j] = -1 - j
    _add_room(programme, _NOTHING, _MOST, 1.0)
    for i in range(count):
        _add_limit(programme, i, 2 * i, size)
        _add_limit(programme, i, 2 * i + 1, size)
    goal = _solve(programme)
    n, highest = r + 2, 0.0
    reserve = programme.table[goal * n + n - 1]
    programme.is_exhausted = 0
    for j in range(n - 1):
        highest = max(highest, -programme.table[goal * n + j])
    for j in range(n - 1):
        owner, price = programme.column_owner[j], -programme.table[goal * n + j]
        limit = programme.limit[owner] if owner >= 0 else _NOTHING
        if limit != _NOTHING and price > _LEAST_PRICE * highest:
            programme.blocks[limit // 2] = -1 if limit % 2 == 1 else 1
            if reserve * size * _weight(programme, limit, size) < -programme.rounding[limit // 2]:
                programme.is_exhausted = 1
    for row in range(programme.rows):
        k = -1 - programme.row_owner[row]
        if k >= 0 and k < r:
            for i in range(count):
                more = size * programme.table[row * n + n - 1]
                programme.carried[i] += programme.stress[3 * programme.size * k + i] * more
    return reserve
