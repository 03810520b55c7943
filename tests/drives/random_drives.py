"""Random drives with every kind of part that is not smooth, for `lumped` and for a reference.

``python tests/drives/random_drives.py 0 1000`` compares a thousand of them with `drive_reference`,
which shares no code with `lumped`, and counts: agree, refused by name, deviates.
"""

import math
import sys
import traceback
from collections import Counter

import numpy as np
from drive_reference import Control, Drive, Element, LostError, Shaft
from hybrid_drives import compose
from random_transmissions import (
    END,
    STEADY,
    WAVES,
    RowSpring,
    command,
    ramped,
    rows_at,
    signal,
    transmission,
)

import lumped as lp
from lumped.components import (
    Backlash,
    BearingFriction,
    Brake,
    Clutch,
    CrankSlider,
    ElastoBacklash,
    Expression,
    Inertia,
    LimitedPI,
    OneWayClutch,
    QuadraticTorque,
    SlipCoupling,
    SpeedSensor,
    SpringDamper,
    Torque,
)
from lumped.errors import LumpedError

POINTS = 60
METHODS = ("auto", "steps", "explicit", "implicit")


# -- signals: an expression for lumped, and the same in pieces -----------------------------------


# -- transmissions -------------------------------------------------------------------------------


# -- drives --------------------------------------------------------------------------------------


