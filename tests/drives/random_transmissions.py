"""Random signals, commands and transmissions with the values that a reference computes."""

import math

import numpy as np
from drive_reference import Signal

import lumped as lp
from lumped.components import (
    CrankSlider,
    EllipticalGear,
    IdealGear,
    Inertia,
    NonCircularGear,
    RackAndPinion,
    translation,
)
from lumped.ops import cos, interpolate, maximum, minimum, sign, sin, table, where

END = 1.5
"""End of a run, s."""


class RowSpring(lp.Component):
    """Spring with a characteristic of rows, and a damper."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    rows: tuple = ()
    d: lp.Param = lp.param("N.m.s/rad", "damping")
    phi_rel: lp.Var = lp.var("rad", "twist")
    tau: lp.Var = lp.var("N.m", "torque on b")

    def equations(self):
        yield self.phi_rel == self.flange_b.phi - self.flange_a.phi
        spring = interpolate(self.phi_rel, *zip(*self.rows, strict=True))
        yield self.tau == spring + self.d * lp.der(self.phi_rel)
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau


def rows_at(x, rows):
    """Straight lines through points, the first and last extended."""
    i = 1
    while i < len(rows) - 1 and x > rows[i][0]:
        i += 1
    (x_a, y_a), (x_b, y_b) = rows[i - 1], rows[i]
    return y_a + (y_b - y_a) / (x_b - x_a) * (x - x_a)


def crossings(w, p, level, end):
    """Instants at which ``sin(w t + p) == level``."""
    first = np.arcsin(level)
    turns = 2 * np.pi * np.arange(-2, int(w * end / 6) + 3)
    t = np.concatenate([first + turns, np.pi - first + turns])
    t = (t - p) / w
    return sorted(t[(t > 0) & (t < end)].tolist())


STEADY = ("constant", "table", "where", "corner")


WAVES = ("sine", "limited", "abs", "sign")


def signal(rng, size, kinds=(*STEADY, *WAVES)):
    """A random torque (speed, command) over the time, of about `size`."""
    kind = rng.choice(kinds)
    t, a, b = lp.time, size * rng.normal(), size * rng.normal()
    w, p = rng.uniform(3, 30), rng.uniform(0, 6)
    wave = Signal(lambda t, _: a * math.sin(w * t + p))
    if kind == "constant":
        return a, Signal(lambda t, _: a)
    if kind == "sine":
        return a * sin(w * t + p) + b, Signal(lambda t, m: wave.value(t, m) + b)
    if kind == "table":
        ts = np.sort(rng.uniform(0, END, 4)).tolist()
        ts.insert(2, ts[1])  # a jump
        ys = (size * rng.normal(size=5)).tolist()

        def rows(t, m):
            i = int(np.searchsorted(ts, m))
            if i in (0, 5):
                return ys[0] if i == 0 else ys[-1]
            return ys[i - 1] + (ys[i] - ys[i - 1]) * (t - ts[i - 1]) / (ts[i] - ts[i - 1])

        return table(ts, ys), Signal(rows, ts)
    if kind == "where":
        one, two = np.sort(rng.uniform(0, END, 2)).tolist()
        made = where(t < one, a, where(t < two, b, a * t))
        return made, Signal(lambda t, m: a if m < one else b if m < two else a * t, (one, two))
    if kind == "corner":
        return corner(rng, a, b)
    level = rng.uniform(-0.8, 0.8)
    if kind == "limited":
        top, low = abs(level), -abs(level) * rng.uniform(0.3, 1)
        made = a * minimum(maximum(sin(w * t + p), low), top)
        breaks = crossings(w, p, top, END) + crossings(w, p, low, END)
        return made, Signal(lambda t, m: a * min(max(math.sin(w * t + p), low), top), breaks)
    breaks = crossings(w, p, level, END)
    if kind == "abs":
        made = a * abs(sin(w * t + p) - level) + b
        return made, Signal(lambda t, m: a * abs(math.sin(w * t + p) - level) + b, breaks)
    made = a * sign(sin(w * t + p) - level)
    return made, Signal(lambda t, m: math.copysign(a, a * (math.sin(w * m + p) - level)), breaks)


def corner(rng, a, b):
    """A function of the time alone with a kink or a jump that is no `where`."""
    t, at = lp.time, float(rng.uniform(0.1, END - 0.1))
    kind = rng.choice(["abs", "minimum", "maximum", "sign", "interpolate"])
    if kind == "abs":
        return a + b * abs(t - at), Signal(lambda t, m: a + b * abs(t - at), (at,))
    if kind == "minimum":
        return a + b * minimum(t, at), Signal(lambda t, m: a + b * min(t, at), (at,))
    if kind == "maximum":
        return a + b * maximum(at, t), Signal(lambda t, m: a + b * max(t, at), (at,))
    if kind == "sign":
        return a + b * sign(t - at), Signal(lambda t, m: a + math.copysign(b, b * (m - at)), (at,))
    ts, ys = (0.1, at + 0.1, at + 0.2), (a, b, -a)
    rows = tuple(zip(ts, ys, strict=True))
    return interpolate(t, ts, ys), Signal(lambda t, m: rows_at(t, rows), ts)


def command(rng):
    """A switched command between 0 and 1."""
    on, off = np.sort(rng.uniform(0.05, END - 0.05, 2)).tolist()
    first = float(rng.integers(0, 2))
    made = where(lp.time < on, first, where(lp.time < off, 1 - first, first))
    return made, Signal(lambda t, m: 1 - first if on < m < off else first, (on, off))


def ramped(rng):
    """A command that rises and falls along a table."""
    t = np.sort(rng.uniform(0.05, END - 0.05, 4)).tolist()
    y = [float(rng.choice([0.0, 0.3])), 1.0, 1.0, 0.2]
    return table(t, y), Signal(lambda now, _: float(np.interp(now, t, y)), t)


def transmission(rng, linear):
    """Part, its second body, that body's inertia, and the motion of that body by the angle."""
    kinds = ["none", "gear", "rack", "crank", "ellipse", "table"]
    kind = rng.choice(kinds[:3] if linear else kinds)
    J = float(rng.uniform(0.1, 1.0))
    if kind == "gear":
        i = float(rng.choice([-1, 1]) * rng.uniform(0.5, 3))
        return IdealGear(ratio=i), Inertia(J=J), J, lambda q: (q / i, 1 / i, 0.0)
    if kind == "rack":
        radius = float(rng.uniform(0.2, 0.6))
        part, body = RackAndPinion(radius=radius), translation.Mass(m=3 * J)
        return part, body, 3 * J, lambda q: (radius * q, radius, 0.0)
    if kind == "crank":
        r, e = float(rng.uniform(0.1, 0.4)), float(rng.uniform(-0.1, 0.1))
        L = (r + abs(e)) * float(rng.uniform(1.5, 4))

        def crank(q):
            s, c = math.sin(q), math.cos(q)
            rise, drise, ddrise = e - r * s, -r * c, r * s
            run = math.sqrt(L**2 - rise**2)
            drun = -rise * drise / run
            ddrun = -(drise**2 + rise * ddrise + drun**2) / run
            return r * c + run, -r * s + drun, -r * c + ddrun

        part, body = CrankSlider(r=r, e=e, L=L), translation.Mass(m=5 * J)
        return part, body, 5 * J, crank
    if kind == "ellipse":
        e, phase = float(rng.uniform(0.1, 0.5)), float(rng.uniform(0, 6))

        def ellipse(q):
            x = q - phase
            below = 1 + e**2 - 2 * e * math.cos(x)
            slope = (1 - e**2) / below
            lead = 2 * math.atan2(e * math.sin(x), 1 - e * math.cos(x))
            lead += 2 * math.atan2(e * math.sin(phase), 1 - e * math.cos(phase))
            return -(q + lead), -slope, slope * 2 * e * math.sin(x) / below

        return EllipticalGear(e=e, phase=phase), Inertia(J=J), J, ellipse
    if kind == "table":
        h, k = float(rng.uniform(0.02, 0.2)), int(rng.integers(1, 4))
        part = NonCircularGear(transmission=lambda x: -(x + h * (1 - cos(k * x))))
        return (
            part,
            Inertia(J=J),
            J,
            lambda q: (
                -(q + h * (1 - math.cos(k * q))),
                -(1 + h * k * math.sin(k * q)),
                -h * k**2 * math.cos(k * q),
            ),
        )
    return None, None, 0.0, lambda q: (q, 1.0, 0.0)
