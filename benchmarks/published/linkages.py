"""Pendulums and rows of four-bars as points and bars in a plane, closed by forces, index 3.

By hand they are written in angles, so that nothing is left to be closed. The references are runs of
these by SciPy's DOP853 at 1e-13; that of the double four-bar is A02 of IFToMM's library.
"""

import numpy as np

import lumped as lp
from benchmarks.published.problem import ByHand, Problem
from lumped.components import Bar
from lumped.components import translation as tr

FALL = 9.81


class Point(lp.Component):
    """A mass in a plane."""

    px = lp.LinearFlange(free=True)
    py = lp.LinearFlange(free=True)
    m: lp.Param = lp.param("kg", "", 1.0)
    x: lp.Var = lp.var("m", "")
    y: lp.Var = lp.var("m", "")
    u: lp.Var = lp.var("m/s", "")
    v: lp.Var = lp.var("m/s", "")

    def equations(self):
        yield self.px.s == self.x
        yield self.py.s == self.y
        yield self.u == lp.der(self.x)
        yield self.v == lp.der(self.y)
        yield self.m * lp.der(self.u) == self.px.f
        yield self.m * lp.der(self.v) == self.py.f - self.m * FALL


class Rod(lp.Component):
    """A rod without mass."""

    ax = lp.LinearFlange(grounded=True)
    ay = lp.LinearFlange(grounded=True)
    bx = lp.LinearFlange()
    by = lp.LinearFlange()
    force: lp.Var = lp.var("N/m", "")

    def equations(self):
        x, y = self.bx.s - self.ax.s, self.by.s - self.ay.s
        yield x**2 + y**2 == 1.0
        for flange, length, sign in ((self.bx, x, 1), (self.by, y, 1), (self.ax, x, -1)):
            yield flange.f == sign * self.force * length
        yield self.ay.f == -self.force * y


def chain(n, angle):
    """Pendulums of 1 m and 1 kg below each other, at rest at an angle to the vertical."""
    masses = [
        Point(x=(i + 1) * np.sin(angle), y=-(i + 1) * np.cos(angle), u=0.0, v=0.0) for i in range(n)
    ]

    def connections(m):
        for i in range(n):
            more = i + 1 < n
            yield lp.connect(m.rod[i].bx, m.mass[i].px, *[m.rod[j].ax for j in [i + 1] if more])
            yield lp.connect(m.rod[i].by, m.mass[i].py, *[m.rod[j].ay for j in [i + 1] if more])

    parts = {"mass": masses, "rod": [Rod() for _ in range(n)]}
    return lp.compose(connections=lambda m: list(connections(m)), **parts)


def chain_by_hand(n, angle):
    """The same in angles."""
    below = n - np.arange(n)
    weight = np.minimum.outer(below, below)

    def rate(_, z):
        a, w = z[:n], z[n:]
        gap = a[:, None] - a[None, :]
        torque = -(weight * np.sin(gap)) @ w**2 - FALL * below * np.sin(a)
        return np.concatenate([w, np.linalg.solve(weight * np.cos(gap), torque)])

    def read(z):
        return np.ravel([np.cumsum(np.sin(z[:n])), -np.cumsum(np.cos(z[:n]))], order="F")

    return ByHand(rate, [angle] * n + [0.0] * n, read)


class UniformBar(lp.Component):
    """A bar of 1 m and 1 kg, told by its ends."""

    ax = lp.LinearFlange()
    ay = lp.LinearFlange()
    bx = lp.LinearFlange()
    by = lp.LinearFlange()
    force: lp.Var = lp.var("N/m", "")

    def equations(self):
        def acceleration(flange):
            return lp.der(lp.der(flange.s))

        for a, b, fall in ((self.ax, self.bx, 0.0), (self.ay, self.by, FALL / 2)):
            pull = self.force * (b.s - a.s)
            yield a.f == (2 * acceleration(a) + acceleration(b)) / 6 + fall - pull
            yield b.f == (2 * acceleration(b) + acceleration(a)) / 6 + fall + pull
        yield (self.bx.s - self.ax.s) ** 2 + (self.by.s - self.ay.s) ** 2 == 1.0


def windows(n):
    """Rows of n four-bars of `UniformBar`, the upper corners at 1 m/s."""

    def connections(m):
        for i, corner in enumerate(m.corner):
            bars = [*m.over[i : i + 1]], [*m.over[i - 1 : i]] if i else []
            yield lp.connect(
                corner.px, m.up[i].bx, *[b.ax for b in bars[0]], *[b.bx for b in bars[1]]
            )
            yield lp.connect(
                corner.py, m.up[i].by, *[b.ay for b in bars[0]], *[b.by for b in bars[1]]
            )
            yield lp.connect(m.foot_x[i].flange, m.up[i].ax)
            yield lp.connect(m.foot_y[i].flange, m.up[i].ay)

    count = range(n + 1)
    return lp.compose(
        corner=[Corner(x=float(i), y=1.0, u=1.0, v=0.0) for i in count],
        foot_x=[tr.Fixed(s0=float(i)) for i in count],
        foot_y=[tr.Fixed() for _ in count],
        up=[UniformBar() for _ in count],
        over=[UniformBar() for _ in range(n)],
        connections=lambda m: list(connections(m)),
    )


