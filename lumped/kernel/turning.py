"""Turning points of loads inside an accepted step, fed to the count of their cycles.

A load is followed by its values and slopes. A part of a step is left as it is where the cubic
through its ends is close to the load at a point inside; elsewhere it is divided. That point is no
simple share of the part, so that a sine that turns by whole turns from end to end is noticed.
"""

from __future__ import annotations

from lumped.code.words import Numbers, kernel
from lumped.kernel.crossing import inside
from lumped.kernel.cycles import begin_count, end_count, feed
from lumped.kernel.extremes import LOWEST
from lumped.kernel.interpret import evaluate
from lumped.kernel.run import Run

__all__ = ["begin_loads", "end_loads", "feed_loads"]

_SPLIT = 0.381966011250105
"""Where a part is divided."""
_FINEST = 2.0**-14
"""Part of a step that is not divided; a sine may turn by a radian in each."""
_CLOSE = 0.003
"""Distance of the cubic from the load, over its way, up to which it tells how often that turns: of
40 000 runs with a fast sine that no state feels, 5 miss some of its turning points."""
_FLAT = 1e-5
"""Slope times the length of a part over the way of the load, at which it turns."""
_SEARCHES = 30
_UNKNOWN = 1e300


@kernel
def begin_loads(run: Run) -> None:
    """No load has been seen yet."""
    watch = run.watch
    watch.loads_at = LOWEST
    begin_count(watch.count)
    for k in range(watch.loads):
        watch.load_size[k] = 0.0


@kernel
def _look(run: Run, part: float) -> None:
    """Loads and their slopes at a part of the step."""
    watch = run.watch
    inside(run, part, watch.x)
    t = run.t + part * (run.t_new - run.t)
    evaluate(watch.load, run, watch.x, t, run.m, watch.load_value)


@kernel
def _feed(run: Run, k: int, value: float) -> None:
    watch = run.watch
    watch.load_size[k] = max(watch.load_size[k], abs(value))
    feed(watch.count, k, value)


@kernel
def _way(span: Numbers, length: float) -> float:
    """How far the cubic through the ends of a part may go: its control points apart."""
    reach = (span[3] - span[0]) * length / 3.0
    inner, last = span[1] + reach * span[2], span[4] - reach * span[5]
    high = max(max(span[1], span[4]), max(inner, last))
    return high - min(min(span[1], span[4]), min(inner, last))


@kernel
def _is_monotone(span: Numbers, length: float) -> bool:
    """Whether the control points of the cubic rise or fall one after the other."""
    reach = (span[3] - span[0]) * length / 3.0
    inner, last = span[1] + reach * span[2], span[4] - reach * span[5]
    rises = span[1] <= inner and inner <= last and last <= span[4]
    return rises or (span[1] >= inner and inner >= last and last >= span[4])


@kernel
def _feed_turn(run: Run, k: int, span: Numbers) -> None:
    """Feed the value at which a load turns in a part of the step: its slope has two signs.

    Illinois variant of the secant method (Dowell and Jarratt, BIT 11 (1971) 168).
    """
    watch, length = run.watch, run.t_new - run.t
    a, fa, b, fb = span[0], span[2], span[3], span[5]
    flat = _FLAT * _way(span, length) / ((b - a) * length)
    for _ in range(_SEARCHES):
        c = (a * fb - b * fa) / (fb - fa)
        _look(run, c)
        fc = watch.load_value[watch.loads + k]
        if abs(fc) <= flat:
            break
        if fc * fb < 0.0:
            a, fa = b, fb
        else:
            fa = 0.5 * fa
        b, fb = c, fc
    _feed(run, k, watch.load_value[k])


@kernel
def _divide(run: Run, k: int, span: Numbers) -> None:
    """Put the two halves of a part in its place, the first one last."""
    watch, first = run.watch, span[7:]
    low, high = span[0], span[3]
    middle = low + _SPLIT * (high - low)
    _look(run, middle)
    y, slope = watch.load_value[k], watch.load_value[watch.loads + k]
    h = (high - low) * (run.t_new - run.t)
    # Hermite's cubic at that point
    s, r = _SPLIT, 1.0 - _SPLIT
    cubic = r * r * ((1.0 + 2.0 * s) * span[1] + s * h * span[2])
    cubic += s * s * ((3.0 - 2.0 * s) * span[4] - r * h * span[5])
    rise = 6.0 * s * r * (span[4] - span[1])
    rise += h * (r * (1.0 - 3.0 * s) * span[2] + s * (3.0 * s - 2.0) * span[5])
    miss = max(abs(y - cubic), 0.25 * abs(h * slope - rise))
    first[0], first[1], first[2], first[6] = low, span[1], span[2], miss
    first[3], first[4], first[5] = middle, y, slope
    span[0], span[1], span[2], span[6] = middle, y, slope, miss


@kernel
def _feed_inner(run: Run, k: int, last: float) -> None:
    """Feed where a load turns between the begin of the step and a part of it."""
    watch, length, depth = run.watch, run.t_new - run.t, 0
    n, ends, span = watch.loads, watch.load_ends, watch.spans
    span[0], span[1], span[2] = 0.0, ends[k], ends[n + k]
    span[3], span[4], span[5], span[6] = last, ends[2 * n + k], ends[3 * n + k], _UNKNOWN
    while depth >= 0:
        span = watch.spans[7 * depth :]
        way = _way(span, length)
        turns = span[2] * span[5] < 0.0
        is_clear = span[6] <= _CLOSE * way and (turns or _is_monotone(span, length))
        is_small = way + span[6] <= run.rtol * watch.load_size[k]
        if is_clear or is_small or span[3] - span[0] <= _FINEST:
            if turns:
                _feed_turn(run, k, span)
            _feed(run, k, span[4])
            depth -= 1
        else:
            _divide(run, k, span)
            depth += 1


@kernel
def feed_loads(run: Run, until: float) -> None:
    """Feed what an accepted step gives, up to a time."""
    watch, n = run.watch, 2 * run.watch.loads
    ends = watch.load_ends
    if watch.loads_at != run.t:
        evaluate(watch.load, run, run.x, run.t, run.m, ends)
        for k in range(watch.loads):
            _feed(run, k, ends[k])
    if until > run.t:
        last = (until - run.t) / (run.t_new - run.t)
        if until == run.t_new:
            evaluate(watch.load, run, run.new, run.t_new, run.m, ends[n:])
        else:
            _look(run, last)
            for i in range(n):
                ends[n + i] = watch.load_value[i]
        for k in range(watch.loads):
            if watch.count.damage[k] >= 0.0:  # a number
                _feed_inner(run, k, last)
        for i in range(n):
            ends[i] = ends[n + i]
    watch.loads_at = until if until == run.t_new else LOWEST


@kernel
def end_loads(run: Run) -> None:
    """Feed the values where a run ends: a jump may be the last that happens."""
    watch = run.watch
    evaluate(watch.load, run, run.x, run.t, run.m, watch.load_value)
    for k in range(watch.loads):
        feed(watch.count, k, watch.load_value[k])
        end_count(watch.count, k)
