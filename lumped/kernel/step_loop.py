"""One step after the other: error control, margins, output (see `lumped.timeloop.stepper`)."""

from __future__ import annotations

import math

from lumped.kernel.crossing import crossing, interpolate, suspected
from lumped.kernel.dop853 import dense_explicit, explicit
from lumped.kernel.layout import (
    ARGUMENT,
    ATOL,
    AUTO,
    BOTH_SIDES,
    CALM,
    CHANGED_AT,
    CLOSED,
    CLOSURE,
    CROSS,
    END,
    FULL,
    GIVEN_UP,
    GRID,
    GRID_NEXT,
    GRID_SIZE,
    IMPLICIT,
    KNOWN,
    LEAVE_SEGMENT,
    LEVER,
    LEVERS,
    LIMIT,
    MAX_STEPS,
    MAY_IMPLICIT,
    MOST_ROWS,
    NEW,
    NG,
    NK,
    NL,
    NM,
    NOT_FINITE,
    ON_GRID,
    OUT_G,
    OUT_T,
    OUT_X,
    PAUSE,
    PHASE,
    REFUSED,
    REJECTED,
    RESTART,
    RHS,
    ROWS,
    RTOL,
    SINGULAR,
    STAGES,
    STEPPING,
    STEPS,
    STIFF,
    T_CROSS,
    T_NEW,
    TOO_MANY,
    TOO_STIFF,
    UNFIT,
    UNTIL,
    H,
    M,
    N,
    P,
    T,
    X,
)
from lumped.kernel.rodas5p_step import dense_implicit, implicit
from lumped.kernel.words import Integers, Numbers, at, doubles, evaluate, kernel

__all__ = ["advance", "edge", "room", "start", "unfit"]

_MOST_LEVERAGE = 1e3
_CLOSED = 1e-9
_STIFF_AFTER = 15
_GOES_ON = -1


@kernel
def room(Z: Integers) -> bool:
    """Whether there is room for all output times that are left and a few rows more."""
    return Z[MOST_ROWS] - Z[ROWS] >= Z[GRID_SIZE] - Z[GRID_NEXT] + 4


@kernel
def _row(Z: Integers, R: Numbers, t: float) -> Numbers:
    """Takes a row of output; gives the place of its states."""
    row, ng = Z[ROWS], Z[NG]
    doubles(Z[OUT_T])[row] = t
    guesses = at(doubles(Z[OUT_G]), row * ng)
    now = at(R, Z[M] + Z[NM] - ng)
    for i in range(ng):
        guesses[i] = now[i]
    Z[ROWS] = row + 1
    return at(doubles(Z[OUT_X]), row * Z[N])


@kernel
def edge(Z: Integers, R: Numbers) -> None:
    """An end of a segment; output times that coincide with it are left out."""
    if Z[BOTH_SIDES] == 0:
        return
    x, out = at(R, Z[X]), _row(Z, R, R[T])
    for i in range(Z[N]):
        out[i] = x[i]
    if Z[ON_GRID] == 1:
        grid = doubles(Z[GRID])
        while Z[GRID_NEXT] < Z[GRID_SIZE] and grid[Z[GRID_NEXT]] <= R[T] + 1e-13 * R[UNTIL]:
            Z[GRID_NEXT] += 1


@kernel
def _record(Z: Integers, R: Numbers, end: float, crossed: bool) -> None:
    """What is asked for of a step up to a time."""
    if Z[ON_GRID] == 0:
        if not crossed or R[T_NEW] < end:
            out, new = _row(Z, R, R[T_NEW]), at(R, Z[NEW])
            for i in range(Z[N]):
                out[i] = new[i]
        return
    grid, k = doubles(Z[GRID]), Z[GRID_NEXT]
    while k < Z[GRID_SIZE] and grid[k] < end:
        interpolate(Z, R, (grid[k] - R[T]) / (R[T_NEW] - R[T]), _row(Z, R, grid[k]))
        k += 1
    Z[GRID_NEXT] = k


@kernel
def unfit(Z: Integers, R: Numbers, x: Numbers, t: float) -> bool:
    """Whether a state hardly leads what depends on it."""
    if Z[NL] == 0:
        return False
    levers = at(R, Z[LEVER])
    evaluate(Z[LEVERS], x, at(R, Z[P]), t, at(R, Z[M]), levers)
    for i in range(Z[NL]):
        if not abs(levers[i]) <= _MOST_LEVERAGE:
            return True
    return False


@kernel
def _norm(v: Numbers, scale: Numbers, x: Numbers, atol: Numbers, rtol: float, n: int) -> float:
    total = 0.0
    for i in range(n):
        part = (v[i] - scale[i]) / (atol[i] + rtol * abs(x[i]))
        total += part * part
    return math.sqrt(total / n)


