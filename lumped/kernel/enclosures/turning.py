"""Turning points of loads inside an accepted step, fed to the count of their cycles.

A load is enclosed over the step and over ever smaller parts of it, until the polynomial of each
part lacks less than counts, and turns once at most.
"""

from __future__ import annotations

from lumped.code.words import Numbers, greatest_of, kernel, least_of
from lumped.kernel.cycles import begin_count, end_count, feed
from lumped.kernel.enclosures import curves
from lumped.kernel.enclosures.enclosure import begin_survey, enclose, select
from lumped.kernel.enclosures.extremes import LOWEST, raise_in
from lumped.kernel.enclosures.models import SIZE, high, low
from lumped.kernel.interpret import evaluate
from lumped.kernel.run import Run

_COUNTS = 0.1
"""Swings below this part of the tolerance, of the largest size of a load, are none."""


@kernel
def begin_loads(run: Run) -> None:
    """No load has been seen yet."""
    watch = run.watch
    watch.loads_at = LOWEST
    begin_count(watch.count)
    for k in range(watch.loads):
        watch.load_size[k] = 0.0


@kernel
def _feed(run: Run, k: int, value: float) -> None:
    watch = run.watch
    watch.load_size[k] = max(watch.load_size[k], abs(value))
    feed(watch.count, k, value)


@kernel
def _feed_at(run: Run, k: int, part: float) -> None:
    """Feed the value at a part of the step, or list it."""
    watch = run.watch
    curves.set_values(run, watch.load, part, watch.load_value)
    value = watch.load_value[k]
    if watch.lists == 0:
        _feed(run, k, value)
        return
    curves.list_point(watch, part, value)
    if value != value:
        watch.count.damage[k] = value


@kernel
def _turns(part: Numbers) -> int:
    """How often the slope of the control polygon changes its sign; the polynomial, no more."""
    b, sign, found = part[curves.FIRST :], 0.0, 0
    for j in range(int(part[curves.TOP])):
        rise = b[j + 1] - b[j]
        found += 1 if rise * sign < 0.0 else 0
        sign = 1.0 if rise > 0.0 else -1.0 if rise < 0.0 else sign
    return found


@kernel
def _feed_between(run: Run, k: int, begin: float, end: float) -> None:
    """Feed where a load turns in a part of the step."""
    watch, e, depth, enclosed, way = run.watch, run.watch.enclosed_loads, 0, 1, 0.0
    values, size = watch.load_value, watch.load_size
    begin_survey(e, watch.load)
    select(run, e, watch.load, k)
    enclose(run, e, watch.load, begin, end - begin)
    model = e.model[SIZE * k :]
    if watch.lists == 0 and not max(high(model), -low(model)) <= size[k]:
        # swings count by the size of the load, which may be that of a burst
        raise_in(run, watch.load, e, k, 0, size, values, begin, end, size[k])
        if size[k] != size[k]:
            watch.count.damage[k] = size[k]
            return
        select(run, e, watch.load, k)
        enclose(run, e, watch.load, begin, end - begin)
    tolerance = _COUNTS * run.rtol * size[k]
    curves.set_part(run, e, watch.curves, k, begin, end, tolerance)
    while depth >= 0 and watch.count.damage[k] >= 0.0:  # a number
        part = watch.curves[curves.WORDS * depth :]
        b, top = part[curves.FIRST :], int(part[curves.TOP])
        width = part[curves.END] - part[curves.BEGIN]
        least, most = least_of(b, top), greatest_of(b, top)
        turns, is_known = _turns(part), part[curves.LACKS] <= 0.25 * tolerance
        is_flat = most - least + 2.0 * part[curves.LACKS] <= tolerance
        if is_flat and width == end - begin:
            depth -= 1
        elif is_flat or width <= curves.TOUCH or enclosed >= curves.MOST_ENCLOSED:
            # it may turn here from one long way to another
            _feed_at(run, k, part[curves.BEGIN] + 0.5 * width)
            depth, way = depth - 1, 0.0
        elif is_known and turns < 2:
            goes = 1.0 if b[0] < most and (turns == 0 or b[top] < most) else -1.0
            if way * goes < 0.0:
                _feed_at(run, k, part[curves.BEGIN])
            if turns == 1:
                _feed_at(run, k, part[curves.BEGIN] + curves.root_of_slope(run, part, goes) * width)
            depth, way = depth - 1, goes if turns == 0 else -goes
        elif curves.refine(run, e, watch.load, k, part, is_known, tolerance):
            depth += 1
        else:
            enclosed += 1


@kernel
def feed_inner(run: Run, last: float) -> None:
    """Feed, or list, where loads turn between the begin of the step and a part of it, and kinks."""
    watch, low, cut = run.watch, 0.0, curves.NEVER
    if watch.kinks > 0:
        curves.set_cuts(run, 0.0, last)
        cut = curves.next_cut(run, 0.0)
    while low < last:
        high = min(cut - curves.BESIDE, last)
        for k in range(watch.loads):
            if high > low and watch.count.damage[k] >= 0.0:
                _feed_between(run, k, low, high)
            if cut < last:
                _feed_at(run, k, cut)
        low = cut + curves.BESIDE
        cut = curves.next_cut(run, low)


@kernel
def feed_loads(run: Run, until: float) -> None:
    """Feed what an accepted step gives, up to a time."""
    watch = run.watch
    if watch.loads_at != run.t:
        evaluate(watch.load, run, run.x, run.t, run.m, watch.load_value)
        for k in range(watch.loads):
            _feed(run, k, watch.load_value[k])
    if until > run.t:
        last = 1.0 if until == run.t_new else (until - run.t) / (run.t_new - run.t)
        curves.set_values(run, watch.load, last, watch.load_end)
        for k in range(watch.loads):
            watch.load_size[k] = max(watch.load_size[k], abs(watch.load_end[k]))
        if run.plant.implicit > 0:
            watch.enclosed_loads.is_surveyed = 0
        feed_inner(run, last)
        for k in range(watch.loads):
            _feed(run, k, watch.load_end[k])
    watch.loads_at = until if until == run.t_new else LOWEST


@kernel
def end_loads(run: Run) -> None:
    """Feed the values where a run ends: a jump may be the last that happens."""
    watch = run.watch
    evaluate(watch.load, run, run.x, run.t, run.m, watch.load_value)
    for k in range(watch.loads):
        feed(watch.count, k, watch.load_value[k])
        end_count(watch.count, k)
