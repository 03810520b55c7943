"""The search for modes that fit at one instant (see `lumped.timeloop.fitting`)."""

from __future__ import annotations

from lumped.kernel.impact import collide, halt, look, put, redundant, standstills
from lumped.kernel.layout import (
    BACK,
    BACKWARD,
    BEFORE,
    DOUBT,
    ENGAGED,
    EXEMPT,
    FIRED,
    FIRED_ROWS,
    FIRST,
    FORWARD,
    GAP,
    HALTED,
    HOLD_FEWEST,
    HOLD_LEFT,
    JUMP_FIRST,
    JUMP_MODE,
    JUMP_PLACE,
    JUMP_RELATION,
    JUMP_START,
    JUMPED,
    KIND,
    LK,
    LOSS,
    MOVED,
    MS,
    NH,
    NJ,
    NM,
    NR,
    NUMBER,
    NV,
    PIECE_COUNT,
    PIECE_FIRST,
    PIECE_WIDTH,
    PLACE,
    RELATION_FEWEST,
    RELATION_LEFT,
    RELATION_MODE,
    SHARED,
    SIGNS,
    SOON,
    STILL,
    STRICT,
    STRUCK,
    TABLE,
    TRIAL,
    WAS_STUCK,
    WAS_TRUE,
    WRONG,
    XS,
    M,
    N,
    X,
)
from lumped.kernel.words import Integers, Numbers, at, kernel

__all__ = ["settle"]

_SLACK = 1e-10
_EQUAL = 1e-12
_PATIENCE = 6
_FEWEST = 1 << 40


@kernel
def _to_change(Z: Integers, fewest: int, left: int, count: int) -> int:
    """Of so many that are wrong, how many change: all, or the first."""
    if count < Z[fewest]:
        Z[fewest] = count
        Z[left] = _PATIENCE
    elif Z[left] > 0:
        Z[left] -= 1
    else:
        return 1
    return count


@kernel
def _outside(Z: Integers, R: Numbers, k: int, run: float, slack: float) -> bool:
    """Whether a condition does not say what its sides say, which differ by `run`."""
    m = at(R, Z[MS] + at(Z, Z[RELATION_MODE])[k])
    if at(Z, Z[PIECE_COUNT])[k] > 0:
        return m[2] + run * (m[3] + m[4] * run) < -slack
    return run < -slack if m[0] > 0.5 else run > slack


@kernel
def _turn(Z: Integers, R: Numbers, k: int, run: float) -> None:
    """Change a condition: to its contrary, or to the next piece."""
    m, count = at(R, Z[MS] + at(Z, Z[RELATION_MODE])[k]), at(Z, Z[PIECE_COUNT])[k]
    if count == 0:
        m[0] = 1.0 - m[0]
        return
    onward = m[3] < 0.0 or m[4] * run < -0.5
    piece, width = int(m[0]) + (1 if onward else -1), at(Z, Z[PIECE_WIDTH])[k]
    piece = min(max(piece, 0), count - 1)
    row = at(R, Z[TABLE] + at(Z, Z[PIECE_FIRST])[k] + piece * width)
    for i in range(width):
        m[i] = row[i]


@kernel
def _relations(Z: Integers, R: Numbers) -> bool:
    """Turn conditions round that do not say what their sides say."""
    r = Z[NR]
    if r == 0:
        return False
    lk, modes = at(R, Z[LK]), at(R, Z[MS])
    places, strict, exempt = at(Z, Z[RELATION_MODE]), at(Z, Z[STRICT]), at(Z, Z[EXEMPT])
    wrong, count = at(Z, Z[WRONG]), 0
    for k in range(r):
        on = modes[places[k]] > 0.5
        g, size = lk[k] - lk[r + k], abs(lk[k]) + abs(lk[r + k])
        slack = _EQUAL * size + 1e-13
        equal = g == 0.0 and on == (strict[k] == 1) and exempt[k] == 0
        equal = equal and at(Z, Z[PIECE_COUNT])[k] == 0
        if equal or _outside(Z, R, k, g, slack):
            wrong[count] = 2 * k + (1 if equal else 0)
            count += 1
    if count == 0:
        return False
    changing = _to_change(Z, RELATION_FEWEST, RELATION_LEFT, count)
    for i in range(count):
        k = wrong[i] // 2
        if i < changing:
            _turn(Z, R, k, lk[k] - lk[r + k])
        if wrong[i] % 2 == 1:
            exempt[k] = 1
    return True


