"""Friction oscillators of Siconos and code_aster, with their exact solutions."""

from collections.abc import Callable, Mapping
from math import atan2, cos, pi, sin, sqrt
from typing import NamedTuple

import lumped as lp
from lumped.components import translation as tr


class Oscillator(NamedTuple):
    """A run with friction, exact values at times, and exact instants of changes.

    `theirs` is the error of the reference of the code that it comes from, relative as ours.
    """

    name: str
    source: str
    model: Callable[[], lp.Component]
    until: float
    values: Mapping[tuple[str, float], float]
    instants: tuple[float, ...]
    theirs: float | None = None

    def simulate(self, system: lp.System, rtol: float) -> lp.Trajectory:
        """Run by lumped."""
        grid = sorted({0.0, self.until, *(t for _, t in self.values)})
        return lp.simulate(system, until=self.until, rtol=rtol, grid=grid)

    def error(self, run: lp.Trajectory) -> float:
        """Largest relative error of values and of the instants at which the friction changes."""
        off = [abs(run.point(t)[name] / exact - 1.0) for (name, t), exact in self.values.items()]
        times = [event.time for event in run.events]
        return max(off + [min(abs(t / exact - 1.0) for t in times) for exact in self.instants])


def on_a_spring(m, c, friction, s, v=0.0):
    """A mass on a spring, rubbing on the ground."""
    return lp.compose(
        mass=tr.Mass(m=m, s=s, v=v),
        spring=tr.Spring(c=c),
        rubbing=tr.SupportFriction(characteristic=((0.0, friction),)),
        ground=tr.Fixed(),
        connections=lambda k: [
            lp.connect(k.ground.flange, k.spring.flange_a),
            lp.connect(k.spring.flange_b, k.mass.flange_a),
            lp.connect(k.mass.flange_b, k.rubbing.flange_a),
        ],
    )


def turning_points(first, start, shift, w):
    """Instants and places of the turns of such a mass, until friction holds it."""
    t, x = first, start
    points = [(t, x)]
    while abs(x) > shift:
        t, x = t + pi / w, (1 if x < 0 else -1) * (abs(x) - 2 * shift)
        points.append((t, x))
    return points


def two_masses():
    """One of two masses rubs, the other is pushed until 0.2 s."""
    return lp.compose(
        one=tr.Mass(m=5.0),
        two=tr.Mass(m=5.0),
        spring=tr.Spring(c=1e4),
        rubbing=tr.SupportFriction(characteristic=((0.0, 2000.0),), peak=1.5),
        push=tr.Force(f=lp.ops.where(lp.time < 0.2, 3000.0, 0.0)),
        connections=lambda k: [
            lp.connect(k.rubbing.flange_b, k.one.flange_a),
            lp.connect(k.one.flange_b, k.spring.flange_a),
            lp.connect(k.spring.flange_b, k.two.flange_a),
            lp.connect(k.two.flange_b, k.push.flange),
        ],
    )


def slide(x1, v1, x2, v2, force, t):
    """Places and speeds of the two masses some time later, while the first slides forward."""
    mean, speed, fall = (x1 + x2) / 2, (v1 + v2) / 2, (force - 2000.0) / 10.0
    apart, rest, w = x2 - x1, (force + 2000.0) / 2e4, sqrt(4e3)
    z = rest + (apart - rest) * cos(w * t) + (v2 - v1) / w * sin(w * t)
    zd = (v2 - v1) * cos(w * t) - (apart - rest) * w * sin(w * t)
    x, v = mean + speed * t + fall * t**2 / 2, speed + fall * t
    return x - z / 2, v - zd / 2, x + z / 2, v + zd / 2


LOOSE, STUCK = pi / 2 / sqrt(2000.0), 0.3149232754474866
PUSHED = slide(0.0, 0.0, 0.3, 0.3 * sqrt(2000.0), 3000.0, 0.2 - LOOSE)
FREED = slide(*PUSHED, 0.0, STUCK - 0.2)
NAMES = ("one.s", "one.v", "two.s", "two.v")

SICONOS = turning_points(atan2(6, 13), sqrt(205) - 1, 1.0, 1.0)
ASTER = turning_points(0.0, 0.85e-3, 1e-4, 100.0)

OSCILLATORS = (
    Oscillator(
        "friction oscillator",
        "Siconos tutorials b6c9bfd1",
        lambda: on_a_spring(1.0, 1.0, 1.0, 12.0, 6.0),
        25.0,
        {("mass.s", 25.0): SICONOS[-1][1]},
        (SICONOS[-1][0],),
        theirs=abs(0.6820441351954105 / 0.6821789367236466 - 1),
    ),
    Oscillator(
        "friction pad",
        "code_aster SDND100",
        lambda: on_a_spring(1.0, 1e4, 1.0, 0.85e-3),
        0.2,
        {("mass.s", 0.2): ASTER[-1][1]} | {("mass.s", t): x for t, x in ASTER[1:]},
        (ASTER[-1][0],),
    ),
    Oscillator(
        "static and kinetic friction",
        "code_aster SDND106",
        two_masses,
        0.33,
        dict(zip([(name, 0.2) for name in NAMES], PUSHED, strict=True))
        | {("one.s", 0.33): FREED[0], ("two.s", STUCK): FREED[2], ("two.v", STUCK): FREED[3]},
        (LOOSE, STUCK),
    ),
)
"""Springs and friction make runs of pieces in closed form: places at the turns and at rest."""
