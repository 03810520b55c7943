"""Extremes of quantities: whether they may rise in a step, and where they do.

What a quantity cannot exceed while states and time move within their ranges clears most steps. In
any other it is enclosed, over the step and over ever smaller parts of it, until its polynomial
tells the greatest value, or no part may hold a greater one than is known.
"""

from __future__ import annotations

from lumped.code.words import Numbers, kernel
from lumped.kernel.enclosed import Enclosed
from lumped.kernel.enclosures import curves
from lumped.kernel.enclosures.enclosure import begin_survey, set_ranges_in
from lumped.kernel.interpret import evaluate
from lumped.kernel.methods.any_method import set_early_ranges
from lumped.kernel.plant import Function
from lumped.kernel.run import Run

LOWEST = -1.7976931348623157e308
MOST_PARTS = 4096
"""Parts of a step in which integrals are taken."""
_EXACT = 1e-10
"""What is greater by less than this part of its size is no better extreme."""


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
def may_rise(run: Run) -> bool:
    """Whether an extreme may rise in the step, before its interpolation is known.

    Where it is computed in any case it tells more.
    """
    if run.plant.margins > 0:
        return True
    set_early_ranges(run)
    return rises(run) > 0.5


@kernel
def _height(sign: int, value: float) -> float:
    """A quantity whose greatest value is wanted."""
    return abs(value) if sign == 0 else value if sign > 0 else -value


@kernel
def _raise(
    run: Run, best: Numbers, sign: int, k: int, part: float, value: float, is_last: bool
) -> None:
    """Raise an extreme to a value at a part of the step, and list that; what is no number stays."""
    watch, height = run.watch, _height(sign, value)
    if watch.lists > 0 and is_last and not height <= best[k]:
        curves.list_point(watch, part, value)
    reached = height - watch.slack
    best[k] = reached if reached > best[k] or reached != reached else best[k]


@kernel
def _highest(part: Numbers, sign: int) -> int:
    """The highest control point of a polynomial."""
    found = 0
    for j in range(1, int(part[curves.TOP]) + 1):
        if _height(sign, part[curves.FIRST + j]) > _height(sign, part[curves.FIRST + found]):
            found = j
    return found


@kernel
def _is_arch(part: Numbers, sign: int, up: float) -> bool:
    """Whether a polynomial bends to one side only, so that it has one top."""
    b, top = part[curves.FIRST :], int(part[curves.TOP])
    for j in range(top + 1):
        if sign == 0 and up * b[j] < 0.0:
            return False
        if j > 0 and j < top and up * (b[j - 1] - 2.0 * b[j] + b[j + 1]) > 0.0:
            return False
    return top > 0


# -- the search ----------------------------------------------------------------------------------


@kernel
def raise_in(
    run: Run,
    function: Function,
    e: Enclosed,
    k: int,
    sign: int,
    best: Numbers,
    values: Numbers,
    begin: float,
    end: float,
    size: float,
) -> None:
    """Raise an extreme to the greatest value in a part of the step.

    `size` is one that the quantity has, `values` is room.
    """
    watch, depth, enclosed, tolerance = run.watch, 0, 1, _EXACT * max(size, abs(best[k]))
    curves.enclose_part(run, e, function, k, watch.curves, begin, end, tolerance)
    while depth >= 0 and best[k] == best[k]:
        tolerance = max(tolerance, _EXACT * abs(best[k]))
        part = watch.curves[curves.WORDS * depth :]
        width, is_fresh = part[curves.END] - part[curves.BEGIN], part[curves.WIDTH] < 0.0
        lacks, top, place = part[curves.LACKS], int(part[curves.TOP]), _highest(part, sign)
        most = _height(sign, part[curves.FIRST + place])
        if most + lacks <= best[k] + tolerance:
            depth -= 1
            continue
        up = 1.0 if sign > 0 or (sign == 0 and part[curves.FIRST + place] > 0.0) else -1.0
        is_arch, is_known = _is_arch(part, sign, up), lacks <= 0.25 * tolerance
        first, last = _height(sign, part[curves.FIRST]), _height(sign, part[curves.FIRST + top])
        is_flat = most - max(first, last) <= 0.25 * tolerance
        is_small = width <= curves.TOUCH or enclosed >= curves.MOST_ENCLOSED
        is_last = is_small or (is_known and (is_arch or is_flat))
        if is_last or is_fresh:
            at = 0.5
            if is_arch:
                at = curves.root_of_slope(run, part, up)
            elif is_flat and top > 0:
                at = 0.0 if first >= last else 1.0
            elif top > 0:
                at = float(place) / float(top)
            at = part[curves.BEGIN] + at * width
            curves.set_values(run, function, at, values)
            _raise(run, best, sign, k, at, values[k], is_last)
        if is_last:
            depth -= 1
        elif curves.refine(run, e, function, k, part, is_known, tolerance):
            depth += 1
        else:
            enclosed += 1