@kernel
def _jumps(Z: Integers, R: Numbers) -> bool:
    """Change states where conditions have become true."""
    modes, x, signs = at(R, Z[MS]), at(R, Z[XS]), at(R, Z[SIGNS])
    values = at(R, Z[LK] + 2 * Z[NR] + 7 * Z[NH])
    places, before = at(Z, Z[JUMP_MODE]), at(Z, Z[WAS_TRUE])
    starts, targets = at(Z, Z[JUMP_START]), at(Z, Z[JUMP_PLACE])
    first, relation, jumped = at(Z, Z[JUMP_FIRST]), at(Z, Z[JUMP_RELATION]), at(Z, Z[JUMPED])
    any_ = False
    for k in range(Z[NJ]):
        now = 1 if modes[places[k]] > 0.5 else 0
        if now == 1 and before[k] == 0:
            any_ = True
            if relation[k] >= 0:
                jumped[relation[k]] = 1
            for i in range(starts[k], starts[k + 1]):
                if targets[i] >= 0:
                    x[targets[i]] = signs[i] * values[first[k] + i - starts[k]]
                    Z[MOVED] = 1
        before[k] = now
    return any_


@kernel
def _engage(Z: Integers, R: Numbers) -> bool:
    """Engage and release holds."""
    nh, modes = Z[NH], at(R, Z[MS])
    first, engaged, halted = at(Z, Z[FIRST]), at(Z, Z[ENGAGED]), at(Z, Z[HALTED])
    gaps, forward, backward = at(Z, Z[GAP]), at(Z, Z[FORWARD]), at(Z, Z[BACKWARD])
    quantities = at(R, Z[LK] + 2 * Z[NR])
    any_ = False
    for h in range(nh):
        on = engaged[h] < 0 or modes[engaged[h]] > 0.5
        m = at(modes, first[h])
        acting = m[0] > 0.5 or m[1] > 0.5 or m[2] > 0.5
        if on == acting:
            continue
        if not any_:
            standstills(Z, R)
            any_ = True
        if acting:
            put(m, -1)
            halted[h] = 0
            continue
        v, gap, least = quantities[h], quantities[5 * nh + h], at(R, Z[STILL])[h]
        still = abs(v) <= least
        if gaps[h] == 1:
            touching = gap <= 1e-13 and v <= least
            put(m, 0 if touching and still else 1)
        elif not still and v < 0.0 and backward[h] == 1:
            put(m, 2)
        elif not still and v > 0.0 and forward[h] == 1:
            put(m, 1)
        else:
            put(m, 0)
    return any_


@kernel
def _rebalance(Z: Integers, R: Numbers) -> bool:
    """Let go what is overloaded, hold what would turn back."""
    nh, modes = Z[NH], at(R, Z[MS])
    if nh == 0:
        return False
    first, gaps = at(Z, Z[FIRST]), at(Z, Z[GAP])
    has_forward, has_backward = at(Z, Z[FORWARD]), at(Z, Z[BACKWARD])
    halted, wrong, back = at(Z, Z[HALTED]), at(Z, Z[WRONG]), at(Z, Z[BACK])
    q = at(R, Z[LK] + 2 * Z[NR])
    rates = at(R, Z[LK] + 2 * Z[NR] + 7 * nh + Z[NV])
    standstills(Z, R)
    still = at(R, Z[STILL])
    largest = 0.0
    for i in range(Z[N]):
        largest = max(largest, abs(rates[i]))
    calm, count = 1e-9 * (1.0 + largest), 0
    for h in range(nh):
        m = at(modes, first[h])
        v, a, reaction = q[h], q[nh + h], q[2 * nh + h]
        upper, lower, gap = q[3 * nh + h], q[4 * nh + h], q[5 * nh + h]
        at_rest = abs(v) <= still[h] or halted[h] == 1
        slack = _SLACK * abs(reaction) + 1e-13
        stuck, forward, backward = m[0] > 0.5, m[1] > 0.5, m[2] > 0.5
        over = stuck and reaction > upper + slack + _SLACK * abs(upper)
        under = stuck and reaction < lower - slack - _SLACK * abs(lower)
        freed = over or under
        if Z[MOVED] == 1 and stuck and not at_rest:
            freed = freed or (has_forward[h] if v > 0.0 else has_backward[h]) == 1
        free = gaps[h] == 0
        ending = free and abs(v) <= abs(a) * R[SOON]
        ending = ending and (
            (forward and v > 0.0 and a < 0.0) or (backward and v < 0.0 and a > 0.0)
        )
        turning = forward and (free or gap <= 1e-13) and ((at_rest and a < -calm) or ending)
        turning = turning or (backward and ((at_rest and a > calm) or ending))
        reversed_ = free and not at_rest and ((forward and v < 0.0) or (backward and v > 0.0))
        if freed or turning or reversed_:
            wrong[count] = h
            ahead = over if over or under else v > 0.0
            back[count] = 0 if turning else (1 if ahead else 2)
            count += 1
    if count == 0:
        return False
    for i in range(_to_change(Z, HOLD_FEWEST, HOLD_LEFT, count)):
        h = wrong[i]
        put(at(modes, first[h]), back[i])
        if back[i] == 0:
            halted[h] = 1
    return True