class RandomDrive:
    """One description, built as a model of `lumped` and as a drive of the reference."""

    def __init__(self, seed):
        rng = self.rng = np.random.default_rng(seed)
        self.parts, self.joints = {}, []  # name -> part; pairs of ports
        self.points, self.elements, self.controls = [], [], []
        self.shafts, self.kinds = [], Counter()
        self.linear = seed % 10 == 9  # between jumps and kinks of its torques: has a closed form
        n = int(rng.integers(1, 5))
        together = rng.random() < 0.3  # all at one speed, so that clutches begin stuck
        speed = float(rng.choice([0.0, rng.uniform(-8, 8)]))
        for i in range(n):
            part, body, J_b, follow = transmission(rng, self.linear)
            J, q = float(rng.uniform(0.2, 2.0)), 0.0
            w = speed if together else float(rng.choice([0.0, rng.uniform(-8, 8)], p=[0.3, 0.7]))
            self.parts[f"body{i}"] = Inertia(J=J, phi=q, w=w)
            self.points.append((i, 0))
            if part is not None:
                self.kinds[type(part).__name__] += 1
                self.parts[f"drive{i}"], self.parts[f"second{i}"] = part, body
                first = "flange" if isinstance(part, CrankSlider) else "flange_a"
                second = "slider" if isinstance(part, CrankSlider) else "flange_b"
                self.joints += [
                    (f"body{i}.flange_b", f"drive{i}.{first}"),
                    (f"drive{i}.{second}", f"second{i}.flange_a"),
                ]
                if isinstance(body, Inertia):
                    self.points.append((i, 1))
            self.shafts.append(Shaft(J, J_b, follow, q, w))
        self.tree = list(range(n + 1))  # groups joined by hard elements; n is the ground
        for i in range(1, n):
            if rng.random() < 0.8:
                self.elastic((i, int(rng.choice([0, 1]))), (int(rng.integers(0, i)), 0))
        for i in range(n):
            if rng.random() < (1.0 if i == 0 else 0.5):
                self.torque(self.point(i))
        for _ in range(int(rng.integers(1, 5))):
            kinds = ["hard", "elastic", "load", "control"]
            kind = rng.choice(kinds, p=[0.6, 0.15, 0.15, 0.1])
            a, b = self.pair()
            if kind == "hard" and not self.linear:
                self.hard(a, b)
            elif kind in ("hard", "elastic") and a is not None:
                self.elastic(b, a)
            elif self.linear:
                self.torque(b)
            elif kind == "load":
                self.load(b)
            elif kind == "control" and not self.controls:
                self.control(b[0])

        for i in range(n):
            if not any(f"body{i}." in end for joint in self.joints for end in joint):
                self.torque((i, 0))

    def point(self, i):
        return (i, int((i, 1) in self.points and self.rng.random() < 0.5))

    def pair(self):
        """Two points of different shafts, or the ground (None) and a point."""
        n = len(self.shafts)
        b = int(self.rng.integers(0, n))
        a = int(self.rng.integers(0, n))
        return (None if a == b else self.point(a)), self.point(b)

    def add(self, part, b, a=None, **element):
        """A part between two points."""
        name = f"part{len(self.parts)}"
        self.parts[name] = part
        self.kinds[type(part).__name__] += 1
        one_port = hasattr(type(part), "flange")
        through = isinstance(part, BearingFriction | Brake)
        ends = [(b, "flange" if one_port else "flange_a" if through else "flange_b")]
        if a is not None:
            ends.append((a, "flange_a"))
        for (i, second), port in ends:
            second = second if (i, 1) in self.points else 0
            self.joints.append((f"{'second' if second else 'body'}{i}.flange_a", f"{name}.{port}"))
        if element:
            fixed = [p if p is None or p in self.points else (p[0], 0) for p in (b, a)]
            self.elements.append(Element(*fixed, **element))
        return name

    def torque(self, b):
        made, s = signal(self.rng, 8.0, STEADY if self.linear else (*STEADY, *WAVES))
        part = Torque(tau=made)
        self.add(part, b, law=lambda t, m, x, v: s.value(t, m), breaks=s.breaks)

    def load(self, b):
        tau = -float(self.rng.uniform(0.5, 5))
        part = QuadraticTorque(tau_nominal=tau, w_nominal=10.0)
        self.add(part, b, law=lambda t, m, x, v: tau * v * abs(v) / 100)

    def control(self, i):
        made, s = signal(self.rng, 5.0, ("constant", "sine", "table", "where"))
        k, T_i, most = (float(self.rng.uniform(*r)) for r in ((1, 8), (0.1, 0.5), (2, 12)))
        self.parts["sensor"] = SpeedSensor()
        self.parts["wanted"] = Expression(value=made)
        self.parts["controller"] = LimitedPI(k=k, T_i=T_i, y_min=-most, y_max=most)
        self.parts["motor"] = Torque()
        self.joints += [
            (f"body{i}.flange_a", "sensor.flange", "motor.flange"),
            ("wanted.y", "controller.wanted"),
            ("sensor.w", "controller.measured"),
            ("controller.y", "motor.tau"),
        ]
        self.kinds["LimitedPI"] += 1
        self.controls.append(Control(i, k, T_i, most, s))

    def elastic(self, b, a):
        rng = self.rng
        c, d = float(rng.uniform(20, 800)), float(rng.uniform(0.05, 3))
        kind = rng.choice(["linear", "play", "rows"])
        if kind == "linear" or self.linear:
            part = SpringDamper(c=c, d=d)
            self.add(part, b, a, law=lambda t, m, x, v: -c * x - d * v)
        elif kind == "play":
            gap = float(rng.uniform(0.02, 0.3))

            def law(t, m, x, v):
                if abs(x) <= gap / 2:
                    return 0.0
                side = math.copysign(1.0, x)
                elastic = c * (abs(x) - gap / 2)
                return -side * max(0.0, elastic + min(elastic, d * side * v))

            self.add(ElastoBacklash(c=c, d=d, b=gap), b, a, law=law)
        else:
            x = np.sort(rng.uniform(-0.5, 0.5, 4))
            slopes = c * rng.uniform(0.2, 2, 3)
            y = np.concatenate([[0.0], np.cumsum(slopes * np.diff(x))])
            rows = tuple(zip(x.tolist(), (y - np.interp(0.0, x, y)).tolist(), strict=True))
            law = lambda t, m, x, v: -rows_at(x, rows) - d * v  # noqa: E731
            self.add(RowSpring(rows=rows, d=d), b, a, law=law)

    def joined(self, b, a):
        """Whether an element may join the two without closing a loop of hard elements."""
        ends = [self.tree[b[0]], self.tree[a[0] if a is not None else len(self.shafts)]]
        if ends[0] == ends[1]:
            return False
        self.tree = [ends[0] if k == ends[1] else k for k in self.tree]
        return True

    def hard(self, a, b):
        rng = self.rng
        if not self.joined(b, a):
            return
        impact = any(e.gap is not None or e.freewheel for e in self.elements)
        if a is None:
            rows = self.friction_rows()
            if rng.random() < 0.5:
                self.add(BearingFriction(characteristic=rows), b, limit=limit_of(rows))
                return
            made, s = command(rng) if rng.random() < 0.5 else ramped(rng)
            part = Brake(characteristic=rows, f_max=1.0, u=made)
            self.add(part, b, limit=limit_of(rows, s), breaks=s.breaks)
            return
        kind = rng.choice(["clutch", "slip", "play", "freewheel"])
        if kind == "clutch" or (impact and kind in ("play", "freewheel")):
            rows = self.friction_rows()
            made, s = command(rng) if rng.random() < 0.5 else ramped(rng)
            part = Clutch(characteristic=rows, f_max=1.0, u=made)
            self.add(part, b, a, limit=limit_of(rows, s), breaks=s.breaks)
        elif kind == "slip":
            tau = float(rng.uniform(0.5, 8))
            made, s = command(rng)
            part = SlipCoupling(kinetic=tau, static=tau, u=made)
            self.add(part, b, a, limit=limit_of(((0.0, tau),), s), breaks=s.breaks)
        elif kind == "play":
            gap, e = float(rng.uniform(0.02, 0.3)), float(rng.choice([0.0, 0.3, 0.6]))
            self.add(Backlash(b=gap, restitution=e), b, a, gap=(gap / 2, e))
        elif all(self.speed(p) == 0 for p in (a, b)) or self.speed(b) > self.speed(a):
            self.add(OneWayClutch(u=0.0), b, a, freewheel=True)

    def speed(self, point):
        i, second = point
        s = self.shafts[i]
        return s.w * (s.follow(s.q)[1] if second and (i, 1) in self.points else 1.0)

    def friction_rows(self):
        first, slope = self.rng.uniform(0.5, 8), self.rng.uniform(-0.05, 0.2)
        return ((0.0, float(first)), (10.0, float(first * (1 + slope * 3))))

    # -- the two drives --------------------------------------------------------------------------

    def reference(self, change=0.0):
        shafts = [
            Shaft(s.J * (1 + change * (-1) ** i), s.J_b, s.follow, s.q, s.w)
            for i, s in enumerate(self.shafts)
        ]
        return Drive(shafts, self.elements, self.controls, END)

    def model(self):
        return compose(self.parts, self.joints)


