"""Drives with dry friction, freewheels, dogs, plays and stops in closed form; knows no `lumped`.

``python tests/drives/hybrid_reference.py 1000`` compares random drives (`hybrid_drives`), with
`impacts` or `units` before the number impacts, or every twentieth drive as a unit; `storms`
rattling plays.

Bodies with constant inertias, linear springs, torques and friction limits that are straight lines
of time (torques may have a sine besides) move linearly as long as no contact changes its mode: the
state ``z = [q, v, 1, time since the last kink, sines]`` obeys ``z' == A z``, and all that ends a
mode is a row ``c z`` that falls through zero. So a motion is a sequence of matrix exponentials; a
step of the watch on the rows only decides what could be overlooked between two steps.

The law, with its sources:

* Sliding friction is its limit against the motion; at rest it bears up to `peak` times that. What
  is at rest stays so as long as *any* distribution of reactions within the static limits carries
  the load (static theorem of limit analysis; Gauss's principle where `peak` is 1): for brakes on
  one shaft the sum of their limits. The loads that can be borne are a zonotope (a cone where
  contacts push): each of its facets is a row, and names the contacts that let go.
* What let go slides, what did not stays if it can; of several ways the one that lets least go
  (two such ways leave the law open, `OpenLawError`).
* An impact is Newton's law for all contacts of the instant (`contact_reference`): gaps that are
  closed, all freewheels and dogs. Friction gives no impulse. Where the law has no answer, or adds
  energy, a user expects that nothing approaches afterwards and no negative loss, not one motion.
"""

import itertools
import sys
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from contact_reference import OpenLawError, facets, impact, lost
from hybrid_parts import Contact, Line, Load, LostError
from numpy.polynomial.polynomial import polyval
from scipy.linalg import expm
from scipy.optimize import brentq

STICK, FORWARD, BACKWARD, OFF = 0, 1, -1, 2
STILL, CLOSED, LEAST = 1e-9, 1e-9, 1e-8
"""Speed taken for standstill, gap taken for none, speed below which a contact does not bounce."""
ORDER, TERMS, BLOCK = 6, 15, 32
"""Derivatives that decide a sign; of a Taylor series in a step; steps at a time."""


@dataclass
class Motion:
    """A linear motion and the rows that end it.

    `blamed` are the contacts that each row lets go, `slides` tells which rows are sliding speeds.
    """

    A: np.ndarray
    rows: np.ndarray
    blamed: np.ndarray
    slides: np.ndarray
    steps: dict[float, list[np.ndarray]] = field(default_factory=dict)

    @cached_property
    def terms(self) -> np.ndarray:
        """Rows of all derivatives."""
        found = [self.rows]
        for _ in range(TERMS):
            found.append(found[-1] @ self.A)
        return np.array(found)

    @cached_property
    def sizes(self) -> np.ndarray:
        return np.abs(self.terms[:ORDER])

    def signs(self, z: np.ndarray) -> np.ndarray:
        """Signs of the rows just after an instant, from their derivatives."""
        found = np.zeros(len(self.rows))
        floors = 1e-11 * (self.sizes @ np.abs(z)) + 1e-12
        for value, floor in zip(self.terms[:ORDER] @ z, floors, strict=True):
            clear = (found == 0) & (np.abs(value) > floor)
            found[clear] = np.sign(value[clear])
        return found

    def block(self, z: np.ndarray, h: float) -> np.ndarray:
        """States after 0 to BLOCK - 1 steps; the matrices of 1, 2, 4, ... of them are kept."""
        if h not in self.steps:
            self.steps[h] = [expm(self.A * h)]
            while 2 ** len(self.steps[h]) < BLOCK:
                self.steps[h].append(self.steps[h][-1] @ self.steps[h][-1])
        found = z[None]
        for step in self.steps[h]:
            found = np.concatenate([found, found @ step.T])
        return found

    def first_fall(self, z: np.ndarray, length: float, begins: bool) -> float | None:
        """Time until a row falls through zero within a short time; at its begin some are zero."""
        values = self.terms @ z
        zero = 1e-11 * (self.sizes @ np.abs(z)) + 1e-12
        faculty = np.cumprod([1.0, *range(1, TERMS + 1)])
        at = np.linspace(0.0, length, 33)[1:]
        first = None
        for j in range(len(self.rows)):
            c, floor = values[:, j] / faculty, 1e-12 * (1 + self.sizes[0, j] @ np.abs(z))
            if (polyval(at, c) >= -floor).all():
                continue
            if not begins and c[0] <= 0:
                return 0.0
            gone = 0
            while begins and gone < ORDER and abs(values[gone, j]) <= zero[gone, j]:
                gone += 1  # it leaves zero: look for the next zero
            c = c[gone:]
            height = polyval(at, c)
            below = np.flatnonzero(height < 0)
            if not len(below):
                continue
            low = at[below[0] - 1] if below[0] else 0.0
            if polyval(low, c) <= 0:
                return float(low)
            root = brentq(polyval, low, at[below[0]], (c,), xtol=1e-17, rtol=1e-15)
            first = root if first is None else min(first, root)
        return first


