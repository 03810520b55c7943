"""What is asked for at one instant: modes at the start, and whether constraints are redundant."""

from __future__ import annotations

from lumped.native.layout import (
    BEFORE,
    DEMAND,
    FIRED,
    FIRST,
    GAP,
    LK,
    NH,
    NM,
    NR,
    PUSH,
    RELATION_MODE,
    REST,
    STRUCK,
    TRIAL,
    M,
    X,
)
from lumped.native.settle import settle
from lumped.native.strike import look, put
from lumped.native.words import Integers, Numbers, at, kernel

__all__ = ["begin", "redundant"]

_INSIDE = 1e-9
_EQUAL = 1e-12


@kernel
def redundant(Z: Integers, R: Numbers) -> int:
    """Whether holds cannot be given any accelerations that one likes if all of them stick.

    The accelerations stand where the holds have their demands.
    """
    nh, nr, first = Z[NH], Z[NR], at(Z, Z[FIRST])
    trial, m, wanted = at(R, Z[TRIAL]), at(R, Z[M]), at(R, Z[DEMAND])
    rest, push = at(R, Z[REST]), at(R, Z[PUSH])
    for i in range(Z[NM]):
        trial[i] = m[i]
    for h in range(nh):
        put(at(trial, first[h]), 0)
        trial[first[h] + 3] = 0.0
    look(Z, R, at(R, Z[X]), trial, rest)
    for h in range(nh):
        trial[first[h] + 4] = wanted[h]
    look(Z, R, at(R, Z[X]), trial, push)
    for h in range(nh):
        k = 2 * nr + nh + h
        error = abs(push[k] - rest[k] - wanted[h])
        reaction = push[k + nh] - rest[k + nh]
        if not error < 1e-6 or not abs(reaction) < 1e300:
            return 1
    return 0


@kernel
def begin(Z: Integers, R: Numbers) -> int:
    """Find modes and states at the start, where they are tried out; 0 if Python should do it.

    Python does what needs words: bodies inside each other, impacts, modes that do not fit.
    """
    nh, nr, m, lk = Z[NH], Z[NR], at(R, Z[M]), at(R, Z[LK])
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
