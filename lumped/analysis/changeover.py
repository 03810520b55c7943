"""Modes that fit the state: which conditions hold, what sticks and what slides, what collides."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from lumped.analysis.calls import called
from lumped.errors import SolverError, StartError
from lumped.system import System

__all__ = ["Change", "Settler"]

_EQUAL = 1e-12
"""Relative difference below which the sides of a condition count as equal."""

_SLACK = 1e-10
"""Relative excess of a limit that is still rounding."""

_INSIDE = 1e-9
"""How deep bodies may start inside each other, m or rad: rounding of start values."""

_COMPLIANCE = 1e-9
"""Of redundant constraints, relative to the compliance of what they hold."""

_TOGETHER = 6
"""Rounds in which all wrong modes change at once; afterwards one at a time (Murty's rule)."""


@dataclass(frozen=True)
class Change:
    """A component that changed its mode: words for before and after, energy lost in J."""

    component: str
    before: str
    after: str
    loss: float = 0.0


class _Look:
    """What decides modes at one point."""

    def __init__(self, system: System, row: np.ndarray) -> None:
        s = system.switching
        r, h = len(s.relation_modes), len(s.first_modes)
        self.greater, self.less = row[:r], row[r : 2 * r]
        self.v, self.a, self.reaction, upper, lower, self.gap, self.restitution = row[
            2 * r : 2 * r + 7 * h
        ].reshape(7, h)
        self.values, self.rates = np.split(row[2 * r + 7 * h :], [s.values.numel()])
        self.upper = np.where(s.has_upper, upper, np.inf)
        self.lower = np.where(s.has_lower, lower, -np.inf)

    def slack(self) -> np.ndarray:
        """Difference of the sides of each condition that is still rounding."""
        size: np.ndarray = np.abs(self.greater) + np.abs(self.less)
        return _EQUAL * size + 1e-13


class Settler:
    """Finds modes for one system and set of parameters.

    Parameters
    ----------
    system : System
        From `assemble`.
    theta : ndarray
        Parameters.
    span : float
        Length of the run, s. What happens within 1e-12 of it happens at once; a bounce that
        would last less than 1e-10 of it is left out.
    """

    def __init__(self, system: System, theta: np.ndarray, span: float) -> None:
        self.system, self.theta, self.span = system, theta, span
        self.s = system.switching
        self._place = {node: i for i, node in enumerate(system.states)}
        s = self.s
        self.impulsive = ~(s.has_upper & s.has_lower)
        self._yielding: float | None = None
        self._known: dict[bytes, bool] = {}
        self._parts = s.first_modes + np.arange(3)[:, None]
        self._still = np.array([node in self._place for node in s.speeds], dtype=bool)

    # -- reading and writing modes -----------------------------------------------------------

    def _get(self, modes: np.ndarray) -> np.ndarray:
        """Stuck, forward, backward of all holds, shape (3, h)."""
        found: np.ndarray = modes[self._parts] > 0.5
        return found

    def _set(self, modes: np.ndarray, hold: int, part: int | None) -> None:
        first = int(self.s.first_modes[hold])
        modes[first : first + 3] = 0.0
        if part is not None:
            modes[first + part] = 1.0

    def _engaged(self, modes: np.ndarray) -> np.ndarray:
        engaged = self.s.engaged
        on: np.ndarray = (engaged < 0) | (modes[engaged] > 0.5 if len(modes) else True)
        return on

    def look(self, t: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray) -> _Look:
        """Evaluate everything that decides modes."""
        (row,) = called(self.system, "look")(x, self.theta, t, np.concatenate([modes, guess]))
        return _Look(self.system, row)

    def rounding(self, x: np.ndarray) -> np.ndarray:
        """Speeds of the holds that may be rounding of the states that they depend on."""
        size = np.zeros(len(self.s.speeds))
        holds, states = self.system.speed_uses
        np.maximum.at(size, holds, np.abs(x[states]))
        return 1e-9 * (1.0 + size)

    def words(self, modes: np.ndarray) -> list[str]:
        """Mode of each hold in words."""
        stuck, forward, backward = self._get(modes)
        found = []
        for h, gap in enumerate(self.s.has_gap):
            if stuck[h]:
                found.append("closed" if gap else "stuck")
            elif forward[h]:
                found.append("open" if gap else "forward")
            else:
                found.append("backward" if backward[h] else "free")
        return found

    # -- finding modes -----------------------------------------------------------------------

    def begin(
        self, t: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, tuple[Change, ...]]:
        """States and modes at the start, and what collides there at once.

        Only modes of functions of time are given.

        Raises
        ------
        StartError
            If bodies start inside each other.
        SolverError
            If no modes fit.
        """
        modes = modes.copy()
        for _ in range(3):
            look = self.look(t, x, modes, guess)
            # not an instant after the start already, so that a clock ticks at zero
            modes[self.s.relation_modes] = look.greater - look.less > look.slack()
        for h in np.flatnonzero(self.s.has_gap & (look.gap < -_INSIDE)):
            raise StartError(
                f"{self.system.name}: {self.s.names[h]} starts {-look.gap[h]:.6g} "
                f"{self.s.gap_units[h]} inside the body that it must not enter. Give start values "
                "that leave a gap, or none."
            )
        work = _Instant(self, t, x.copy(), modes.copy(), guess, modes)
        work.run()
        words = self.words(work.modes)
        slow = self.rounding(x)
        hits = [h for h in sorted(work.impacts) if abs(look.v[h]) > slow[h]]
        return (
            work.x,
            work.modes,
            tuple(Change(self.s.names[h], "", words[h], work.impacts[h]) for h in hits),
        )

    def settle(
        self,
        t: float,
        x: np.ndarray,
        modes: np.ndarray,
        guess: np.ndarray,
        before: np.ndarray,
        fired: Iterable[tuple[str, int]] = (),
    ) -> tuple[np.ndarray, np.ndarray, list[Change]]:
        """States and modes just after an instant.

        Parameters
        ----------
        modes, before : ndarray
            Modes with those of functions of time as they are from now on; all as they were.
        fired : iterable of (str, int)
            Margins that are used up (see `Switching.margins`).

        Raises
        ------
        SolverError
            If no modes fit, or changes follow each other without end.
        """
        work = _Instant(self, t, x.copy(), modes.copy(), guess, before)
        work.flip(fired)
        work.run()
        return work.x, work.modes, work.changes(before)

    def _softest(self, t: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray) -> float:
        """How much acceleration a unit of force gives at most where a constraint acts."""
        found = 0.0
        alone = modes.copy()
        alone[self.s.first_modes + 3] = 0.0
        for i in range(len(self.s.first_modes)):
            self._set(alone, i, None)
        for i, first in enumerate(self.s.first_modes.tolist()):
            self._set(alone, i, 0)
            rest = self.look(t, x, alone, guess)
            alone[first + 4] = 1.0
            with np.errstate(invalid="ignore"):  # infinite where a motion is prescribed
                force = abs(self.look(t, x, alone, guess).reaction[i] - rest.reaction[i])
            alone[first + 4] = 0.0
            self._set(alone, i, None)
            if np.isfinite(force) and force > 0:
                found = max(found, 1.0 / force)
        return found or 1.0

    def _redundant(self, t: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray) -> bool:
        """Whether what sticks cannot have any accelerations that one likes."""
        stuck = self._get(modes)[0]
        if not stuck.any():
            return False
        key = stuck.tobytes()
        if key not in self._known:
            trial, h = modes.copy(), len(stuck)
            trial[self.s.first_modes + 3] = 0.0
            rest = self.look(t, x, trial, guess)
            wanted = np.random.default_rng(4).uniform(0.5, 1.5, h)
            trial[self.s.first_modes + 4] = wanted
            look = self.look(t, x, trial, guess)
            with np.errstate(invalid="ignore"):  # reactions are infinite where they are redundant
                error = np.abs(look.a - rest.a - wanted)[stuck].max(initial=0.0)
                finite = np.isfinite(look.reaction - rest.reaction)[stuck].all()
            self._known[key] = not (finite and error < 1e-6)
        return self._known[key]

    def share(self, t: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray) -> None:
        """Let redundant constraints yield a little; the stronger one carries more."""
        modes[self.s.first_modes + 3] = 0.0
        if not self._redundant(t, x, modes, guess):
            return
        if self._yielding is None:
            self._yielding = _COMPLIANCE * self._softest(t, x, modes, guess)
        modes[self.s.first_modes + 3] = self._yielding
        look = self.look(t, x, modes, guess)
        reach = np.minimum(np.abs(look.upper), np.abs(look.lower))
        finite = np.isfinite(reach) & (reach > 0)
        largest = reach[finite].max(initial=0.0)
        weight = np.where(finite & (largest > 0), largest / np.where(finite, reach, 1.0), 1.0)
        modes[self.s.first_modes + 3] *= np.minimum(weight, 1e3)


class _Instant:
    """Modes and states while they settle at one instant."""

    def __init__(
        self,
        settler: Settler,
        t: float,
        x: np.ndarray,
        modes: np.ndarray,
        guess: np.ndarray,
        before: np.ndarray,
    ) -> None:
        self.o, self.s = settler, settler.s
        self.t, self.x, self.modes, self.guess = t, x, modes, guess
        self._was_stuck = settler._get(before)[0]
        self.edge = before[np.array([j.mode for j in self.s.jumps], dtype=int)] > 0.5
        self.moved = False
        self.halted: set[int] = set()
        self.exempt: set[int] = set()
        self.impacts: dict[int, float] = {}
        self.jumped: list[int] = []
        for h in np.flatnonzero(self._was_stuck).tolist():
            self._stop(h, True)  # implicit steps leave rounding there

    def flip(self, fired: Iterable[tuple[str, int]]) -> None:
        """Change what an event says changes."""
        for kind, i in fired:
            if kind == "relation":
                mode = self.s.relation_modes[i]
                self.modes[mode] = 1.0 - self.modes[mode]
                self.exempt.add(i)
            elif kind == "slide":
                self.halted.add(i)
                if not self.s.has_gap[i]:
                    self.o._set(self.modes, i, 0)
            else:
                self.o._set(self.modes, i, 1 if kind == "upper" else 2)

    def run(self) -> None:
        """Change modes and states until everything fits."""
        h, r = len(self.s.first_modes), len(self.s.relation_modes)
        most = 40 + 20 * (h + r + len(self.s.jumps))
        for number in range(most):
            self.o.share(self.t, self.x, self.modes, self.guess)
            look = self.o.look(self.t, self.x, self.modes, self.guess)
            if self._relations(look, number) or self._jumps(look) or self._switch(look):
                continue
            if self._collide(look) or self._rebalance(look, number):
                continue
            self._halt(look)
            return
        raise SolverError(self._endless(most), None)

    def _endless(self, most: int) -> str:
        look = self.o.look(self.t, self.x, self.modes, self.guess)
        words = self.o.words(self.modes)
        listed = [
            f"{name}: {word}, speed {look.v[h]:.4g}, reaction {look.reaction[h]:.6g}"
            for h, (name, word) in enumerate(zip(self.s.names, words, strict=True))
        ]
        texts = [
            "{}: {}".format(*self.s.relation_text(k, bool(self.modes[m] > 0.5)))
            for k, m in enumerate(self.s.relation_modes)
        ]
        return (
            f"{self.o.system.name}: no set of modes fits at t = {self.t:.9g} s after {most} "
            "attempts; changes follow each other without end. Last tried:\n  "
            + "\n  ".join((listed + texts)[:12])
            + "\nCheck conditions that switch each other, limits of reactions that depend on the "
            "reaction itself, and jumps that make their own condition true again."
        )

    def _relations(self, look: _Look, number: int) -> bool:
        modes = self.s.relation_modes
        if not len(modes):
            return False
        on = self.modes[modes] > 0.5
        g = look.greater - look.less
        slack = look.slack()
        wrong = np.where(on, g < -slack, g > slack)
        equal = (g == 0.0) & (on == self.s.strict)
        equal[list(self.exempt)] = False
        places = np.flatnonzero(wrong | equal)
        if number >= _TOGETHER:
            places = places[:1]
        self.modes[modes[places]] = 1.0 - self.modes[modes[places]]
        self.exempt.update(np.flatnonzero(equal).tolist())
        return bool(len(places))

    def _jumps(self, look: _Look) -> bool:
        if not self.s.jumps:
            return False
        now = self.modes[[j.mode for j in self.s.jumps]] > 0.5
        rising = now & ~self.edge
        self.edge = now
        for k in np.flatnonzero(rising):
            jump = self.s.jumps[k]
            self.jumped.append(jump.mode)
            for i, (node, sign) in enumerate(zip(jump.nodes, jump.signs, strict=True)):
                place = self.o._place[node]
                self.x[place] = sign * look.values[jump.first + i]
                self.moved = True
        return bool(rising.any())

    def _switch(self, look: _Look) -> bool:
        """Engage and release holds."""
        engaged = self.o._engaged(self.modes)
        stuck, forward, backward = self.o._get(self.modes)
        free = ~(stuck | forward | backward)
        released = np.flatnonzero(~engaged & ~free).tolist()
        for h in released:
            self.o._set(self.modes, h, None)
            self.halted.discard(h)
        closed = np.flatnonzero(engaged & free).tolist()
        for h in closed:
            self._slide(h, look)
        return bool(released or closed)

    def _slide(self, h: int, look: _Look) -> None:
        """The mode that follows from speed and gap alone."""
        s, least = self.s, self._standstills()[h]
        still = abs(look.v[h]) <= least
        if s.has_gap[h]:
            touching = look.gap[h] <= 1e-13 and look.v[h] <= least
            self.o._set(self.modes, h, 0 if touching and still else 1)
        elif still:
            self.o._set(self.modes, h, 0)
        else:
            part = 1 if look.v[h] > 0 else 2
            known = s.has_forward[h] if part == 1 else s.has_backward[h]
            self.o._set(self.modes, h, part if known else 0)

    def _standstills(self) -> np.ndarray:
        """Speeds that count as zero: where they are states, only zero does."""
        return np.where(self.o._still, 0.0, self.o.rounding(self.x))

    # -- collisions --------------------------------------------------------------------------

    def _collide(self, look: _Look) -> bool:
        """Jumps of speeds where constraints without limit close."""
        s = self.s
        if not self.o.impulsive.any():
            return False
        stuck, forward, backward = self.o._get(self.modes)
        acting = stuck | forward | backward
        at = np.where(s.has_gap, look.gap <= 1e-13, True)
        at[[h for h in self.halted if s.has_gap[h]]] = True
        still = self._standstills()
        approaching = (look.v < -still) & ~s.has_backward & at
        approaching |= (look.v > still) & ~s.has_forward
        approaching[[h for h in self.halted if not s.has_gap[h]]] = False
        if not self.moved:
            approaching &= ~stuck | ~self._was_stuck
        closing = np.flatnonzero(acting & self.o.impulsive & approaching)
        if not len(closing):
            return False
        bouncing = {h: float(look.restitution[h]) for h in closing.tolist()}
        taken = self._impact(look, bouncing)
        after = self.o.look(self.t, self.x, self.modes, self.guess)
        for h in closing.tolist():
            if h not in taken or bouncing[h] == 0 or not self._rests(h, after):
                continue
            self._impact(after, {h: 0.0}, pull=True)
            bouncing[h] = 0.0
        for h in closing.tolist():
            self.halted.discard(h)
            if h in taken:
                self.o._set(self.modes, h, 1 if bouncing[h] else 0)
                self._stop(h, bouncing[h] == 0)
            else:  # others pull it away
                self.o._set(self.modes, h, 1 if s.has_upper[h] else 2)
        return True

    def _rests(self, h: int, look: _Look) -> bool:
        """Whether a bounce would be over at once."""
        trial = self.modes.copy()
        self.o._set(trial, h, 1)
        a = self.o.look(self.t, self.x, trial, self.guess).a[h]
        return bool(a < 0 and 2 * look.v[h] <= -a * 1e-10 * self.o.span)

    def _stop(self, h: int, really: bool) -> None:
        place = self.o._place.get(self.s.speeds[h])
        if really and place is not None:
            self.x[place] = 0.0

    def _impact(
        self, look: _Look, closing: dict[int, float], pull: bool = False
    ) -> dict[int, float]:
        """Impulses of what closes and of all constraints without limit that hold.

        Gives back those that take part, with the changes of their speeds.

        The jump of all speeds is what the accelerations would be if the closing constraints
        demanded the change of their speed in unit time, without any other force: the impulsive
        form of the same equations (Routh, Dynamics of a System of Rigid Bodies, ch. VIII).
        """
        s = self.s
        stuck = self.o._get(self.modes)[0]
        members = {int(h): 0.0 for h in np.flatnonzero(stuck & self.o.impulsive)}
        members.update({h: -(1.0 + e) * look.v[h] for h, e in closing.items()})
        for _ in range(2 * len(s.names) + 2):
            trial = self.modes.copy()
            for h in range(len(s.names)):
                self.o._set(trial, h, 0 if h in members else None)
            self.o.share(self.t, self.x, trial, self.guess)
            rest = self.o.look(self.t, self.x, trial, self.guess)
            for h, change in members.items():
                trial[s.first_modes[h] + 4] = change
            push = self.o.look(self.t, self.x, trial, self.guess)
            impulse = push.reaction - rest.reaction
            speed = look.v + push.a - rest.a
            wrong = [
                h
                for h in members
                if not pull
                and (
                    (s.has_upper[h] and not s.has_lower[h] and impulse[h] > 0)
                    or (s.has_lower[h] and not s.has_upper[h] and impulse[h] < 0)
                )
                and abs(impulse[h]) > 1e-12 * np.abs(impulse).max()
            ]
            touching = [
                h
                for h in range(len(s.names))
                if h not in members
                and s.has_gap[h]
                and self.modes[s.first_modes[h] + 1] > 0.5
                and look.gap[h] <= 1e-13
                and speed[h] < -1e-12
            ]
            if wrong:
                del members[max(wrong, key=lambda h: abs(impulse[h]))]
            elif touching:
                # it did not approach, so there is nothing that would bounce
                members[touching[0]] = -look.v[touching[0]]
            else:
                break
        self.x = self.x + push.rates - rest.rates
        self.moved = True
        for h in members:
            lost = 0.5 * impulse[h] * (look.v[h] + speed[h])
            self.impacts[h] = self.impacts.get(h, 0.0) + float(lost)
        return members

    # -- forces ------------------------------------------------------------------------------

    def _rebalance(self, look: _Look, number: int) -> bool:
        """Let go what is overloaded, hold what would turn back."""
        s = self.s
        if not len(s.names):
            return False
        stuck, forward, backward = self.o._get(self.modes)
        slack = _SLACK * np.abs(look.reaction) + 1e-13
        if self.modes[s.first_modes + 3].any():
            slack = slack * 1e4
        calm = 1e-9 * (1.0 + np.abs(look.rates).max(initial=0.0))
        still = self._standstills()
        at_rest = np.abs(look.v) <= still
        at_rest[list(self.halted)] = True
        if not self.moved:
            at_rest |= stuck
        soon = 1e-12 * self.o.span
        ending = np.where(forward, look.v > 0, look.v < 0) & (forward | backward) & ~s.has_gap
        ending &= np.where(forward, look.a < 0, look.a > 0) & (
            np.abs(look.v) <= np.abs(look.a) * soon
        )
        over = stuck & (look.reaction > look.upper + slack + _SLACK * np.abs(look.upper))
        under = stuck & (look.reaction < look.lower - slack - _SLACK * np.abs(look.lower))
        known = np.where(look.v > 0, s.has_forward, s.has_backward)
        moving = stuck & ~at_rest & known
        contact = ~s.has_gap | (look.gap <= 1e-13)
        back = forward & contact & (at_rest & (look.a < -calm) | ending)
        back |= backward & (at_rest & (look.a > calm) | ending)
        wrong_way = ~s.has_gap & (
            forward & ~at_rest & (look.v < 0) | backward & ~at_rest & (look.v > 0)
        )
        actions: list[tuple[int, int]] = []
        for h in np.flatnonzero(over | under | moving | back | wrong_way).tolist():
            if back[h]:
                actions.append((h, 0))
            elif over[h] or under[h]:
                actions.append((h, 1 if over[h] else 2))
            else:
                actions.append((h, 1 if look.v[h] > 0 else 2))
        if number >= _TOGETHER:
            actions = actions[:1]
        for h, part in actions:
            self.o._set(self.modes, h, part)
            if part == 0:
                self.halted.add(h)
        return bool(actions)

    def _halt(self, look: _Look) -> None:
        """Bring the speed of what sticks to exactly zero."""
        stuck = self.o._get(self.modes)[0]
        late = {int(h): 0.0 for h in np.flatnonzero(stuck & (look.v != 0.0))}
        if late:
            lost = dict(self.impacts)
            for held in np.flatnonzero(stuck).tolist():
                late.setdefault(held, 0.0)
            self._impact(look, late, pull=True)
            self.impacts = lost
        for h in np.flatnonzero(stuck).tolist():
            self._stop(h, True)
        for h in self.halted:
            self._stop(h, not self.s.has_gap[h])

    def changes(self, before: np.ndarray) -> list[Change]:
        """What is different from before."""
        found = []
        for k, mode in enumerate(self.s.relation_modes):
            was, now = bool(before[mode] > 0.5), bool(self.modes[mode] > 0.5)
            if mode in self.jumped:
                was, now = False, True
            if was != now:
                name, old = self.s.relation_text(k, was)
                found.append(Change(name, old, self.s.relation_text(k, now)[1]))
        old_words, new_words = self.o.words(before), self.o.words(self.modes)
        for h, (old, new) in enumerate(zip(old_words, new_words, strict=True)):
            if old != new or h in self.impacts:
                loss = self.impacts.get(h, 0.0)
                found.append(Change(self.s.names[h], old, new, loss))
        return found
