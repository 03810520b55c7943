"""Points inside steps at which a quantity may be highest, or turns; extremes of a run."""

from __future__ import annotations

from typing import Literal, NamedTuple

import casadi as ca
import numpy as np

from lumped.code.operations import Operations, operations_of
from lumped.functionals.damage_law import DamageLaw
from lumped.functionals.readings import Extreme
from lumped.gradients.legs import SmoothParts
from lumped.gradients.readings.product_curve import Ends, Points, ProductCurve, Turn, Window
from lumped.gradients.spans import Span
from lumped.gradients.steps import Steps
from lumped.kernel.watch import Watch
from lumped.support.made_once import made_once
from lumped.timeloop.cycle_count import count_record
from lumped.timeloop.plants.many_points import CountedFunction
from lumped.timeloop.plants.parts import make_enclosed
from lumped.timeloop.step_bounds import heights, kinks

Signs = tuple[Literal[-1, 0, 1], ...]
"""Of each extreme: 1 for the greatest value, -1 for the least, 0 for the largest size."""

_ROOM = 256
"""Points for which there is room at first."""
_LOCATED, _TIES = 64, 6
"""Most extremes of nearly the same height that are located, and that are kept."""
_SAME = 1e-9
"""Distance, as a part of a step, of instants at which the same extreme was found twice."""
_EXACT = 1e-10
"""Relative height by which kernels may miss an extreme."""


class _Functions(NamedTuple):
    """What kernels need to enclose a quantity, by the fields of a watch."""

    operations: dict[str, Operations]
    counted: dict[str, CountedFunction]


@made_once
def _functions(steps: Steps, factors: tuple[str, ...], signs: Signs) -> _Functions:
    """A quantity as extremes with these signs, or as a load without any."""
    system = steps.system
    quantity = system.product(factors)
    repeated = [quantity] * max(len(signs), 1)
    whole = ca.Function("quantities", system.inputs, [ca.densify(ca.vertcat(*repeated))])
    found = {"extreme" if signs else "load": operations_of(whole)}
    if signs:
        found["height"] = heights(system, repeated, signs, steps.states + steps.integrals)
    kinked = kinks(system, [quantity])
    if kinked is not None:
        found["kink"] = operations_of(kinked)
    return _Functions(found, {field: CountedFunction(own) for field, own in found.items()})


def _watch(steps: Steps, functions: _Functions, signs: Signs) -> Watch:
    operations = functions.operations
    counts = dict.fromkeys(("integrands", "points", "finals", "event_points", "wanted_events"), 0)
    counts |= {"extremes": len(signs), "loads": int(not signs)}
    counts["kinks"] = operations["kink"].results if "kink" in operations else 0
    watch = Watch({**counts, "states": steps.states + steps.integrals})
    for field, count in counts.items():
        setattr(watch, field, count)
    watch.begin[:], watch.end[:], watch.sign[:] = -np.inf, np.inf, signs
    watch.enclosed_extremes = make_enclosed(operations.get("extreme"))
    watch.enclosed_loads = make_enclosed(operations.get("load"))
    watch.count = count_record([DamageLaw()] * counts["loads"], 0)
    return watch


def highest_points(
    steps: Steps,
    span: Span,
    factors: tuple[str, ...],
    sign: Literal[-1, 0, 1],
    best: float,
    slack: float,
) -> tuple[np.ndarray, float]:
    """Where a quantity is highest in parts of steps, up to a slack, shape (k, 3); what it reaches.

    Each row has the number of the step, the part of it, and the value there. A part that is highest
    at its end gives this end. That it reaches `best` is known.
    """
    functions = _functions(steps, factors, (sign,))
    watch = _watch(steps, functions, (sign,))
    watch.lists, watch.best[0], watch.slack = _ROOM, best - slack, slack
    rows = steps.list_points(span, watch, functions.counted, 1.0)
    return rows, float(np.maximum(best, watch.best[0] + slack))


def turning_points_in(
    steps: Steps, span: Span, factors: tuple[str, ...], least: float
) -> np.ndarray:
    """Where a quantity turns, or has a kink, inside steps, as `highest_points`.

    Turning points may be missed beside which it swings by less than a tenth of `least`.
    """
    functions = _functions(steps, factors, ())
    watch = _watch(steps, functions, ())
    watch.lists, watch.load_size[0] = _ROOM, 1.0
    return steps.list_points(span, watch, functions.counted, least)


def range_of(
    steps: Steps, span: Span, factors: tuple[str, ...], known: tuple[float, float]
) -> tuple[float, float]:
    """Least and greatest value of a quantity in steps, no narrower than a known range."""
    functions = _functions(steps, factors, (-1, 1))
    watch = _watch(steps, functions, (-1, 1))
    watch.best[:] = -known[0], known[1]
    steps.list_points(span, watch, functions.counted, 1.0)
    return -float(watch.best[0]), float(watch.best[1])


