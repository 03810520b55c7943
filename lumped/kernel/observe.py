"""Functionals of a run, collected while it goes on."""

from __future__ import annotations

from lumped.code.words import Numbers, copy_numbers, kernel
from lumped.kernel.enclosures.extremes import (
    LOWEST,
    MOST_PARTS,
    has_same_part,
    may_rise,
    raise_all,
    raise_at,
    rises,
)
from lumped.kernel.enclosures.turning import begin_loads, end_loads, feed_loads
from lumped.kernel.interpret import evaluate
from lumped.kernel.methods.any_method import inside, integrals, set_all_ranges
from lumped.kernel.run import Run
from lumped.kernel.watch import ALL, ANY, COUNT, IMPULSE, INSTANT, LOSS, TIMED, VALUE

NODES = (
    0.019855071751231884,
    0.10166676129318664,
    0.2372337950418355,
    0.4082826787521751,
    0.5917173212478249,
    0.7627662049581645,
    0.8983332387068134,
    0.9801449282487681,
)
WEIGHTS = (
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


@kernel
def begin_watch(run: Run) -> None:
    """Nothing has been taken yet."""
    watch = run.watch
    watch.next_time = 0
    if watch.loads > 0:
        begin_loads(run)
    for k in range(watch.integrands):
        watch.sums[k] = 0.0
    for k in range(watch.extremes):
        watch.best[k] = LOWEST
    for k in range(watch.points):
        watch.totals[k] = 0.0
    for k in range(watch.wanted_events):
        watch.happened[k] = 0
        watch.taken[k] = 0.0
        watch.last_time[k] = LOWEST


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
    return integrals(run, run.t_new - run.t) > 1.0


@kernel
def is_inside_wanted(run: Run) -> bool:
    """Whether a functional needs values inside the present step."""
    watch = run.watch
    watch.may_rise = watch.extremes > 0 and may_rise(run)
    watch.is_rough = watch.integrands > 0 and _is_rough(run)
    if watch.is_rough or watch.may_rise or watch.loads > 0:
        return True
    return watch.next_time < watch.times and watch.time[watch.next_time] < run.t_new


@kernel
def _gauss(run: Run, begin: float, end: float, parts: int, sums: Numbers) -> None:
    """Integrals by Gauss's rule in equal parts, and those of the sizes."""
    watch, length, width = run.watch, run.t_new - run.t, (end - begin) / parts
    for i in range(watch.integrands):
        sums[i] = watch.sizes[i] = 0.0
    for k in range(parts):
        for j in range(8):
            t = begin + (k + NODES[j]) * width
            inside(run, (t - run.t) / length, watch.x)
            evaluate(watch.integrand, run, watch.x, t, run.m, watch.value)
            for i in range(watch.integrands):
                part = WEIGHTS[j] * width * watch.value[i]
                sums[i] += part
                watch.sizes[i] += abs(part)


@kernel
def _integrate(run: Run, k: int, begin: float, end: float) -> None:
    """Add an integral over a part of the step to its sum, and all others with the same part.

    The parts are halved until nothing changes; a function of time may be faster than all states.
    """
    watch = run.watch
    n, coarse, fine, parts, is_close = watch.integrands, watch.coarse, watch.fine, 1, False
    _gauss(run, begin, end, 1, fine)
    while not is_close and parts < MOST_PARTS:
        copy_numbers(n, fine, coarse)
        parts *= 2
        _gauss(run, begin, end, parts, fine)
        is_close = True
        for i in range(k, n):
            size = max(watch.sizes[i], abs(watch.sums[i]))
            is_meant = has_same_part(watch.begin, watch.end, i, k)
            if is_meant and abs(fine[i] - coarse[i]) > run.rtol * size:
                is_close = False
    for i in range(k, n):
        if has_same_part(watch.begin, watch.end, i, k):
            watch.sums[i] += fine[i]


@kernel
def is_first_with_its_part(begin: Numbers, end: Numbers, first: int, k: int) -> bool:
    """Whether no integral or extreme before another is taken over the same part of the run."""
    for i in range(first, k):
        if has_same_part(begin, end, i, k):
            return False
    return True


@kernel
def _add_next_point(run: Run, x: Numbers, t: float) -> None:
    """Add the value at the next of the given instants."""
    watch = run.watch
    place = watch.time_of[watch.next_time]
    evaluate(watch.point, run, x, t, run.m, watch.value)
    watch.totals[place] += watch.value[place]
    watch.next_time += 1


@kernel
def observe(run: Run, until: float) -> None:
    """Take what functionals need from an accepted step, up to a time."""
    watch = run.watch
    n = watch.integrands
    if run.t_new > run.t:
        if watch.may_rise:
            set_all_ranges(run)
            watch.may_rise = int(rises(run))
        for k in range(n + watch.extremes):
            begin, end = max(run.t, watch.begin[k]), min(until, watch.end[k])
            if k < n:
                if end == run.t_new and begin == run.t and not watch.is_rough:
                    watch.sums[k] += watch.parts[k]
                elif end > begin and is_first_with_its_part(watch.begin, watch.end, 0, k):
                    _integrate(run, k, begin, end)
            elif (
                watch.may_rise
                and end >= begin
                and is_first_with_its_part(watch.begin, watch.end, n, k)
            ):
                raise_all(run, k - n, begin, end)
        if watch.loads > 0:
            feed_loads(run, until)
    while watch.next_time < watch.times and watch.time[watch.next_time] < until:
        t = watch.time[watch.next_time]
        inside(run, (t - run.t) / (run.t_new - run.t), watch.x)
        _add_next_point(run, watch.x, t)


@kernel
def end_watch(run: Run) -> None:
    """Take what is wanted at the end of a run."""
    watch = run.watch
    while watch.next_time < watch.times:
        _add_next_point(run, run.x, run.t)
    if watch.extremes > 0:
        raise_at(run)
    if watch.loads > 0:
        end_loads(run)
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
def observe_event(run: Run, kind: int, number: int, after: int, loss: float, delay: float) -> None:
    """Take what functionals need from a change of position.

    The states and settings before it are those of the run, apart from functions of time; those
    after it are in `instant`.
    """
    watch, instant = run.watch, run.instant
    for i in range(watch.matches):
        row = watch.match[4 * i :]
        k = row[3]
        is_noted = kind == TIMED and watch.last_time[k] == run.t
        if row[0] == kind and row[1] == number and (row[2] == ANY or row[2] == after):
            if is_noted:
                continue
            if kind == TIMED:
                watch.last_time[k] = run.t
            what = watch.event_kind[k]
            if what == COUNT:
                _take(run, k, 1.0)
            elif what == INSTANT:
                _take(run, k, run.t + delay)
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
def _has_changed(run: Run, i: int) -> bool:
    """Whether a setting of a function of time is another one in this segment."""
    now = run.segment * run.timed + i
    return run.timed_values[now] != run.timed_values[now - run.timed]


@kernel
def observe_clocks(run: Run) -> None:
    """Take what functionals need where functions of time change their settings."""
    watch = run.watch
    for i in range(run.timed):
        is_own = _has_changed(run, i)
        for j in range(watch.needs):
            if watch.need[2 * j] == i and _has_changed(run, watch.need[2 * j + 1]):
                is_own = False
        if is_own:
            observe_event(run, TIMED, i, 0, 0.0, 0.0)
