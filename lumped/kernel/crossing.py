"""Margins inside a step and where the first is used up (see `lumped.timeloop.crossing`)."""

from __future__ import annotations

import math

from lumped.kernel.layout import (
    CROSSINGS,
    DENSE,
    ENDS,
    FIRED,
    FIRED_ROWS,
    FIRST,
    IMPLICIT,
    INNER,
    KIND,
    KNOWN,
    MARGIN,
    MARGINS,
    NEW,
    NK,
    NUMBER,
    RING,
    SAMPLES,
    SLOPES,
    STACK,
    STORM_SIZE,
    SUSPECT,
    T_CROSS,
    T_NEW,
    M,
    N,
    P,
    T,
    X,
)
from lumped.kernel.words import Integers, Numbers, at, evaluate, kernel

__all__ = ["crossing", "interpolate", "suspected"]

_FINEST = 1e-3
_LOCATING = 40
_ROUNDING = 2.0**-53
_CROWDED = 1e-14
_SLIDE = 3


@kernel
def interpolate(Z: Integers, R: Numbers, part: float, out: Numbers) -> None:
    """States at a part of the step."""
    n, x, new, c = Z[N], at(R, Z[X]), at(R, Z[NEW]), at(R, Z[DENSE])
    rest = 1.0 - part
    if Z[IMPLICIT] == 1:
        for i in range(n):
            inner = c[i] + part * (c[n + i] + part * c[2 * n + i])
            out[i] = rest * x[i] + part * (new[i] + rest * inner)
        return
    for i in range(n):
        y = c[6 * n + i] * part
        y = (y + c[5 * n + i]) * rest
        y = (y + c[4 * n + i]) * part
        y = (y + c[3 * n + i]) * rest
        y = (y + c[2 * n + i]) * part
        y = (y + c[n + i]) * rest
        y = (y + c[i]) * part
        out[i] = x[i] + y


@kernel
def _margins(Z: Integers, R: Numbers, part: float) -> None:
    """Margins and tolerances at a part of the step."""
    x, t = at(R, Z[INNER]), R[T] + part * (R[T_NEW] - R[T])
    if part == 0.0:
        x = at(R, Z[X])
    elif part == 1.0:
        x, t = at(R, Z[NEW]), R[T_NEW]
    else:
        interpolate(Z, R, part, x)
    evaluate(Z[MARGINS], x, at(R, Z[P]), t, at(R, Z[M]), at(R, Z[MARGIN]))


@kernel
def _sample(Z: Integers, R: Numbers, row: int, part: float) -> None:
    """Margins with their tolerances as one of five samples."""
    nk = Z[NK]
    _margins(Z, R, part)
    margin, samples = at(R, Z[MARGIN]), at(R, Z[SAMPLES] + row * nk)
    for k in range(nk):
        samples[k] = margin[k] + margin[nk + k]


@kernel
def _slope(Z: Integers, R: Numbers, row: int, part: float) -> None:
    """Time derivatives of the margins at the first or last sample."""
    x, t = at(R, Z[INNER]), R[T] + part * (R[T_NEW] - R[T])
    interpolate(Z, R, part, x)
    evaluate(Z[SLOPES], x, at(R, Z[P]), t, at(R, Z[M]), at(R, Z[ENDS] + row * Z[NK]))


@kernel
def _doubtful(Z: Integers, R: Numbers, k: int, length: float) -> bool:
    """Whether a margin may have been below zero between samples."""
    nk = Z[NK]
    samples, ends = at(R, Z[SAMPLES] + k), at(R, Z[ENDS] + k)
    s0, s1, s2 = samples[0], samples[nk], samples[2 * nk]
    s3, s4 = samples[3 * nk], samples[4 * nk]
    g0, g1 = length * ends[0], length * ends[nk]
    least = min(min(min(min(s0, s1), s2), s3), s4)
    most = max(max(max(max(s0, s1), s2), s3), s4)
    r0, r1, r2, r3 = s1 - s0, s2 - s1, s3 - s2, s4 - s3
    b0, b1, b2 = r1 - r0, r2 - r1, r3 - r2
    bend = max(max(abs(b0), abs(b1)), abs(b2))
    falls = min(min(min(min(min(r0, r1), r2), r3), g0), g1)
    climbs = max(max(max(max(max(r0, r1), r2), r3), g0), g1)
    if falls * climbs < 0.0 and least < bend / 8.0:
        return True
    early = -25 / 12 * s0 + 4.0 * s1 - 3.0 * s2 + 4 / 3 * s3 - 1 / 4 * s4
    late = 25 / 12 * s4 - 4.0 * s3 + 3.0 * s2 - 4 / 3 * s1 + 1 / 4 * s0
    rough = max(abs(b0 - 2.0 * b1 + b2), abs(0.25 * g0 - early))
    rough = max(rough, abs(0.25 * g1 - late))
    return rough > 0.2 * (most - least) and least < rough


