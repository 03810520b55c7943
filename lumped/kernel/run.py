"""Records that a run writes: its progress, its present step, its output.

Lengths are expressions of the sizes of a plant: ``states``, ``settings``, ``implicit``,
``parameters``, ``prepared``, ``margins``, ``conditions``, ``holds``, ``jumps``, ``jump_values``,
``levers``, ``followers``, and ``work``, the numbers that its functions need while interpreted;
``enclosed_rows``, ``enclosed_work`` and ``enclosed_results``: operations, numbers and results of
those that are enclosed.
"""

from __future__ import annotations

from typing import Annotated

from lumped.code.records import Record
from lumped.code.words import Integers, Numbers
from lumped.kernel.enclosed import Enclosed
from lumped.kernel.instant_search import InstantSearch
from lumped.kernel.plant import Function, Plant
from lumped.kernel.roots import Bracket
from lumped.kernel.watch import Watch

STORM_SIZE = 200
"""Changes of position that may follow each other at practically the same instant."""

STORM_WITHIN = 1e-9
"""Distance of changes, relative to the size of all times, below which they make a storm."""

MOST_JUMP = 1e-9
"""Jump of a prescribed motion, relative and absolute, that is rounding."""

(GOES_ON, DONE, FULL, UNFIT, NOT_FINITE, GIVEN_UP, TOO_MANY, STORM, NEEDS_MATRIX) = range(9)
(NO_FIT, NOT_CLOSED, JUMPS, INSIDE, NO_START, ASKS, SET_TWICE) = range(9, 16)
"""Why the loop returns. UNFIT: another state must lead. NEEDS_MATRIX: an implicit step is due and
has no matrix yet. NO_FIT: no positions fit. NOT_CLOSED: a linkage cannot be closed. JUMPS: a body
would have to follow a jump. INSIDE: a body starts inside another. NO_START: the start must be
searched for. ASKS: a program must answer. SET_TWICE: two `when` set one state."""

(BEGIN_SEGMENT, OPEN_SEGMENT, RESTART, STEPPING, CROSS, OPEN_CROSSING, LEAVE_SEGMENT) = range(7)
WAITING, SETTLING = 7, 8
"""Where a run goes on. WAITING: in an accepted step in which more times may be wanted. SETTLING:
at an instant at which positions are being found."""


class Pattern(Record):
    """Where the entries of a factorised matrix are: row after row, in the order of the pivots.

    Attributes
    ----------
    nonzeros, entries : int
        Of the Jacobian; of both factors.
    row, column : Integers
        States of each nonzero of the Jacobian.
    place : Integers
        Its entry.
    order : Integers
        State of each pivot.
    begin, diagonal : Integers
        First entry, and that of the pivot, of each row.
    at : Integers
        Column of each entry.
    colours : int
        Groups of columns without common rows, or 0: whether the Jacobian is found along
        directions, one for each group, and the time.
    colour, grouped, first_grouped : Integers
        Group of each column, nonzeros group by group, and the first of each group.
    """

    nonzeros: int
    entries: int
    row: Integers
    column: Integers
    place: Integers
    order: Integers
    begin: Integers
    diagonal: Integers
    at: Integers
    colours: int
    colour: Integers
    grouped: Integers
    first_grouped: Integers


class Matrix(Record):
    """The matrix of an implicit step, factorised."""

    pattern: Pattern
    slopes: Annotated[Numbers, "nonzeros", "nonzeros + states"]
    drift: Annotated[Numbers, "states"]
    factors: Annotated[Numbers, "entries"]
    row: Annotated[Numbers, "states"]
    size: Annotated[Numbers, "states"]
    right: Annotated[Numbers, "states"]
    direction: Annotated[Numbers, "states + states + 1"]


class RunOutput(Record):
    """Results of a run, with the room for each."""

    # points: time, states, implicit quantities
    t: Numbers
    x: Numbers
    implicit: Numbers
    rows: int
    most_rows: int

    # smooth pieces: first row and settings of each
    piece_row: Integers
    piece_settings: Numbers
    pieces: int
    most_pieces: int

    # changes: 0 for a condition or 1 for a hold, its number, position before and after; time, loss
    change: Integers
    change_time: Numbers
    changes: int
    most_changes: int

    # when the method changed, s; no room where nobody asks
    turn: Numbers
    turns: int
    most_turns: int

    # times that are wanted
    grid: Numbers
    grid_size: int
    grid_next: int
    is_on_grid: int
    has_both_sides: int

    # whether pieces and changes are left out
    is_short: int


LENGTH, END, TOLERANCE, ERROR, STIFFNESS, ANGLE = range(6)
"""Numbers of an attempt of a step: what it takes and gives, and the largest angle of its sines."""


class Samples(Record):
    """Points one after the other, with the results of a function at each of them."""

    points: int
    states: int
    settings: int
    results: int
    t: Numbers
    x: Numbers
    m: Numbers
    found: Numbers


