"""Records of an instant at which positions are found (see `lumped.kernel.run` for lengths)."""

from __future__ import annotations

from typing import Annotated

from lumped.code.records import Record
from lumped.code.words import Integers, Numbers
from lumped.kernel.rounds import Rounds


class Look(Record):
    """The quantities that decide positions at one point, in the order of the function `look`."""

    greater: Annotated[Numbers, "conditions", "2 * conditions + 7 * holds + jump_values + states"]
    less: Annotated[Numbers, "conditions"]
    speed: Annotated[Numbers, "holds"]
    acceleration: Annotated[Numbers, "holds"]
    reaction: Annotated[Numbers, "holds"]
    upper: Annotated[Numbers, "holds"]
    lower: Annotated[Numbers, "holds"]
    gap: Annotated[Numbers, "holds"]
    restitution: Annotated[Numbers, "holds"]
    jumped: Annotated[Numbers, "jump_values"]
    rates: Annotated[Numbers, "states"]


class Reserve(Record):
    """The linear programme for the largest reserve of constraints that share (see `reserve`).

    Everything is written before it is read, so another run need not clear it.

    Attributes
    ----------
    size : int
        Number of all holds.
    least_size : float
        Load that counts as one where all carry less and no limit tells another.
    influence : Numbers
        Changes of reaction, upper and lower limit of each hold if one yields a little, for each.
    changes : int
        Whether any limit comes nearer.
    is_exhausted : int
        Whether more is missing.
    stresses : int
        Independent distributions of reactions that move nothing.
    upper, lower, carried : Numbers
        Limits and reaction of each constraint of a group.
    rounding : Numbers
        What may be missing at a limit of each.
    nears_upper, nears_lower : Numbers
        How much nearer each limit comes, relative to the one that comes nearest; 0 if it does not.
    blocks : Integers
        1 or -1 where the upper or lower limit keeps the reserve from being larger.
    stress : Numbers
        Reaction, upper and lower limit of each constraint in each of the distributions.
    table, rows : Numbers, int
        The variable of each row, expressed by those of the columns and a constant.
    row_owner, column_owner : Integers
        Variable of each row and column: a room; below zero a distribution, or the reserve.
    limit : Integers
        Which limit leaves each of the rooms.
    """

    size: int
    least_size: float
    influence: Annotated[Numbers, "3 * holds * holds"]
    changes: int
    is_exhausted: int
    stresses: int
    rows: int
    upper: Annotated[Numbers, "holds"]
    lower: Annotated[Numbers, "holds"]
    carried: Annotated[Numbers, "holds"]
    rounding: Annotated[Numbers, "holds"]
    nears_upper: Annotated[Numbers, "holds"]
    nears_lower: Annotated[Numbers, "holds"]
    blocks: Annotated[Integers, "holds"]
    stress: Annotated[Numbers, "3 * holds * holds"]
    table: Annotated[Numbers, "(2 * holds + 1) * (holds + 2)"]
    row_owner: Annotated[Integers, "2 * holds + 1"]
    column_owner: Annotated[Integers, "holds + 1"]
    limit: Annotated[Integers, "2 * holds + 1"]


class Problem(Record):
    """What holds carry within their limits (see `lumped.kernel.instants.problem`).

    Attributes
    ----------
    place, next_place : Integers
        Whether each hold is outside of the problem, within its limits, or at one of them.
    carried, motion : Numbers
        Its reaction or impulse; its acceleration or speed beyond that within its limits.
    most, least : Numbers
        Its limits.
    beyond : Numbers
        What it carries at its limit beside its law.
    room : Numbers
        Acceleration that is rounding.
    slides : Integers
        Whether its limit is that of sliding.
    is_wrong : Integers
        Whether its place was wrong when it was looked at last.
    """

    place: Annotated[Integers, "holds"]
    next_place: Annotated[Integers, "holds"]
    carried: Annotated[Numbers, "holds"]
    motion: Annotated[Numbers, "holds"]
    most: Annotated[Numbers, "holds"]
    least: Annotated[Numbers, "holds"]
    beyond: Annotated[Numbers, "holds"]
    room: Annotated[Numbers, "holds"]
    slides: Annotated[Integers, "holds"]
    is_wrong: Annotated[Integers, "holds"]


class InstantSearch(Record):
    """Positions and states while they are found at one instant."""

    x: Annotated[Numbers, "states"]
    m: Annotated[Numbers, "settings"]
    before: Annotated[Numbers, "settings"]

    # margins that fired
    fired: Annotated[Integers, "margins"]
    fired_count: int

    # when it was begun; conditions that may stay although both sides are equal; those that made
    # states jump
    prepared_at: float
    is_exempt: Annotated[Integers, "conditions"]
    has_jumped: Annotated[Integers, "conditions"]
    was_true: Annotated[Integers, "jumps"]

    # the jump, from 1, that has set a state at this instant (0: none; below zero: in an earlier
    # round of it); the state that two set, and the later of them
    set_by: Annotated[Integers, "states"]
    set_twice: int
    setting_again: int

    # whether a program is to answer now, and the jump for which; jumps for which one was asked
    is_waiting: int
    asking: int
    was_asked: Annotated[Integers, "jumps"]

    # holds that stuck before, come to a standstill now, rest by the answer of an impact, are struck
    # by it, let go; energy lost in the impact, its impulse, and how much later the bounces end that
    # are left out; speeds with the settings before; whether speeds jumped
    was_stuck: Annotated[Integers, "holds"]
    is_halted: Annotated[Integers, "holds"]
    is_settled: Annotated[Integers, "holds"]
    is_struck: Annotated[Integers, "holds"]
    was_let_go: Annotated[Integers, "holds"]
    loss: Annotated[Numbers, "holds"]
    impulse: Annotated[Numbers, "holds"]
    delay: Annotated[Numbers, "holds"]
    speed_before: Annotated[Numbers, "holds"]
    has_moved: int
    fastest: float

    # conditions, or holds by their places, that are wrong; rounds in which they change
    condition_rounds: Rounds
    place_rounds: Rounds
    wrong: Annotated[Integers, "max(conditions, holds)"]
    problem: Problem

    # impacts: holds that close, their restitution and the speed with which a hold leaves; speeds
    # and states before
    is_closing: Annotated[Integers, "holds"]
    bounce: Annotated[Numbers, "holds"]
    leaving: Annotated[Numbers, "holds"]
    rest_speed: Annotated[Numbers, "holds"]
    x_before: Annotated[Numbers, "states"]
    speed_at_begin: Annotated[Numbers, "holds"]

    # redundant constraints: whether they share, whether no reserve is left, and those that keep it
    # from being larger; members of a group
    is_shared: int
    is_exhausted: int
    gives_way: Annotated[Integers, "holds"]
    group: Annotated[Integers, "holds"]
    is_grouped: Annotated[Integers, "holds"]
    reserve: Reserve

    trial: Annotated[Numbers, "settings"]
    sole: Annotated[Numbers, "settings"]
    seen: Look
    at_rest: Look
    pushed: Look
    after: Look