def extremes(course: SmoothParts, extreme: Extreme) -> list[Turn]:
    """The extremes of a run that are highest within its accuracy, the highest first.

    A quantity is enclosed inside steps, as while a run goes on (see
    `lumped.kernel.enclosures.extremes`).
    """
    curve = ProductCurve(course, tuple(map(course.run.system.key, extreme.factors)))
    sign, between, rtol = extreme.sign, extreme.between, course.rtol
    ends = curve.ends(between)
    signs = (1.0, -1.0) if sign == 0 else (float(sign),)
    best = max(float((each * ends.y).max()) for each in signs)
    size = known = float(np.abs(ends.y).max())
    is_known = False
    while not is_known:  # a burst inside a step may be larger than all that was known
        slack = 20 * max(rtol, _EXACT) * size
        tops, best = _tops(curve, sign, best, slack, between)
        known, size = size, max(size, abs(best))
        is_known = size <= 2 * known
    slack = 10 * rtol * size
    order = np.argsort(-tops.value, kind="stable")
    order = order[tops.value[order] >= best - slack][:_LOCATED]
    found = [end for each in signs for end in _ends(ends, each, len(course.legs) - 1, between)]
    at_ends = {(end.leg, end.time, end.sign) for end in found}
    points, is_located = curve.locate(tops.of(order), between)
    inner = _turns(points.of(np.flatnonzero(is_located)))
    found += [e for e in inner if (e.leg, e.time, e.sign) not in at_ends]
    best = max((e.value for e in found), default=-np.inf)
    # such as jumps, of which only one side is high
    found += [e for e in _turns(points.of(np.flatnonzero(~is_located))) if e.value > best + slack]
    best = max(e.value for e in found)
    found = [e for e in found if e.value >= best - slack]
    found.sort(key=lambda e: (-e.value, e.time))
    return found[:_TIES]


def _tops(
    curve: ProductCurve, sign: Literal[-1, 0, 1], best: float, slack: float, between: Window
) -> tuple[Points, float]:
    """Where a quantity times its sign is highest in parts of steps, up to a slack, and how high."""
    found: list[Points] = []
    for numbers, span in curve.spans(between):
        rows, best = highest_points(curve.course.steps, span, curve.factors, sign, best, slack)
        curve.check(np.array(best))
        points = curve.points(numbers, span, rows)
        own = np.where(points.value < 0, -1.0, 1.0) if sign == 0 else np.full(len(rows), sign)
        points = points._replace(value=own * points.value, sign=own)
        # at the end of a step it may go on into the next one
        last = np.flatnonzero(np.isin(rows[:, 1], (0.0, 1.0)))
        places = (rows[last, 0] + rows[last, 1]).astype(int)
        given = span.x[places], span.theta, span.t[places], span.m[places]
        rises = own[last] * curve.look(*given)[:, 1] * (2 * rows[last, 1] - 1) > 0
        found.append(points.of(np.setdiff1d(np.arange(len(rows)), last[rises])))
    none = [np.zeros(0, dtype=int), *np.zeros((4, 0))]
    return Points(*(np.concatenate(v) for v in zip(none, *found, strict=True))), best


def _ends(ends: Ends, sign: float, last: int, between: Window) -> list[Turn]:
    """Ends of the legs at which a quantity does not rise inwards."""
    found = []
    for number, a, b in ends.of_legs:
        begin, end = float(ends.t[a]), float(ends.t[b])
        if sign * ends.slope[a] <= 0:
            fixed = between is not None and begin <= between[0]
            found.append(Turn(number, begin, float(sign * ends.y[a]), sign, 0 if fixed else number))
        if sign * ends.slope[b] >= 0:
            fixed = number == last or (between is not None and end >= between[1])
            edge = 0 if fixed else number + 1
            found.append(Turn(number, end, float(sign * ends.y[b]), sign, edge))
    return found


def _turns(points: Points) -> list[Turn]:
    """Extremes inside steps, each once."""
    points = points.of(np.lexsort((points.t, points.leg, points.sign)))
    is_same = np.zeros(len(points.t), dtype=bool)
    is_same[1:] = (np.diff(points.t) <= _SAME * points.length[1:]) & (
        (np.diff(points.leg) == 0) & (np.diff(points.sign) == 0)
    )
    leg, t, _, value, sign = points.of(np.flatnonzero(~is_same))
    rows = zip(leg.tolist(), t.tolist(), value.tolist(), sign.tolist(), strict=True)
    return [Turn(number, time, height, sign, 0) for number, time, height, sign in rows]
