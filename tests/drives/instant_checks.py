"""Checks a run of a drive against the laws of its instants and motions; knows no `lumped`.

A run is given by its states on both sides of each event, and at some times between. It is not
simulated a second time, but each part of it is checked from its own states, so that chaos does not
matter:

* an impact is Newton's law, the nearest speeds in the kinetic metric that no contact forbids
  (least distance programming by non-negative least squares: Lawson and Hanson, Solving Least
  Squares Problems, ch. 23); where the law has no answer or adds energy, nothing approaches, no
  energy is gained and contacts push;
* accelerations just after an instant are those of Gauss's principle: of all reactions within their
  limits those with the least accelerations in the kinetic metric. The limits are static for what is
  at rest, and kinetic for what the problem sets in motion, until nothing else moves; where fewer
  could move as well, the law is open;
* the modes of a part are seen from speeds and gaps in it. Its states are those of a matrix
  exponential in these modes, and no margin of the modes (`hybrid_reference.Motion.rows`: gaps,
  sliding speeds, all facets of what is at rest can bear) falls below zero in between.
"""

from dataclasses import dataclass, field
from itertools import product

import numpy as np
from hybrid_reference import BACKWARD, FORWARD, OFF, STICK, Drive
from instant_problems import NoAnswerError, least_accelerations, nearest
from pressed_reference import Pressed
from scipy.linalg import expm
from scipy.optimize import nnls

REST = 1e-9
"""Speed that is none, relative to the greatest speed (plus 1)."""
NEAR, LEAST, MOST = 1e-12, 1e-14, 1e-10
"""Gap that is none, rad or m; between the others each gap may be the last that is none, as what has
yielded overlaps."""
BRIEF = 1e-4
"""Speed, relative to the greatest, that a bounce or friction may end as it is over at once."""
SPEEDS, RATES, STATES, MARGINS = 1e-7, 1e-6, 1e-6, 1e-6
"""Differences allowed in speeds after impacts, accelerations, states after a motion, margins."""
CREEP, YIELDING, TOUCHES, CLOSED = 1e-8, 2e-6, 1e-13, 1e-10
"""Speed and acceleration, relative to the greatest, of what rests but yields a little; gap that
surely is none, and that may be none, as what touched may have yielded."""
ROUNDING = 1e-13
"""Speed that is rounding."""
_FREE = {"gap": OFF, "freewheel": FORWARD}
"""Mode in which a contact bears nothing."""
MOMENT = 1e-8
"""Length of a part of a run that is too short to see its modes, s."""
KNIFE, SHARED = 1e-6, 1e-7
"""Share of a limit by which it may be missed, as events are met to rounding; and of the largest
load, as shares of redundant contacts are solved for together."""


@dataclass
class Part:
    """Rows of a run between two events: times, positions, speeds and accelerations."""

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray


@dataclass
class Finding:
    """What is wrong with a run, and where the law leaves it open."""

    wrong: list[str] = field(default_factory=list)
    open: list[str] = field(default_factory=list)
    impacts: int = 0
    instants: int = 0
    brief: int = 0

    def add(self, other):
        """Take over what another has found."""
        self.wrong += other.wrong
        self.open += other.open
        self.impacts += int(other.impacts)
        self.instants += other.instants
        self.brief += other.brief


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
    q, v, modes, named = drive.q, drive.v, None, set()
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
        law.check_rates(part, found)
        named |= {
            name
            for s, name, _ in happened
            if abs(s - t) < 1e-12 or law.ends_series(name, t, s, happened)
        }
        if part.t[-1] - t > MOMENT:
            before, doubtful = modes, law.doubtful
            modes = law.check_motion(part, modes, found)
            changed = law.changed(before or modes, modes) - named - doubtful
            changed = {name for name in changed if not law.was_idle(name, past)}
            modes = law.as_before_if_idle(part, modes, before, changed)
            changed &= law.changed(before or modes, modes)
            past.append((part, modes, drive.piece, named))
            if changed:
                found.wrong.append(f"{t:.7f}: {sorted(changed)} change without event")
            named = set()
        q, v = part.q[-1], part.v[-1]
        if len(found.wrong) > 3:
            break
    return found