@dataclass
class Drive:
    """Bodies of inertia J, springs (row, c, d), loads and contacts, from q and v to the end."""

    J: np.ndarray
    q: np.ndarray
    v: np.ndarray
    springs: list[tuple[np.ndarray, float, float]]
    loads: list[Load]
    contacts: list[Contact]
    end: float

    def __post_init__(self) -> None:
        self.n, self.one = len(self.J), 2 * len(self.J)
        self.waves = [p for p in self.loads if p.size]
        self.dim = self.one + 2 + 2 * len(self.waves)
        lines = [p.line for p in self.loads] + [c.level for c in self.contacts]
        kinks = {t for line in lines for t in line.ts if 0 < t < self.end}
        self.pieces = list(itertools.pairwise([0.0, *sorted(kinks), self.end]))
        self.rows = np.array([c.row for c in self.contacts]).reshape(-1, self.n)

    # -- a motion in given modes -----------------------------------------------------------------

    def line(self, line: Line, factor: float = 1.0) -> np.ndarray:
        """A line of the present piece as a row."""
        row = np.zeros(self.dim)
        row[self.one : self.one + 2] = np.multiply(line.on(*self.piece), factor)
        return row

    def on(self, row: np.ndarray, order: int) -> np.ndarray:
        """``row @ q`` or ``row @ v`` as a row of the whole state."""
        found = np.zeros(self.dim)
        found[order * self.n : (order + 1) * self.n] = row
        return found

    @cached_property
    def smooth(self) -> np.ndarray:
        """Torques of springs as rows."""
        load = np.zeros((self.n, self.dim))
        for row, c, d in self.springs:
            load -= np.outer(row, c * self.on(row, 0) + d * self.on(row, 1))
        return load

    def motion(self, modes: tuple[int, ...]) -> Motion:
        """The motion in modes, made once for each piece."""
        key = (self.piece, modes)
        if key not in self.made:
            self.made[key] = self.make(modes)
        return self.made[key]

    def make(self, modes: tuple[int, ...]) -> Motion:
        load, A = self.smooth.copy(), np.zeros((self.dim, self.dim))
        for p in self.loads:
            load += np.outer(p.row, self.line(p.line))
        A[self.one + 1, self.one] = 1.0
        for k, p in enumerate(self.waves):
            at = self.one + 2 + 2 * k
            A[at, at + 1], A[at + 1, at] = p.rate, -p.rate
            load[:, at] += p.size * p.row
        rows, owners, slides, held, ranges = [], [], [], [], []
        for k, (c, mode) in enumerate(zip(self.contacts, modes, strict=True)):
            if mode in (FORWARD, BACKWARD):
                rows.append(mode * self.on(c.row, 1))
                owners.append([k])
                load -= np.outer(c.row, self.line(c.level, mode) + c.rise * self.on(c.row, 1))
            elif mode == OFF and c.kind == "gap":
                rows.append(self.on(c.row, 0) + c.gap * (np.arange(self.dim) == self.one))
                owners.append([k])
            elif mode == STICK:
                most = self.line(c.level, c.peak)
                least = {"gap": np.zeros(self.dim), "dog": None}.get(c.kind, -most)
                ranges.append((least, most if c.kind == "friction" else None))
                held.append(k)
            slides += [mode != OFF] * (len(rows) - len(slides))
        if held:
            W = self.rows[held]
            carried = -W.T @ np.linalg.pinv(W / self.J @ W.T, 1e-12) @ (W / self.J) @ load
            rounding = 1e-13 * np.abs(load).max(axis=0)
            load = load + carried
            load[np.abs(load) < rounding] = 0.0
            carried[np.abs(carried) < rounding] = 0.0
            margins, letting_go = facets(W, ranges, carried)
            rows += margins
            owners += [np.array(held)[part] for part in letting_go]
            slides += [False] * len(margins)
        A[: self.n, self.n : self.one] = np.eye(self.n)
        A[self.n : self.one] = load / self.J[:, None]
        blamed = np.zeros((len(rows), len(modes)), dtype=bool)
        for row, owner in zip(blamed, owners, strict=True):
            row[owner] = True
        return Motion(A, np.reshape(rows, (-1, self.dim)), blamed, np.array(slides, dtype=bool))

    # -- modes and impacts -----------------------------------------------------------------------

    def options(self, k: int, z: np.ndarray) -> tuple[int, ...]:
        c, speed = self.contacts[k], float(self.rows[k] @ z[self.n : self.one])
        if c.kind == "dog":
            return (STICK,) if c.level.on(*self.piece)[0] > 0.5 else (OFF,)
        if c.kind == "gap":
            closed = c.gap + c.row @ z[: self.n] < CLOSED and speed < STILL
            return (STICK, OFF) if closed else (OFF,)
        if c.kind == "freewheel":
            return (STICK, FORWARD) if speed < STILL else (FORWARD,)
        if not any(c.level.on(*self.piece)):
            return (OFF,)
        return (STICK, FORWARD, BACKWARD) if abs(speed) < STILL else (int(np.sign(speed)),)

    def choose(self, z: np.ndarray, before: tuple[int, ...] | None) -> tuple[int, ...]:
        """Modes that fit, with least of what was at rest let go."""
        options = [self.options(k, z) for k in range(len(self.contacts))]
        rest = slides = [False] * len(options)
        if before is not None:
            known = [a if a in o else o[0] for a, o in zip(before, options, strict=True)]
            motion = self.motion(tuple(known))
            below = motion.signs(z) < 0
            fired = motion.blamed[below].any(axis=0)
            stuck = np.array(before) == STICK
            rest = (stuck & ~fired).tolist()
            # a limit that is just reached, not exceeded by a jump
            zero = 1e-9 * (1 + motion.sizes[0] @ np.abs(z))
            if (np.abs(motion.rows @ z) < zero)[below].all():
                slides = (stuck & fired).tolist()

        def key(modes: tuple[int, ...]) -> tuple[int, int, int]:
            freed = [r and m != STICK for r, m in zip(rest, modes, strict=True)]
            held = [s and m == STICK for s, m in zip(slides, modes, strict=True)]
            return sum(freed), sum(held), -modes.count(STICK)

        ways = sorted(itertools.product(*options), key=key)
        for _, group in itertools.groupby(ways, key):
            motions = {m: self.motion(m) for m in group}
            fitting = [m for m, way in motions.items() if (way.signs(z) >= way.slides).all()]
            rates = [motions[m].A @ z for m in fitting]
            if len(rates) > 1 and np.ptp(rates, axis=0).max() > 1e-6 * (1 + np.abs(rates).max()):
                raise OpenLawError(f"several ways on at {self.t:.6g}")
            if fitting:
                return fitting[0]
        raise LostError(f"no modes at {self.t:.9g}")

    def settle(self, z: np.ndarray) -> np.ndarray:
        """The state after impacts, with what stands still exactly still."""
        z, v = z.copy(), z[self.n : self.one]
        W, least, still = [], [], []
        crowd = [0.0]
        D = [c.row for c in self.contacts if c.kind == "dog" and c.level.on(*self.piece)[0] > 0.5]
        hit = any(abs(row @ v) > STILL for row in D)
        for c in self.contacts:
            speed, apart = float(c.row @ v), float(c.gap + c.row @ z[: self.n])
            if c.kind == "freewheel" or (c.kind == "gap" and apart < CLOSED):
                crowd += [apart] if c.kind == "gap" and abs(speed) > STILL else []
                W.append(c.row)
                bounce = c.e * -speed
                least.append(bounce if speed < -STILL and bounce > LEAST else 0.0)
                hit |= speed < -STILL
        shape = (-1, self.n)
        if hit:
            if max(crowd) > 1e-12:
                raise OpenLawError(f"impacts at practically one instant {self.t:.6g}")
            after, _ = impact(
                self.J, v, np.reshape(W, shape), np.array(least), np.reshape(D, shape)
            )
            loss = lost(self.J, v, after)
            if loss < -1e-12 * (1 + float(self.J @ v**2)):
                raise OpenLawError(f"Newton's law adds {-loss:.2g} J at {self.t:.6g}")
            self.losses.append(loss)
            v = after
        for c in self.contacts:
            near = c.kind != "gap" or c.gap + c.row @ z[: self.n] < CLOSED
            if near and c.kind != "dog" and abs(c.row @ v) < STILL:
                still.append(c.row)
        if still or D:
            R = np.reshape(still + D, shape)
            v = v - (R / self.J).T @ np.linalg.pinv(R / self.J @ R.T, 1e-12) @ (R @ v)
        z[self.n : self.one] = v
        return z

    # -- the run ---------------------------------------------------------------------------------

    def run(self, grid: np.ndarray, h: float = 2e-3) -> np.ndarray:
        """Positions and speeds on a grid, shape (len(grid), 2 n); events and losses beside."""
        self.made, self.events, self.losses, self.out = {}, [], [], []
        left = itertools.count(5000, -1)
        waves = [f(p.phase) for p in self.waves for f in (np.sin, np.cos)]
        z, modes = np.array([*self.q, *self.v, 1.0, 0.0, *waves]), None
        for piece in self.pieces:
            self.piece, (self.t, end) = piece, piece
            z[self.one + 1], arrived = 0.0, False
            while not arrived:
                if not next(left):
                    raise LostError(f"5000 events before {self.t}")
                collisions = len(self.losses)
                z = self.settle(z)
                before, modes = modes, self.choose(z, modes)
                if len(self.losses) > collisions or before not in (None, modes):
                    pairs = zip(self.contacts, before or modes, modes, strict=True)
                    self.events.append((self.t, {c.name for c, a, b in pairs if a != b}))
                z, arrived = self.advance(self.motion(modes), z, end, h, grid)
        self.out.append(self.settle(z)[: self.one])
        return np.array(self.out)

    def advance(
        self, motion: Motion, z: np.ndarray, end: float, h: float, grid: np.ndarray
    ) -> tuple[np.ndarray, bool]:
        """Go on to the end of the piece or to the first row that falls through zero."""
        begins = True
        while True:
            states = motion.block(z, h)
            values, rates = states @ motion.rows.T, states @ (motion.terms[1].T * h)
            a, b, da, db = values[:-1], values[1:], rates[:-1], rates[1:]
            # lowest value that a cubic through both ends can have there
            low = np.minimum(np.minimum(a, b), np.minimum(a + da / 3, b - db / 3))
            doubtful = (low < 1e-12).any(axis=1)
            for k in range(BLOCK - 1):
                now = self.t + k * h
                length = min(h, end - now)
                s = motion.first_fall(states[k], length, begins) if doubtful[k] else None
                if s is not None or now + h >= end:
                    last = length if s is None else s
                    self.take(motion, states[0], grid, now + last)
                    self.t = end if s is None else now + last
                    return expm(motion.A * last) @ states[k], s is None
                begins = False
            until = self.t + (BLOCK - 1) * h
            self.take(motion, states[0], grid, until)
            z, self.t = states[-1], until

    def take(self, motion: Motion, z: np.ndarray, grid: np.ndarray, end: float) -> None:
        for at in grid[(grid >= self.t) & (grid < end)]:
            self.out.append((expm(motion.A * (at - self.t)) @ z)[: self.one])


if __name__ == "__main__":
    from hybrid_comparisons import main

    main(sys.argv[1:])
