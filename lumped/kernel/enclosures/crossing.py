"""Margins inside a step, and the first instant at which one fires.

A margin falls below zero when a position must change; it has a tolerance for rounding. Lower bounds
over a step, from the ranges of the states, clear most margins. Any other is enclosed over the step
and over ever smaller parts of it, the first ones first, until it is clear of zero or falls once.
The root is then found on the margin at the polynomials of the states. So the instants are those of
the polynomials, however short a margin is below zero.
"""

from __future__ import annotations

from lumped.code.words import Numbers, copy_numbers, kernel
from lumped.kernel.enclosures.enclosure import enclose, select, select_open, value_at
from lumped.kernel.enclosures.models import REST, SIZE, to_bernstein
from lumped.kernel.interpret import evaluate
from lumped.kernel.methods.any_method import inside, set_all_ranges
from lumped.kernel.plant import CONDITION, SLIDE
from lumped.kernel.roots import begin_bracket, narrow, next_point
from lumped.kernel.run import STORM_SIZE, Run

_TOUCH = 1e-12
"""Part of a step that is not divided: what is open there touches zero."""
_MOST_PARTS = 4096
"""Parts in which a margin is enclosed; only one that is zero for long needs more."""
_TOGETHER = 1e-3
"""Part of a step within which others may fire with the first margin."""
_EARLY = 0.25
"""Part of a step in which a margin that begins below zero must come back."""
_LAST = 1e-9
"""Part of a step before its end: what falls in it may fall with what happens there."""
_ROUNDING = 2.0**-53
"""Rounding of a part of a step."""
_CROWDED = 1e-14
"""Relative distance of instants that differ by rounding."""
_NEVER = 2.0

_CLEAR, _FALLS, _OPEN = range(3)


@kernel
def _value(run: Run, k: int, part: float, extra: float) -> float:
    """A margin at a part of the step, plus a multiple of its tolerance."""
    margin = run.at_begin[k]
    if part >= 1.0:
        margin = run.at_end[k]
    elif part > 0.0:
        select(run, run.enclosed_margins, run.plant.margin, k)
        inside(run, part, run.inner)
        t = run.t + part * (run.t_new - run.t)
        margin = value_at(run.enclosed_margins, run.plant.margin, run.inner, t)
    return margin + extra * _tolerance(run, k)


@kernel
def _look(run: Run, part: float) -> None:
    """States, margins and tolerances at a part of the step."""
    if part < 1.0:
        inside(run, part, run.inner)
    else:
        copy_numbers(run.plant.states, run.new, run.inner)
    t = run.t + part * (run.t_new - run.t)
    evaluate(run.plant.margin, run, run.inner, t, run.m, run.margin)


@kernel
def _tolerance(run: Run, k: int) -> float:
    """Tolerance of a margin at the ends of the step."""
    n = run.plant.margins
    return min(run.at_begin[n + k], run.at_end[n + k])


@kernel
def _root(run: Run, k: int, low: float, high: float, extra: float, sign: float) -> float:
    """Part of the step at which a margin falls to zero, or rises (sign -1): the end that has."""
    b = run.bracket
    at_low, at_high = sign * _value(run, k, low, extra), sign * _value(run, k, high, extra)
    if not at_low > 0.0:
        return low
    if not at_high < 0.0:
        return high
    begin_bracket(b, low, at_low, high, at_high)
    part = next_point(b)
    while narrow(b, part, sign * _value(run, k, part, extra), _ROUNDING):
        part = next_point(b)
    return b.last if b.at_last <= 0.0 else b.other


@kernel
def _find_rise(run: Run, k: int, end: float) -> float:
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
def _judge(
    run: Run, model: Numbers, tolerance: float, level: float, last: float, width: float
) -> int:
    """What a margin does in a part, from its model and its value at the end."""
    top, rest, b = to_bernstein(model, run.bernstein), model[REST], run.bernstein
    least, changes = b[0], 0
    for j in range(1, top + 1):
        least = min(least, b[j])
        if (b[j] < level) != (b[j - 1] < level):
            changes += 1
    if least - rest >= level:
        return _CLEAR
    is_low = not last >= level
    # the model falls once, and what it lacks counts as nothing
    if is_low and changes == 1 and rest <= tolerance:
        return _FALLS
    if width <= _TOUCH:
        return _FALLS if is_low else _CLEAR
    return _OPEN


