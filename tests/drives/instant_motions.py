"""Checks a run of a drive against the laws of its instants and motions; knows no `lumped`.

A run is given by its states on both sides of each event, and at some times between. It is not
simulated a second time, but each part of it is checked from its own states, so that chaos does not
matter. It begins by the laws of an instant (`instant_laws`). The modes of a part are seen from
speeds and gaps in it; its states are those of a matrix exponential in these modes, and no margin of
the modes (`hybrid_reference.Motion.rows`: gaps, sliding speeds, all facets of what is at rest can
bear) falls below zero in between.
"""

from itertools import product

import numpy as np
from hybrid_reference import BACKWARD, FORWARD, OFF, STICK
from instant_laws import CREEP, KNIFE, MARGINS, REST, ROUNDING, Finding, Law
from scipy.linalg import expm

YIELDING, TOUCHES, CLOSED = 2e-6, 1e-13, 1e-10
"""Acceleration, relative to the greatest, of what rests but yields a little; gap that surely is
none, and that may be none, as what touched may have yielded."""
STATES, SHARED = 1e-6, 1e-7
"""Difference allowed in states after a motion, and, of the largest load or range of limits, in
shares of redundant contacts, which are solved for together."""
MOMENT = 1e-8
"""Length of a part of a run that is too short to see its modes, s."""
_FREE = {"gap": OFF, "freewheel": FORWARD}
"""Mode in which a contact bears nothing."""


class Motions:
    """The motions that a drive may make between its instants."""

    def __init__(self, law: Law):
        self.law, self.drive, self.n, self.rows = law, law.drive, law.n, law.rows
        self.contacts, self.J, self.kinds = law.contacts, law.J, law.kinds
        self.gaps, self.pressed = law.gaps, law.pressed
        self.doubtful: set[str] = set()

    def changed(self, before, after):
        """Names of contacts whose modes differ; dogs are told from outside."""
        pairs = zip(self.contacts, before, after, strict=True)
        return {c.name for c, a, b in pairs if a != b and c.kind != "dog"}

    def was_idle(self, name, past):
        """Whether a contact rests but bears nothing since a change that was told, or the begin.

        Where others keep it at rest, a contact without load may as well be open.
        """
        own = [k for k, c in enumerate(self.contacts) if c.name == name and c.kind in _FREE]
        piece, is_told = self.drive.piece, False
        for part, modes, its_piece, named in reversed(past):
            k = next((k for k in own if modes[k] == STICK), None)
            if k is None:
                break
            self.drive.piece = its_piece
            idle = (*modes[:k], _FREE[self.kinds[k]], *modes[k + 1 :])
            is_fit = not self.fault(part, idle)
            is_told = is_fit and (name in named or part is past[0][0])
            if is_told or not is_fit:
                break
        self.drive.piece = piece
        return is_told

    def as_before_if_idle(self, part, modes, before, changed):
        """Modes of a part in which what came to rest stays free as before, if it bears nothing."""
        for k, c in enumerate(self.contacts):
            if c.name in changed and c.kind in _FREE and before[k] == _FREE[c.kind]:
                idle = (*modes[:k], before[k], *modes[k + 1 :])
                modes = modes if self.fault(part, idle) else idle
        return modes

    def modes(self, part):
        """Modes that a part may have, from its speeds, gaps and accelerations."""
        size = 1.0 + np.abs(part.v).max()
        gap, speed = self.gaps + part.q @ self.rows.T, part.v @ self.rows.T
        rate = part.a[[0, -1]] @ self.rows.T
        still = YIELDING * (1.0 + np.abs(part.a).max())
        found = []
        for k, kind in enumerate(self.kinds):
            fast = speed[np.abs(speed[:, k]).argmax(), k]
            if abs(fast) <= CREEP * size:
                moved = gap[-1, k] - gap[0, k]
                length = part.t[-1] - part.t[0]
                fast = sense(moved, length, speed[[0, -1], k], rate[:, k], still, REST * size)
            if not self.law.engaged(k, part.t[0]):
                found.append([OFF])
            elif kind == "dog":
                found.append([STICK])
            elif kind == "gap":
                apart = np.inf if fast != 0.0 else gap[:, k].max()
                opens = rate[1, k] > REST  # it may have opened just now
                fits = (STICK, apart < CLOSED), (OFF, apart > TOUCHES or opens)
                ways = [m for m, fit in fits if fit]
                found.append(ways)
            else:
                backward = FORWARD if kind == "freewheel" else BACKWARD
                sign = {0.0: STICK, 1.0: FORWARD, -1.0: backward}
                ways = [sign[np.sign(fast)]]
                if fast == 0.0 and abs(rate[1, k]) > REST:  # it may have let go just now
                    ways.append(sign[np.sign(rate[1, k])])
                found.append(ways)
        for modes in map(list, product(*found)):
            for k in self.pressed:
                modes[k] = OFF if modes[self.contacts[k].level.by] == OFF else modes[k]
            yield tuple(modes)

    def check(self, part, before, finding):
        """Check a part in modes that it may have; gives those that fit, as before if possible."""
        ways = list(self.modes(part))
        self.doubtful = set().union(*(self.changed(ways[0], modes) for modes in ways))
        ways.sort(key=lambda modes: len(self.changed(before or modes, modes)))
        found = []
        for modes in ways:
            if not (text := self.fault(part, modes)):
                return modes
            found.append(text)
        finding.wrong.append(found[0])
        return ways[0]

    def fault(self, part, modes):
        """Compare a part with a matrix exponential, and see that nothing is overlooked in it."""
        motion = self.drive.motion(modes)
        length = part.t[-1] - part.t[0]
        z = self.law.state(part.t[0], part.q[0], part.v[0])
        after = np.array([expm(motion.A * (t - part.t[0])) @ z for t in part.t[1:]])
        n = self.n
        scale = np.repeat([0.3 + np.abs(part.q).max(), 1.0 + np.abs(part.v).max()], n)
        received = np.concatenate([part.q, part.v], axis=1)[1:]
        error = (np.abs(after[:, : 2 * n] - received) / scale).max(axis=1)
        named = dict(zip([c.name for c in self.contacts], modes, strict=True))
        if error.max() > STATES:
            at = part.t[1:][error.argmax()]
            return (
                f"{part.t[0]:.7f}: motion deviates by {error.max():.1e} at {at:.7f}, modes {named}"
            )
        steps = max(int(np.ceil(length / 2e-3)), 4)
        lowest = lows(motion, z, length / steps, steps)
        allowed = MARGINS * (1.0 + motion.sizes[0] @ np.maximum(np.abs(z), np.abs(after[-1])))
        # limits and loads cancel in a row; what yields is accelerated by what shares lack
        limits = [c.peak * self.law.level(k, part.t[0]) for k, c in enumerate(self.contacts)]
        free = self.law.smooth([OFF] * len(modes), part.t[-1], part.q[-1], part.v[-1])
        missing = self.J @ np.abs(part.a[-1] - (motion.A @ after[-1])[n : 2 * n])
        missing += SHARED * max(np.abs(self.J * free).max(), 2 * max(limits))
        allowed += motion.blamed @ (KNIFE * np.array(limits)) + missing
        bad = lowest < -allowed
        if bad.any():
            k = int((lowest / allowed).argmin())
            blamed = [c.name for c, b in zip(self.contacts, motion.blamed[k], strict=True) if b]
            return (
                f"{part.t[0]:.7f}: margin of {blamed} falls to {lowest[k]:.1e} before "
                f"{part.t[-1]:.7f}, modes {named}"
            )
        return ""