@kernel
def suspected(Z: Integers, R: Numbers) -> bool:
    """Whether a step that was accepted uses up a margin, or may do so between samples."""
    nk = Z[NK]
    samples, ends = at(R, Z[SAMPLES]), at(R, Z[ENDS])
    x, new, p, m = at(R, Z[X]), at(R, Z[NEW]), at(R, Z[P]), at(R, Z[M])
    t, t_new = R[T], R[T_NEW]
    if R[KNOWN] == t:
        for k in range(nk):
            samples[k] = samples[4 * nk + k]
            ends[k] = ends[nk + k]
    else:
        _sample(Z, R, 0, 0.0)
        evaluate(Z[SLOPES], x, p, t, m, ends)
    _sample(Z, R, 1, 0.25)
    _sample(Z, R, 2, 0.5)
    _sample(Z, R, 3, 0.75)
    _sample(Z, R, 4, 1.0)
    evaluate(Z[SLOPES], new, p, t_new, m, at(R, Z[ENDS] + nk))
    R[KNOWN] = t_new
    for k in range(nk):
        for j in range(1, 5):
            if samples[j * nk + k] < 0.0:
                return True
        if _doubtful(Z, R, k, t_new - t):
            return True
    return False


@kernel
def _probe(Z: Integers, R: Numbers, low: float, width: float) -> int:
    """First sample of a part of the step with a margin below zero (0 if none); doubts, in tens."""
    nk, samples = Z[NK], at(R, Z[SAMPLES])
    for j in range(5):
        _sample(Z, R, j, low + 0.25 * j * width)
    _slope(Z, R, 0, low)
    _slope(Z, R, 1, low + width)
    end, doubts = 0, 0
    for j in range(1, 5):
        for k in range(nk):
            if samples[j * nk + k] < 0.0:
                end = j
                break
        if end != 0:
            break
    for k in range(nk):
        if _doubtful(Z, R, k, width * (R[T_NEW] - R[T])):
            doubts = 1
            break
    return end + 10 * doubts


@kernel
def _first_below(Z: Integers, R: Numbers) -> bool:
    """Finds between which parts of the step a margin first falls below zero.

    Leaves the two parts in the stack's first places and marks what falls; gives whether there is
    anything. The search goes depth first through halves that are in doubt.
    """
    nk, stack, suspect = Z[NK], at(R, Z[STACK]), at(Z, Z[SUSPECT])
    stack[0], stack[1], stack[2], stack[3] = 0.0, 1.0, -1.0, 0.0
    depth = 0
    while depth >= 0:
        top = at(stack, 4 * depth)
        low, width = top[0], top[1]
        if top[2] < 0.0:
            found = _probe(Z, R, low, width)
            top[2] = float(found % 10)
            top[3] = 0.0 if found >= 10 and width > _FINEST else 2.0
        end = int(top[2])
        half = int(top[3])
        if half < 2:
            begin = low + 0.5 * half * width
            if end > 0 and low + 0.25 * (end - 1) * width <= begin:
                top[3] = 2.0
            else:
                top[3] = half + 1.0
                depth += 1
                inner = at(stack, 4 * depth)
                inner[0], inner[1], inner[2], inner[3] = begin, 0.5 * width, -1.0, 0.0
            continue
        if end > 0:
            _sample(Z, R, 0, low + 0.25 * end * width)
            samples = at(R, Z[SAMPLES])
            for k in range(nk):
                suspect[k] = 1 if samples[k] < 0.0 else 0
            stack[0] = low + 0.25 * (end - 1) * width
            stack[1] = low + 0.25 * end * width
            return True
        depth -= 1
    return False


