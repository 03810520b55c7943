"""What changes modes or states: lowered relations, holds and jumps of one component class."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from lumped.language.pieces import Pieces
from lumped.language.program import Program


@dataclass(frozen=True, eq=False)
class Relation:
    """What chooses among expressions.

    Attributes
    ----------
    mode : int
        Its mode, which is 1 while ``greater >= less`` (or ``>`` if `strict`), else 0; or the first
        of the settings of a piece.
    greater, less : SX
        Sides; or the argument of a piecewise polynomial and the begin of the piece it is in.
    sides : (str, str)
        Both as written.
    words : (str, str), optional
        What it is called while it holds and while it does not.
    pieces : Pieces, optional
        Of a piecewise polynomial.
    told : bool
        Its changes are events.
    """

    mode: int
    greater: ca.SX
    less: ca.SX
    strict: bool
    sides: tuple[str, str]
    words: tuple[str, str] | None = None
    pieces: Pieces | None = None
    told: bool = True


@dataclass(frozen=True, eq=False)
class Stick:
    """A lowered `Hold`.

    Attributes
    ----------
    equation : int
        Number of the equation that determines the reaction.
    first : int
        First of its modes (see `hold_modes`).
    engaged : int or None
        Mode of the condition under which it acts.
    speed, acceleration, reaction : (int, int)
        Local unknown and order of derivative.
    upper, lower, gap, restitution : SX
        Infinite limits, and gaps that do not exist, are nan.
    given : tuple of bool
        Whether there are `upper`, `lower`, `forward`, `backward` and `gap`, whether impulses press
        it, whether its speed may jump with conditions and functions of time, and whether its
        reaction determines its speed, not its rate.
    opposite : int
        How many after it the hold of the opposite limit is, 0 if there is none.
    words : (str, str, str), optional
        What it is called while it sticks, slides forward, and is free.
    """

    equation: int
    first: int
    engaged: int | None
    speed: tuple[int, int]
    acceleration: tuple[int, int]
    reaction: tuple[int, int]
    upper: ca.SX
    lower: ca.SX
    gap: ca.SX
    restitution: ca.SX
    given: tuple[bool, ...]
    opposite: int
    words: tuple[str, str, str] | None


@dataclass(frozen=True, eq=False)
class Jump:
    """A lowered `When`.

    Attributes
    ----------
    mode : int
        Mode of its condition.
    targets : list of int
        Local unknowns that change.
    values : list of SX
        Their new values, then those that a program is given.
    condition : str
        The condition in words.
    program : Program or None
        What is asked.
    answers : list of int
        Local unknowns that take its answers.
    """

    mode: int
    targets: list[int]
    values: list[ca.SX]
    condition: str
    program: Program | None
    answers: list[int]