def limit_of(rows, command=None):
    def limit(t, m, speed):
        grip = 1.0 if command is None else command.value(t, m)
        return grip * max(0.0, rows_at(speed, rows)) if len(rows) > 1 else grip * rows[0][1]

    return limit


def compare(seed, method=None, rtol=1e-9):
    """Largest deviation over the scale, what the reference is worth, and a description."""
    drive = RandomDrive(seed)
    n = len(drive.shafts)
    grid = np.linspace(0, END, POINTS + 1)
    exact = drive.reference()
    expected = exact.run(grid)
    names = [f"body{i}.{v}" for v in ("phi", "w") for i in range(n)]
    method = method or ("auto" if drive.linear else METHODS[seed % len(METHODS)])
    system = lp.assemble(drive.model(), keep=names[:n])
    run = lp.simulate(system, until=END, grid=grid, rtol=rtol, method=method)
    received = run.table(names)
    scale = np.maximum(np.abs(expected).max(axis=0), [1.0] * n + [3.0] * n)
    quiet = np.all(np.abs(grid[:, None] - np.array([*exact.events, -1.0])) > 1e-5, axis=1)
    error = (np.abs(received - expected) / scale)[quiet].max(axis=1)
    if error.max() > 1e-5:  # the reference may have stepped over a kink
        expected = drive.reference().run(grid, 1e-12)
        error = (np.abs(received - expected) / scale)[quiet].max(axis=1)
    worth = np.zeros(1)
    if error.max() > 1e-5:  # how far apart two references go that differ by 1e-9
        beside = drive.reference(1e-9).run(grid)
        worth = (np.abs(beside - expected) / scale)[quiet].max(axis=1)
    bad = error > 1e-5 + 100 * worth
    first = grid[quiet][bad.argmax()] if bad.any() else None
    return error.max(), worth.max(), first, method, drive, len(exact.events)


def main(first, last, step=1):
    """Compare many drives and count."""
    count, kinds = Counter(), Counter()
    for seed in range(first, last, step):
        try:
            error, worth, when, method, drive, events = compare(seed)
        except LostError as lost:
            count["reference lost"] += 1
            print(f"{seed}: reference: {lost}")
            continue
        except LumpedError as refusal:
            count["refused"] += 1
            print(f"{seed}: {type(refusal).__name__}: {str(refusal)[:300]}")
            continue
        except Exception:
            count["raw error"] += 1
            print(f"{seed}: " + traceback.format_exc(limit=-3))
            continue
        kinds.update(drive.kinds.keys())
        verdict = "agrees" if when is None else "DEVIATES"
        count[verdict] += 1
        if seed % 50 == 49:
            print(f"{seed}: {dict(count)}")
        if when is not None:
            what = ", ".join(f"{k}" for k in drive.kinds)
            print(
                f"{seed}: deviates from t = {when:.3f} s by {error:.1e}, reference worth "
                f"{worth:.0e}, {method}, {events} events: {what}"
            )
        sys.stdout.flush()
    print(dict(count))
    print(dict(kinds))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
