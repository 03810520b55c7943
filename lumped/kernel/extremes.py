"""Extremes of quantities: whether they may rise in a step, and where they do.

What a quantity cannot exceed while states and time move within their ranges clears most steps. In
any other it is enclosed, over the step and over ever smaller parts of it, until its polynomial
tells the greatest value, or no part may hold a greater one than is known.
"""

from __future__ import annotations

from lumped.code.words import Numbers, kernel, sqrt
from lumped.kernel import dop853, rodas5p
from lumped.kernel.crossing import inside, set_all_ranges
from lumped.kernel.enclosure import (
    begin_survey,
    enclose,
    select,
    set_ranges_in,
)
from lumped.kernel.interpret import evaluate
from lumped.kernel.models import REST, SIZE, to_bernstein
from lumped.kernel.plant import Function
from lumped.kernel.run import Run

__all__ = [
    "LOWEST",
    "MOST_PARTS",
    "has_same_part",
    "may_rise",
    "raise_all",
    "raise_at",
    "rises",
    "set_rough_ranges",
]

LOWEST = -1.7976931348623157e308
MOST_PARTS = 4096
"""Parts of a step in which integrals are taken."""
_EXACT = 1e-10
"""What is greater by less than this part of its size is no better extreme."""
_TOUCH = 1e-12
"""Part of a step that is not divided."""
_MOST_PARTS = 1 << 16
"""Parts in which a quantity is enclosed; only one that jumps, or is rough everywhere, needs more."""
_ROUGH = 0.01
"""What a polynomial may lack, over its way, for a guess how much less it lacks in a smaller part."""
_LEAST_PART = 1.0 / 16.0
"""Of a part in which a quantity was enclosed, where it is enclosed next."""
_SEARCHES = 60
_CLOSE = 1e-8
"""Part of a part at which the top of a polynomial is found; its value is known to the square."""

_SAME = 1e-15
"""Distance of parts of a step that differ by rounding."""
_BESIDE = 1e-10
"""Of a kink, where parts with smooth quantities begin and end."""
_NEVER = 2.0

_BEGIN, _END, _LACKS, _TOP, _WIDTH, _FIRST = range(6)
"""A part of the step that waits: its ends, what its polynomial lacks, the degree of that, the width
from which on it is enclosed again (below zero: it was), and the first of eight coefficients."""
_WORDS = _FIRST + 8


@kernel
def has_same_part(begin: Numbers, end: Numbers, i: int, k: int) -> bool:
    """Whether two integrals or extremes are taken over the same part of the run."""
    return begin[i] == begin[k] and end[i] == end[k]


@kernel
def rises(run: Run) -> float:
    """1 if an extreme may rise in the step, for all that ranges of states and time tell, else 0."""
    watch, found = run.watch, 0.0 * run.t
    n = watch.integrands
    evaluate(watch.height, run, run.ranges, run.t, run.m, watch.heights)
    for k in range(watch.extremes):
        best = watch.best[k]
        is_out = run.t_new < watch.begin[n + k] or run.t > watch.end[n + k] or best != best
        found = found if is_out or watch.heights[k] <= best + _EXACT * abs(best) else 1.0
    return found


@kernel
def set_rough_ranges(run: Run) -> None:
    """Ranges of states and time in an explicit step whose interpolation is not known."""
    n = run.plant.states
    dop853.set_rough_ranges(run.x, run.new, run.ranges, run.stages, n, run.t_new - run.t)
    run.ranges[2 * n], run.ranges[2 * n + 1] = run.t, run.t_new


@kernel
def may_rise(run: Run) -> bool:
    """Whether an extreme may rise in the step, before its interpolation is known.

    Where it is computed in any case it tells more.
    """
    if run.plant.margins > 0:
        return True
    if run.is_implicit or run.by_series or run.plant.states == 0:
        if run.is_implicit:
            rodas5p.dense_output(run)
        set_all_ranges(run)
    else:
        set_rough_ranges(run)
    return rises(run) > 0.5


@kernel
def _height(sign: int, value: float) -> float:
    """A quantity whose greatest value is wanted."""
    return abs(value) if sign == 0 else value if sign > 0 else -value


@kernel
def _raise(run: Run, k: int, value: float) -> None:
    """Raise an extreme to a value; what is no number stays."""
    best, height = run.watch.best, _height(run.watch.sign[k], value)
    best[k] = height if height > best[k] or height != height else best[k]


@kernel
def _set_values(run: Run, function: Function, part: float, out: Numbers) -> None:
    """Results of a function at a part of the step."""
    t, x = run.t + part * (run.t_new - run.t), run.watch.x
    if part <= 0.0:
        evaluate(function, run, run.x, run.t, run.m, out)
    elif part >= 1.0:
        evaluate(function, run, run.new, run.t_new, run.m, out)
    else:
        inside(run, part, x)
        evaluate(function, run, x, t, run.m, out)