@kernel
def _value(Z: Integers, R: Numbers, k: int, part: float, extra: float) -> float:
    """A margin and some of its tolerances."""
    _margins(Z, R, part)
    margin = at(R, Z[MARGIN] + k)
    return margin[0] + extra * margin[Z[NK]]


@kernel
def _locate(Z: Integers, R: Numbers, k: int, low: float, high: float, extra: float) -> float:
    """Part of the step at which it falls to zero, by the Illinois variant of the secant."""
    a, fa = low, _value(Z, R, k, low, extra)
    b, fb = high, _value(Z, R, k, high, extra)
    for _ in range(_LOCATING):
        if fb == 0.0 or not abs(a - b) > _ROUNDING:
            break
        c = b if fa == fb else (a * fb - b * fa) / (fb - fa)
        fc = _value(Z, R, k, c, extra)
        if fc * fb < 0.0:
            a, fa = b, fb
        else:
            fa = 0.5 * fa
        b, fb = c, fc
    return b if fb <= 0.0 else a


@kernel
def _risen(Z: Integers, R: Numbers, k: int, end: float) -> float:
    """Where a margin that is zero when the step begins is positive before it falls again."""
    part = end
    for _ in range(1, 30):
        part *= 0.5
        if _value(Z, R, k, part, 0.0) > 0.0:
            return part
    return 0.0


@kernel
def _crowded(Z: Integers, R: Numbers) -> float:
    """1 if modes changed twice where the step begins (see `lumped.timeloop.crossing`), else 0."""
    k, ring = Z[CROSSINGS], at(R, Z[RING])
    if k < 2 or abs(R[T] - ring[(k - 2) % STORM_SIZE]) > _CROWDED * (1.0 + abs(R[T])):
        return 0.0
    return 1.0


@kernel
def crossing(Z: Integers, R: Numbers) -> bool:
    """Find the first instant in the step at which a margin is used up; whether there is one.

    Leaves the states there among the inner ones, the time, and which margins fired.
    """
    R[KNOWN] = math.inf
    if not _first_below(Z, R):
        return False
    nk, stack, suspect = Z[NK], at(R, Z[STACK]), at(Z, Z[SUSPECT])
    low, high = stack[0], stack[1]
    margin, fired = at(R, Z[MARGIN]), at(Z, Z[FIRED_ROWS])
    last = -1
    for k in range(nk):
        if suspect[k] == 1:
            last = k
            break
    previous, crowded = -1, _crowded(Z, R)
    x = at(R, Z[INNER])
    # bit 1: suspect; bit 2: not used up any more at an earlier root
    while last >= 0:
        begin = low if low > 0.0 else _risen(Z, R, last, high)
        extra = 0.5 * crowded if at(Z, Z[KIND])[last] == _SLIDE else crowded
        found = _locate(Z, R, last, begin, high, extra)
        if not (begin - _FINEST <= found and found <= high):
            # zero within its tolerance all the time before, as where rounding alone moves a rest
            found = _locate(Z, R, last, begin, high, 1.0)
        high = max(found, 0.0)
        if high < 1.0:
            interpolate(Z, R, high, x)
        else:
            new = at(R, Z[NEW])
            for i in range(Z[N]):
                x[i] = new[i]
        R[T_CROSS] = R[T] + high * (R[T_NEW] - R[T])
        evaluate(Z[MARGINS], x, at(R, Z[P]), R[T_CROSS], at(R, Z[M]), margin)
        previous, last = last, -1
        for k in range(nk):
            if suspect[k] & 3 == 1 and not (margin[k] < -margin[nk + k] and k != previous):
                suspect[k] |= 2
            if last < 0 and suspect[k] == 1:
                last = k
    kinds, numbers, first = at(Z, Z[KIND]), at(Z, Z[NUMBER]), at(Z, Z[FIRST])
    m = at(R, Z[M])
    count = 0
    for k in range(nk):
        near = margin[k] <= margin[nk + k]
        shares = (kinds[k] == 1 or kinds[k] == 2) and m[first[numbers[k]] + 3] > 0.0
        if k == previous or (near and (suspect[k] != 0 or shares)):
            fired[count] = k
            count += 1
    Z[FIRED] = count
    return True
