"""What functionals take from a run while it goes on: the record.

Integrals, extremes, cycles of loads, values at given instants and events are collected step by
step, so that no point of the run need be kept. Lengths are expressions of ``integrands``,
``extremes``, ``loads``, ``points``, ``finals``, ``wanted_events``, ``event_points`` and ``states``.
"""

from __future__ import annotations

from typing import Annotated

from lumped.code.records import Record
from lumped.code.words import Integers, Numbers
from lumped.kernel.cycles import Count
from lumped.kernel.enclosed import Enclosed
from lumped.kernel.plant import Function

COUNT, INSTANT, LOSS, IMPULSE, VALUE = range(5)
"""What is taken from an event: that it happened, when, the energy lost, the impulse, a value
beside it."""

TIMED = 2
"""Kind of an event that a function of time makes; 0 and 1 are those of conditions and holds. Its
number is the place of the setting among all of functions of time."""

ALL = 1 << 40
"""Number of an event that means all of them."""

ANY = -2
"""Position after an event that means any."""


class Watch(Record):
    """What is taken from a run.

    Attributes
    ----------
    integrand, extreme, point, final, event_point : Function
        Quantities that are integrated; whose extremes, values at given instants, at the end, and
        beside events are wanted.
    height, heights, part_heights : Function, Numbers, Numbers
        What these, with their signs, do not exceed while states and time move (see `margin_floor`
        of a plant); that in the step, and in a part of it.
    at_begin, at_end : Numbers
        The same quantities at both ends of a part of the step.
    enclosed_extremes, curves : Enclosed, Numbers
        What is known of them, and their polynomials in parts that wait to be looked at.
    kinks, kink : int, Function
        What changes its sign where they, and loads, have kinks or jump.
    kink_begin, kink_end, cuts : Numbers
        This at both ends of a part of the step, and the parts at which it changes its sign there.
    may_rise : int
        Whether an extreme may rise in the step.
    begin, end : Numbers
        Part of the run in which each integral is taken, then that of each extreme, s.
    sums : Numbers
        Integrals so far.
    parts, is_rough : Numbers, int
        Integrals over the step, and whether these are not good enough.
    coarse, fine, sizes : Numbers
        Integrals over a step, in parts and in twice as many, and those of the sizes.
    sign : Integers
        1 for the greatest value of an extreme, -1 for the least (with its sign turned), 0 for the
        largest size.
    best, slack : Numbers, float
        Extremes so far, less a slack: lower values need not be found.
    load : Function
        Loads whose cycles are counted.
    load_end, loads_at : Numbers, float
        These at the end of the step, and its time, s.
    enclosed_loads : Enclosed
        What is known of them.
    load_size : Numbers
        Largest sizes of the loads so far.
    times, time_of : Numbers, Integers
        Instants at which values are wanted, ascending, and of which point; then what is added to.
    totals : Numbers
        Sums of these values.
    match : Integers
        Kind, number and position after (or `ANY`) of events, and which of those wanted they are.
    event_kind, event_number : Integers
        What is taken from a wanted event, and which of them: from 0, from -1 backwards, or `ALL`.
    event_side, event_of : Integers
        Whether a value is that after the event, and of which quantity.
    happened, last_time : Integers, Numbers
        How often each happened, and when last, s.
    lists, list, listed : int, Numbers, int
        Room for points, where one quantity may be highest, or the load turns, in a recorded run:
        number of the step, part of it, and value; these; and how many there are, which may be more.
        Turning points are listed in place of their count.
    place : int
        Number of the step.
    needs, need : int, Integers
        Settings of functions of time that change because others do: pairs of their places.
    latest : Integers
        Where the latest ones of each wanted event begin in `ring`.
    """

    x: Annotated[Numbers, "states"]

    integrands: int
    integrand: Function
    value: Annotated[Numbers, "max(integrands, extremes, points, event_points)"]
    begin: Annotated[Numbers, "integrands + extremes"]
    end: Annotated[Numbers, "integrands + extremes"]
    sums: Annotated[Numbers, "integrands"]
    parts: Annotated[Numbers, "integrands"]
    coarse: Annotated[Numbers, "integrands"]
    fine: Annotated[Numbers, "integrands"]
    sizes: Annotated[Numbers, "integrands"]
    is_rough: int

    extremes: int
    extreme: Function
    height: Function
    heights: Annotated[Numbers, "extremes"]
    part_heights: Annotated[Numbers, "extremes"]
    at_begin: Annotated[Numbers, "extremes"]
    at_end: Annotated[Numbers, "extremes"]
    enclosed_extremes: Enclosed
    curves: Annotated[Numbers, "832 * (extremes + loads > 0)"]
    kinks: int
    kink: Function
    kink_begin: Annotated[Numbers, "kinks"]
    kink_end: Annotated[Numbers, "kinks"]
    cuts: Annotated[Numbers, "kinks"]
    may_rise: int
    sign: Annotated[Integers, "extremes"]
    best: Annotated[Numbers, "extremes"]
    slack: float

    loads: int
    load: Function
    enclosed_loads: Enclosed
    load_value: Annotated[Numbers, "loads"]
    load_end: Annotated[Numbers, "loads"]
    loads_at: float
    load_size: Annotated[Numbers, "loads"]
    count: Count

    points: int
    point: Function
    times: int
    next_time: int
    time: Numbers
    time_of: Integers
    totals: Annotated[Numbers, "points"]

    finals: int
    final: Function
    last: Annotated[Numbers, "finals"]

    matches: int
    match: Integers
    event_points: int
    event_point: Function
    wanted_events: int
    event_kind: Annotated[Integers, "wanted_events"]
    event_number: Annotated[Integers, "wanted_events"]
    event_side: Annotated[Integers, "wanted_events"]
    event_of: Annotated[Integers, "wanted_events"]
    happened: Annotated[Integers, "wanted_events"]
    last_time: Annotated[Numbers, "wanted_events"]
    taken: Annotated[Numbers, "wanted_events"]
    latest: Annotated[Integers, "wanted_events"]
    ring: Numbers
    lists: int
    list: Numbers
    listed: int
    place: int
    needs: int
    need: Integers
