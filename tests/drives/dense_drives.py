"""Random drives of few bodies with many contacts between them, for `lumped` and for a reference."""

from dataclasses import replace

import numpy as np
from hybrid_drives import END, RandomDrive, compose
from hybrid_parts import Contact, Line, steady
from pressed_reference import Pressed, PressedDrive

import lumped as lp
from lumped import components as rotating


class InstantDrive(RandomDrive):
    """Few bodies with many contacts between them; torques are constants, sines and steps."""

    turning = 0.9

    def __init__(self, seed):
        rng = self.rng = np.random.default_rng((11, seed))
        self.parts, self.joints, self.kinds = {}, [], []
        self.loads, self.springs, self.contacts = [], [], []
        self.turns = rng.random() < self.turning
        self.n = n = int(rng.integers(2, 6))
        self.J, self.v = rng.uniform(0.3, 2.0, n), np.zeros(n)
        if rng.random() < 0.6:
            self.v = rng.normal(size=n).round(2) * 2
        self.total, self.points = self.J.copy(), [self.point(i) for i in range(n)]
        for i in range(n):
            if self.turns and rng.random() < 0.15:
                self.points.append(self.geared(i))
        for i in range(1, n):
            if rng.random() < 0.4:
                self.spring(self.points[i], self.points[int(rng.integers(0, i))])
        if rng.random() < 0.5:
            self.spring(self.any(), None)
        for i in range(n):
            if rng.random() < 0.8 or i == 0:
                self.torque(self.points[i])
        kinds = ["freewheel", "facing", "friction", "redundant", "play", "stop", "dog"]
        odds = [0.3, 0.1, 0.15, 0.1, 0.2, 0.1, 0.05] if self.turns else [0, 0, 3, 2, 3, 1, 1]
        for _ in range(int(rng.integers(2, 6))):
            if len(self.contacts) < 6:
                getattr(self, str(rng.choice(kinds, p=np.divide(odds, sum(odds)))))()

    def line(self, size, least=-1.0):
        rng = self.rng
        values = size * rng.uniform(least, 1.0, 2)
        if rng.random() < 0.7:
            return steady(float(values[0]) or size)
        at = float(rng.uniform(0.05, END - 0.05))
        return Line((at, at), values.tolist())

    def pair(self, ground=0.4):
        """Neighbours, mostly: contacts then lie side by side."""
        if self.rng.random() < 0.3:
            return super().pair(ground)
        i = int(self.rng.integers(0, self.n - 1))
        ends = [self.points[i], self.points[i + 1]]
        if self.rng.random() < 0.5:
            ends.reverse()
        return ends[0], None if self.rng.random() < ground else ends[1]

    def facing(self):
        """Two freewheels between the same bodies, of opposite directions."""
        b, a = self.pair(0.0)
        if a is None:
            return self.freewheel()
        for front, back in ((b, a), (a, b)):
            part = rotating.OneWayClutch(u=0.0)
            name, row = self.add("wheel", part, front, back)
            self.contacts.append(Contact(name, "freewheel", row))
        return None

    def model(self, backwards=False):
        """The model; `backwards` declares its parts and connections in the other order."""
        turn = -1 if backwards else 1
        parts = dict(list(self.parts.items())[::turn])
        return compose(parts, [joint[::turn] for joint in self.joints[::turn]])


class RoughStop(lp.Component):
    """Stop of one shaft that presses a friction on another: ``|tau| <= mu |tau_n|``."""

    normal = lp.Flange()
    sliding = lp.Flange()
    phi_min: lp.Param = lp.param("rad", "least angle", 0.0)
    restitution: lp.Param = lp.param("1", "speed after an impact over that before", 0.0)
    mu: lp.Param = lp.param("1", "friction torque over that of the stop", 0.3, min=0)
    gap: lp.Var = lp.var("rad", "angle to the stop", state="prefer")
    w_n: lp.Var = lp.var("rad/s", "speed away from the stop", state="prefer")
    w: lp.Var = lp.var("rad/s", "sliding speed", state="prefer")
    tau_n: lp.Var = lp.var("N.m", "torque of the stop")
    tau: lp.Var = lp.var("N.m", "torque of the friction")

    def equations(self):
        yield self.gap == self.normal.phi - self.phi_min
        yield self.w_n == lp.der(self.gap)
        yield self.w == lp.der(self.sliding.phi)
        yield self.normal.tau == self.tau_n
        yield self.sliding.tau == self.tau
        yield lp.hold(self.tau_n, self.w_n, gap=self.gap, restitution=self.restitution)
        most = -self.mu * self.tau_n
        yield lp.hold(self.tau, self.w, forward=most, backward=-most, upper=most, lower=-most)


class RoughDrive(InstantDrive):
    """An instant drive without bounces, and a body that bounces on a rough stop."""

    turning = 1.0

    def __init__(self, seed):
        super().__init__(seed)
        rng, anvil = self.rng, self.n

        def wider(row):
            return np.append(row, 0.0)

        self.springs = [(wider(row), c, d) for row, c, d in self.springs]
        self.loads = [replace(p, row=wider(p.row)) for p in self.loads]
        self.contacts = [replace(c, row=wider(c.row)) for c in self.contacts]
        self.points = [(wider(row), name) for row, name in self.points]
        self.J = np.append(self.J, rng.uniform(0.3, 2.0))
        self.v, self.total = wider(self.v), np.append(self.total, self.J[-1])
        self.n += 1
        body = self.point(anvil)
        self.torque(body)
        self.spring(body, self.any() if rng.random() < 0.5 else None)
        gap, e, mu = (float(x) for x in rng.uniform([0.0, 0.0, 0.1], [0.1, 0.6, 1.5]))
        e *= float(rng.random() < 0.5)
        under, by = self.any(), len(self.contacts)
        name = f"rough{len(self.parts)}"
        self.parts[name] = RoughStop(phi_min=-gap, restitution=e, mu=mu)
        self.kinds.append("RoughStop")
        self.joints += [(body[1], f"{name}.normal"), (under[1], f"{name}.sliding")]
        self.contacts.append(Contact(name, "gap", body[0], gap=gap, e=e))
        self.contacts.append(Contact(name, "friction", under[0], Pressed(mu, by, anvil)))

    def restitution(self):
        return 0.0 * super().restitution()

    def reference(self):
        springs, contacts = self.springs, self.contacts
        return PressedDrive(
            self.total, np.zeros(self.n), self.v, springs, self.loads, contacts, END
        )
