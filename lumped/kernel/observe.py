"""Functionals of a run, collected while it goes on."""

from __future__ import annotations

from lumped.code.words import Numbers, kernel
from lumped.kernel.crossing import inside
from lumped.kernel.interpret import evaluate
from lumped.kernel.run import Run
from lumped.kernel.watch import ALL, ANY, COUNT, INSTANT, LOSS, TIMED, VALUE

__all__ = [
    "begin_watch",
    "bound",
    "end_watch",
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

_FINE = 16
_FINEST = 4.0 / _FINE
"""Parts of a step in which the curve through five samples is looked at, over a part between two."""
_DOUBT = 0.1
"""Error of that curve over its fourth difference: 0.03 for a curve that goes on so, and more."""
_GOLDEN = 0.3819660112501051
_CLOSE = 1e-7
"""Part of a step to which an extreme is located; its value is then exact to the square of it."""
_SEARCHES = 40
_LOWEST = -1.7976931348623157e308


@kernel
def begin_watch(run: Run) -> None:
    """Nothing has been taken yet."""
    watch = run.watch
    watch.next_time = 0
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
def is_inside_wanted(run: Run) -> bool:
    """Whether a functional needs values inside the present step."""
    watch = run.watch
    if watch.looks_inside:
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
def _highest(run: Run, k: int, sign: float, low: float, high: float) -> float:
    """Greatest height between two parts of the step.

    Parabolas through the best three points, golden sections where they fail (Brent, Algorithms for
    Minimization without Derivatives, 1973, chapter 5).
    """
    x = low + _GOLDEN * (high - low)
    w = v = x
    fx = _height(run, k, sign, x)
    fw = fv = fx
    d = e = 0.0
    for _ in range(_SEARCHES):
        middle = 0.5 * (low + high)
        if abs(x - middle) <= 2.0 * _CLOSE - 0.5 * (high - low):
            break
        p = q = r = 0.0
        if abs(e) > _CLOSE:
            r = (x - w) * (fx - fv)
            q = (x - v) * (fx - fw)
            p = (x - v) * q - (x - w) * r
            q = 2.0 * (q - r)
            p = -p if q > 0.0 else p
            q = abs(q)
            r = e
            e = d
        is_parabola = abs(p) < abs(0.5 * q * r) and p > q * (low - x) and p < q * (high - x)
        if is_parabola:
            d = p / q
        else:
            e = high - x if x < middle else low - x
            d = _GOLDEN * e
        step = d if abs(d) >= _CLOSE else (_CLOSE if d > 0.0 else -_CLOSE)
        u = x + step
        fu = _height(run, k, sign, u)
        if fu >= fx:
            if u >= x:
                low = x
            else:
                high = x
            v, fv = w, fw
            w, fw = x, fx
            x, fx = u, fu
        else:
            if u < x:
                low = u
            else:
                high = u
            if fu >= fw or w == x:
                v, fv = w, fw
                w, fw = u, fu
            elif fu >= fv or v == x or v == w:
                v, fv = u, fu
    return fx


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
                first, last = max(i - 3, 0), min(i + 3, _FINE)
                a, b = low + width * first / _FINE, low + width * last / _FINE
                best = max(best, _highest(run, k, sign, a, b))
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
                if end > begin and is_first_with_its_part(watch.begin, watch.end, 0, k):
                    integrate(run, k, begin, end)
            elif end >= begin and is_first_with_its_part(watch.begin, watch.end, n, k):
                _raise_all(run, k - n, begin, end)
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
