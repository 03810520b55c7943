"""The search for modes that fit at one instant."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lumped.errors import SolverError
from lumped.timeloop.holds import BACKWARD, FORWARD, STUCK, Holds, Look, Situation
from lumped.timeloop.impact import Impacts
from lumped.timeloop.sharing import Sharing

__all__ = ["Fitting"]

_SLACK = 1e-10
"""Relative excess of a limit that is still rounding."""

_PATIENCE = 6
"""Rounds in which all wrong modes change at once although they have not become fewer."""


class _Wrong:
    """Which wrong modes change in a round.

    All do while that helps, then the first alone, until there are fewer than ever before (Judice
    and Pires, Computers and Operations Research 21 (1994) 587; Murty's rule).
    """

    def __init__(self) -> None:
        self._fewest, self._left = np.inf, _PATIENCE

    def to_change(self, wrong: np.ndarray) -> np.ndarray:
        """Of the numbers of all that are wrong, those that change."""
        if len(wrong) < self._fewest:
            self._fewest, self._left = len(wrong), _PATIENCE
        elif self._left:
            self._left -= 1
        else:
            return wrong[:1]
        return wrong


class Fitting:
    """Changes modes and states at one instant until everything fits.

    Parameters
    ----------
    holds, sharing, impacts : Holds, Sharing, Impacts
        Of the system, with one set of parameters; without impacts nothing collides.
    at : Situation
        What is changed.
    before : ndarray
        Modes before the instant.
    soon : float
        What happens within this time happens at once, s.

    Attributes
    ----------
    jumped : set of int
        Modes of conditions that made states jump.
    """

    def __init__(
        self,
        holds: Holds,
        sharing: Sharing,
        impacts: Impacts | None,
        at: Situation,
        before: np.ndarray,
        soon: float,
    ) -> None:
        self._holds, self._sharing, self._impacts = holds, sharing, impacts
        self._s, self._at, self._soon = holds.switching, at, soon
        self._jump_modes = np.array([j.mode for j in self._s.jumps], dtype=int)
        self._edge = before[self._jump_modes] > 0.5
        self._exempt = np.zeros(len(self._s.relation_modes), dtype=bool)
        self._relations_wrong, self._holds_wrong = _Wrong(), _Wrong()
        self.jumped: set[int] = set()

    def flip(self, fired: Sequence[tuple[str, int]]) -> None:
        """Change what an event says changes."""
        at, s = self._at, self._s
        tables = {k for k, _ in s.tables}
        look = (
            self._holds.look_at(at) if tables & {i for k, i in fired if k == "relation"} else None
        )
        for kind, i in fired:
            if kind == "relation":
                run = 0.0 if look is None else float(look.greater[i] - look.less[i])
                s.turn(at.modes, i, run)
                self._exempt[i] = True
            elif kind == "slide":
                at.halted[i] = True
                if not s.has_gap[i]:
                    self._holds.put(at.modes, i, STUCK)
            else:
                self._holds.put(at.modes, i, FORWARD if kind == "upper" else BACKWARD)

    def run(self) -> Look:
        """Change modes and states until everything fits.

        Returns
        -------
        Look
            At what fits, before speeds of what sticks are made exactly zero.

        Raises
        ------
        SolverError
            If no modes fit, or changes follow each other without end.
        """
        at, s = self._at, self._s
        most = 40 + 20 * (len(s.first_modes) + len(s.relation_modes) + len(s.jumps))
        for _ in range(most):
            self._sharing.share(at.t, at.x, at.modes, at.guess)
            look = self._holds.look_at(at)
            if self._relations(look) or self._jumps(look) or self._engage(look):
                continue
            impacts = self._impacts
            if (impacts and impacts.collide(at, look)) or self._rebalance(look):
                continue
            if impacts:
                impacts.halt(at, look)
            return look
        raise SolverError(self._endless(most), None)

    def _endless(self, most: int) -> str:
        at, s = self._at, self._s
        look = self._holds.look_at(at)
        listed = [
            f"{name}: {self._holds.word(at.modes, h)}, speed {look.v[h]:.4g}, "
            f"reaction {look.reaction[h]:.6g}"
            for h, name in enumerate(s.names)
        ]
        texts = [
            "{}: {}".format(*s.relation_text(k, at.modes[m]))
            for k, m in enumerate(s.relation_modes)
        ]
        return (
            f"{self._holds.system.name}: no set of modes fits at t = {at.t:.9g} s after {most} "
            "attempts; changes follow each other without end. Last tried:\n  "
            + "\n  ".join((listed + texts)[:12])
            + "\nCheck conditions that switch each other, limits of reactions that depend on the "
            "reaction itself, and jumps that make their own condition true again."
        )

    def _relations(self, look: Look) -> bool:
        """Turn conditions round that do not say what their sides say."""
        modes, s = self._at.modes, self._s
        if not len(s.relation_modes):
            return False
        on = modes[s.relation_modes] > 0.5
        g, slack = look.greater - look.less, look.slack()
        equal = (g == 0.0) & (on == s.strict) & ~self._exempt & ~s.is_table
        wrong = np.flatnonzero(s.wrong(modes, g, slack) | equal)
        if not len(wrong):
            return False
        for k in self._relations_wrong.to_change(wrong).tolist():
            s.turn(modes, k, float(g[k]))
        self._exempt |= equal
        return True

    def _jumps(self, look: Look) -> bool:
        """Change states where conditions have become true."""
        if not self._s.jumps:
            return False
        now = self._at.modes[self._jump_modes] > 0.5
        rising = now & ~self._edge
        self._edge = now
        for k in np.flatnonzero(rising).tolist():
            jump, places = self._s.jumps[k], self._holds.jump_places[k]
            self.jumped.add(jump.mode)
            for i, (place, sign) in enumerate(zip(places, jump.signs, strict=True)):
                if place is not None:
                    self._at.x[place] = sign * look.values[jump.first + i]
                    self._at.moved = True
        return bool(rising.any())

    def _engage(self, look: Look) -> bool:
        """Engage and release holds."""
        engaged = self._holds.engaged(self._at.modes)
        acting = self._holds.parts(self._at.modes).any(axis=0)
        wrong = engaged != acting
        if not wrong.any():
            return False
        released, closed = wrong & acting, wrong & engaged
        self._holds.put(self._at.modes, released, None)
        self._at.halted &= ~released
        self._slide(closed, look)
        return True

    def _slide(self, which: np.ndarray, look: Look) -> None:
        """Give modes that follow from speed and gap alone."""
        s, least = self._s, self._holds.standstills(self._at.x)
        still = np.abs(look.v) <= least
        touching = (look.gap <= 1e-13) & (look.v <= least)
        backward = which & ~s.has_gap & ~still & (look.v < 0) & s.has_backward
        forward = which & np.where(
            s.has_gap, ~(touching & still), ~still & (look.v > 0) & s.has_forward
        )
        put, modes = self._holds.put, self._at.modes
        put(modes, forward, FORWARD)
        put(modes, backward, BACKWARD)
        put(modes, which & ~forward & ~backward, STUCK)

    def _rebalance(self, look: Look) -> bool:
        """Let go what is overloaded, hold what would turn back."""
        s, at, holds = self._s, self._at, self._holds
        if not s.names:
            return False
        stuck, forward, backward = holds.parts(at.modes)
        at_rest = (np.abs(look.v) <= holds.standstills(at.x)) | at.halted
        slack = _SLACK * np.abs(look.reaction) + 1e-13
        if at.modes[holds.compliances].any():
            slack *= 1e4
        over = stuck & (look.reaction > look.upper + slack + _SLACK * np.abs(look.upper))
        under = stuck & (look.reaction < look.lower - slack - _SLACK * np.abs(look.lower))
        onward = look.v > 0
        overloaded = over | under
        freed = overloaded
        if at.moved:
            known = np.where(onward, s.has_forward, s.has_backward)
            freed = freed | (stuck & ~at_rest & known)
        back = self._turning(look, at_rest, forward, backward)
        reversed_ = ~s.has_gap & ~at_rest & ((forward & (look.v < 0)) | (backward & onward))
        wrong = np.flatnonzero(freed | back | reversed_)
        if not len(wrong):
            return False
        changing = self._holds_wrong.to_change(wrong)
        ahead = np.where(overloaded, over, onward)[changing]
        halting = back[changing]
        holds.put(at.modes, changing[halting], STUCK)
        holds.put(at.modes, changing[~halting & ahead], FORWARD)
        holds.put(at.modes, changing[~halting & ~ahead], BACKWARD)
        at.halted[changing[halting]] = True
        return True

    def _turning(
        self, look: Look, at_rest: np.ndarray, forward: np.ndarray, backward: np.ndarray
    ) -> np.ndarray:
        """What slides but would turn back at once."""
        has_gap = self._s.has_gap
        calm = 1e-9 * (1.0 + float(np.abs(look.rates).max(initial=0.0)))
        falling, rising = look.a < 0, look.a > 0
        ending = (np.abs(look.v) <= np.abs(look.a) * self._soon) & ~has_gap
        ending &= (forward & (look.v > 0) & falling) | (backward & (look.v < 0) & rising)
        contact = ~has_gap | (look.gap <= 1e-13)
        back = forward & contact & ((at_rest & (look.a < -calm)) | ending)
        found: np.ndarray = back | (backward & ((at_rest & (look.a > calm)) | ending))
        return found
