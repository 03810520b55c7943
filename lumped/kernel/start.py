"""What is asked for at one instant: modes at the start, and whether constraints are redundant."""

from __future__ import annotations

from lumped.kernel.fitting import settle
from lumped.kernel.impact import look, put, redundant
from lumped.kernel.layout import (
    BEFORE,
    DOUBT,
    FIRED,
    FIRST,
    GAP,
    LK,
    NH,
    NM,
    NR,
    PIECE_COUNT,
    RELATION_MODE,
    STRUCK,
    TRIAL,
    M,
    X,
)
from lumped.kernel.words import Integers, Numbers, at, kernel

__all__ = ["begin", "doubt"]

_INSIDE = 1e-9
_EQUAL = 1e-12


@kernel
def doubt(Z: Integers, R: Numbers) -> int:
    """Whether constraints are redundant if all of them stick; what is not, remains so with less."""
    nh, first = Z[NH], at(Z, Z[FIRST])
    trial, m = at(R, Z[TRIAL]), at(R, Z[M])
    for i in range(Z[NM]):
        trial[i] = m[i]
    for h in range(nh):
        put(at(trial, first[h]), 0)
        trial[first[h] + 3] = 0.0
    Z[DOUBT] = 1 if redundant(Z, R, at(R, Z[X]), trial) else 0
    return Z[DOUBT]


@kernel
def begin(Z: Integers, R: Numbers) -> int:
    """Find modes and states at the start, where they are tried out; 0 if Python should do it.

    Python does what needs words: bodies inside each other, impacts, modes that do not fit; and it
    looks up tables.
    """
    nh, nr, m, lk = Z[NH], Z[NR], at(R, Z[M]), at(R, Z[LK])
    for k in range(nr):
        if at(Z, Z[PIECE_COUNT])[k] > 0:
            return 0
    for _ in range(3):
        look(Z, R, at(R, Z[X]), m, lk)
        for k in range(nr):
            slack = _EQUAL * (abs(lk[k]) + abs(lk[nr + k])) + 1e-13
            m[at(Z, Z[RELATION_MODE])[k]] = 1.0 if lk[k] - lk[nr + k] > slack else 0.0
    for h in range(nh):
        if at(Z, Z[GAP])[h] == 1 and lk[2 * nr + 5 * nh + h] < -_INSIDE:
            return 0
    for i in range(Z[NM]):
        at(R, Z[BEFORE])[i] = m[i]
    Z[FIRED] = 0
    if not settle(Z, R):
        return 0
    for h in range(nh):
        if at(Z, Z[STRUCK])[h] == 1:
            return 0
    return 1