@kernel
def _first_fall(run: Run, k: int, until: float) -> bool:
    """Find a part of the step, begun before another, in which a margin first falls below zero.

    It is left as the first of `halves`. It begins where the margin is last known to be above zero:
    where it falls flatly, other parts of the step may lie within its tolerance.
    """
    ends, levels, tolerance = run.halves, run.levels, _tolerance(run, k)
    begin, above, depth, parts = 0.0, 0.0, 0, 0
    ends_low = run.at_begin[k] > tolerance and run.at_end[k] < 0.0
    ends_low = ends_low and _value(run, k, 1.0 - _LAST, 0.0) < 0.0
    if run.at_begin[k] < -tolerance:
        if _value(run, k, _EARLY, 0.0) < -tolerance:
            ends[0] = ends[1] = 0.0
            return True
        begin = above = _root(run, k, 0.0, _EARLY, 1.0, -1.0)
    ends[0], levels[0] = 1.0, run.at_end[k]
    while depth >= 0 and begin <= until:
        end, last = ends[depth], levels[depth]
        if parts > 0 or begin > 0.0:
            select(run, run.enclosed_margins, run.plant.margin, k)
            enclose(run, run.enclosed_margins, run.plant.margin, begin, end - begin)
        parts += 1
        width = end - begin if parts < _MOST_PARTS else 0.0
        # what comes from above its tolerance, and was below zero before the end, has fallen
        level = 0.0 if ends_low and end >= 1.0 else -tolerance
        found = _judge(run, run.enclosed_margins.model[SIZE * k :], tolerance, level, last, width)
        if found == _FALLS:
            ends[0], ends[1] = above, end
            return True
        if found == _CLEAR:
            begin = end
            above = end if last > tolerance else above
            depth -= 1
        else:
            depth += 1
            ends[depth] = begin + 0.5 * (end - begin)
            _look(run, ends[depth])
            levels[depth] = run.margin[k]
            # sides that are small inside the step leave a smaller tolerance
            tolerance = min(tolerance, run.tolerance[k])
    return False


@kernel
def _find_firing(run: Run, k: int, low: float, high: float, is_crowded: bool) -> float:
    """Part of the step at which a margin fires that is below zero at the end of an interval."""
    # speeds and gaps may stay where they stop, so they fire at half of their tolerance
    extra = 0.0 if not is_crowded else 0.5 if run.plant.margin_kind[k] == SLIDE else 1.0
    begin = low
    if not _value(run, k, low, -1.0) > 0.0:
        # it may rise from zero first
        begin = max(_find_rise(run, k, high), low)
        if not _value(run, k, begin, extra) > 0.0:
            # it was within its tolerance all the time before, as rounding may move a rest
            once, twice = _root(run, k, low, high, 1.0, 1.0), _root(run, k, low, high, 2.0, 1.0)
            found = once - (twice - once)
            return found if found > low + _TOUCH else low
    return _root(run, k, begin, high, extra, 1.0)


@kernel
def _note_fired(run: Run, first: float, last: int) -> None:
    """Note the margins that fire at the crossing: the first, and those that fall to zero with it.

    That of a hold which rests at zero, or has just left it, does not fall.
    """
    instant, n = run.instant, run.plant.margins
    count = 0
    for k in range(n):
        is_near = run.fires[k] <= first + _TOGETHER and run.margin[k] <= run.tolerance[k]
        falls = run.plant.margin_kind[k] == CONDITION or run.at_begin[k] > run.at_begin[n + k]
        if k == last or (is_near and falls):
            instant.fired[count] = k
            count += 1
    instant.fired_count = count


@kernel
def find_crossing(run: Run) -> bool:
    """Find the first instant in the step at which a margin fires; whether there is one.

    Leaves the states there in `inner`, the time in `t_cross`, and the margins that fired.
    """
    set_all_ranges(run)
    evaluate(run.plant.margin_floor, run, run.ranges, run.t, run.m, run.floor)
    for k in range(run.plant.margins):
        if not run.floor[k] >= 0.0:
            return find_below(run)
    return False


@kernel
def find_below(run: Run) -> bool:
    """The same, where lower bounds of the margins are known, and one is below zero."""
    n = run.plant.margins
    e, is_same = run.enclosed_margins, True
    if run.plant.implicit > 0:
        e.is_surveyed = 0
    for k in range(n):
        is_open = 0 if run.floor[k] >= 0.0 else 1
        is_same = is_same and e.is_open[k] == is_open
        e.is_open[k] = is_open
    select_open(run, e, run.plant.margin, is_same)
    enclose(run, run.enclosed_margins, run.plant.margin, 0.0, 1.0)
    evaluate(run.plant.margin, run, run.x, run.t, run.m, run.at_begin)
    evaluate(run.plant.margin, run, run.new, run.t_new, run.m, run.at_end)
    first, last = _NEVER, -1
    is_crowded = _is_crowded(run)
    for k in range(n):
        run.fires[k] = _NEVER
        if not run.floor[k] >= 0.0 and _first_fall(run, k, first + _TOGETHER):
            low, high = run.halves[0], run.halves[1]
            if last >= 0 and low <= first and first < high and _value(run, k, first, 1.0) >= 0.0:
                # it falls later, or at the same instant
                run.fires[k] = first
                continue
            run.fires[k] = _find_firing(run, k, low, high, is_crowded)
            if run.fires[k] < first:
                first, last = run.fires[k], k
    if last < 0:
        return False
    run.t_cross = run.t + first * (run.t_new - run.t)
    _look(run, first)
    _note_fired(run, first, last)
    return True
