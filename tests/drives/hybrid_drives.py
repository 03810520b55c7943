"""Random hybrid drives, for `lumped` and for `hybrid_reference`."""

import numpy as np
from hybrid_parts import Contact, Line, Load, steady
from hybrid_reference import Drive

import lumped as lp
from lumped import components as rotating
from lumped.components import translation as sliding
from lumped.ops import sin, table, where

END = 1.5


def expression(line):
    """A line as an expression of `lumped`."""
    if len(line.ts) == 1:
        return float(line.ys[0])
    return table([float(t) for t in line.ts], [float(y) for y in line.ys])


def switched(line):
    """A command that is one above and zero below a half."""
    value = float(line.ys[0])
    for t, y in list(zip(line.ts, line.ys, strict=True))[1:]:
        value = where(lp.time >= float(t), float(y), value)
    return value


def compose(parts, joints):
    """A model of parts some of whose ports, named "part.port", are joined."""

    def port(m, name):
        owner, end = name.split(".")
        return getattr(getattr(m, owner), end)

    return lp.compose(
        **parts,
        connections=lambda m: [lp.connect(*(port(m, end) for end in joint)) for joint in joints],
    )


class RandomDrive:
    """One description, built as a model of `lumped` and as a drive of the reference."""

    def __init__(self, seed):
        rng = self.rng = np.random.default_rng(seed)
        self.parts, self.joints, self.kinds = {}, [], []
        self.loads, self.springs, self.contacts = [], [], []
        self.turns = rng.random() < 0.75
        self.n = n = int(rng.integers(1, 5))
        self.J, self.v = rng.uniform(0.2, 2.0, n), np.zeros(n)
        speed = float(rng.choice([0.0, 0.0, rng.uniform(-5, 5)]))
        for i in range(n):
            alone = rng.random() < 0.4
            self.v[i] = rng.choice([0.0, rng.uniform(-6, 6)]) if alone else speed
        self.total, self.points = self.J.copy(), [self.point(i) for i in range(n)]
        for i in range(n):
            if self.turns and rng.random() < 0.3:
                self.points.append(self.geared(i))
        for i in range(1, n):
            if rng.random() < 0.5:
                self.spring(self.points[i], self.points[int(rng.integers(0, i))])
        if rng.random() < 0.5:
            self.spring(self.any(), None)
        for i in range(n):
            if rng.random() < 0.7 or i == 0:
                self.torque(self.points[i])
        kinds = ["friction", "redundant", "freewheel", "play", "stop", "dog"]
        odds = [0.2, 0.25, 0.15 if self.turns else 0.0, 0.15, 0.15, 0.1]
        for _ in range(int(rng.integers(1, 4))):
            kind = str(rng.choice(kinds, p=np.divide(odds, sum(odds))))
            if len(self.contacts) < 5:
                getattr(self, kind)()
        if not self.contacts:
            self.redundant()

    # -- points ----------------------------------------------------------------------------------

    def point(self, i):
        """A body: its row, and a name of a port."""
        J, v = float(self.J[i]), float(self.v[i])
        part = rotating.Inertia(J=J, phi=0.0, w=v) if self.turns else sliding.Mass(m=J, s=0.0, v=v)
        self.parts[f"body{i}"] = part
        row = np.zeros(self.n)
        row[i] = 1.0
        return row, f"body{i}.flange_a"

    def geared(self, i):
        """A second body behind a gear."""
        ratio, J = float(self.rng.choice([-1, 1]) * self.rng.uniform(0.5, 3)), 0.3
        self.parts[f"gear{i}"] = rotating.IdealGear(ratio=ratio)
        self.parts[f"second{i}"] = rotating.Inertia(J=J)
        self.joints += [
            (f"body{i}.flange_b", f"gear{i}.flange_a"),
            (f"gear{i}.flange_b", f"second{i}.flange_a"),
        ]
        self.total[i] += J / ratio**2
        return self.points[i][0] / ratio, f"second{i}.flange_b"

    def any(self):
        return self.points[int(self.rng.integers(0, len(self.points)))]

    def pair(self, ground=0.4):
        """Two points of different bodies, or one and the ground (None)."""
        b, a = self.any(), self.any()
        same = bool((np.abs(b[0]) > 0)[np.abs(a[0]) > 0].any())
        return b, None if same or self.rng.random() < ground else a

    def add(self, kind, part, b, a, through=False):
        """A part between points; gives back its name and the row of its relative motion."""
        name = f"{kind}{len(self.parts)}"
        self.parts[name] = part
        self.kinds.append(type(part).__name__)
        self.joints.append((b[1], f"{name}.{'flange_a' if through else 'flange_b'}"))
        if a is not None:
            self.joints.append((a[1], f"{name}.flange_a"))
        return name, b[0] - (0.0 if a is None else a[0])

    # -- smooth parts ----------------------------------------------------------------------------

    def line(self, size, least=-1.0):
        """A number, a ramp, or a table with a jump."""
        kind = self.rng.integers(0, 3)
        if kind == 0:
            return steady(size * float(self.rng.uniform(max(least, -1.0) or 0.1, 1.0)))
        ts = np.sort(self.rng.uniform(0.05, END - 0.05, 3 + kind)).tolist()
        if kind == 2:
            ts[2] = ts[1]
        return Line(ts, (size * self.rng.uniform(least, 1.0, len(ts))).tolist())

    def torque(self, b):
        rng, line = self.rng, self.line(12.0)
        wave = (0.0, 0.0, 0.0)
        if rng.random() < 0.5:
            wave = float(rng.uniform(1, 10)), float(rng.uniform(3, 25)), float(rng.uniform(0, 6))
        self.loads.append(Load(b[0], line, *wave))
        tau = expression(line)
        if wave[0]:
            tau = tau + wave[0] * sin(wave[1] * lp.time + wave[2])
        name = f"load{len(self.parts)}"
        self.parts[name] = rotating.Torque(tau=tau) if self.turns else sliding.Force(f=tau)
        self.joints.append((b[1], f"{name}.flange"))

    def spring(self, b, a):
        family = rotating if self.turns else sliding
        c, d = float(self.rng.uniform(20, 400)), float(self.rng.uniform(0.1, 3))
        if a is None:
            self.parts["wall"] = family.Fixed()
            a = (np.zeros(self.n), "wall.flange")
        _, row = self.add("spring", family.SpringDamper(c=c, d=d), b, a)
        self.springs.append((row, c, d))

    # -- contacts --------------------------------------------------------------------------------

    def friction(self, b=None, a=None):
        rng = self.rng
        if b is None:
            b, a = self.pair()
        peak = float(rng.choice([1.0, 1.0, rng.uniform(1, 2)]))
        limit = float(rng.uniform(1, 8))
        if rng.random() < 0.3:  # constant, and rising with the speed
            rise, line = float(rng.uniform(0, 0.2)), steady(limit)
            rows = ((0.0, limit), (10.0, limit + 10 * rise))
            given = {"characteristic": rows, "peak": peak}
            force = {"f_max": 1.0, "u": 1.0} if a is not None else {}
        else:
            rise, line = 0.0, self.line(limit, least=float(rng.choice([0.0, 0.3])))
            given = {"characteristic": ((0.0, 1.0),), "peak": peak}
            force = {"f_max": 1.0, "u": expression(line)}
        family = rotating if self.turns else sliding
        if a is not None:
            part = (rotating.Clutch if self.turns else sliding.FrictionPair)(**given, **force)
        elif force:
            part = family.Brake(**given, **force)
        else:
            part = (rotating.BearingFriction if self.turns else sliding.SupportFriction)(**given)
        name, row = self.add("rub", part, b, a, through=a is None)
        self.contacts.append(Contact(name, "friction", row, line, rise, peak))

    def redundant(self):
        """Frictions that share a load: side by side, on both sides of a gear, or in a ring."""
        rng, n = self.rng, self.n
        if n > 1 and rng.random() < 0.4:
            i, j = rng.choice(n, 2, replace=False).tolist()
            self.friction(self.points[i], None)
            self.friction(self.points[j], None)
            self.friction(self.points[i], self.points[j])
            return
        b, a = self.pair(0.6)
        beside = [p for p in self.points if np.abs(p[0]) @ np.abs(b[0]) > 0]
        for _ in range(int(rng.integers(2, 4))):
            self.friction(beside[int(rng.integers(0, len(beside)))], a)

    def freewheel(self):
        b, a = self.pair(0.0)
        if a is None or not self.turns:
            return self.friction()
        level, peak = float(self.rng.choice([0.0, 0.0, self.rng.uniform(0.5, 3)])), 1.3
        part = rotating.OneWayClutch(u=level, f_max=1.0, characteristic=((0.0, 1.0),), peak=peak)
        name, row = self.add("wheel", part, b, a)
        self.contacts.append(Contact(name, "freewheel", row, steady(level), 0.0, peak))
        return None

    def restitution(self):
        return float(self.rng.choice([0.0, 0.0, 0.3, 0.6]))

    def play(self):
        b, a = self.pair(0.0)
        if a is None:
            return self.stop()
        gap, e = float(self.rng.uniform(0.01, 0.2)), self.restitution()
        family = rotating if self.turns else sliding
        name, row = self.add("play", family.Backlash(b=gap, restitution=e), b, a)
        for sign in (1.0, -1.0):
            self.contacts.append(Contact(name, "gap", sign * row, gap=gap / 2, e=e))
        return None

    def stop(self):
        (b, a), e = self.pair(), self.restitution()
        gap = float(self.rng.choice([0.0, self.rng.uniform(0.01, 0.3)]))
        least = {"phi_min" if self.turns else "s_min": -gap}
        family = rotating if self.turns else sliding
        name, row = self.add("stop", family.Stop(restitution=e, **least), b, a)
        self.contacts.append(Contact(name, "gap", row, gap=gap, e=e))

    def dog(self):
        b, a = self.pair(0.0)
        if a is None:
            return self.friction()
        on, off = np.sort(self.rng.uniform(0.05, END - 0.05, 2)).tolist()
        first = float(self.rng.integers(0, 2))
        # a jump has two rows for the reference, and one for the command
        line = Line((on, on, off, off), (first, 1 - first, 1 - first, first))
        command = switched(Line((0.0, on, off), (first, 1 - first, first)))
        family = rotating if self.turns else sliding
        name, row = self.add("dog", family.Coupling(u=command), b, a)
        self.contacts.append(Contact(name, "dog", row, line))
        return None

    # -- the two drives --------------------------------------------------------------------------

    def reference(self):
        springs, contacts = self.springs, self.contacts
        return Drive(self.total, np.zeros(self.n), self.v, springs, self.loads, contacts, END)

    def names(self):
        position, speed = ("phi", "w") if self.turns else ("s", "v")
        return [f"body{i}.{x}" for x in (position, speed) for i in range(self.n)]

    def model(self):
        return compose(self.parts, self.joints)
