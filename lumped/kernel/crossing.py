"""Margins inside a step, and the first instant at which one fires.

A margin falls below zero when a position must change; it has a tolerance for rounding. Each step
evaluates the margins at five points, and their slopes at both ends. Where a margin may have dipped
below zero in between, parts of the step are searched. The root is found on the dense output.
"""

from __future__ import annotations

import math

from lumped.code.words import Numbers, kernel
from lumped.kernel import dop853, falls, rodas5p, taylor
from lumped.kernel.interpret import evaluate
from lumped.kernel.plant import SLIDE
from lumped.kernel.run import STORM_SIZE, Run

__all__ = ["find_crossing", "inside", "inside_explicit", "is_suspected", "may_dip"]

_FINEST = 1e-3
"""Part of a step down to which a margin is searched for a dip below zero."""
_ITERATIONS = 40
_ROUNDING = 2.0**-53
"""Rounding of a part of a step."""
_CROWDED = 1e-14
"""Relative distance of instants that differ by rounding."""
_NOT_YET, _DONE = -1.0, 2.0

_STAYS, _FALLS, _UNSURE = range(3)
_SUSPECT, _LATER = 1, 2
"""A margin that fell below zero; one that has not fired yet at an earlier root."""


@kernel
def inside_explicit(run: Run, part: float, out: Numbers) -> None:
    """States at a part of an explicit step."""
    if run.by_series:
        taylor.interpolate(run, part, out)
    else:
        dop853.interpolate(run, part, out)


@kernel
def inside(run: Run, part: float, out: Numbers) -> None:
    """States at a part of the step."""
    if run.is_implicit:
        rodas5p.interpolate(run, part, out)
    else:
        inside_explicit(run, part, out)


@kernel
def _look(run: Run, part: float) -> None:
    """Margins and tolerances at a part of the step."""
    if part == 0.0:
        evaluate(run.plant.margin, run, run.x, run.t, run.m, run.margin)
    elif part == 1.0:
        evaluate(run.plant.margin, run, run.new, run.t_new, run.m, run.margin)
    else:
        inside(run, part, run.inner)
        t = run.t + part * (run.t_new - run.t)
        evaluate(run.plant.margin, run, run.inner, t, run.m, run.margin)


@kernel
def _sample(run: Run, row: int, part: float) -> None:
    """Margins with their tolerances as one of five samples."""
    n = run.plant.margins
    _look(run, part)
    for k in range(n):
        run.samples[row * n + k] = run.margin[k] + run.tolerance[k]


@kernel
def _slope(run: Run, row: int, part: float) -> None:
    """Time derivatives of the margins at the first or last sample."""
    t = run.t + part * (run.t_new - run.t)
    inside(run, part, run.inner)
    evaluate(run.plant.margin_rate, run, run.inner, t, run.m, run.slopes[row * run.plant.margins :])


@kernel
def may_dip(run: Run, k: int, length: float) -> bool:
    """Whether a margin may have been below zero between samples.

    Between samples a parabola dips by an eighth of its second difference, a sine that turns by up
    to a radian from one to the next by less than a sixth. If its fourth difference is not small, or
    the samples contradict its slopes, the samples do not resolve it and it may dip by more. The
    one-sided differences of fourth order are those of Fornberg, Mathematics of Computation 51
    (1988) 699.
    """
    n = run.plant.margins
    s, slopes = run.samples[k:], run.slopes[k:]
    s0, s1, s2, s3, s4 = s[0], s[n], s[2 * n], s[3 * n], s[4 * n]
    g0, g1 = length * slopes[0], length * slopes[n]
    least = min(min(min(min(s0, s1), s2), s3), s4)
    most = max(max(max(max(s0, s1), s2), s3), s4)
    r0, r1, r2, r3 = s1 - s0, s2 - s1, s3 - s2, s4 - s3
    b0, b1, b2 = r1 - r0, r2 - r1, r3 - r2
    bend = max(max(abs(b0), abs(b1)), abs(b2))
    falls = min(min(min(min(min(r0, r1), r2), r3), g0), g1)
    climbs = max(max(max(max(max(r0, r1), r2), r3), g0), g1)
    turns = falls * climbs < 0.0 and least < bend / 6.0
    early = -25 / 12 * s0 + 4.0 * s1 - 3.0 * s2 + 4 / 3 * s3 - 1 / 4 * s4
    late = 25 / 12 * s4 - 4.0 * s3 + 3.0 * s2 - 4 / 3 * s1 + 1 / 4 * s0
    rough = max(abs(b0 - 2.0 * b1 + b2), abs(0.25 * g0 - early))
    rough = max(rough, abs(0.25 * g1 - late))
    return turns or (rough > 0.2 * (most - least) and least < rough)