@kernel
def start(Z: Integers, R: Numbers) -> int:
    """Derivatives and first step at the begin of a smooth part; 0 if they are not finite."""
    n, t, end, rtol = Z[N], R[T], R[END], R[RTOL]
    x, f, atol = at(R, Z[X]), at(R, Z[STAGES]), at(R, Z[ATOL])
    p, m, a, later = at(R, Z[P]), at(R, Z[M]), at(R, Z[ARGUMENT]), at(R, Z[NEW])
    evaluate(Z[RHS], x, p, t, m, f)
    for i in range(n):
        if not abs(f[i]) < math.inf:
            return 0
        later[i] = 0.0
    d0, d1 = _norm(x, later, x, atol, rtol, n), _norm(f, later, x, atol, rtol, n)
    h0 = 1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1
    h0 = min(h0, end - t)
    for i in range(n):
        a[i] = x[i] + h0 * f[i]
    evaluate(Z[RHS], a, p, t + h0, m, later)
    steepest = max(d1, _norm(later, f, x, atol, rtol, n) / h0)
    h1 = max(1e-6, h0 * 1e-3) if steepest <= 1e-15 else (0.01 / steepest) ** 0.125
    first = min(min(100.0 * h0, h1), end - t)
    R[H] = first if first > 0.0 and first < math.inf else 1e-6 * (end - t)
    R[KNOWN] = math.inf
    Z[REJECTED] = Z[STIFF] = Z[CALM] = 0
    return 1


@kernel
def _closed(Z: Integers, R: Numbers, error: float) -> float:
    """Error of the step, with what Newton's method of implicit quantities says to it."""
    ng = Z[NG]
    found, guesses = at(R, Z[CLOSED]), at(R, Z[M] + Z[NM] - Z[NG])
    evaluate(Z[CLOSURE], at(R, Z[NEW]), at(R, Z[P]), R[T_NEW], at(R, Z[M]), found)
    for i in range(ng):
        if not abs(found[ng + i] / (1.0 + abs(found[i]))) <= _CLOSED:
            return 100.0
    if error <= 1.0:
        for i in range(ng):
            guesses[i] = found[i]
    return error


@kernel
def _finite(Z: Integers, R: Numbers) -> bool:
    n, new = Z[N], at(R, Z[NEW])
    f = at(R, Z[STAGES] + 12 * n)
    for i in range(n):
        if not (abs(new[i]) < 1e300 and abs(f[i]) < 1e300):
            return False
    return True


@kernel
def _step_on(Z: Integers, R: Numbers) -> None:
    """The end of the step becomes the begin of the next."""
    n, x, new, k = Z[N], at(R, Z[X]), at(R, Z[NEW]), at(R, Z[STAGES])
    for i in range(n):
        x[i] = new[i]
        k[i] = k[12 * n + i]
    R[T] = R[T_NEW]


@kernel
def _attempt(Z: Integers, R: Numbers) -> int:
    """One attempt of a step; why the loop must return, or -1."""
    t, end = R[T], R[END]
    h = min(R[H], end - t)
    stiff_method = Z[IMPLICIT] == 1
    R[T_NEW] = end if h >= end - t else t + h
    if stiff_method:
        error = implicit(Z, R, h)
        if error == -1.0:
            return SINGULAR
    else:
        error = explicit(Z, R, h)
    if Z[NG] > 0:
        error = _closed(Z, R, error)
    accept = error <= 1.0 and _finite(Z, R)
    size = error if error > 1e-12 else 1e-12
    growth = 0.9 * size ** (-0.2 if stiff_method else -0.125)
    growth = min(max(growth, 0.2), 1.0 if Z[REJECTED] == 1 else 8.0)
    if not accept:
        Z[REFUSED] += 1
        Z[REJECTED] = 1
        R[H] = h * min(growth, 0.9)
        if R[H] < 1e-14 * max(abs(t), 1e-6):
            return GIVEN_UP
        return _GOES_ON
    R[H] = h * growth
    Z[REJECTED] = 0
    Z[STEPS] += 1
    if not stiff_method:
        if R[LIMIT] > 6.1:
            Z[CALM] = 0
            Z[STIFF] += 1
        else:
            Z[CALM] += 1
            if Z[CALM] >= 6:
                Z[STIFF] = 0
    wanted = Z[GRID_NEXT] < Z[GRID_SIZE] and doubles(Z[GRID])[Z[GRID_NEXT]] < R[T_NEW]
    if Z[NK] > 0 or wanted:
        if stiff_method:
            dense_implicit(Z, R)
        else:
            dense_explicit(Z, R, h)
    if Z[NK] > 0 and suspected(Z, R) and crossing(Z, R):
        _record(Z, R, R[T_CROSS], True)
        Z[PHASE] = CROSS
        return _GOES_ON
    _record(Z, R, R[T_NEW], False)
    _step_on(Z, R)
    if unfit(Z, R, at(R, Z[X]), R[T]):
        return UNFIT
    if Z[AUTO] == 1 and not stiff_method and Z[STIFF] >= _STIFF_AFTER:
        if Z[MAY_IMPLICIT] == 0:
            return TOO_STIFF
        Z[IMPLICIT] = 1
        R[CHANGED_AT] = R[T]
    return _GOES_ON


@kernel
def advance(Z: Integers, R: Numbers) -> int:
    """Steps up to the end of the segment or a change of modes; why the loop returns, or -1."""
    if Z[PHASE] == RESTART:
        if R[T] >= R[END]:
            Z[PHASE] = LEAVE_SEGMENT
            return _GOES_ON
        if start(Z, R) == 0:
            return NOT_FINITE
        Z[PHASE] = STEPPING
    while R[T] < R[END]:
        if not room(Z) or Z[STEPS] + Z[REFUSED] >= Z[PAUSE]:
            return FULL
        status = _attempt(Z, R)
        if status != _GOES_ON:
            return status
        if Z[PHASE] == CROSS:
            return _GOES_ON
        if Z[STEPS] + Z[REFUSED] > Z[MAX_STEPS]:
            return TOO_MANY
    Z[PHASE] = LEAVE_SEGMENT
    return _GOES_ON
