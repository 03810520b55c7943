"""A plant: the functions and tables of a system that the time loop needs, without any names.

A function takes states x, parameters p, the time t and settings m, and writes its results one
after the other. Settings are the positions of conditions and holds, then implicit quantities.

One function takes the ends of ranges in place of the states and the time: the least values of all
states, the greatest, and both times. `margin_floor` gives lower bounds of the margins in between.
`forcing` gives what of the rates follows the time alone, `forcing_range` lower and upper bounds of
that between two times, which take the place of the states. `projection` gives the change of the
states that meets their invariants, and how independent these are. `opened` gives the sides of all
conditions where implicit quantities have their guesses, if these depend on conditions.

A hold is a constraint that sticks, or slides forward or backward, or is free; its settings are
those of `lumped.flattening.hold_modes`. A condition has one, or those of a piece of a table: its
number, its begin, and three of its margin, ``k0 + s (k1 + k2 s)`` with s the distance from the
begin.
"""

from __future__ import annotations

from lumped.code.records import Record
from lumped.code.words import Integers, Numbers

FREE = -1
"""The position of a hold that neither sticks nor slides."""

CONDITION, UPPER, LOWER, SLIDE = range(4)
"""Kinds of margins: of a condition, of the limits of a reaction, of a speed or gap."""


class Function(Record):
    """A function of a plant.

    Attributes
    ----------
    address : int
        Address of its machine code; 0 as long as it is interpreted.
    wide_address : int
        Address of that for several lanes; 0 if there is none.
    count : int
        Number of its operations.
    operations : Integers
        Operation, result and two arguments of each (see `interpret`).
    constants : Numbers
        Constants, which operations name by their number.
    """

    address: int
    wide_address: int
    count: int
    operations: Integers
    constants: Numbers


class Plant(Record):
    """The data of a system that a run needs."""

    # sizes
    states: int
    settings: int
    implicit: int
    margins: int
    conditions: int
    holds: int
    jumps: int
    levers: int
    has_opened: int
    followers: int
    speed_uses: int
    parameters: int
    prepared: int
    forcings: int
    invariants: int

    # functions; the first gives what others need of parameters alone, which follows these
    prepare: Function
    rates: Function
    jacobian: Function
    look: Function
    margin: Function
    margin_floor: Function
    forcing: Function
    forcing_range: Function
    closure: Function
    opened: Function
    leverage: Function
    following: Function
    projection: Function

    # conditions: the first setting of each, whether it is strict, and its table of pieces, if any
    condition_setting: Integers
    is_strict: Integers
    piece_count: Integers
    piece_width: Integers
    first_piece: Integers
    pieces: Numbers

    # holds: the first setting of each, the condition under which it acts (or -1), which limits and
    # laws it has, the state that is its speed (or -1), whether it takes impulses, whether they
    # press it, whether its speed may jump with conditions and functions of time, and whether its
    # reaction determines its speed, not its rate
    hold_setting: Integers
    engaged_by: Integers
    has_upper: Integers
    has_lower: Integers
    has_forward: Integers
    has_backward: Integers
    has_gap: Integers
    speed_state: Integers
    is_impulsive: Integers
    is_pressed: Integers
    may_leap: Integers
    is_direct: Integers
    opposite: Integers

    # which states have rates that are no unknowns of the equations of motion
    is_moved: Integers

    # states of the same unit that share an invariant with each, from `first_companion[i]` on
    first_companion: Integers
    companion: Integers

    # which states the speeds of holds depend on
    use_hold: Integers
    use_state: Integers

    # jumps of states: setting of the condition, its number (or -1), the rank among those
    # before which a program is asked (or 0), and from `jump_begin[k]` on the states that change
    # (or -1), with their signs
    jump_setting: Integers
    jump_condition: Integers
    jump_asks: Integers
    jump_begin: Integers
    jump_state: Integers
    jump_sign: Numbers

    # margins
    margin_kind: Integers
    margin_number: Integers

    # arbitrary accelerations of the holds, arbitrary directions of the implicit quantities
    any_demand: Numbers
    any_direction: Numbers
