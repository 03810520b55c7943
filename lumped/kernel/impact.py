"""Impulses of constraints that close (see `lumped.timeloop.impact`)."""

from __future__ import annotations

from lumped.kernel.layout import (
    AFTER,
    BACK,
    BACKWARD,
    BOUNCE,
    CLOSING,
    DEMAND,
    DOUBT,
    FIRST,
    FORWARD,
    GAP,
    HALTED,
    IMPULSIVE,
    LK,
    LOOK,
    LOSS,
    LOWER,
    MEMBER,
    MOVED,
    MS,
    NH,
    NM,
    NR,
    NU,
    NV,
    PLACE,
    PUSH,
    REST,
    SHARED,
    SHORTEST,
    STILL,
    STRUCK,
    TRIAL,
    UPPER,
    USE_HOLD,
    USE_STATE,
    WAS_STUCK,
    WISH,
    XS,
    N,
    P,
    T,
)
from lumped.kernel.words import Integers, Numbers, at, evaluate, kernel

__all__ = ["collide", "halt", "look", "put", "redundant", "standstills"]

_INFINITE = float("inf")


@kernel
def put(m: Numbers, part: int) -> None:
    """Let a hold stick (0), slide (1, 2) or be free (-1)."""
    m[0] = m[1] = m[2] = 0.0
    if part >= 0:
        m[part] = 1.0


@kernel
def look(Z: Integers, R: Numbers, x: Numbers, modes: Numbers, out: Numbers) -> None:
    """Everything that decides modes; limits that are not given are infinite."""
    evaluate(Z[LOOK], x, at(R, Z[P]), R[T], modes, out)
    nh, upper, lower = Z[NH], at(Z, Z[UPPER]), at(Z, Z[LOWER])
    q = at(out, 2 * Z[NR])
    for h in range(nh):
        if upper[h] == 0:
            q[3 * nh + h] = _INFINITE
        if lower[h] == 0:
            q[4 * nh + h] = -_INFINITE


@kernel
def redundant(Z: Integers, R: Numbers, x: Numbers, trial: Numbers) -> bool:
    """Whether what sticks cannot be given any accelerations that one likes.

    Leaves what is seen without them in the place for the rest.
    """
    nh, first, wish = Z[NH], at(Z, Z[FIRST]), at(R, Z[WISH])
    rest, push = at(R, Z[REST]), at(R, Z[PUSH])
    look(Z, R, x, trial, rest)
    for h in range(nh):
        trial[first[h] + 4] = wish[h]
    look(Z, R, x, trial, push)
    found = False
    for h in range(nh):
        trial[first[h] + 4] = 0.0
        k = 2 * Z[NR] + nh + h
        error = abs(push[k] - rest[k] - wish[h])
        reaction = abs(push[k + nh] - rest[k + nh])
        if trial[first[h]] > 0.5 and (not error < 1e-6 or not reaction < _INFINITE):
            found = True
    return found


@kernel
def standstills(Z: Integers, R: Numbers) -> None:
    """Speeds that count as zero: where they are states, only zero does."""
    still, x, places = at(R, Z[STILL]), at(R, Z[XS]), at(Z, Z[PLACE])
    holds, states = at(Z, Z[USE_HOLD]), at(Z, Z[USE_STATE])
    for h in range(Z[NH]):
        still[h] = 0.0
    for i in range(Z[NU]):
        still[holds[i]] = max(still[holds[i]], abs(x[states[i]]))
    for h in range(Z[NH]):
        still[h] = 0.0 if places[h] >= 0 else 1e-9 * (1.0 + still[h])


@kernel
def _stop(Z: Integers, R: Numbers, h: int) -> None:
    """Make a speed exactly zero if it is a state."""
    place = at(Z, Z[PLACE])[h]
    if place >= 0:
        at(R, Z[XS])[place] = 0.0