@kernel
def _any_may_dip(run: Run, length: float) -> bool:
    for k in range(run.plant.margins):
        if may_dip(run, k, length):
            return True
    return False


@kernel
def _first_below_zero(run: Run) -> int:
    """Number of the first sample after the begin with a margin below zero; 0 if none."""
    n = run.plant.margins
    for j in range(1, 5):
        for k in range(n):
            if run.samples[j * n + k] < 0.0:
                return j
    return 0


@kernel
def _may_fall(run: Run) -> bool:
    """Whether the polynomial of a margin falls below zero in the step, or begins there."""
    h = run.t_new - run.t
    run.sampled_to = math.inf
    _look(run, 0.0)
    for k in range(run.plant.margins):
        bound = falls.rest(run, k, h)
        if not bound > 0.0 and not falls.least(run, k, h, bound) > 0.0:
            return True
    return False


@kernel
def is_suspected(run: Run) -> bool:
    """Whether a margin fires in an accepted step, or may fire between samples."""
    n, samples, slopes, plant = run.plant.margins, run.samples, run.slopes, run.plant
    if run.by_series and run.row > run.columns:
        return _may_fall(run)
    if run.sampled_to == run.t:
        for k in range(n):
            samples[k] = samples[4 * n + k]
            slopes[k] = slopes[n + k]
    else:
        _sample(run, 0, 0.0)
        evaluate(plant.margin_rate, run, run.x, run.t, run.m, slopes)
    for j in range(1, 5):
        _sample(run, j, 0.25 * j)
    evaluate(plant.margin_rate, run, run.new, run.t_new, run.m, slopes[n:])
    run.sampled_to = run.t_new
    return _first_below_zero(run) > 0 or _any_may_dip(run, run.t_new - run.t)


@kernel
def _bracketed(run: Run) -> bool:
    """Find between which parts of the step a margin first falls below zero.

    Leaves the two parts as the first of `halves` and marks the margins that fall; gives whether
    there are any. The search goes depth first through doubtful halves, up to the first sample below
    zero: another margin may dip just before it. Each entry has its begin, its width, that sample,
    and the number of its own halves already searched.
    """
    n, halves, suspect = run.plant.margins, run.halves, run.suspect
    halves[0], halves[1], halves[2], halves[3] = 0.0, 1.0, _NOT_YET, 0.0
    depth = 0
    while depth >= 0:
        part = halves[4 * depth :]
        low, width = part[0], part[1]
        if part[2] == _NOT_YET:
            for j in range(5):
                _sample(run, j, low + 0.25 * j * width)
            _slope(run, 0, low)
            _slope(run, 1, low + width)
            part[2] = float(_first_below_zero(run))
            closer = width > _FINEST and _any_may_dip(run, width * (run.t_new - run.t))
            part[3] = 0.0 if closer else _DONE
        end = int(part[2])
        if part[3] < _DONE:
            begin = low + 0.5 * part[3] * width
            if end > 0 and low + 0.25 * end * width <= begin:
                part[3] = _DONE
            else:
                part[3] += 1.0
                depth += 1
                half = halves[4 * depth :]
                half[0], half[1], half[2], half[3] = begin, 0.5 * width, _NOT_YET, 0.0
        elif end > 0:
            _sample(run, 0, low + 0.25 * end * width)
            for k in range(n):
                suspect[k] = _SUSPECT if run.samples[k] < 0.0 else 0
            halves[0] = low + 0.25 * (end - 1) * width
            halves[1] = low + 0.25 * end * width
            return True
        else:
            depth -= 1
    return False


@kernel
def _value(run: Run, k: int, part: float, extra: float) -> float:
    """A margin plus a multiple of its tolerance."""
    _look(run, part)
    return run.margin[k] + extra * run.tolerance[k]


@kernel
def _root(run: Run, k: int, low: float, high: float, extra: float) -> float:
    """Part of the step at which a margin falls to zero: the lower end of the last bracket.

    Illinois variant of the secant method (Dowell and Jarratt, BIT 11 (1971) 168).
    """
    a, fa = low, _value(run, k, low, extra)
    b, fb = high, _value(run, k, high, extra)
    for _ in range(_ITERATIONS):
        if fb == 0.0 or not abs(a - b) > _ROUNDING:
            break
        c = b if fa == fb else (a * fb - b * fa) / (fb - fa)
        fc = _value(run, k, c, extra)
        if fc * fb < 0.0:
            a, fa = b, fb
        else:
            fa = 0.5 * fa
        b, fb = c, fc
    return b if fb <= 0.0 else a


