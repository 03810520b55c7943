"""The laws of an instant of a drive; knows no `lumped`.

* An impact is Newton's law, the nearest speeds in the kinetic metric that no contact forbids
  (least distance programming by non-negative least squares: Lawson and Hanson, Solving Least
  Squares Problems, ch. 23); where the law has no answer or adds energy, nothing approaches, no
  energy is gained and contacts push.
* Accelerations just after an instant are those of Gauss's principle: of all reactions within their
  limits those with the least accelerations in the kinetic metric. The limits are static for what is
  at rest, and kinetic for what the problem sets in motion, until nothing else moves, first for what
  did not stick before the instant; where fewer could move as well, the law is open.
"""

from dataclasses import dataclass, field
from itertools import product

import numpy as np
from hybrid_reference import OFF, Drive
from pressed_reference import Pressed
from scipy.optimize import lsq_linear, nnls

REST = 1e-9
"""Speed that is none, relative to the greatest speed (plus 1)."""
CREEP = 1e-8
"""Speed, relative to the greatest, of what rests but yields a little."""
ROUNDING = 1e-13
"""Speed that is rounding."""
NEAR, LEAST, MOST = 1e-12, 1e-14, 1e-10
"""Gap that is none, rad or m; between the others each gap may be the last that is none, as what has
yielded overlaps."""
BRIEF = 1e-4
"""Speed, relative to the greatest, that a bounce or friction may end as it is over at once."""
RISE = 1e-11
"""Rise of a bounce, rad or m, that is left out."""
SPEEDS, RATES, MARGINS = 1e-7, 1e-6, 1e-6
"""Differences allowed in speeds after impacts, accelerations, margins."""
KNIFE = 1e-6
"""Share of a limit by which it may be missed, as events are met to rounding."""
_SOFT = 1e-6
_ROUNDING = 1e-13
"""Accelerations that are rounding, as bodies and loads are about 1."""


# -- the two problems of an instant, for impulses and for reactions, solved by SciPy ---------------


class NoAnswerError(Exception):
    """A problem of an instant has no answer."""


def nearest(J, v, W, least, D):
    """Speeds nearest to v in the kinetic metric with ``W v >= least`` and ``D v == 0``.

    Raises
    ------
    NoAnswerError
        If there are none.
    """
    root = np.sqrt(J)
    rows = np.concatenate([W, D, -D])
    if not len(rows):
        return v
    wanted = np.concatenate([least, np.zeros(2 * len(D))]) - rows @ v
    sizes = np.linalg.norm(rows / root, axis=1)
    size = np.abs(wanted).max(initial=0.0) + 1e-300
    E = np.vstack([(rows / root).T / sizes, wanted / sizes / size])
    for order in (np.arange(len(rows)), np.arange(len(rows))[::-1]):
        p, rest = nnls(E[:, order], np.append(np.zeros(len(J)), 1.0), maxiter=1000)
        if rest < 1e-7:
            raise NoAnswerError("Newton's law asks for speeds that others forbid")
        gone = E[:, order] @ p
        after = v - size * gone[:-1] / (gone[-1] - 1.0) / root
        room = (rows @ (after - v) - wanted)[order]
        if (room > -1e-8 * size).all() and (room[p > 1e-9 * p.max()] < 1e-8 * size).all():
            return after
    raise NoAnswerError("least squares ended beside the answer")


def least_accelerations(J, free, rows, low, high):
    """Accelerations and reactions by Gauss's principle: in a box, least in the kinetic metric.

    Redundant reactions are told apart by their squares, which count `_SOFT` squared of the rest.

    Raises
    ------
    NoAnswerError
        If what is found is not the least.
    """
    if not len(rows):
        return free, np.zeros(0)
    root = np.sqrt(J)
    G = (rows / root).T
    soft = np.eye(len(rows)) * _SOFT * np.linalg.norm(G)
    wanted = np.append(-root * free, np.zeros(len(rows)))
    box = {"bounds": (low, high), "method": "bvls", "tol": 1e-15, "max_iter": 500}
    r = lsq_linear(np.vstack([G, soft]), wanted, **box).x
    found = root * free + G @ r
    slopes, size = G.T @ found, 1e-9 * (np.abs(root * free).max() + np.abs(G * r).max()) + _ROUNDING
    room = 1e-9 * np.abs(r).max()
    if ((slopes > size) & (r > low + room)).any() or ((slopes < -size) & (r < high - room)).any():
        raise NoAnswerError("bounded least squares ended before the least")
    return found / root, r


# -- the laws --------------------------------------------------------------------------------------


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
        self.stuck: set[int] = set()
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

    def ends_series(self, name, t, a, end, happened):
        """Whether bounces that a run leaves out from a time on end at another.

        Each flight lasts as long as the one before it times the restitution; the first rises by
        `RISE` at most, at the accelerations just before.
        """
        if name not in self.bouncing or end <= t:
            return False
        e = max(c.e for c in self.contacts if c.name == name)
        last = max((s for s, other, _ in happened if other == name and s < t), default=t)
        rest = (t - last) * e / (1.0 - e)
        back = max(abs(c.row @ a) for c in self.contacts if c.name == name)
        brief = max(BRIEF, np.sqrt(8 * RISE / max(back, ROUNDING)) / (1.0 - e))
        return end < t + brief or abs(end - t - rest) < 0.1 * rest

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
            new = new - self.stuck or new
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
