"""One complementarity problem: what each hold carries within its limits, and how it moves.

    w = b - A r,  lower <= r <= upper,  w = 0 within, w >= 0 at the upper, w <= 0 at the lower one.

Here r are reactions and w accelerations (`lumped.kernel.instants.reactions`), or r are impulses and
w speeds beyond those that restitution asks for (`lumped.kernel.instants.impacts`); ``A = G M^-1
G'`` for constraints ``G v`` of bodies with the masses M. One evaluation of the plant, with the
holds within their limits stuck and the others at theirs, gives r and w for these places, so A is
never formed. All wrong places change at once while their number falls, then only the first
(`lumped.kernel.rounds`): this ends, and the answer is the same in any order, if A is positive
definite, as it is for holds that are not redundant and limits that do not depend on reactions
(Murty, Opsearch 11 (1974) 196). Redundant ones yield a little, so that A is definite for them, too,
and proximal steps undo it. Else there may be no answer.
"""

from __future__ import annotations

from lumped.code.words import kernel
from lumped.flattening.hold_modes import BACKWARD, FORWARD, STUCK
from lumped.kernel.instant_search import InstantSearch, Problem
from lumped.kernel.plant import FREE
from lumped.kernel.rounds import may_change

OUTSIDE, WITHIN, AT_UPPER, AT_LOWER = range(4)
"""Places of a hold: no part of the problem, within its limits, at one of them."""


@kernel
def position_at(place: int) -> int:
    """Position of a hold at a place; outside of the problem it is free."""
    if place == WITHIN:
        return STUCK
    return FORWARD if place == AT_UPPER else BACKWARD if place == AT_LOWER else FREE


@kernel
def right_place(problem: Problem, h: int, excess: float, room: float) -> int:
    """The place of a hold that its reaction or motion asks for.

    Parameters
    ----------
    excess, room : float
        Excess over a limit, and motion, that are rounding.
    """
    place = problem.place[h]
    if place == WITHIN:
        if problem.carried[h] > problem.most[h] + excess:
            return AT_UPPER
        if problem.carried[h] < problem.least[h] - excess:
            return AT_LOWER
    turns_back = place == AT_UPPER and problem.motion[h] < -room
    turns_back = turns_back or (place == AT_LOWER and problem.motion[h] > room)
    return WITHIN if turns_back else place


@kernel
def change_places(instant: InstantSearch, holds: int) -> bool:
    """Go to the next places, to all or to the first that differs; whether any does."""
    problem, wrong, count = instant.problem, instant.wrong, 0
    for h in range(holds):
        problem.is_wrong[h] = problem.next_place[h] != problem.place[h]
        if problem.is_wrong[h]:
            wrong[count] = h
            count += 1
    if count == 0:
        return False
    for i in range(may_change(instant.place_rounds, count)):
        problem.place[wrong[i]] = problem.next_place[wrong[i]]
        problem.beyond[wrong[i]] = 0.0
    return True
