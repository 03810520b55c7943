"""Drives with friction, play and switched parts, by Gauss's principle; knows nothing of `lumped`.

A drive has n independent angles q, each of one shaft with a second body that follows by a rigid
transmission ``p = g(q)``. Elements act between points of these bodies or a point and the ground.
Between events the motion is integrated by SciPy's DOP853; at each event the modes (sticking,
sliding, closed, open) are those that satisfy the signs of accelerations and reactions (Pfeiffer
and Glocker, Multibody Dynamics with Unilateral Contacts, 1996, ch. 5). Friction gives no impulse.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

STICK, FORWARD, BACKWARD, OFF = 0, 1, -1, 2
STILL = 1e-9
"""Relative speed taken for standstill, rad/s."""
LEAST = 1e-5
"""Speed after an impact below which a flank stays closed, rad/s."""
SLACK = 1e-10
"""Reaction beyond its limit at which a mode ends, N.m."""
INSIDE = (0.2, 0.4, 0.6, 0.8, 1.0)
"""Where in a step margins are looked at."""

Kinematics = Callable[[float], tuple[float, float, float]]


class LostError(Exception):
    """The reference itself finds no way on."""


@dataclass
class Signal:
    """A function of time in pieces: `value(t, middle)` with any instant `middle` of the piece."""

    value: Callable[[float, float], float]
    breaks: Sequence[float] = ()


@dataclass
class Shaft:
    """A body of inertia `J`, and one of inertia `J_b` that follows by ``p = follow(q)``."""

    J: float
    J_b: float
    follow: Kinematics
    q: float
    w: float


@dataclass
class Element:
    """What acts between two points (shaft, 0 or 1 for its second body), or one and the ground.

    `law` is the smooth torque on b by (t, middle, x_rel, v_rel). `limit` is that of friction by
    (t, middle, speed), None where the element is no friction; `gap` is (b / 2, restitution) of a
    play; a freewheel lets only positive speeds pass.
    """

    b: tuple[int, int]
    a: tuple[int, int] | None = None
    law: Callable[[float, float, float, float], float] | None = None
    limit: Callable[[float, float, float], float] | None = None
    gap: tuple[float, float] | None = None
    freewheel: bool = False
    breaks: Sequence[float] = ()


@dataclass
class Control:
    """PI controller of a shaft's speed with back calculation, and a limited torque."""

    shaft: int
    k: float
    T_i: float
    most: float
    wanted: Signal

    def output(self, t: float, middle: float, w: float, x: float) -> tuple[float, float]:
        e = self.wanted.value(t, middle) - w
        u = self.k * (e + x)
        y = min(max(u, -self.most), self.most)
        return y, (e + (y - u) / self.k) / self.T_i