@kernel
def _strike(Z: Integers, R: Numbers, seen: Numbers, pull: bool, count_losses: bool) -> None:
    """Impulses of what closes and of all constraints without limit that hold."""
    nh, n, r = Z[NH], Z[N], Z[NR]
    x, modes, trial = at(R, Z[XS]), at(R, Z[MS]), at(R, Z[TRIAL])
    first, gaps, impulsive = at(Z, Z[FIRST]), at(Z, Z[GAP]), at(Z, Z[IMPULSIVE])
    has_upper, has_lower = at(Z, Z[UPPER]), at(Z, Z[LOWER])
    closing, member = at(Z, Z[CLOSING]), at(Z, Z[MEMBER])
    demand, bounce = at(R, Z[DEMAND]), at(R, Z[BOUNCE])
    v, gap = at(seen, 2 * r), at(seen, 2 * r + 5 * nh)
    rest, push = at(R, Z[REST]), at(R, Z[PUSH])
    a0, a1 = at(rest, 2 * r + nh), at(push, 2 * r + nh)
    f0, f1 = at(rest, 2 * r + 2 * nh), at(push, 2 * r + 2 * nh)
    for h in range(nh):
        stuck = modes[first[h]] > 0.5
        member[h] = 1 if closing[h] == 1 or (stuck and impulsive[h] == 1) else 0
        demand[h] = -(1.0 + bounce[h]) * v[h] if closing[h] == 1 else 0.0
    for _ in range(2 * nh + 2):
        for i in range(Z[NM]):
            trial[i] = modes[i]
        for h in range(nh):
            put(at(trial, first[h]), 0 if member[h] == 1 else -1)
            trial[first[h] + 3] = 0.0
        if Z[DOUBT] == 1:
            if redundant(Z, R, x, trial):
                Z[SHARED] = 1
                return
        else:
            look(Z, R, x, trial, rest)
        for h in range(nh):
            if member[h] == 1:
                trial[first[h] + 4] = demand[h]
        look(Z, R, x, trial, push)
        largest = 0.0
        for h in range(nh):
            largest = max(largest, abs(f1[h] - f0[h]))
        worst, worst_size, closer = -1, 0.0, -1
        for h in range(nh):
            impulse = f1[h] - f0[h]
            wrong = (has_upper[h] == 1 and has_lower[h] == 0 and impulse > 0.0) or (
                has_lower[h] == 1 and has_upper[h] == 0 and impulse < 0.0
            )
            wrong = wrong and member[h] == 1 and abs(impulse) > 1e-12 * largest
            if wrong and abs(impulse) > worst_size:
                worst, worst_size = h, abs(impulse)
            touching = gaps[h] == 1 and modes[first[h] + 1] > 0.5 and gap[h] <= 1e-13
            if touching and member[h] == 0 and v[h] + a1[h] - a0[h] < -1e-12 and closer < 0:
                closer = h
        if worst >= 0 and not pull:
            member[worst] = 0
        elif closer >= 0:
            member[closer] = 1
            demand[closer] = -v[closer]
        else:
            break
    rates = 2 * r + 7 * nh + Z[NV]
    for i in range(n):
        x[i] += push[rates + i] - rest[rates + i]
    Z[MOVED] = 1
    if not count_losses:
        return
    struck, loss = at(Z, Z[STRUCK]), at(R, Z[LOSS])
    for h in range(nh):
        if member[h] == 1:
            speed = v[h] + a1[h] - a0[h]
            loss[h] += 0.5 * (f1[h] - f0[h]) * (v[h] + speed)
            struck[h] = 1


@kernel
def halt(Z: Integers, R: Numbers) -> None:
    """Bring the speed of what sticks to exactly zero."""
    nh, modes, first = Z[NH], at(R, Z[MS]), at(Z, Z[FIRST])
    seen, closing, bounce = at(R, Z[LK]), at(Z, Z[CLOSING]), at(R, Z[BOUNCE])
    moving = False
    for h in range(nh):
        stuck = modes[first[h]] > 0.5
        closing[h] = 1 if stuck else 0
        bounce[h] = 0.0
        if stuck and seen[2 * Z[NR] + h] != 0.0:
            moving = True
    if moving:
        _strike(Z, R, seen, True, False)
    halted, gaps = at(Z, Z[HALTED]), at(Z, Z[GAP])
    for h in range(nh):
        if modes[first[h]] > 0.5 or (halted[h] == 1 and gaps[h] == 0):
            _stop(Z, R, h)