@kernel
def _flip(Z: Integers, R: Numbers) -> None:
    """Change what an event says changes."""
    kinds, numbers, fired = at(Z, Z[KIND]), at(Z, Z[NUMBER]), at(Z, Z[FIRED_ROWS])
    modes, first, lk = at(R, Z[MS]), at(Z, Z[FIRST]), at(R, Z[LK])
    seen = False
    for i in range(Z[FIRED]):
        kind, k = kinds[fired[i]], numbers[fired[i]]
        if kind == 0:
            if not seen and at(Z, Z[PIECE_COUNT])[k] > 0:
                look(Z, R, at(R, Z[XS]), modes, lk)
                seen = True
            _turn(Z, R, k, lk[k] - lk[Z[NR] + k] if seen else 0.0)
            at(Z, Z[EXEMPT])[k] = 1
        elif kind == 3:
            at(Z, Z[HALTED])[k] = 1
            if at(Z, Z[GAP])[k] == 0:
                put(at(modes, first[k]), 0)
        else:
            put(at(modes, first[k]), kind)


@kernel
def _prepare(Z: Integers, R: Numbers) -> None:
    """States and modes that are tried out."""
    nh, x, m = Z[NH], at(R, Z[XS]), at(R, Z[MS])
    for i in range(Z[N]):
        x[i] = at(R, Z[X])[i]
    for i in range(Z[NM]):
        m[i] = at(R, Z[M])[i]
    before, first, places = at(R, Z[BEFORE]), at(Z, Z[FIRST]), at(Z, Z[PLACE])
    for h in range(nh):
        stuck = 1 if before[first[h]] > 0.5 else 0
        at(Z, Z[WAS_STUCK])[h] = stuck
        at(Z, Z[HALTED])[h] = 0
        at(Z, Z[STRUCK])[h] = 0
        at(R, Z[LOSS])[h] = 0.0
        if stuck == 1 and places[h] >= 0:
            x[places[h]] = 0.0
    for k in range(Z[NR]):
        at(Z, Z[EXEMPT])[k] = 0
        at(Z, Z[JUMPED])[k] = 0
    for k in range(Z[NJ]):
        at(Z, Z[WAS_TRUE])[k] = 1 if before[at(Z, Z[JUMP_MODE])[k]] > 0.5 else 0
    Z[MOVED] = Z[SHARED] = 0
    Z[RELATION_FEWEST] = Z[HOLD_FEWEST] = _FEWEST
    Z[RELATION_LEFT] = Z[HOLD_LEFT] = _PATIENCE


@kernel
def _sharing(Z: Integers, R: Numbers) -> bool:
    """Whether what sticks now is redundant."""
    trial, modes, first = at(R, Z[TRIAL]), at(R, Z[MS]), at(Z, Z[FIRST])
    for i in range(Z[NM]):
        trial[i] = modes[i]
    for h in range(Z[NH]):
        if modes[first[h]] > 0.5:
            return redundant(Z, R, at(R, Z[XS]), trial)
    return False


@kernel
def settle(Z: Integers, R: Numbers) -> bool:
    """Modes and states just after an instant; whether some were found that fit.

    They stand where they are tried out; nothing else is touched. Redundant constraints are left
    to others.
    """
    _prepare(Z, R)
    _flip(Z, R)
    modes, first = at(R, Z[MS]), at(Z, Z[FIRST])
    for _ in range(40 + 20 * (Z[NH] + Z[NR] + Z[NJ])):
        for h in range(Z[NH]):
            modes[first[h] + 3] = 0.0
        if Z[DOUBT] == 1 and _sharing(Z, R):
            return False
        look(Z, R, at(R, Z[XS]), modes, at(R, Z[LK]))
        if _relations(Z, R) or _jumps(Z, R) or _engage(Z, R):
            continue
        struck = collide(Z, R)
        if Z[SHARED] == 1:
            return False
        if struck or _rebalance(Z, R):
            continue
        halt(Z, R)
        return Z[SHARED] == 0
    return False