@kernel
def _raise_all_to(run: Run, first: int, part: float, values: Numbers) -> None:
    """Raise extremes to the values at a part of the step, and list those inside."""
    watch, n = run.watch, run.watch.integrands
    curves.set_values(run, watch.extreme, part, values)
    for k in range(first, watch.extremes):
        if has_same_part(watch.begin, watch.end, n + k, n + first):
            is_inside = part > 0.0 and part < 1.0
            _raise(run, watch.best, watch.sign[k], k, part, values[k], is_inside)


@kernel
def _raise_between(run: Run, first: int, begin: float, end: float, is_whole: bool) -> None:
    """Extremes over a part of the step in which quantities are smooth, as far as is known."""
    watch, e, n = run.watch, run.watch.enclosed_extremes, run.watch.integrands
    best = watch.best
    _raise_all_to(run, first, begin, watch.at_begin)
    _raise_all_to(run, first, end, watch.at_end)
    if not is_whole:
        set_ranges_in(run, begin, end - begin)
        evaluate(watch.height, run, run.ranges, run.t, run.m, watch.part_heights)
    if run.plant.implicit > 0:
        e.is_surveyed = 0
    for k in range(first, watch.extremes):
        if has_same_part(watch.begin, watch.end, n + k, n + first):
            # what is no number is known to be none
            height = watch.heights[k] if is_whole else watch.part_heights[k]
            is_clear = best[k] != best[k] or height <= best[k] + _EXACT * abs(best[k])
            if end > begin and not is_clear:
                begin_survey(e, watch.extreme)
                size = max(abs(watch.at_begin[k]), abs(watch.at_end[k]))
                raise_in(
                    run, watch.extreme, e, k, watch.sign[k], best, watch.value, begin, end, size
                )


@kernel
def raise_all(run: Run, first: int, begin: float, end: float) -> None:
    """Extremes over a part of the step: of a quantity and of all others with the same part."""
    length = run.t_new - run.t
    low, high = (begin - run.t) / length, (end - run.t) / length
    cut = curves.NEVER
    if run.watch.kinks > 0:
        curves.set_cuts(run, low, high)
        cut = curves.next_cut(run, low)
    while cut < high:
        _raise_between(run, first, low, max(cut - curves.BESIDE, low), False)
        _raise_all_to(run, first, cut, run.watch.at_begin)
        low = cut + curves.BESIDE
        cut = curves.next_cut(run, low)
    if low <= high:
        _raise_between(run, first, low, high, low == 0.0 and high == 1.0)


@kernel
def raise_at(run: Run) -> None:
    """Extremes where a run is: a jump may be the last that happens."""
    watch, n = run.watch, run.watch.integrands
    evaluate(watch.extreme, run, run.x, run.t, run.m, watch.value)
    for k in range(watch.extremes):
        if watch.begin[n + k] <= run.t and run.t <= watch.end[n + k]:
            _raise(run, watch.best, watch.sign[k], k, 0.0, watch.value[k], False)
