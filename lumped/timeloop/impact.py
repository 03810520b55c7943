"""Impacts: impulses of constraints that close at a speed."""

from __future__ import annotations

import numpy as np

from lumped.timeloop.holds import BACKWARD, FORWARD, STUCK, Holds, Look, Situation
from lumped.timeloop.sharing import Sharing

__all__ = ["Impacts"]


class Impacts:
    """Jumps of speeds in a system.

    Parameters
    ----------
    holds, sharing : Holds, Sharing
        Of the system, with one set of parameters.
    shortest : float
        Bounces that would last less are left out, s.
    """

    def __init__(self, holds: Holds, sharing: Sharing, shortest: float) -> None:
        s = holds.switching
        self._holds, self._sharing, self._shortest = holds, sharing, shortest
        self._s, self._any = s, bool(holds.impulsive.any())
        self._pushing = s.has_upper & ~s.has_lower
        self._pulling = s.has_lower & ~s.has_upper

    def collide(self, at: Situation, look: Look) -> bool:
        """Let constraints without limit that close at a speed do so; whether there were any."""
        if not self._any:
            return False
        s, holds = self._s, self._holds
        stuck, forward, backward = holds.parts(at.modes)
        still = holds.standstills(at.x)
        near = ~s.has_gap | (look.gap <= 1e-13) | at.halted
        approaching = (look.v < -still) & ~s.has_backward & near
        approaching |= (look.v > still) & ~s.has_forward
        approaching &= ~at.halted | s.has_gap
        if not at.moved:
            approaching &= ~stuck | ~at.was_stuck
        closing = (stuck | forward | backward) & holds.impulsive & approaching
        if not closing.any():
            return False
        bounce = np.where(closing, look.restitution, 0.0)
        taken = self._strike(at, look, closing, bounce)
        after = holds.look_at(at)
        for h in np.flatnonzero(closing & taken & (bounce != 0)).tolist():
            if self._rests(at, h, after):
                bounce[h] = 0.0
                only = np.zeros_like(closing)
                only[h] = True
                self._strike(at, after, only, bounce, pull=True)
        at.halted &= ~closing
        resting = closing & taken & (bounce == 0)
        away = closing & ~taken  # others pull it away
        holds.put(at.modes, resting, STUCK)
        holds.put(at.modes, closing & taken & ~resting, FORWARD)
        holds.put(at.modes, away & s.has_upper, FORWARD)
        holds.put(at.modes, away & ~s.has_upper, BACKWARD)
        holds.stop(at.x, resting)
        return True

    def halt(self, at: Situation, look: Look) -> None:
        """Bring the speed of what sticks to exactly zero."""
        stuck = self._holds.parts(at.modes)[STUCK]
        if (look.v[stuck] != 0.0).any():
            losses = dict(at.losses)
            self._strike(at, look, stuck, np.zeros_like(look.v), pull=True)
            at.losses = losses
        self._holds.stop(at.x, stuck | (at.halted & ~self._s.has_gap))

    def _rests(self, at: Situation, hold: int, look: Look) -> bool:
        """Whether a bounce would be over at once."""
        trial = at.modes.copy()
        self._holds.put(trial, hold, FORWARD)
        a = self._holds.look(at.t, at.x, trial, at.guess).a[hold]
        return bool(a < 0 and 2 * look.v[hold] <= -a * self._shortest)

    def _strike(
        self,
        at: Situation,
        look: Look,
        closing: np.ndarray,
        bounce: np.ndarray,
        pull: bool = False,
    ) -> np.ndarray:
        """Impulses of what closes and of all constraints without limit that hold.

        Gives back which take part.

        The jump of all speeds is what the accelerations would be if the closing constraints
        demanded the change of their speed in unit time, without any other force: the impulsive
        form of the same equations (Routh, Dynamics of a System of Rigid Bodies, ch. VIII).
        """
        holds = self._holds
        stuck, forward, _ = holds.parts(at.modes)
        members: np.ndarray = closing | (stuck & holds.impulsive)
        change = np.where(closing, -(1.0 + bounce) * look.v, 0.0)
        touching = self._s.has_gap & forward & (look.gap <= 1e-13)
        for _ in range(2 * len(members) + 2):
            trial = at.modes.copy()
            holds.put(trial, ~members, None)
            holds.put(trial, members, STUCK)
            self._sharing.share(at.t, at.x, trial, at.guess)
            rest = holds.look(at.t, at.x, trial, at.guess)
            trial[holds.demands[members]] = change[members]
            push = holds.look(at.t, at.x, trial, at.guess)
            impulse = push.reaction - rest.reaction
            speed = look.v + push.a - rest.a
            size = np.abs(impulse)
            wrong = (self._pushing & (impulse > 0)) | (self._pulling & (impulse < 0))
            wrong &= members & (size > 1e-12 * size.max())
            closer = touching & ~members & (speed < -1e-12)
            if wrong.any() and not pull:
                members[np.argmax(np.where(wrong, size, 0.0))] = False
            elif closer.any():
                # it did not approach, so there is nothing that would bounce
                first = np.argmax(closer)
                members[first], change[first] = True, -look.v[first]
            else:
                break
        at.x = at.x + push.rates - rest.rates
        at.moved = True
        lost = 0.5 * impulse * (look.v + speed)
        for h in np.flatnonzero(members).tolist():
            at.losses[h] = at.losses.get(h, 0.0) + float(lost[h])
        return members
