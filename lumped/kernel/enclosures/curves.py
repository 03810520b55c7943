"""Polynomials of quantities in parts of a step, which wait to be looked at, and cuts between parts.

A part holds what an enclosure gave of it. Its halves inherit the polynomial and what that lacks,
and are enclosed again only where this is too much.
"""

from __future__ import annotations

from lumped.code.words import Numbers, copy_numbers, greatest_of, kernel, least_of, sqrt
from lumped.kernel.enclosed import Enclosed
from lumped.kernel.enclosures.enclosure import enclose, select
from lumped.kernel.enclosures.models import REST, SIZE, to_bernstein
from lumped.kernel.interpret import evaluate
from lumped.kernel.methods.any_method import inside
from lumped.kernel.plant import Function
from lumped.kernel.roots import begin_bracket, narrow, next_point
from lumped.kernel.run import Run
from lumped.kernel.watch import Watch

TOUCH = 1e-12
"""Part of a step that is not divided."""
MOST_ENCLOSED = 1 << 16
"""Parts in which a quantity is enclosed; only one that is rough everywhere needs more."""
BESIDE = 1e-10
"""Of a kink, where parts with smooth quantities begin and end."""
NEVER = 2.0
_ROUGH = 0.01
"""What a polynomial may lack, over its way, for a guess what it lacks in a smaller part."""
_LEAST_PART = 1.0 / 16.0
"""Of a part in which a quantity was enclosed, where it is enclosed next."""
_CLOSE = 1e-8
"""Part of a part at which the slope is zero; the value there is known to the square."""
_SAME = 1e-15
"""Distance of parts of a step that differ by rounding."""

BEGIN, END, LACKS, TOP, WIDTH, FIRST = range(6)
"""A part of the step that waits: its ends, what its polynomial lacks, the degree of that, the width
from which on it is enclosed again (below zero: it was), and the first of eight coefficients."""
WORDS = FIRST + 8
POINT = 3
"""Numbers of a point that is listed."""


@kernel
def set_values(run: Run, function: Function, part: float, out: Numbers) -> None:
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
def list_point(watch: Watch, part: float, value: float) -> None:
    """List a value at a part of a recorded step; without room it is only counted."""
    if watch.listed < watch.lists:
        row = watch.list[POINT * watch.listed :]
        row[0], row[1], row[2] = float(watch.place), part, value
    watch.listed += 1


@kernel
def set_part(
    run: Run, e: Enclosed, part: Numbers, k: int, begin: float, end: float, tolerance: float
) -> None:
    """What the model of a quantity tells of a part of the step."""
    model = e.model[SIZE * k :]
    b = part[FIRST:]
    top = to_bernstein(model, b)
    part[BEGIN], part[END] = begin, end
    part[LACKS], part[TOP], part[WIDTH] = model[REST], float(top), -0.5 * (end - begin)
    if model[REST] <= _ROUGH * (greatest_of(b, top) - least_of(b, top)):
        # it lacks what the term of order eight gives
        share = sqrt(sqrt(sqrt(0.25 * tolerance / model[REST])))
        part[WIDTH] = -(end - begin) * min(max(share, _LEAST_PART), 0.5)


@kernel
def halve(part: Numbers) -> None:
    """Put the halves of a part in its place and behind it, the second one first (de Casteljau)."""
    left, top = part[WORDS:], int(part[TOP])
    a, b = left[FIRST:], part[FIRST:]
    copy_numbers(FIRST, part, left)
    for k in range(top + 1):
        a[k] = b[0]
        for j in range(top - k):
            b[j] = 0.5 * (b[j] + b[j + 1])
    left[END] = part[BEGIN] = part[BEGIN] + 0.5 * (part[END] - part[BEGIN])
    left[WIDTH] = part[WIDTH] = abs(part[WIDTH])


@kernel
def enclose_part(
    run: Run,
    e: Enclosed,
    function: Function,
    k: int,
    part: Numbers,
    begin: float,
    end: float,
    tolerance: float,
) -> None:
    """Enclose a quantity in a part of the step."""
    select(run, e, function, k)
    enclose(run, e, function, begin, end - begin)
    set_part(run, e, part, k, begin, end, tolerance)


@kernel
def refine(
    run: Run,
    e: Enclosed,
    function: Function,
    k: int,
    part: Numbers,
    is_known: bool,
    tolerance: float,
) -> bool:
    """Halve a part, or enclose it again where its polynomial lacks too much; whether it is two."""
    begin, end = part[BEGIN], part[END]
    if is_known or part[WIDTH] < 0.0 or end - begin > part[WIDTH]:
        halve(part)
        return True
    enclose_part(run, e, function, k, part, begin, end, tolerance)
    return False


@kernel
def _slope(run: Run, part: Numbers, at: float) -> float:
    """Slope of a polynomial over its degree (de Casteljau)."""
    b, d, top = part[FIRST:], run.bernstein, int(part[TOP])
    for j in range(top):
        d[j] = b[j + 1] - b[j]
    for k in range(1, top):
        for j in range(top - k):
            d[j] += at * (d[j + 1] - d[j])
    return d[0]


@kernel
def root_of_slope(run: Run, part: Numbers, up: float) -> float:
    """Where the slope of a polynomial changes its sign, as a share of the part; else an end.

    With the sign `up` it goes from above zero to below it.
    """
    b = run.bracket
    first, last = up * _slope(run, part, 0.0), up * _slope(run, part, 1.0)
    if first <= 0.0 or last >= 0.0:
        return 0.0 if first <= 0.0 else 1.0
    begin_bracket(b, 0.0, first, 1.0, last)
    at = next_point(b)
    while narrow(b, at, up * _slope(run, part, at), _CLOSE):
        at = next_point(b)
    return b.last


@kernel
def set_cuts(run: Run, begin: float, end: float) -> None:
    """Find where quantities have kinks in a part of the step, as far as its ends tell."""
    watch, b = run.watch, run.bracket
    set_values(run, watch.kink, begin, watch.kink_begin)
    set_values(run, watch.kink, end, watch.kink_end)
    for i in range(watch.kinks):
        watch.cuts[i] = NEVER
    for i in range(watch.kinks):
        if watch.kink_begin[i] * watch.kink_end[i] < 0.0:
            begin_bracket(b, begin, watch.kink_begin[i], end, watch.kink_end[i])
            goes_on = True
            while goes_on:
                at = next_point(b)
                set_values(run, watch.kink, at, watch.kink_end)
                goes_on = narrow(b, at, watch.kink_end[i], _SAME)
            watch.cuts[i] = b.last
            set_values(run, watch.kink, end, watch.kink_end)


@kernel
def next_cut(run: Run, after: float) -> float:
    """The first part of the step at which a quantity has a kink after another part."""
    found = NEVER
    for i in range(run.watch.kinks):
        cut = run.watch.cuts[i]
        if cut > after and cut < found:
            found = cut
    return found
