"""The time loop of a run, from one change of modes to the next (see `lumped.timeloop.run`)."""

from __future__ import annotations

from lumped.kernel.fitting import settle
from lumped.kernel.layout import (
    ASK,
    AT_CROSSING,
    AT_INSTANT,
    BEFORE,
    BEGIN_SEGMENT,
    CHANGE_D,
    CHANGE_I,
    CHANGES,
    CROSS,
    CROSSINGS,
    DONE,
    EDGES,
    END,
    FIRED,
    FIRST,
    FULL,
    INNER,
    JUMPED,
    LEAVE_SEGMENT,
    LOSS,
    MOST_CHANGES,
    MOST_PIECES,
    MS,
    NG,
    NH,
    NJ,
    NM,
    NR,
    ON_GRID,
    OPEN_CROSSING,
    OPEN_SEGMENT,
    PHASE,
    PIECE_MODES,
    PIECE_ROW,
    PIECES,
    RELATION_MODE,
    RESTART,
    RING,
    ROWS,
    SEGMENT,
    SEGMENTS,
    STORM,
    STORM_SIZE,
    STRUCK,
    T_CROSS,
    TIMED,
    TIMED_MODE,
    TIMED_VALUES,
    UNFIT,
    UNTIL,
    XS,
    M,
    N,
    T,
    X,
)
from lumped.kernel.step_loop import advance, edge, room, unfit
from lumped.kernel.words import Integers, Numbers, at, doubles, integers, kernel

__all__ = ["loop"]

_GOES_ON = -1


@kernel
def _open(Z: Integers, R: Numbers) -> None:
    """Begin a new piece of output."""
    k, m, count = Z[PIECES], at(R, Z[M]), Z[NM] - Z[NG]
    integers(Z[PIECE_ROW])[k] = Z[ROWS]
    modes = at(doubles(Z[PIECE_MODES]), k * count)
    for i in range(count):
        modes[i] = m[i]
    Z[PIECES] = k + 1
    edge(Z, R)


@kernel
def _part(m: Numbers) -> int:
    """0 stuck, 1 forward, 2 backward, 3 free."""
    if m[0] > 0.5:
        return 0
    if m[1] > 0.5:
        return 1
    return 2 if m[2] > 0.5 else 3


@kernel
def _change(
    Z: Integers, R: Numbers, kind: int, number: int, was: int, now: int, loss: float
) -> None:
    k = Z[CHANGES]
    row, values = at(integers(Z[CHANGE_I]), 4 * k), at(doubles(Z[CHANGE_D]), 2 * k)
    row[0], row[1], row[2], row[3] = kind, number, was, now
    values[0], values[1] = R[T], loss
    Z[CHANGES] = k + 1


@kernel
def _settled(Z: Integers, R: Numbers) -> bool:
    """Settle an instant; whether that was possible."""
    if Z[NR] + Z[NH] + Z[NJ] == 0:
        return True
    if not settle(Z, R):
        return False
    before, after, places = at(R, Z[BEFORE]), at(R, Z[MS]), at(Z, Z[RELATION_MODE])
    for k in range(Z[NR]):
        was, now = int(before[places[k]]), int(after[places[k]])
        if at(Z, Z[JUMPED])[k] == 1:
            was, now = 0, 1
        if was != now:
            _change(Z, R, 0, k, was, now, 0.0)
    first, struck = at(Z, Z[FIRST]), at(Z, Z[STRUCK])
    for h in range(Z[NH]):
        was, now = _part(at(before, first[h])), _part(at(after, first[h]))
        if was != now or struck[h] == 1:
            _change(Z, R, 1, h, was, now, at(R, Z[LOSS])[h])
    m, x = at(R, Z[M]), at(R, Z[X])
    for i in range(Z[NM]):
        m[i] = after[i]
    for i in range(Z[N]):
        x[i] = at(R, Z[XS])[i]
    return True


@kernel
def _begin_segment(Z: Integers, R: Numbers) -> int:
    s, m, before = Z[SEGMENT], at(R, Z[M]), at(R, Z[BEFORE])
    for i in range(Z[NM]):
        before[i] = m[i]
    R[T], R[END] = at(R, Z[EDGES])[s], at(R, Z[EDGES])[s + 1]
    places, values = at(Z, Z[TIMED_MODE]), at(R, Z[TIMED_VALUES] + s * Z[TIMED])
    for i in range(Z[TIMED]):
        m[places[i]] = values[i]
    Z[FIRED] = 0
    Z[PHASE] = OPEN_SEGMENT
    if Z[ASK] & 1 == 1 or not _settled(Z, R):
        return AT_INSTANT
    return _GOES_ON


@kernel
def _cross(Z: Integers, R: Numbers) -> int:
    x, found = at(R, Z[X]), at(R, Z[INNER])
    for i in range(Z[N]):
        x[i] = found[i]
    R[T] = R[T_CROSS]
    edge(Z, R)
    m, before = at(R, Z[M]), at(R, Z[BEFORE])
    for i in range(Z[NM]):
        before[i] = m[i]
    Z[PHASE] = OPEN_CROSSING
    if Z[ASK] & 2 == 2 or not _settled(Z, R):
        return AT_CROSSING
    return _GOES_ON


@kernel
def _open_crossing(Z: Integers, R: Numbers) -> int:
    _open(Z, R)
    k, ring = Z[CROSSINGS], at(R, Z[RING])
    ring[k % STORM_SIZE] = R[T]
    Z[CROSSINGS] = k + 1
    Z[PHASE] = RESTART
    if k >= STORM_SIZE and R[T] - ring[(k + 1) % STORM_SIZE] <= 1e-9 * R[UNTIL]:
        return STORM
    return _GOES_ON


@kernel
def loop(Z: Integers, R: Numbers) -> int:
    """Go on from where the run stands, until it is done or something is left to Python.

    Parameters
    ----------
    Z, R : pointers
        The blocks of `lumped.kernel.layout`.

    Returns
    -------
    int
        Why it returns.
    """
    while True:
        phase, status = Z[PHASE], _GOES_ON
        if Z[PIECES] >= Z[MOST_PIECES] or Z[MOST_CHANGES] - Z[CHANGES] < Z[NR] + Z[NH]:
            return FULL
        if not room(Z):
            return FULL
        if phase == BEGIN_SEGMENT:
            status = _begin_segment(Z, R)
        elif phase == OPEN_SEGMENT:
            _open(Z, R)
            Z[PHASE] = RESTART
            if unfit(Z, R, at(R, Z[X]), R[T]):
                status = UNFIT
        elif phase == CROSS:
            status = _cross(Z, R)
        elif phase == OPEN_CROSSING:
            status = _open_crossing(Z, R)
        elif phase == LEAVE_SEGMENT:
            s = Z[SEGMENT]
            if Z[ON_GRID] == 1 and at(R, Z[EDGES])[s + 1] > at(R, Z[EDGES])[s]:
                edge(Z, R)
            Z[SEGMENT] = s + 1
            Z[PHASE] = BEGIN_SEGMENT
            if s + 1 == Z[SEGMENTS]:
                return DONE
        else:
            status = advance(Z, R)
        if status != _GOES_ON:
            return status