@dataclass
class Drive:
    shafts: list[Shaft]
    elements: list[Element]
    controls: list[Control]
    end: float
    events: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.n = len(self.shafts)
        self.hard = [e for e in self.elements if e.law is None]
        times = {b for e in self.elements for b in e.breaks}
        times |= {b for c in self.controls for b in c.wanted.breaks}
        self.times = [0.0, *sorted(t for t in times if 0 < t < self.end), self.end]

    # -- kinematics and forces -----------------------------------------------------------------

    def relative(self, e: Element, q: Sequence[float]) -> tuple[float, list[tuple]]:
        """Relative position, and for each of its shafts: index, derivative by q, the second one."""
        x, ends = 0.0, []
        for point, sign in ((e.b, 1.0), (e.a, -1.0)):
            if point is not None:
                i, second = point
                p, dp, ddp = self.shafts[i].follow(q[i]) if second else (q[i], 1.0, 0.0)
                x += sign * p
                ends.append((i, sign * dp, sign * ddp))
        return x, ends

    def forces(self, t: float, middle: float, y: list[float]) -> tuple[list, list, list]:
        """Inertia, generalised torques of all but hard elements, rates of controllers."""
        q, v, z = y[: self.n], y[self.n : 2 * self.n], y[2 * self.n :]
        mass, load, rates = [], [], []
        for s, angle, speed in zip(self.shafts, q, v, strict=True):
            _, dp, ddp = s.follow(angle)
            mass.append(s.J + s.J_b * dp**2)
            load.append(-s.J_b * dp * ddp * speed**2)
        for e in self.elements:
            if e.law is not None:
                x, ends = self.relative(e, q)
                tau = e.law(t, middle, x, along(ends, v))
                for i, slope, _ in ends:
                    load[i] += slope * tau
        for c, x in zip(self.controls, z, strict=True):
            tau, rate = c.output(t, middle, v[c.shaft], x)
            load[c.shaft] += tau
            rates.append(rate)
        return mass, load, rates

    def accelerations(
        self, t: float, middle: float, y: list[float], modes: tuple[int, ...]
    ) -> tuple[list, list, list]:
        """Accelerations, reactions of hard elements, rates of controllers in given modes."""
        mass, load, rates = self.forces(t, middle, y)
        q, v = y[: self.n], y[self.n : 2 * self.n]
        rows, biases, held = [], [], []
        r = [0.0] * len(self.hard)
        for k, (e, mode) in enumerate(zip(self.hard, modes, strict=True)):
            if mode == OFF:
                continue
            _, ends = self.relative(e, q)
            if mode == STICK:
                rows.append(self.row(ends))
                biases.append(bend(ends, v))
                held.append(k)
            else:
                r[k] = -mode * e.limit(t, middle, abs(along(ends, v)))
                for i, slope, _ in ends:
                    load[i] += slope * r[k]
        if held:
            G, M = np.array(rows), np.array(mass)
            found = solved(G / M @ G.T, -(G @ (np.array(load) / M) + biases))
            load = (load + found @ G).tolist()
            for k, value in zip(held, found.tolist(), strict=True):
                r[k] = value
        return [f / m for f, m in zip(load, mass, strict=True)], r, rates

    def row(self, ends: list[tuple]) -> np.ndarray:
        row = np.zeros(self.n)
        for i, slope, _ in ends:
            row[i] += slope
        return row

    # -- modes ---------------------------------------------------------------------------------

    def choices(self, e: Element, t: float, middle: float, y: np.ndarray) -> tuple[int, ...]:
        x, ends = self.relative(e, y[: self.n])
        s = along(ends, y[self.n : 2 * self.n])
        if e.gap is not None:
            touching = abs(x) > e.gap[0] - 1e-9
            return (STICK, OFF) if touching and abs(s) < STILL else (OFF,)
        if e.freewheel:
            return (STICK, OFF) if s < STILL else (OFF,)
        if e.limit(middle, middle, 0.0) <= 0:
            return (OFF,)
        return (STICK, FORWARD, BACKWARD) if abs(s) < STILL else (int(np.sign(s)),)

    def find_modes(self, t: float, middle: float, y: np.ndarray) -> tuple[int, ...]:
        """The modes in which accelerations and reactions have the signs that they must have."""
        best, least = None, np.inf
        q, v = y[: self.n], y[self.n : 2 * self.n]
        options = [self.choices(e, t, middle, y) for e in self.hard]
        for modes in itertools.product(*options):
            a, r, _ = self.accelerations(t, middle, y, modes)
            wrong = 0.0
            for k, (e, mode) in enumerate(zip(self.hard, modes, strict=True)):
                if len(options[k]) == 1:
                    continue
                x, ends = self.relative(e, q)
                away = along(ends, a) + bend(ends, v)
                side = -np.sign(x) if e.gap is not None else 1.0
                if e.limit is not None and mode == STICK:
                    wrong = max(wrong, abs(r[k]) - e.limit(t, middle, 0.0))
                elif e.limit is not None:
                    wrong = max(wrong, -mode * away)
                elif mode == STICK:
                    wrong = max(wrong, -side * r[k])
                else:
                    wrong = max(wrong, -side * away)
            if wrong < least:
                best, least = modes, wrong
        if best is None or least > 1e-6:
            raise LostError(f"no modes at {t}: {least}")
        return best

    def collide(self, y: list[float]) -> list[float]:
        """Speeds after the impact of a play's flank, if one is hit."""
        q, v = y[: self.n], np.array(y[self.n : 2 * self.n])
        mass = np.array(self.forces(0.0, 0.0, y)[0])
        rows, jumps = [], []
        for e in self.hard:
            x, ends = self.relative(e, q)
            row, s = self.row(ends), along(ends, v)
            if e.gap is not None and abs(x) > e.gap[0] - 1e-9 and s * x > 0:
                back = e.gap[1] * abs(s)
                rows.append(row)
                jumps.append(-s - np.sign(x) * (back if back > LEAST else 0.0))
            elif e.freewheel and s < STILL:
                rows.append(row)
                jumps.append(-s)
        if rows:
            G = np.array(rows)
            v += solved(G / mass @ G.T, np.array(jumps)) @ G / mass
        return [*q, *v.tolist(), *y[2 * self.n :]]

    # -- motion --------------------------------------------------------------------------------

    def margins(self, middle: float, modes: tuple[int, ...]) -> Callable:
        """Function of (t, y) with the values whose fall through zero ends a mode."""
        pairs = list(zip(self.hard, modes, strict=True))
        forced = any(mode == STICK for mode in modes)

        def values(t, y):
            y = y.tolist()
            q, v, found = y[: self.n], y[self.n : 2 * self.n], []
            r = self.accelerations(t, middle, y, modes)[1] if forced else None
            for k, (e, mode) in enumerate(pairs):
                if mode == STICK and e.limit is not None:
                    most = e.limit(t, middle, 0.0) + SLACK
                    found += [most - r[k], most + r[k]]
                    continue
                if mode == OFF and e.limit is not None:
                    continue
                x, ends = self.relative(e, q)
                if mode == STICK:
                    found.append((r[k] if e.freewheel else -np.sign(x) * r[k]) + SLACK)
                elif e.gap is not None:
                    found += [e.gap[0] - x, e.gap[0] + x]
                else:
                    found.append(along(ends, v) if e.freewheel else mode * along(ends, v))
            return np.array(found)

        return values

    def run(self, grid: np.ndarray, rtol: float = 1e-10) -> np.ndarray:
        """Angles and speeds at the instants of `grid`, shape (len(grid), 2 n)."""
        q, w = ([getattr(s, name) for s in self.shafts] for name in ("q", "w"))
        y = [*q, *w, *[0.0] * len(self.controls)]
        t, out, self.events = 0.0, [], []

        def take(begin, end, curve):
            out.extend(curve(at)[: 2 * self.n] for at in grid[(grid >= begin) & (grid < end)])

        for begin, end in itertools.pairwise(self.times):
            middle = (begin + end) / 2
            while t < end:
                y = self.settled(y)
                modes = self.find_modes(t, middle, y)

                def rate(t, y, middle=middle, modes=modes):
                    y = y.tolist()
                    a, _, rates = self.accelerations(t, middle, y, modes)
                    return np.array(y[self.n : 2 * self.n] + a + rates)

                t, y, hit = self.segment(rate, t, y, end, self.margins(middle, modes), rtol, take)
                if hit:
                    self.events.append(t)
                    if len(self.events) > 3000:
                        raise LostError("more than 3000 events")
        out.append(self.settled(y)[: 2 * self.n])
        return np.array(out)

    def segment(self, rate, t, y, end, margins, rtol, take):
        """Integrate to the end or to the first margin that falls through zero."""
        first = min(1e-9, (end - t) / 2)
        solver = DOP853(rate, t, y, end, 0.02, rtol, rtol * 1e-2, first_step=first)
        before = margins(t, np.array(y))
        while solver.status == "running":
            solver.step()
            if solver.status == "failed":
                raise LostError(f"step at {solver.t}")
            begin, curve = solver.t_old, solver.dense_output()
            for part in INSIDE if len(before) else ():
                now = solver.t_old + part * (solver.t - solver.t_old)
                values = margins(now, curve(now))
                falls = [
                    fall(margins, curve, k, begin, now)
                    for k in np.flatnonzero((before > 0) & (values <= 0))
                ]
                if falls:
                    take(solver.t_old, min(falls), curve)
                    return min(falls), curve(min(falls)).tolist(), True
                begin, before = now, values
            take(solver.t_old, solver.t, curve)
        return end, solver.y.tolist(), False

    def settled(self, y: list[float]) -> list[float]:
        """The state after impacts, with what stands still exactly still."""
        y = np.array(self.collide(y))
        mass = np.array(self.forces(0.0, 0.0, y.tolist())[0])
        for _ in range(3):
            for e in self.hard:
                x, ends = self.relative(e, y[: self.n])
                row, s = self.row(ends), along(ends, y[self.n : 2 * self.n])
                near = abs(x) > e.gap[0] - 1e-9 if e.gap is not None else True
                if near and 0 < abs(s) < STILL:
                    y[self.n : 2 * self.n] -= row / mass * s / (row @ (row / mass))
        return y.tolist()


def fall(margins: Callable, curve: Callable, k: int, begin: float, end: float) -> float:
    """The instant at which a margin passes zero."""
    return brentq(lambda t: margins(t, curve(t))[k], begin, end, xtol=1e-15)


def solved(A: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Solution of a system that a dead centre may leave singular."""
    if len(b) == 1 and A[0, 0] > 1e-12:
        return b / A[0]
    return np.linalg.lstsq(A, b, rcond=None)[0]


def along(ends: list[tuple], v: Sequence[float]) -> float:
    """Relative speed."""
    return sum(slope * v[i] for i, slope, _ in ends)


def bend(ends: list[tuple], v: Sequence[float]) -> float:
    """Relative acceleration at constant speeds of the shafts."""
    return sum(curve * v[i] ** 2 for i, _, curve in ends)
