"""Functionals of a run, collected while it goes on."""

from __future__ import annotations

from lumped.code.words import Numbers, kernel
from lumped.kernel import dop853
from lumped.kernel.crossing import inside
from lumped.kernel.interpret import evaluate
from lumped.kernel.run import Run
from lumped.kernel.watch import ALL, ANY, COUNT, IMPULSE, INSTANT, LOSS, TIMED, VALUE

__all__ = [
    "begin_watch",
    "bound",
    "end_bound",
    "end_watch",
    "has_border",
    "highest_sample",
    "integrate",
    "is_first_with_its_part",
    "is_inside_wanted",
    "observe",
    "observe_clocks",
    "observe_event",
    "rough_bound",
    "sample_extremes",
]

_NODES = (
    0.019855071751231884,
    0.10166676129318664,
    0.2372337950418355,
    0.4082826787521751,
    0.5917173212478249,
    0.7627662049581645,
    0.8983332387068134,
    0.9801449282487681,
)
_WEIGHTS = (
    0.05061426814518813,
    0.11119051722668724,
    0.15685332293894363,
    0.18134189168918097,
    0.18134189168918097,
    0.15685332293894363,
    0.11119051722668724,
    0.05061426814518813,
)
"""Gauss's rule on (0, 1): exact for the square of what the interpolation of a step gives."""

_REACH = 0.3
"""How far a quantity may rise above its ends in a step, over the way that its ends tell."""
_FINE = 16
_FINEST = 4.0 / _FINE
"""Parts of a step in which the curve through five samples is looked at, over a part between two."""
_DOUBT = 0.1
"""Error of that curve over its fourth difference: 0.03 for a curve that goes on so, and more."""
_CLOSE = 1e-4
"""Way of a vertex over the step from which on the next one would change nothing."""
_SEARCHES = 5
_LOWEST = -1.7976931348623157e308


@kernel
def begin_watch(run: Run) -> None:
    """Nothing has been taken yet."""
    watch = run.watch
    watch.next_time = 0
    watch.ends_at = _LOWEST
    for k in range(watch.integrands):
        watch.sums[k] = 0.0
    for k in range(watch.extremes):
        watch.best[k] = _LOWEST
    for k in range(watch.points):
        watch.totals[k] = 0.0
    for k in range(watch.wanted_events):
        watch.happened[k] = 0
        watch.taken[k] = 0.0
        watch.told[k] = _LOWEST


@kernel
def end_bound(run: Run, k: int, sign: float) -> float:
    """Height that a quantity does not exceed in a step, from its values and slopes at both ends.

    A sine that turns by up to five radians in the step rises above its ends by less.
    """
    n, v = run.watch.extremes, run.watch.ends[k:]
    way = abs(v[2 * n] - v[0]) + (run.t_new - run.t) * (abs(v[n]) + abs(v[3 * n]))
    return max(sign * v[0], sign * v[2 * n]) + _REACH * way


@kernel
def _may_rise(run: Run) -> bool:
    """Whether an extreme may rise in the present step."""
    watch = run.watch
    n, ends = watch.extremes, watch.ends
    if watch.ends_at != run.t:
        evaluate(watch.end_value, run, run.x, run.t, run.m, ends)
        watch.ends_at = run.t
    evaluate(watch.end_value, run, run.new, run.t_new, run.m, ends[2 * n :])
    for k in range(n):
        if watch.sign[k] >= 0 and end_bound(run, k, 1.0) > watch.best[k]:
            return True
        if watch.sign[k] <= 0 and end_bound(run, k, -1.0) > watch.best[k]:
            return True
    return False


@kernel
def has_border(begin: float, end: float, t: float, t_new: float) -> bool:
    """Whether a part of the run begins or ends inside a step."""
    return (t < begin and begin < t_new) or (t < end and end < t_new)


@kernel
def _is_rough(run: Run) -> bool:
    """Whether integrals over the step need values inside it."""
    watch = run.watch
    if run.is_implicit:
        return True
    for k in range(watch.integrands):
        if has_border(watch.begin[k], watch.end[k], run.t, run.t_new):
            return True
    return dop853.integrals_by_stages(run, run.t_new - run.t) > 1.0


@kernel
def is_inside_wanted(run: Run) -> bool:
    """Whether a functional needs values inside the present step."""
    watch = run.watch
    watch.may_rise = watch.extremes > 0 and _may_rise(run)
    watch.is_rough = watch.integrands > 0 and _is_rough(run)
    if watch.is_rough or watch.may_rise:
        return True
    return watch.next_time < watch.times and watch.time[watch.next_time] < run.t_new


@kernel
def integrate(run: Run, k: int, begin: float, end: float) -> None:
    """Add an integral over a part of the step to its sum, and all others with the same part."""
    watch, length = run.watch, run.t_new - run.t
    for j in range(8):
        t = begin + _NODES[j] * (end - begin)
        inside(run, (t - run.t) / length, watch.x)
        evaluate(watch.integrand, run, watch.x, t, run.m, watch.value)
        for i in range(k, watch.integrands):
            if watch.begin[i] == watch.begin[k] and watch.end[i] == watch.end[k]:
                part = _WEIGHTS[j] * (end - begin) * watch.value[i]
                watch.sums[i] += part if end > begin else 0.0