class Law:
    """The laws of one drive."""

    def __init__(self, drive: Drive):
        self.drive, self.n, self.rows = drive, drive.n, drive.rows
        self.contacts, self.J = drive.contacts, drive.J
        self.bouncing = {c.name for c in drive.contacts if c.e > 0}
        self.kinds = np.array([c.kind for c in drive.contacts])
        self.gaps = np.array([c.gap for c in drive.contacts])
        self.pressed = [k for k, c in enumerate(drive.contacts) if isinstance(c.level, Pressed)]
        self.pressing: dict[int, float] = {}
        self.kinetic: set[int] = set()
        self.doubtful: set[str] = set()
        drive.made = {}

    def state(self, t, q, v):
        """The whole state, for times in the present piece."""
        d = self.drive
        waves = [f(p.rate * t + p.phase) for p in d.waves for f in (np.sin, np.cos)]
        return np.array([*q, *v, 1.0, t - d.piece[0], *waves])

    def enter(self, t):
        """Take the piece of the lines that begins at or before a time."""
        pieces = self.drive.pieces
        self.drive.piece = next((p for p in pieces if t < p[1] - 1e-12), pieces[-1])

    def changed(self, before, after):
        """Names of contacts whose modes differ; dogs are told from outside."""
        pairs = zip(self.contacts, before, after, strict=True)
        return {c.name for c, a, b in pairs if a != b and c.kind != "dog"}

    def ends_series(self, name, t, end, happened):
        """Whether bounces that a run leaves out from a time on end at another.

        Each flight lasts as long as the one before it times the restitution.
        """
        if name not in self.bouncing or end <= t:
            return False
        e = max(c.e for c in self.contacts if c.name == name)
        last = max((s for s, other, _ in happened if other == name and s < t), default=t)
        rest = (t - last) * e / (1.0 - e)
        return end < t + BRIEF or abs(end - t - rest) < 0.1 * rest

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
            is_fit = not self.fault_of_motion(part, idle)
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
                modes = modes if self.fault_of_motion(part, idle) else idle
        return modes

    def nears(self, gap):
        """Gaps below which all are none: the usual one, and others that may be meant."""
        doubtful = gap[(self.kinds == "gap") & (gap > LEAST) & (gap < MOST)]
        return [NEAR, LEAST, *np.nextafter(doubtful, 1.0)]

    def level(self, k, t):
        if k in self.pressing:
            return self.pressing[k]
        value, slope = self.contacts[k].level.on(*self.drive.piece)
        return value + slope * (t - self.drive.piece[0])

    def engaged(self, k, t):
        """Whether a dog is closed, or friction faces are pressed."""
        if self.kinds[k] == "dog":
            return self.level(k, t) > 0.5
        return self.kinds[k] != "friction" or any(self.contacts[k].level.on(*self.drive.piece))

    # -- impacts ---------------------------------------------------------------------------------

    def check_impact(self, t, q, before, after, finding):
        """Compare speeds after an instant with those before it."""
        gap = self.gaps + self.rows @ q
        ways = []
        for near in self.nears(gap):
            ways.append(self.judged(t, gap < near, before, after))
            if not ways[-1][0]:
                break
        wrong, open_, is_impact = min(ways, key=lambda way: len(way[0]))
        finding.impacts += is_impact
        finding.wrong += [f"{t:.7f}: {text}" for text in wrong]
        finding.open += [f"{t:.7f}: Newton's law"] * int(open_)

    def judged(self, t, closed, before, after):
        """What is wrong with an instant; whether the law is open; whether it is an impact."""
        size = 1.0 + np.abs(before).max()
        one = (self.kinds == "freewheel") | ((self.kinds == "gap") & closed)
        dogs = np.array([k == "dog" and self.engaged(i, t) for i, k in enumerate(self.kinds)], bool)
        W, D = self.rows[one], self.rows[dogs]
        u, left = W @ before, W @ after
        e = np.array([c.e for c in self.contacts])[one]
        allowed, wrong = SPEEDS * size, []
        if left.min(initial=0.0) < -allowed:
            names = [c.name for c, o in zip(self.contacts, one, strict=True) if o]
            wrong.append(f"{names[left.argmin()]} approaches at {left.min():.1e}")
        if np.abs(D @ after).max(initial=0.0) > allowed:
            wrong.append("a dog slips")
        is_impact = (u < -REST * size).any() or (np.abs(D @ before) > REST * size).any()
        bounce = np.where(u < -REST * size, -e * u, 0.0)
        try:
            expected = nearest(self.J, before, W, bounce, D)
            if np.abs(after - expected).max() > allowed:
                brief, bounces = (np.abs(left) < allowed), bounce > 0
                brief &= W @ expected < BRIEF * size
                bounce[brief] = 0.0
                own = np.concatenate([D, W[brief & bounces]])
                expected = nearest(self.J, before, W, bounce, own)
                # what others have thrown comes back
                D = np.concatenate([D, W[brief], self.slow(t, expected, after, size)])
                expected = nearest(self.J, expected, W, 0 * bounce, D)
            expected = self.rubbed(before, expected, W, D)
            work = self.J * (expected - before) * (expected + before)
            open_ = work.sum() > 1e-9 * np.abs(work).sum()
        except NoAnswerError:
            expected, open_ = before, True
        if open_:
            pushes = np.concatenate([W, D, -D]).T
            if nnls(pushes, self.J * (after - before))[1] > 10 * allowed:
                wrong.append("impulses pull, or momentum is lost")
            gain = float(self.J @ (after**2 - before**2)) / 2
            if gain > allowed * size:
                wrong.append(f"an impact adds {gain:.2g} J")
        elif np.abs(after - expected).max() > allowed:
            wrong.append(f"speeds {after} follow on {before}, expected {expected}")
        return wrong, open_, is_impact

    def slow(self, t, expected, after, size):
        """Rows of friction that may come to rest at once, and does."""
        rub = np.array([k == "friction" and self.engaged(i, t) for i, k in enumerate(self.kinds)])
        slow = np.abs(self.rows @ expected) < BRIEF * size
        return self.rows[rub & slow & (np.abs(self.rows @ after) < SPEEDS * size)]

    def rubbed(self, before, after, W, D):
        """Speeds after an impact whose impulses press frictions; only what presses bounces."""
        levels = {k: self.contacts[k].level for k in self.pressed}
        bodies = {x.body for x in levels.values() if after[x.body] != before[x.body]}
        rubbing = [k for k, x in levels.items() if x.body in bodies]
        if not rubbing:
            return after
        start = before.copy()
        start[list(bodies)] = after[list(bodies)]
        most = [
            levels[k].mu * self.J[levels[k].body] * (after - before)[levels[k].body]
            for k in rubbing
        ]
        W = W[np.abs(W[:, list(bodies)]).max(axis=1, initial=0.0) == 0]
        low = np.concatenate([np.negative(most), np.zeros(len(W)), np.full(len(D), -np.inf)])
        high = np.concatenate([most, np.full(len(W) + len(D), np.inf)])
        rows = np.concatenate([self.rows[rubbing], W, D])
        return least_accelerations(self.J, start, rows, low, high)[0]

    # -- accelerations ---------------------------------------------------------------------------

    def box(self, k, t, kinetic, share, slack):
        """Least and greatest reaction of a contact at rest, towards positive speed."""
        c, level = self.contacts[k], self.level(k, t)
        share = 0.0 if kinetic else share
        level *= (1.0 if kinetic else c.peak) * (1 + share)
        pull = max(share, 0.0) * slack
        return {
            "gap": (-pull, np.inf),
            "dog": (-np.inf, np.inf),
            "freewheel": (-level - pull, np.inf),
            "friction": (-level - abs(share) * slack * 1e-6, level + abs(share) * slack * 1e-6),
        }[c.kind]

    def rates(self, t, q, v, share=0.0, near=NEAR, rest=REST, given=None):
        """Accelerations just after a time, with limits changed by a share of them.

        With given accelerations, limits are kinetic where these move, and static elsewhere.
        """
        size, gap, speed = 1.0 + np.abs(v).max(), self.gaps + self.rows @ q, self.rows @ v
        still = np.abs(speed) <= rest * size
        closed = (self.kinds != "gap") | (gap < near)
        engaged = np.array([self.engaged(k, t) for k in range(len(self.kinds))], bool)
        rest = np.flatnonzero(closed & engaged & (still | (self.kinds == "dog")))
        modes = np.full(len(self.kinds), OFF)
        sliding = ~still & engaged & ((self.kinds == "friction") | (self.kinds == "freewheel"))
        modes[sliding] = np.sign(speed[sliding])
        free = self.smooth(tuple(modes), t, q, v)
        for k in self.pressed:
            level = self.contacts[k].level
            force = max(float(self.drive.force(level.body) @ self.state(t, q, v)), 0.0)
            self.pressing[k] = level.mu * force * (level.by in rest)
            free = free - self.rows[k] / self.J * self.pressing[k] * sliding[k] * modes[k]
        load = np.abs(self.J * free).max(initial=0.0) + 1.0
        still_rate = 1e-9 * load / self.J.min()
        rubs = np.isin(self.kinds[rest], ("friction", "freewheel"))
        kinetic: set[int] = set()
        if given is not None:
            moves = rubs & (np.abs(self.rows[rest] @ given) > RATES * load / self.J.min())
            kinetic = set(rest[moves].tolist())
        while True:
            limits = [self.box(k, t, k in kinetic, share, load) for k in rest]
            low, high = np.array(limits).reshape(-1, 2).T
            bears = low < high
            found, r = least_accelerations(
                self.J, free, self.rows[rest][bears], low[bears], high[bears]
            )
            moves = np.abs(self.rows[rest] @ found) > still_rate
            if share < 0:  # a short lever moves slowly
                moves[bears] |= (r <= low[bears]) | (r >= high[bears])
            new = set(rest[moves & rubs].tolist()) - kinetic
            if not new or given is not None:
                self.kinetic = kinetic
                return found
            kinetic |= new

    def smooth(self, modes, t, q, v):
        """Accelerations by springs, loads and what slides; contacts at rest bear nothing."""
        A = self.drive.motion(tuple(int(m) for m in modes)).A
        return A[self.n : 2 * self.n] @ self.state(t, q, v)

    def check_rates(self, part, finding):
        """Compare accelerations at the begin of a part with Gauss's principle."""
        t, q, v, a = part.t[0], part.q[0], part.v[0], part.a[0]
        finding.instants += 1
        expected = self.rates(t, q, v)
        size = 1.0 + np.abs(expected).max() + np.abs(a).max()
        if np.abs(a - expected).max() <= RATES * size:
            return
        away, may_move = np.inf, set()
        nears = self.nears(self.gaps + self.rows @ q)
        for rest, near, share in product((ROUNDING, REST, CREEP), nears, (-KNIFE, 0.0, KNIFE)):
            away = min(away, np.abs(a - self.rates(t, q, v, share, near, rest)).max())
            may_move |= self.kinetic
        fewer = np.abs(a - self.rates(t, q, v, given=a)).max() <= 10 * RATES * size
        if away * (part.t[-1] - t) < CREEP * (1.0 + np.abs(v).max()):
            finding.brief += 1
        elif fewer and self.kinetic < may_move:
            finding.open.append(f"{t:.7f}: fewer let go")
        elif away > 10 * RATES * size:
            finding.wrong.append(f"{t:.7f}: accelerations {a}, expected {expected}")

    # -- motions ---------------------------------------------------------------------------------

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
            if not self.engaged(k, part.t[0]):
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

    def check_motion(self, part, before, finding):
        """Check a part in modes that it may have; gives those that fit, as before if possible."""
        ways = list(self.modes(part))
        self.doubtful = set().union(*(self.changed(ways[0], modes) for modes in ways))
        ways.sort(key=lambda modes: len(self.changed(before or modes, modes)))
        found = []
        for modes in ways:
            if not (text := self.fault_of_motion(part, modes)):
                return modes
            found.append(text)
        finding.wrong.append(found[0])
        return ways[0]

    def fault_of_motion(self, part, modes):
        """Compare a part with a matrix exponential, and see that nothing is overlooked in it."""
        motion = self.drive.motion(modes)
        length = part.t[-1] - part.t[0]
        z = self.state(part.t[0], part.q[0], part.v[0])
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
        limits = [c.peak * self.level(k, part.t[0]) for k, c in enumerate(self.contacts)]
        free = self.smooth([OFF] * len(modes), part.t[-1], part.q[-1], part.v[-1])
        missing = self.J @ np.abs(part.a[-1] - (motion.A @ after[-1])[n : 2 * n])
        missing += SHARED * np.abs(self.J * free).max()
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
        grows = speed[1] * rate[1] > 0 and abs(speed[1]) > ROUNDING
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