@kernel
def _raise_inside(run: Run, k: int, part: float) -> None:
    """Raise an extreme to the value at a part of the step."""
    watch = run.watch
    _set_values(run, watch.extreme, part, watch.value)
    _raise(run, k, watch.value[k])


# -- polynomials ---------------------------------------------------------------------------------


@kernel
def _set_part(run: Run, part: Numbers, k: int, begin: float, end: float, tolerance: float) -> None:
    """What the model of a quantity tells of a part of the step."""
    model = run.watch.enclosed_extremes.model[SIZE * k :]
    top, b = to_bernstein(model, run.bernstein), run.bernstein
    least, most = b[0], b[0]
    for j in range(top + 1):
        part[_FIRST + j] = b[j]
        least, most = min(least, b[j]), max(most, b[j])
    part[_BEGIN], part[_END] = begin, end
    part[_LACKS], part[_TOP], part[_WIDTH] = model[REST], float(top), -0.5 * (end - begin)
    if model[REST] <= _ROUGH * (most - least):
        # it lacks what the term of order eight gives
        share = sqrt(sqrt(sqrt(0.25 * tolerance / model[REST])))
        part[_WIDTH] = -(end - begin) * min(max(share, _LEAST_PART), 0.5)


@kernel
def _halve(part: Numbers) -> None:
    """Put the halves of a part in its place and behind it, the second one first (de Casteljau)."""
    left, top = part[_WORDS:], int(part[_TOP])
    a, b = left[_FIRST:], part[_FIRST:]
    for j in range(_FIRST):
        left[j] = part[j]
    for k in range(top + 1):
        a[k] = b[0]
        for j in range(top - k):
            b[j] = 0.5 * (b[j] + b[j + 1])
    left[_END] = part[_BEGIN] = part[_BEGIN] + 0.5 * (part[_END] - part[_BEGIN])
    left[_WIDTH] = part[_WIDTH] = abs(part[_WIDTH])


@kernel
def _highest(part: Numbers, sign: int) -> int:
    """The highest control point of a polynomial."""
    found = 0
    for j in range(1, int(part[_TOP]) + 1):
        if _height(sign, part[_FIRST + j]) > _height(sign, part[_FIRST + found]):
            found = j
    return found


@kernel
def _is_arch(part: Numbers, sign: int, up: float) -> bool:
    """Whether a polynomial bends to one side only, so that it has one top."""
    b, top = part[_FIRST:], int(part[_TOP])
    for j in range(top + 1):
        if sign == 0 and up * b[j] < 0.0:
            return False
        if 0 < j and j < top and up * (b[j - 1] - 2.0 * b[j] + b[j + 1]) > 0.0:
            return False
    return top > 0


@kernel
def _slope(run: Run, part: Numbers, at: float) -> float:
    """Slope of a polynomial over its degree (de Casteljau)."""
    b, d, top = part[_FIRST:], run.bernstein, int(part[_TOP])
    for j in range(top):
        d[j] = b[j + 1] - b[j]
    for k in range(1, top):
        for j in range(top - k):
            d[j] += at * (d[j + 1] - d[j])
    return d[0]


@kernel
def _top_of_arch(run: Run, part: Numbers, up: float) -> float:
    """Where a polynomial with one top has it, as a share of the part.

    Illinois variant of the secant method (Dowell and Jarratt, BIT 11 (1971) 168).
    """
    a, b = 0.0, 1.0
    fa, fb = up * _slope(run, part, a), up * _slope(run, part, b)
    if fa <= 0.0 or fb >= 0.0:
        return a if fa <= 0.0 else b
    for _ in range(_SEARCHES):
        c = (a * fb - b * fa) / (fb - fa)
        fc = up * _slope(run, part, c)
        is_close = abs(c - b) <= _CLOSE
        if fc * fb < 0.0:
            a, fa = b, fb
        else:
            fa = 0.5 * fa
        b, fb = c, fc
        if is_close or fc == 0.0:
            break
    return b


# -- the search ----------------------------------------------------------------------------------


@kernel
def _search(run: Run, k: int, begin: float, end: float) -> None:
    """Raise an extreme to the greatest value in a part of the step over which it is enclosed."""
    watch, e = run.watch, run.watch.enclosed_extremes
    best, sign, depth, enclosed = watch.best, watch.sign[k], 0, 1
    size = max(abs(best[k]), max(abs(watch.at_begin[k]), abs(watch.at_end[k])))
    tolerance = _EXACT * size
    select(run, e, watch.extreme, k)
    enclose(run, e, watch.extreme, begin, end - begin)
    _set_part(run, watch.curves, k, begin, end, tolerance)
    while depth >= 0 and best[k] == best[k]:
        part = watch.curves[_WORDS * depth :]
        lacks, width, is_fresh = part[_LACKS], part[_END] - part[_BEGIN], part[_WIDTH] < 0.0
        top, place = int(part[_TOP]), _highest(part, sign)
        most = _height(sign, part[_FIRST + place])
        if most + lacks <= best[k] + tolerance:
            depth -= 1
            continue
        up = 1.0 if sign > 0 or (sign == 0 and part[_FIRST + place] > 0.0) else -1.0
        is_arch, is_known = _is_arch(part, sign, up), lacks <= 0.25 * tolerance
        first, last = _height(sign, part[_FIRST]), _height(sign, part[_FIRST + top])
        is_flat = most - max(first, last) <= 0.25 * tolerance
        is_small = width <= _TOUCH or enclosed >= _MOST_PARTS
        is_last = is_small or (is_known and (is_arch or is_flat))
        if is_last or is_fresh:
            at = 0.5
            if is_arch:
                at = _top_of_arch(run, part, up)
            elif is_flat and top > 0:
                at = 0.0 if first >= last else 1.0
            elif top > 0:
                at = float(place) / float(top)
            _raise_inside(run, k, part[_BEGIN] + at * width)
        if is_last:
            depth -= 1
        elif is_known or is_fresh or width > part[_WIDTH]:
            _halve(part)
            depth += 1
        else:
            select(run, e, watch.extreme, k)
            enclose(run, e, watch.extreme, part[_BEGIN], width)
            enclosed += 1
            _set_part(run, part, k, part[_BEGIN], part[_END], tolerance)


