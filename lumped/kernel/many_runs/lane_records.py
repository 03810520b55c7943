"""Records of runs side by side in lanes: what the steps of a run read and write, for all at once.

Fields have the names of those of `Run` and `Watch`, so the formulas of a step serve both.
"""

from __future__ import annotations

from typing import Annotated

from lumped.code.records import Record
from lumped.code.words import Integers, Numbers, Wide, Wides
from lumped.kernel.plant import Function, Plant

(WAITING, STEPPING, IDLE) = range(3)
"""State of a lane: its run must go on alone; it makes steps; no variant is left for it."""


class LaneWatch(Record):
    """What functionals take from runs in lanes (see `Watch`)."""

    integrands: int
    integrand: Function
    begin: Annotated[Numbers, "integrands + extremes"]
    end: Annotated[Numbers, "integrands + extremes"]
    sums: Annotated[Wides, "lanes * integrands"]
    parts: Annotated[Wides, "lanes * integrands"]
    extremes: int
    height: Function
    heights: Annotated[Wides, "lanes * extremes"]
    best: Annotated[Wides, "lanes * extremes"]
    loads: int


class Lanes(Record):
    """Runs of one system side by side, each with its own step.

    Attributes
    ----------
    count : int
        Number of lanes.
    slot : Integers
        Address of the `Variants` of each lane.
    state, entry : Integers
        State of each, and the entry by which its run goes on if it waits.
    waiting : int
        The lane that Python must act for.
    until_steps_of, attempt_of, crossing_of, look_of, end_of : int
        Addresses of these entries.
    looks_inside : int
        Whether values inside all steps are needed.
    next_look : Wide
        The next instant at which a value is wanted, s.
    """

    plant: Plant
    watch: LaneWatch
    count: int
    slot: Annotated[Integers, "lanes"]
    state: Annotated[Integers, "lanes"]
    entry: Annotated[Integers, "lanes"]
    waiting: int
    is_stopped: int
    until_steps_of: int
    attempt_of: int
    crossing_of: int
    look_of: int
    end_of: int

    parameters: int
    looks_inside: int
    watches: int
    chooses_method: int
    max_steps: float
    rtol: float
    longest: float

    p: Annotated[Wides, "lanes * (parameters + prepared)"]
    m: Annotated[Wides, "lanes * settings"]
    t: Annotated[Wide, "lanes"]
    t_new: Annotated[Wide, "lanes"]
    end: Annotated[Wide, "lanes"]
    h: Annotated[Wide, "lanes"]
    next_look: Annotated[Wide, "lanes"]
    was_rejected: Annotated[Wide, "lanes"]
    stiff_steps: Annotated[Wide, "lanes"]
    patience: Annotated[Wide, "lanes"]
    untried_steps: Annotated[Wide, "lanes"]
    long_enough: Annotated[Wide, "lanes"]
    steps: Annotated[Wide, "lanes"]
    rejected: Annotated[Wide, "lanes"]
    is_on: Annotated[Wide, "lanes"]
    mark: Annotated[Wide, "lanes"]
    look_mark: Annotated[Wide, "lanes"]
    may_rise: Annotated[Wide, "lanes"]
    is_rough: Annotated[Wide, "lanes"]

    evaluations: int
    shares: int
    is_written: int
    written: Function
    x: Annotated[Wides, "lanes * states"]
    stages: Annotated[Wides, "lanes * 16 * states"]
    new: Annotated[Wides, "lanes * states"]
    atol: Annotated[Wides, "lanes * states"]
    attempt: Annotated[Wides, "lanes * 6"]
    at_stages: Annotated[Wides, "lanes * 8 * integrands"]
    argument: Annotated[Wides, "lanes * states"]
    dense: Annotated[Wides, "lanes * 7 * states"]
    stiffness: Annotated[Wide, "lanes"]

    floor: Annotated[Wides, "lanes * margins"]
    ranges: Annotated[Wides, "lanes * (2 * states + 2)"]
    force: Annotated[Wides, "lanes * forcings"]
    force_low: Annotated[Wides, "lanes * forcings"]
    force_high: Annotated[Wides, "lanes * forcings"]
    force_range: Annotated[Wides, "lanes * 2 * forcings"]
    ratio: Annotated[Wides, "lanes * levers"]
    found: Annotated[Wides, "lanes * implicit"]
    correction: Annotated[Wides, "lanes * implicit"]

    series: Function
    order: int
    terms: int
    row: int
    by_series: int
    caution: float
    coefficients: Annotated[Wides, "lanes * terms * row"]
    bernstein: Annotated[Wides, "lanes * terms"]