@kernel
def is_first_with_its_part(begin: Numbers, end: Numbers, first: int, k: int) -> bool:
    """Whether no integral or extreme before another is taken over the same part of the run."""
    for i in range(first, k):
        if begin[i] == begin[k] and end[i] == end[k]:
            return False
    return True


@kernel
def _height(run: Run, k: int, sign: float, part: float) -> float:
    """A quantity at a part of the step, with a sign."""
    watch = run.watch
    t = run.t + part * (run.t_new - run.t)
    inside(run, part, watch.x)
    evaluate(watch.extreme, run, watch.x, t, run.m, watch.value)
    return sign * watch.value[k]


@kernel
def _highest(run: Run, k: int, sign: float, low: float, width: float, near: int) -> float:
    """Greatest height near one of the fine points: vertices of ever narrower parabolas."""
    high, reach = low + width, width / _FINE
    u = low + reach * min(max(near, 1), _FINE - 1)
    best = _LOWEST
    for _ in range(_SEARCHES):
        a, c = max(u - reach, low), min(u + reach, high)
        fa, fb, fc = _height(run, k, sign, a), _height(run, k, sign, u), _height(run, k, sign, c)
        best = max(max(best, fa), max(fb, fc))
        p, q = (u - a) * (fb - fc), (u - c) * (fb - fa)
        if not p > q:
            break
        x = min(max(u - 0.5 * ((u - a) * p - (u - c) * q) / (p - q), low), high)
        is_close = abs(x - u) <= _CLOSE * width
        u = x
        reach *= 0.0625
        if is_close:
            break
    return max(best, _height(run, k, sign, u))


@kernel
def _curve(run: Run, k: int, s: float) -> float:
    """The polynomial through five samples (Newton's form), with s from 0 to 4."""
    n, v = run.watch.extremes, run.watch.samples[k:]
    a0, a1, a2, a3 = v[n] - v[0], v[2 * n] - v[n], v[3 * n] - v[2 * n], v[4 * n] - v[3 * n]
    b0, b1, b2 = a1 - a0, a2 - a1, a3 - a2
    c0, c1 = b1 - b0, b2 - b1
    rest = c0 / 6.0 + (s - 3.0) / 24.0 * (c1 - c0)
    return v[0] + s * (a0 + (s - 1.0) * (0.5 * b0 + (s - 2.0) * rest))


@kernel
def _fourth(run: Run, k: int) -> float:
    n, v = run.watch.extremes, run.watch.samples[k:]
    return abs(v[0] - 4.0 * v[n] + 6.0 * v[2 * n] - 4.0 * v[3 * n] + v[4 * n])


@kernel
def _bend(run: Run, k: int) -> float:
    """Largest second difference of the samples."""
    n, v, bend = run.watch.extremes, run.watch.samples[k:], 0.0
    for j in range(1, 4):
        bend = max(bend, abs(v[(j - 1) * n] - 2.0 * v[j * n] + v[(j + 1) * n]))
    return bend


@kernel
def _doubt(run: Run, k: int) -> float:
    """How far the curve may be from the quantity between samples."""
    # between two of the fine points the curve rises by an eighth of its second difference there
    return _DOUBT * _fourth(run, k) + 0.125 * _FINEST * _FINEST * _bend(run, k)


@kernel
def highest_sample(run: Run, k: int, sign: float) -> float:
    """Greatest of the samples, with a sign."""
    n, v = run.watch.extremes, run.watch.samples[k:]
    top = sign * v[0]
    for j in range(1, 5):
        top = max(top, sign * v[j * n])
    return top


@kernel
def rough_bound(run: Run, k: int, sign: float) -> float:
    """Height that the curve and its doubt do not exceed, from differences alone."""
    bend, fourth = _bend(run, k), _fourth(run, k)
    # the second derivative of the curve is below three times the bend and the fourth difference
    most = highest_sample(run, k, sign) + 0.375 * bend + 0.125 * fourth
    return most + _doubt(run, k)


@kernel
def bound(run: Run, k: int, sign: float) -> float:
    """Height that the quantity does not exceed in the samples' part of the step."""
    top = sign * _curve(run, k, 0.0)
    for i in range(1, _FINE + 1):
        top = max(top, sign * _curve(run, k, _FINEST * i))
    return top + _doubt(run, k)


@kernel
def _raise(run: Run, k: int, sign: float, low: float, width: float) -> None:
    """Raise the best height of a quantity by what a part of the step gives."""
    watch = run.watch
    if rough_bound(run, k, sign) <= watch.best[k]:
        return
    best = max(watch.best[k], highest_sample(run, k, sign))
    least = best - _doubt(run, k)
    for i in range(_FINE + 1):
        here = sign * _curve(run, k, _FINEST * i)
        if here > least:
            before = sign * _curve(run, k, _FINEST * (i - 1))
            after = sign * _curve(run, k, _FINEST * (i + 1))
            if (i == 0 or here >= before) and (i == _FINE or here > after):
                best = max(best, _highest(run, k, sign, low, width, i))
    watch.best[k] = best