@kernel
def _risen(run: Run, k: int, end: float) -> float:
    """A part at which a margin that begins at zero is positive before it falls again; else 0."""
    part = end
    for _ in range(1, 30):
        part *= 0.5
        if _value(run, k, part, 0.0) > 0.0:
            return part
    return 0.0


@kernel
def _is_crowded(run: Run) -> bool:
    """Whether positions changed twice at the begin of the step.

    A margin already slightly negative there fires only when it leaves its tolerance band, as
    rounding alone would change positions again.
    """
    k = run.changed_count
    if k < 2:
        return False
    return abs(run.t - run.changed[(k - 2) % STORM_SIZE]) <= _CROWDED * (1.0 + abs(run.t))


@kernel
def _next_suspect(run: Run, previous: int) -> int:
    """The first margin that has already fired at the root of the previous one; -1 if none."""
    found = -1
    for k in range(run.plant.margins):
        if run.suspect[k] == _SUSPECT:
            if k == previous or not run.margin[k] < -run.tolerance[k]:
                run.suspect[k] = _LATER
            elif found < 0:
                found = k
    return found


@kernel
def _note_fired(run: Run, last: int) -> None:
    """Note the margins that fire at the crossing: the last, and those at zero with it."""
    instant = run.instant
    count = 0
    for k in range(run.plant.margins):
        if k == last or (run.margin[k] <= run.tolerance[k] and run.suspect[k] != 0):
            instant.fired[count] = k
            count += 1
    instant.fired_count = count


@kernel
def _fired_at(run: Run, k: int, low: float, high: float, is_crowded: bool) -> float:
    """Part of the step at which a margin fires that is below zero at the end of an interval."""
    begin = low if low > 0.0 else _risen(run, k, high)
    # speeds and gaps may stay where they stop, so they fire at half of their tolerance
    extra = 0.0 if not is_crowded else 0.5 if run.plant.margin_kind[k] == SLIDE else 1.0
    found = _root(run, k, begin, high, extra)
    if not (begin - _FINEST <= found and found <= high):
        # the margin was within its tolerance all the time before, as rounding may move a rest
        found = _root(run, k, begin, high, 1.0)
    return max(found, 0.0)


@kernel
def _stand(run: Run, part: float) -> None:
    """States, time and margins at a crossing."""
    plant = run.plant
    run.t_cross = run.t + part * (run.t_new - run.t)
    if part < 1.0:
        inside(run, part, run.inner)
    else:
        for i in range(plant.states):
            run.inner[i] = run.new[i]
    evaluate(plant.margin, run, run.inner, run.t_cross, run.m, run.margin)


@kernel
def _find_fall(run: Run) -> int:
    """Find the first instant from the polynomials of all margins: FALLS, STAYS or UNSURE.

    UNSURE: a margin begins below zero, has no series there, as of a root at zero, or differs from
    its polynomial by more than its tolerance.
    """
    n, h = run.plant.margins, run.t_new - run.t
    is_crowded = _is_crowded(run)
    first, last = _DONE, -1
    _look(run, 0.0)
    for k in range(n):
        run.samples[k] = _DONE
        bound = falls.rest(run, k, h)
        if not (run.margin[k] + run.tolerance[k] >= 0.0 and bound > -falls.LARGEST):
            return _UNSURE
        if not bound > 0.0 and falls.first_fall(run, k, h):
            low, high = run.halves[0], run.halves[1]
            if not _value(run, k, high, 1.0) < 0.0:
                return _UNSURE
            run.samples[k] = _fired_at(run, k, low, high, is_crowded)
            if run.samples[k] < first:
                first, last = run.samples[k], k
            _look(run, 0.0)
    if last < 0:
        return _STAYS
    for k in range(n):
        run.suspect[k] = _SUSPECT if run.samples[k] <= first + _FINEST else 0
    _stand(run, first)
    _note_fired(run, last)
    return _FALLS


@kernel
def find_crossing(run: Run) -> bool:
    """Find the first instant in the step at which a margin fires; whether there is one.

    Leaves the states there in `inner`, the time in `t_cross`, and the margins that fired.
    """
    run.sampled_to = math.inf
    if run.by_series and run.row > run.columns:
        status = _find_fall(run)
        if status != _UNSURE:
            return status == _FALLS
    if not _bracketed(run):
        return False
    low, high, last = run.halves[0], run.halves[1], -1
    is_crowded = _is_crowded(run)
    margin = 0
    while run.suspect[margin] != _SUSPECT:
        margin += 1
    while margin >= 0:
        high = _fired_at(run, margin, low, high, is_crowded)
        _stand(run, high)
        last = margin
        margin = _next_suspect(run, last)
    _note_fired(run, last)
    return True
