"""What stands where in the two blocks that the time loop works on.

A block of integers and one of numbers hold everything: first scalars at the places named here,
then vectors and tables, whose first place is itself one of the integers.
"""

__all__: list[str] = []

# -- integers: sizes -------------------------------------------------------------------------
(N, NM, NG, NK, NR, NH, NJ, NV, NU, NL, NNZ, SEGMENTS, TIMED) = range(13)
"""States, settings, implicit quantities, margins, relations, holds, jumps, their values, uses of
states by speeds, levers, nonzeros of the Jacobian, segments, modes of functions of time."""

# -- integers: functions, by address -----------------------------------------------------------
(RHS, JACOBIAN, MARGINS, SLOPES, LOOK, CLOSURE, LEVERS) = range(13, 20)

# -- integers: choices -------------------------------------------------------------------------
(AUTO, IMPLICIT, MAY_IMPLICIT, ASK, BOTH_SIDES, ON_GRID, MAX_STEPS, PAUSE) = range(20, 28)
"""ASK: what Python settles, 1 instants of functions of time, 2 crossings. PAUSE: number of attempts
at which the loop returns, so that a long run can be interrupted."""

# -- integers: where a run stands ----------------------------------------------------------------
(PHASE, SEGMENT, REJECTED, STIFF, CALM, STEPS, REFUSED, EVALUATIONS, CROSSINGS) = range(28, 37)
(FIRED, MOVED, RELATION_FEWEST, RELATION_LEFT, HOLD_FEWEST, HOLD_LEFT, DOUBT, SHARED) = range(
    37, 45
)
"""FIRED: number of margins that are used up. DOUBT: constraints may be redundant. SHARED: they were
found to be so."""

# -- integers: output, by address, with how much is taken and how much there is -----------------
(OUT_T, OUT_X, OUT_G, ROWS, MOST_ROWS) = range(45, 50)
(PIECE_ROW, PIECE_MODES, PIECES, MOST_PIECES) = range(50, 54)
(CHANGE_I, CHANGE_D, CHANGES, MOST_CHANGES) = range(54, 58)
(GRID, GRID_SIZE, GRID_NEXT) = range(58, 61)

# -- integers: first places of vectors of numbers ------------------------------------------------
(X, NEW, STAGES, ARGUMENT, DENSE, INNER, P, M, BEFORE, ATOL) = range(61, 71)
(SAMPLES, ENDS, MARGIN, XS, MS, LK, REST, PUSH, AFTER, TRIAL, DEMAND, WISH, BOUNCE) = range(71, 84)
(LOSS, STILL, EDGES, TIMED_VALUES, SIGNS, RING, LEVER, CLOSED, MATRIX, RATES, STACK) = range(84, 95)

# -- integers: first places of tables and vectors of integers -------------------------------------
(RELATION_MODE, STRICT, EXEMPT, JUMPED) = range(95, 99)
(FIRST, ENGAGED, UPPER, LOWER, FORWARD, BACKWARD, GAP, PLACE, IMPULSIVE) = range(99, 108)
(WAS_STUCK, HALTED, CLOSING, MEMBER, STRUCK, WRONG, BACK) = range(108, 115)
(JUMP_MODE, JUMP_FIRST, JUMP_START, JUMP_PLACE, JUMP_RELATION, WAS_TRUE) = range(115, 121)
(USE_HOLD, USE_STATE, KIND, NUMBER, FIRED_ROWS, SUSPECT, TIMED_MODE) = range(121, 128)
(JAC_ROW, JAC_COLUMN, PIVOT) = range(128, 131)
(PIECE_COUNT, PIECE_FIRST, PIECE_WIDTH, TABLE) = range(131, 135)
"""Of the pieces of tables: how many (0 for a relation), where they stand from TABLE on, which is a
place of numbers, and how many settings each has."""
INTEGERS = 135

# -- numbers ---------------------------------------------------------------------------------
(T, H, END, UNTIL, RTOL, LIMIT, T_NEW, T_CROSS, SOON, SHORTEST, KNOWN, CHANGED_AT, E5) = range(13)
"""KNOWN: time at which the last sample of margins was taken. CHANGED_AT: when the method
became implicit. E5: four sums over the states."""
NUMBERS = 17

# -- why the loop returns ------------------------------------------------------------------------
(DONE, FULL, AT_INSTANT, AT_CROSSING, UNFIT, NOT_FINITE, GIVEN_UP, TOO_MANY) = range(8)
(STORM, TOO_STIFF, SINGULAR) = range(8, 11)

# -- where it goes on ------------------------------------------------------------------------------
(BEGIN_SEGMENT, OPEN_SEGMENT, RESTART, STEPPING, CROSS, OPEN_CROSSING, LEAVE_SEGMENT) = range(7)

STORM_SIZE = 200
"""Changes of mode that may follow each other at practically the same instant."""