class Corner(lp.Component):
    """A joint of bars, which declares where they are."""

    px = lp.LinearFlange(free=True)
    py = lp.LinearFlange(free=True)
    x: lp.Var = lp.var("m", "")
    y: lp.Var = lp.var("m", "")
    u: lp.Var = lp.var("m/s", "")
    v: lp.Var = lp.var("m/s", "")

    def equations(self):
        for flange, position, speed in ((self.px, self.x, self.u), (self.py, self.y, self.v)):
            yield flange.s == position
            yield speed == lp.der(position)
            yield flange.f == 0


def double_four_bar(w=0.0, g=0.0):
    """A02 of IFToMM: two windows of rigid bars of 1 m and 1 kg, told by their angles."""

    def connections(k):
        up = k.u0, k.u1, k.u2
        for i in range(3):
            yield lp.connect(k.gx[i].flange, up[i].a_x)
            yield lp.connect(k.gy[i].flange, up[i].a_y)
        for way in "xy":
            a, b = f"a_{way}", f"b_{way}"
            yield lp.connect(getattr(k.u0, b), getattr(k.o0, a))
            yield lp.connect(getattr(k.u1, b), getattr(k.o0, b), getattr(k.o1, a))
            yield lp.connect(getattr(k.u2, b), getattr(k.o1, b))

    bars = {name: Bar(length=1.0, m=1.0, J=1 / 12, g=g) for name in ("u1", "u2", "o0", "o1")}
    bars["u0"] = Bar(length=1.0, m=1.0, J=1 / 12, g=g, w=w)
    ground = {"gx": [tr.Fixed(s0=float(i)) for i in range(3)], "gy": [tr.Fixed() for _ in "abc"]}
    return lp.compose(connections=lambda k: list(connections(k)), **bars, **ground)


def windows_by_hand(n):
    """One angle: all uprights turn alike, the bars over them only move."""
    inertia, weight = (n + 1) / 3 + n, FALL * ((n + 1) / 2 + n)

    def rate(_, z):
        return np.array([z[1], -weight / inertia * np.cos(z[0])])

    return ByHand(rate, (np.pi / 2, -1.0), lambda z: (np.cos(z[0]), np.sin(z[0])))


def row(n, x, y):
    """A row of n four-bars."""
    end = {"corner[0].x": x, "corner[0].y": y}
    source = "IFToMM A02, in Cartesian ends" if n == 2 else "IFToMM, N-four-bar"
    return Problem(
        f"{n} four-bar{'s' * (n > 1)} in x and y",
        source,
        lambda: windows(n),
        10.0,
        end,
        windows_by_hand(n),
        digits=1e-11,
        largest=(1.0, 1.0),
    )


BY_BARS = windows_by_hand(2)
DOUBLE_FOUR_BAR = Problem(
    "double four-bar of rigid bars",
    "IFToMM A02",
    lambda: double_four_bar(w=-1.0, g=FALL),
    10.0,
    {"u0.phi": -30.179800860182763},
    BY_BARS._replace(read=lambda z: z[:1]),
    start={"u0.phi": np.pi / 2},
)
ONE = row(1, 0.4783850577540066, 0.878150178795003)
TWO = row(2, 0.328458111532841, 0.944518538181374)
TEN = row(10, 0.20435356098281773, 0.9788971458297556)


def pendulums(n, name, until, *places):
    """A chain that falls from the horizontal."""
    names = [f"mass[{i}].{way}" for i in range(n) for way in "xy"]
    return Problem(
        name,
        "in angles by DOP853",
        lambda: chain(n, np.pi / 2),
        until,
        dict(zip(names, places, strict=True)),
        chain_by_hand(n, np.pi / 2),
        digits=1e-11,
        largest=np.repeat(np.arange(1.0, n + 1), 2),
    )


PENDULUM = pendulums(1, "pendulum in x and y", 10.0, 0.275087462576417, -0.9614192050990392)
FOUR_PENDULUMS = pendulums(
    4,
    "four pendulums in x and y",
    0.8,
    *(0.3538862656440767, -0.9352884640518614, 0.715095978585046, -1.867773071580105),
    *(1.2200427566331284, -2.730923551704435, 2.148672321432604, -3.10193181492823),
)