@kernel
def _rests(Z: Integers, R: Numbers, h: int, seen: Numbers, scratch: Numbers) -> bool:
    """Whether a bounce would be over at once."""
    trial, modes, nh, r = at(R, Z[TRIAL]), at(R, Z[MS]), Z[NH], Z[NR]
    for i in range(Z[NM]):
        trial[i] = modes[i]
    put(at(trial, at(Z, Z[FIRST])[h]), 1)
    look(Z, R, at(R, Z[XS]), trial, scratch)
    a = scratch[2 * r + nh + h]
    return a < 0.0 and 2.0 * seen[2 * r + h] <= -a * R[SHORTEST]


@kernel
def collide(Z: Integers, R: Numbers) -> bool:
    """Let constraints without limit that close at a speed do so; whether there were any."""
    nh, r, modes = Z[NH], Z[NR], at(R, Z[MS])
    first, impulsive, gaps = at(Z, Z[FIRST]), at(Z, Z[IMPULSIVE]), at(Z, Z[GAP])
    forward, backward = at(Z, Z[FORWARD]), at(Z, Z[BACKWARD])
    was_stuck, halted = at(Z, Z[WAS_STUCK]), at(Z, Z[HALTED])
    closing, member = at(Z, Z[CLOSING]), at(Z, Z[MEMBER])
    bounce, still, lk = at(R, Z[BOUNCE]), at(R, Z[STILL]), at(R, Z[LK])
    q = at(lk, 2 * r)
    ready, any_ = False, False
    for h in range(nh):
        closing[h] = 0
        bounce[h] = 0.0
        if impulsive[h] == 0:
            continue
        if not ready:
            standstills(Z, R)
            ready = True
        m = at(modes, first[h])
        stuck, v = m[0] > 0.5, q[h]
        near = gaps[h] == 0 or q[5 * nh + h] <= 1e-13 or halted[h] == 1
        hit = v < -still[h] and backward[h] == 0 and near
        hit = hit or (v > still[h] and forward[h] == 0)
        hit = hit and (halted[h] == 0 or gaps[h] == 1)
        if Z[MOVED] == 0:
            hit = hit and (not stuck or was_stuck[h] == 0)
        if hit and (stuck or m[1] > 0.5 or m[2] > 0.5):
            closing[h] = 1
            bounce[h] = q[6 * nh + h]
            any_ = True
    if not any_:
        return False
    _strike(Z, R, lk, False, True)
    back = at(Z, Z[BACK])
    for h in range(nh):
        # 1: closes, 2: takes part, 4: bounces
        back[h] = closing[h] + (2 if member[h] == 1 else 0) + (4 if bounce[h] != 0.0 else 0)
    bouncing = False
    for h in range(nh):
        bouncing = bouncing or back[h] == 7
    if bouncing:
        after = at(R, Z[AFTER])
        look(Z, R, at(R, Z[XS]), modes, after)
        for h in range(nh):
            if back[h] == 7 and _rests(Z, R, h, after, at(R, Z[REST])):
                back[h] = 3
                for j in range(nh):
                    closing[j] = 1 if j == h else 0
                bounce[h] = 0.0
                _strike(Z, R, after, True, True)
    for h in range(nh):
        if back[h] & 1 == 0:
            continue
        halted[h] = 0
        m = at(modes, first[h])
        if back[h] == 3:
            put(m, 0)
            _stop(Z, R, h)
        elif back[h] == 7:
            put(m, 1)
        else:
            put(m, 1 if at(Z, Z[UPPER])[h] == 1 else 2)
    return True