@kernel
def _set_cuts(run: Run, begin: float, end: float) -> None:
    """Find where quantities have kinks in a part of the step, as far as its ends tell."""
    watch = run.watch
    _set_values(run, watch.kink, begin, watch.kink_begin)
    _set_values(run, watch.kink, end, watch.kink_end)
    for i in range(watch.kinks):
        watch.cuts[i] = _NEVER
    for i in range(watch.kinks):
        a, b, fa, fb = begin, end, watch.kink_begin[i], watch.kink_end[i]
        if fa * fb < 0.0:
            for _ in range(_SEARCHES):
                c = (a * fb - b * fa) / (fb - fa)
                _set_values(run, watch.kink, c, watch.kink_end)
                fc = watch.kink_end[i]
                is_close = abs(c - b) <= _SAME
                if fc * fb < 0.0:
                    a, fa = b, fb
                else:
                    fa = 0.5 * fa
                b, fb = c, fc
                if is_close or fc == 0.0:
                    break
            watch.cuts[i] = b
            _set_values(run, watch.kink, end, watch.kink_end)


@kernel
def _next_cut(run: Run, after: float) -> float:
    """The first part of the step at which a quantity has a kink after another part."""
    found = _NEVER
    for i in range(run.watch.kinks):
        cut = run.watch.cuts[i]
        if cut > after and cut < found:
            found = cut
    return found


@kernel
def _raise_all_to(run: Run, first: int, part: float, values: Numbers) -> None:
    """Raise extremes to the values at a part of the step."""
    watch, n = run.watch, run.watch.integrands
    _set_values(run, watch.extreme, part, values)
    for k in range(first, watch.extremes):
        if has_same_part(watch.begin, watch.end, n + k, n + first):
            _raise(run, k, values[k])


@kernel
def _raise_between(run: Run, first: int, begin: float, end: float, is_whole: bool) -> None:
    """Extremes over a part of the step in which quantities are smooth, as far as is known."""
    watch, e, n = run.watch, run.watch.enclosed_extremes, run.watch.integrands
    _raise_all_to(run, first, begin, watch.at_begin)
    _raise_all_to(run, first, end, watch.at_end)
    if not is_whole:
        set_ranges_in(run, begin, end - begin)
        evaluate(watch.height, run, run.ranges, run.t, run.m, watch.heights)
    if run.plant.implicit > 0:
        e.is_surveyed = 0
    for k in range(first, watch.extremes):
        if has_same_part(watch.begin, watch.end, n + k, n + first):
            best = watch.best[k]
            # what is no number is known to be none
            is_clear = best != best or watch.heights[k] <= best + _EXACT * abs(best)
            if end > begin and not is_clear:
                begin_survey(e, watch.extreme)
                _search(run, k, begin, end)


@kernel
def raise_all(run: Run, first: int, begin: float, end: float) -> None:
    """Extremes over a part of the step: of a quantity and of all others with the same part."""
    length = run.t_new - run.t
    low, high = (begin - run.t) / length, (end - run.t) / length
    cut = _NEVER
    if run.watch.kinks > 0:
        _set_cuts(run, low, high)
        cut = _next_cut(run, low)
    while cut < high:
        _raise_between(run, first, low, max(cut - _BESIDE, low), False)
        _raise_all_to(run, first, cut, run.watch.at_begin)
        low = cut + _BESIDE
        cut = _next_cut(run, low)
    if low <= high:
        _raise_between(run, first, low, high, low == 0.0 and high == 1.0)


@kernel
def raise_at(run: Run) -> None:
    """Extremes where a run stands: a jump may be the last that happens."""
    watch, n = run.watch, run.watch.integrands
    evaluate(watch.extreme, run, run.x, run.t, run.m, watch.value)
    for k in range(watch.extremes):
        if watch.begin[n + k] <= run.t and run.t <= watch.end[n + k]:
            _raise(run, k, watch.value[k])