def sense(moved, length, speed, rate, still, rest):
    """Sense of a motion that is hardly seen, by speeds and accelerations at both ends.

    What yields shows accelerations, but hardly moves as they would let it.
    """
    follows = abs(moved) + abs(speed[1]) * length
    if abs(rate[0]) < still and follows < 1e-3 * abs(rate[1]) * length**2:
        return 0.0
    if max(abs(rate)) > still and abs(moved) > 1e-10:
        return moved
    if abs(rate[0]) > still:
        slows = speed[0] * rate[0] < 0 and abs(speed[0]) > rest
        return speed[0] if slows else rate[0]
    if abs(rate[1]) > still:
        least = min(ROUNDING, 0.1 * abs(rate[1]) * length)
        grows = speed[1] * rate[1] > 0 and abs(speed[1]) > least
        return speed[1] if grows else -rate[1]
    return 0.0


def lows(motion, z, h, steps):
    """Lowest values of all rows of a motion in so many steps, to about 1e-9 of their size."""
    powers = [np.eye(len(z)), expm(motion.A * h)]
    states = [z]
    for _ in range(steps):
        states.append(powers[1] @ states[-1])
    states = np.array(states)
    terms = motion.terms[:12]
    at = np.linspace(0.0, h, 9)
    powers = at ** np.arange(12)[:, None] / np.cumprod([1.0, *range(1, 12)])[:, None]
    found = np.full(len(motion.rows), np.inf)
    for part in np.array_split(states[:-1], max(len(states) // 64, 1)):
        values = np.tensordot(terms, part.T, axes=1)  # derivative, row, step
        found = np.minimum(found, np.einsum("drs,dk->rsk", values, powers).min(axis=(1, 2)))
    return found


def check(drive, parts, happened):
    """What is wrong with a run.

    Parameters
    ----------
    drive : Drive
        Its reference, with positions and speeds before the run begins.
    parts : list of Part
        Between its events.
    happened : list of tuple
        Times of events, names of contacts that change or collide, and energies lost.
    """
    found, law, past = Finding(), Law(drive), []
    motions = Motions(law)
    q, v, a, modes, named = drive.q, drive.v, 0.0 * drive.v, None, set()
    for part in parts:
        t, size = part.t[0], 1.0 + np.abs(part.q[0]).max()
        law.enter(t)
        if np.abs(part.q[0] - q).max() > 1e-9 * size:
            found.wrong.append(f"{t:.7f}: positions jump")
        law.check_impact(t, part.q[0], v, part.v[0], found)
        told = sum(loss for s, _, loss in happened if s == t)
        lost = float(law.J @ (v**2 - part.v[0] ** 2)) / 2
        if abs(lost - told) > MARGINS * (1 + float(law.J @ v**2)):
            found.wrong.append(f"{t:.7f}: events say {told:.4g} J of {lost:.4g} J lost")
        law.stuck = {k for k, mode in enumerate(modes or ()) if mode == STICK}
        law.check_rates(part, found)
        named |= {
            name
            for s, name, _ in happened
            if abs(s - t) < 1e-12 or law.ends_series(name, t, a, s, happened)
        }
        if part.t[-1] - t > MOMENT:
            before, doubtful = modes, motions.doubtful
            modes = motions.check(part, modes, found)
            changed = motions.changed(before or modes, modes) - named - doubtful
            changed = {name for name in changed if not motions.was_idle(name, past)}
            modes = motions.as_before_if_idle(part, modes, before, changed)
            changed &= motions.changed(before or modes, modes)
            past.append((part, modes, drive.piece, named))
            if changed:
                found.wrong.append(f"{t:.7f}: {sorted(changed)} change without event")
            named = set()
        q, v, a = part.q[-1], part.v[-1], part.a[-1]
        if len(found.wrong) > 3:
            break
    return found
