"""Extremes of quantities: whether they may rise in a step, and where they do."""

from __future__ import annotations

from lumped.code.words import Numbers, kernel
from lumped.kernel.crossing import inside
from lumped.kernel.interpret import evaluate
from lumped.kernel.run import Run

__all__ = [
    "LOWEST",
    "MOST_PARTS",
    "bound",
    "end_bound",
    "has_same_part",
    "highest_sample",
    "is_unresolved",
    "may_rise",
    "raise_all",
    "raise_at",
    "rough_bound",
    "sample_extremes",
]

MOST_PARTS = 4096
"""Parts of a step, for a quantity that is faster than all states; a sine may turn by four radians
in each."""
_REACH = 0.3
"""How far a quantity may rise above its ends in a step, over the way that its ends tell."""
_FINE = 16
_FINEST = 4.0 / _FINE
"""Parts of a step in which the curve through five samples is looked at, over a part between two."""
_DOUBT = 0.1
"""Error of that curve over its fourth difference: 0.03 for a curve that goes on so, and more."""
_SAMPLES = 8
_BESIDE = (0.38, 1.63, 3.29)
"""Where three more samples check it: five of a sine that turns by about whole turns from one to the
next lie on a slow one, too. Of fast sines, one in eight thousand passes in one part of a step."""
_ASTRAY = 0.05
"""Distance of these samples from the curve, over its second and fourth difference."""
_CLOSE = 1e-4
"""Way of a vertex over the step from which on the next one would change nothing."""
_SEARCHES = 5
LOWEST = -1.7976931348623157e308


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
    best = LOWEST
    for _ in range(_SEARCHES):
        a, c = max(u - reach, low), min(u + reach, high)
        fa, fb, fc = _height(run, k, sign, a), _height(run, k, sign, u), _height(run, k, sign, c)
        best = max(max(best, fa), max(fb, fc))
        p, q = (u - a) * (fb - fc), (u - c) * (fb - fa)
        if not p > q:
            break
        x = min(max(u - 0.5 * ((u - a) * p - (u - c) * q) / (p - q), low), high)
        # the first parabola may have its vertex in the middle by chance
        is_close = reach < width / _FINE and abs(x - u) <= _CLOSE * width
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
    for j in range(1, _SAMPLES):
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
    for j in range(_SAMPLES):
        value = watch.samples[j * watch.extremes + k]
        if value != value:
            watch.best[k] = value
    if watch.best[k] != watch.best[k] or rough_bound(run, k, sign) <= watch.best[k]:
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
    """Quantities whose extremes are wanted at five points of a part of a step, and beside them."""
    watch, length = run.watch, run.t_new - run.t
    low = (begin - run.t) / length
    width = (end - begin) / length
    for j in range(_SAMPLES):
        place = float(j) if j < 5 else _BESIDE[j - 5]
        part = low + 0.25 * place * width
        t = run.t + part * length
        inside(run, part, watch.x)
        evaluate(watch.extreme, run, watch.x, t, run.m, watch.samples[j * watch.extremes :])


@kernel
def is_unresolved(run: Run, k: int) -> bool:
    """Whether five samples are too few: a sine turns by more than a radian between two of them."""
    n, v = run.watch.extremes, run.watch.samples[k:]
    fourth, bend, beside, size = _fourth(run, k), _bend(run, k), 0.0, abs(v[0])
    for j in range(1, 5):
        size = max(size, abs(v[j * n]))
    for j in range(5, _SAMPLES):
        beside = max(beside, abs(v[j * n] - _curve(run, k, _BESIDE[j - 5])))
    is_rough = fourth > bend or beside > _ASTRAY * (fourth + bend)
    return is_rough and max(fourth, beside) > run.rtol * size


@kernel
def has_same_part(begin: Numbers, end: Numbers, i: int, k: int) -> bool:
    """Whether two integrals or extremes are taken over the same part of the run."""
    return begin[i] == begin[k] and end[i] == end[k]


@kernel
def _is_any_unresolved(run: Run, first: int, begin: float, end: float, parts: int) -> bool:
    """Whether samples are too few in one of equal parts; one part was sampled before."""
    watch, width = run.watch, (end - begin) / parts
    n = watch.integrands
    for j in range(parts):
        if parts > 1:
            sample_extremes(run, begin + j * width, begin + (j + 1) * width)
        for k in range(first, watch.extremes):
            is_meant = has_same_part(watch.begin, watch.end, n + k, n + first)
            if is_meant and is_unresolved(run, k):
                return True
    return False


@kernel
def raise_all(run: Run, first: int, begin: float, end: float) -> None:
    """Extremes over a part of the step: of a quantity and of all others with the same part.

    Steps by series are so long that each half is looked at by itself.
    """
    if run.by_series:
        middle = 0.5 * (begin + end)
        _raise_between(run, first, begin, middle)
        _raise_between(run, first, middle, end)
    else:
        _raise_between(run, first, begin, end)


@kernel
def _raise_between(run: Run, first: int, begin: float, end: float) -> None:
    watch, length, parts = run.watch, run.t_new - run.t, 1
    n = watch.integrands
    sample_extremes(run, begin, end)
    while parts < MOST_PARTS and _is_any_unresolved(run, first, begin, end, parts):
        parts *= 2
    width = (end - begin) / parts
    for j in range(parts):
        low = begin + j * width
        if parts > 1:
            sample_extremes(run, low, low + width)
        for k in range(first, watch.extremes):
            if has_same_part(watch.begin, watch.end, n + k, n + first):
                if watch.sign[k] >= 0:
                    _raise(run, k, 1.0, (low - run.t) / length, width / length)
                if watch.sign[k] <= 0:
                    _raise(run, k, -1.0, (low - run.t) / length, width / length)


@kernel
def end_bound(run: Run, k: int, sign: float) -> float:
    """Height that a quantity does not exceed in a step, from its values and slopes at both ends.

    A sine that turns by up to five radians in the step rises above its ends by less.
    """
    n, v = run.watch.extremes, run.watch.ends[k:]
    way = abs(v[2 * n] - v[0]) + (run.t_new - run.t) * (abs(v[n]) + abs(v[3 * n]))
    return max(sign * v[0], sign * v[2 * n]) + _REACH * way


@kernel
def may_rise(run: Run) -> bool:
    """Whether an extreme may rise in the present step."""
    watch = run.watch
    n, ends = watch.extremes, watch.ends
    if watch.ends_at != run.t:
        evaluate(watch.end_value, run, run.x, run.t, run.m, ends)
        watch.ends_at = run.t
    evaluate(watch.end_value, run, run.new, run.t_new, run.m, ends[2 * n :])
    for k in range(n):
        # what is no number may rise too, so that it is noticed
        if watch.sign[k] >= 0 and not end_bound(run, k, 1.0) <= watch.best[k]:
            return True
        if watch.sign[k] <= 0 and not end_bound(run, k, -1.0) <= watch.best[k]:
            return True
    return False


@kernel
def raise_at(run: Run) -> None:
    """Extremes where a run stands: a jump may be the last that happens."""
    watch, n = run.watch, run.watch.integrands
    evaluate(watch.extreme, run, run.x, run.t, run.m, watch.value)
    for k in range(watch.extremes):
        if watch.begin[n + k] <= run.t and run.t <= watch.end[n + k]:
            value = watch.value[k]
            if value != value:
                watch.best[k] = value
            if watch.sign[k] >= 0:
                watch.best[k] = max(watch.best[k], value)
            if watch.sign[k] <= 0:
                watch.best[k] = max(watch.best[k], -value)