@kernel
def sample_extremes(run: Run, begin: float, end: float) -> None:
    """Quantities whose extremes are wanted at five points of a part of the step."""
    watch, length = run.watch, run.t_new - run.t
    low = (begin - run.t) / length
    width = (end - begin) / length
    for j in range(5):
        part = low + 0.25 * j * width
        t = run.t + part * length
        inside(run, part, watch.x)
        evaluate(watch.extreme, run, watch.x, t, run.m, watch.samples[j * watch.extremes :])


@kernel
def _raise_all(run: Run, first: int, begin: float, end: float) -> None:
    """Extremes over a part of the step: of a quantity and of all others with the same part."""
    watch, length = run.watch, run.t_new - run.t
    n, i = watch.extremes, watch.integrands
    low = (begin - run.t) / length
    width = (end - begin) / length
    sample_extremes(run, begin, end)
    for k in range(first, n):
        has_same_begin = watch.begin[i + k] == watch.begin[i + first]
        if has_same_begin and watch.end[i + k] == watch.end[i + first]:
            if watch.sign[k] >= 0:
                _raise(run, k, 1.0, low, width)
            if watch.sign[k] <= 0:
                _raise(run, k, -1.0, low, width)


@kernel
def observe(run: Run, until: float) -> None:
    """Take what functionals need from an accepted step, up to a time."""
    watch = run.watch
    n = watch.integrands
    if run.t_new > run.t:
        for k in range(n + watch.extremes):
            begin, end = max(run.t, watch.begin[k]), min(until, watch.end[k])
            if k < n:
                if end == run.t_new and begin == run.t and not watch.is_rough:
                    watch.sums[k] += watch.parts[k]
                elif end > begin and is_first_with_its_part(watch.begin, watch.end, 0, k):
                    integrate(run, k, begin, end)
            elif (
                watch.may_rise
                and end >= begin
                and is_first_with_its_part(watch.begin, watch.end, n, k)
            ):
                _raise_all(run, k - n, begin, end)
    watch.ends_at = run.t_new if until == run.t_new else _LOWEST
    for i in range(2 * watch.extremes):
        watch.ends[i] = watch.ends[2 * watch.extremes + i]
    k = watch.next_time
    while k < watch.times and watch.time[k] < until:
        part = (watch.time[k] - run.t) / (run.t_new - run.t)
        inside(run, part, watch.x)
        evaluate(watch.point, run, watch.x, watch.time[k], run.m, watch.value)
        watch.totals[watch.time_of[k]] += watch.value[watch.time_of[k]]
        k += 1
    watch.next_time = k


@kernel
def end_watch(run: Run) -> None:
    """Take what is wanted at the end of a run."""
    watch = run.watch
    while watch.next_time < watch.times:
        k = watch.next_time
        evaluate(watch.point, run, run.x, run.t, run.m, watch.value)
        watch.totals[watch.time_of[k]] += watch.value[watch.time_of[k]]
        watch.next_time = k + 1
    if watch.finals > 0:
        evaluate(watch.final, run, run.x, run.t, run.m, watch.last)


@kernel
def _take(run: Run, k: int, value: float) -> None:
    """Take a number from one of the wanted events."""
    watch, number = run.watch, run.watch.event_number[k]
    if number == ALL:
        watch.taken[k] += value
    elif number < 0:
        watch.ring[watch.latest[k] + watch.happened[k] % (0 - number)] = value
    elif number == watch.happened[k]:
        watch.taken[k] = value
    watch.happened[k] += 1


@kernel
def observe_event(run: Run, kind: int, number: int, after: int, loss: float) -> None:
    """Take what functionals need from a change of position.

    The states and settings before it are those of the run, apart from functions of time; those
    after it are in `instant`.
    """
    watch, instant = run.watch, run.instant
    for i in range(watch.matches):
        row = watch.match[4 * i :]
        k = row[3]
        is_told = kind == TIMED and watch.told[k] == run.t
        if row[0] == kind and row[1] == number and (row[2] == ANY or row[2] == after):
            if is_told:
                continue
            watch.told[k] = run.t
            what = watch.event_kind[k]
            if what == COUNT:
                _take(run, k, 1.0)
            elif what == INSTANT:
                _take(run, k, run.t)
            elif what == LOSS:
                if loss != 0.0 or instant.is_struck[number]:
                    _take(run, k, loss)
            elif what == IMPULSE:
                if instant.impulse[number] != 0.0:
                    _take(run, k, instant.impulse[number])
            elif what == VALUE:
                if watch.event_side[k]:
                    evaluate(watch.event_point, run, instant.x, run.t, instant.m, watch.value)
                else:
                    evaluate(watch.event_point, run, run.x, run.t, instant.before, watch.value)
                _take(run, k, watch.value[watch.event_of[k]])


@kernel
def observe_clocks(run: Run) -> None:
    """Take what functionals need where functions of time change their settings."""
    n = run.timed
    for i in range(n):
        now = run.segment * n + i
        if run.timed_values[now] != run.timed_values[now - n]:
            observe_event(run, TIMED, i, 0, 0.0)