class Run(Record):
    """A run."""

    plant: Plant
    instant: InstantSearch
    output: RunOutput
    matrix: Matrix
    watch: Watch
    watches: int

    # this record and all that it writes in one block, and how that was at first; how much of it
    # another run must find as it was
    memory: Integers
    memory_at_first: Integers
    memory_size: int

    # options
    p: Annotated[Numbers, "parameters + prepared"]
    least_atol: Annotated[Numbers, "states"]
    projected: Annotated[Numbers, "states"]
    change: Annotated[Numbers, "states + 1"]
    independence: float
    reach: float
    along: Annotated[Numbers, "states"]
    aside: Annotated[Numbers, "states"]
    rtol: float
    chooses_method: int
    max_steps: int
    lenience: float

    # times: size of all, delay that counts as at once, shortest bounce, longest step
    span: float
    soon: float
    shortest: float
    longest: float

    # segments between instants of functions of time, with the settings that these have in each
    segments: int
    edges: Numbers
    timed: int
    timed_setting: Integers
    timed_values: Numbers

    # progress: where it goes on, and where after positions are found; sizes that states had
    phase: int
    next_phase: int
    segment: int
    t: float
    end: float
    h: float
    m: Annotated[Numbers, "settings"]
    largest: Annotated[Numbers, "states"]
    is_implicit: int
    has_matrix: int
    was_rejected: int

    # the choice of the method: steps in a row that speak for the other one, if they are explicit
    # and if they are implicit; steps to the next trial of it, and to the one after that if it
    # fails; length of an explicit step for which none has failed; steps without a trial; size of
    # the fastest eigenvalue, and a vector along its motion
    stiff_steps: int
    soft_steps: int
    patience: int
    next_patience: int
    long_enough: float
    untried_steps: int
    fastest: float
    fast: Annotated[Numbers, "states"]

    # whether constraints may be redundant, and share what they carry in the present positions;
    # compliance of those that share (see `yielding`)
    may_be_redundant: int
    shares: int
    yielding: float

    # cost so far; the number of steps at which it pauses
    steps: int
    rejected: int
    evaluations: int
    interpreted: int
    pause: int

    # whether it returns as soon as all wanted times are recorded, and stays in that step; whether
    # positions change in the step
    waits: int
    is_crossed: int

    # from here on a run reads no array before it has written it, but for states and tolerances
    scratch: Annotated[Numbers, "0"]

    # number of the last changes of position, and their times
    changed_count: int
    changed: Annotated[Numbers, str(STORM_SIZE)]

    # the present step; whether an attempt may be written out (see `timeloop.plants.written_step`),
    # as a function that takes these fields from the states on, and writes those from the stages on
    t_new: float
    is_written: int
    written: Function
    x: Annotated[Numbers, "states"]
    stages: Annotated[Numbers, "16 * states"]
    new: Annotated[Numbers, "states"]
    atol: Annotated[Numbers, "states"]
    attempt: Annotated[Numbers, "6"]
    at_stages: Annotated[Numbers, "8 * integrands"]
    argument: Annotated[Numbers, "states"]
    dense: Annotated[Numbers, "7 * states"]
    stiffness: float

    # margins in the step: at a point, with their tolerances; at both ends; lower bounds over all of
    # it; when each fires, as a part of the step; parts that wait to be looked at: ends, and values
    # there; where a root lies
    margin: Annotated[Numbers, "margins", "2 * margins"]
    tolerance: Annotated[Numbers, "margins"]
    at_begin: Annotated[Numbers, "2 * margins"]
    at_end: Annotated[Numbers, "2 * margins"]
    floor: Annotated[Numbers, "margins"]
    fires: Annotated[Numbers, "margins"]
    halves: Annotated[Numbers, "64"]
    levels: Annotated[Numbers, "64"]
    inner: Annotated[Numbers, "states"]
    bracket: Bracket
    t_cross: float

    # enclosures (see `enclosure`): ranges of states and time over the step; coefficients of one
    # polynomial, and in the Bernstein basis; a model; operations of margins, and of rates while
    # states rest
    ranges: Annotated[Numbers, "2 * states + 2"]
    powers: Annotated[Numbers, "64"]
    bernstein: Annotated[Numbers, "64"]
    part_model: Annotated[Numbers, "10"]
    enclosed_margins: Enclosed
    enclosed_rates: Enclosed

    # what acts by the time alone: values at nodes of the step, and between which bounds; rates at
    # these nodes, and their least and greatest
    force: Annotated[Numbers, "forcings"]
    force_low: Annotated[Numbers, "forcings"]
    force_high: Annotated[Numbers, "forcings"]
    force_range: Annotated[Numbers, "2 * forcings"]
    rate_low: Annotated[Numbers, "states"]
    rate_high: Annotated[Numbers, "states"]

    # results of functions
    found: Annotated[Numbers, "implicit", "2 * implicit"]
    correction: Annotated[Numbers, "implicit"]
    first_guess: Annotated[Numbers, "implicit"]
    ratio: Annotated[Numbers, "levers"]
    followed_before: Annotated[Numbers, "followers"]
    followed_after: Annotated[Numbers, "followers"]
    work: Annotated[Numbers, "work"]

    # steps by Taylor's series: the function of its coefficients; its order (0: other steps are
    # made); rows of coefficients and their length: those of states, then of integrals; whether the
    # present step is made by them; the part of the step that the last terms allow
    series: Function
    order: int
    terms: int
    row: int
    by_series: int
    caution: float
    coefficients: Numbers
