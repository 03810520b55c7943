"""Events whose instants are known in closed form, by all methods, in lanes and as exported units.

``python tests/known_events.py 30000`` draws cases until so many events were checked by each method
and prints how many were missed and invented, and the largest error of an instant over its
tolerance; with words behind the number only by these methods. Cases are narrow cams and pulses of
fast shafts, sines that pass a threshold by a thousandth beside an oscillator that allows long
steps, powers of a uniform motion, motions that almost touch or almost miss, and pulses of time that
are short against the run on stuck brakes and free inertias.

The tolerance of an instant is the error of the state, `RTOL` of its value, over the speed of the
margin; where the margin depends on the time alone, `ROUNDING`.
"""

import sys
import tempfile
import time
from collections import defaultdict
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from known_pulses import PULSES

import lumped as lp
from lumped import functionals as fun
from lumped.components import Brake, CamSwitch, Inertia, PulseTorque, Torque
from lumped.errors import LumpedError
from lumped.ops import cos, sin, where

RTOL, ROUNDING, END = 1e-8, 1e-11, 1.0
METHODS = ("auto", "explicit", "implicit", "taylor", "steps")


class Oscillator(lp.Component):
    """Slow enough for long steps, and never at rest."""

    x: lp.Var = lp.var("1", "place", 1.0)
    u: lp.Var = lp.var("1/s", "its rate", 0.0)

    def equations(self):
        yield lp.der(self.x) == self.u
        yield lp.der(self.u) == -self.x


class Cam(lp.Component):
    """A cam on a shaft that turns uniformly."""

    speed: lp.Param = lp.param("rad/s", "speed", 10.0)
    centre: lp.Param = lp.param("rad", "middle of the cam", 1.0)
    width: lp.Param = lp.param("rad", "width of the cam", 0.1, above=0)
    wheel: Inertia = Inertia(J=1.0, phi=0.0, w=speed)
    cam: CamSwitch = CamSwitch(centre=centre, width=width)

    def connections(self):
        yield lp.connect(self.wheel.flange_a, self.cam.flange)


class Pulse(lp.Component):
    """A shaft that is pushed by the same torque in a part of each turn."""

    speed: lp.Param = lp.param("rad/s", "speed", 10.0)
    centre: lp.Param = lp.param("rad", "middle of the pulse", 1.0)
    width: lp.Param = lp.param("rad", "width of the pulse", 0.1, above=0)
    tau: lp.Param = lp.param("N.m", "torque of the pulse", 1.0)
    wheel: Inertia = Inertia(J=10.0, phi=0.0, w=speed)
    cam: PulseTorque = PulseTorque(tau_max=tau, centre=centre, width=width, shape="rectangle")

    def connections(self):
        yield lp.connect(self.wheel.flange_a, self.cam.flange)


class Moved(Oscillator):
    """A uniform motion ``phi = speed time``, watched."""

    speed: lp.Param = lp.param("1/s", "speed", 1.0)
    a: lp.Param = lp.param("1", "place of the event", 0.5)
    size: lp.Param = lp.param("1", "size of the margin", 1.0)
    phi: lp.Var = lp.var("1", "place", 0.0)
    y: lp.Var = lp.var("1", "1 where the condition holds")

    def equations(self):
        yield from super().equations()
        yield lp.der(self.phi) == self.speed
        yield self.y == where(self.condition(self.phi - self.a), 1.0, 0.0)


class Sine(Moved):
    def condition(self, x):
        return sin(x) > self.size


class Cube(Moved):
    def condition(self, x):
        return self.size * x**3 > 0


class Fifth(Moved):
    def condition(self, x):
        return self.size * x**5 > 0


class Square(Moved):
    def condition(self, x):
        return x**2 < self.size


class Cosine(Moved):
    def condition(self, x):
        return 1 - cos(x) < self.size


def shoved(shape):
    """Models of an inertia under a pulse of torque, without a brake and with one of 10 N.m."""

    class Free(lp.Component):
        t0: lp.Param = lp.param("s", "middle of the pulse", 0.5)
        length: lp.Param = lp.param("s", "length of the pulse", 1e-5, above=0)
        most: lp.Param = lp.param("N.m", "torque of the pulse", 20.0)
        body: Inertia = Inertia(J=1.0, phi=0.0, w=0.0)
        push: Torque = Torque(tau=most * shape.law((lp.time - t0) / length))

        def connections(self):
            yield lp.connect(self.body.flange_a, self.push.flange)

    class Braked(Free):
        brake: Brake = Brake(f_max=20.0, u=1.0)

        def connections(self):
            yield from super().connections()
            yield lp.connect(self.body.flange_a, self.brake.flange_a)

    return Free, Braked


# -- what is known ---------------------------------------------------------------------------------


@dataclass
class Known:
    """Parameters; instants and their tolerances; the last speed and its tolerance, if asked."""

    parameters: dict
    times: np.ndarray
    allowed: np.ndarray
    speed: tuple[float, float] | None = None


def turning(rng):
    """Speed, centre and width of a cam: 1 to 3000 rad/s, 0.1 to 5 degrees."""
    speed, width = 10 ** rng.uniform(0, 3.477), np.radians(10 ** rng.uniform(-1, 0.7))
    return float(speed), float(rng.uniform(0.2, 6.0)), float(width)


def cam(rng):
    speed, centre, width = turning(rng)
    turns = 2 * np.pi * np.arange(-1, speed * END / 2 / np.pi + 1)
    times = (centre + np.add.outer(turns, [-width / 2, width / 2])).ravel() / speed
    return {"speed": speed, "centre": centre, "width": width}, times, RTOL * times


def pulse(rng):
    """Energy grows by ``tau width`` in each turn; half of the pulses drive."""
    speed, centre, width = turning(rng)
    tau = float(rng.choice([-1, 1]) * 10 * speed**2 * rng.uniform(0.02, 0.2) / width / 500)
    tau = max(tau, -0.3 * 10 * speed**2 / (2 * width * (2 + speed * END / 6)))
    t, v, angle, times = 0.0, speed, 0.0, []
    edge = centre - width / 2
    while t < 1.2 * END:
        t += (edge - angle) / v
        after = np.sqrt(v * v + 2 * tau * width / 10)
        times += [t, t + 2 * width / (v + after)]
        t, v, angle, edge = times[-1], after, edge + width, edge + 2 * np.pi
    times = np.array(times)
    return {"speed": speed, "centre": centre, "width": width, "tau": tau}, times, RTOL * times


def sine(rng):
    """It passes the threshold by a thousandth, or stays a thousandth below it."""
    speed, a = float(10 ** rng.uniform(0, 3)), float(rng.uniform(0, 6))
    size = 1 + float(rng.choice([-1e-3, 1e-3]))
    turns = 2 * np.pi * np.arange(-2, speed * END / 2 / np.pi + 1)
    half = np.arccos(size) if size < 1 else np.nan
    times = (a + np.pi / 2 + np.add.outer(turns, [-half, half])).ravel() / speed
    times = times[np.isfinite(times)]
    return {"speed": speed, "a": a, "size": size}, times, RTOL * np.abs(times)


def power(rng):
    speed = float(10 ** rng.uniform(-1, 3))
    a = float(rng.uniform(0.05, 0.95)) * speed
    given = {"speed": speed, "a": a, "size": float(10 ** rng.uniform(-2, 2) * rng.choice([-1, 1]))}
    return given, np.array([a / speed]), RTOL * np.array([a / speed])


def touch(rng, half=np.sqrt):
    """Two instants close to each other, or none: it misses by as little."""
    speed = float(10 ** rng.uniform(-0.5, 1.5))
    a = float(rng.uniform(0.05, 0.95)) * speed
    size = float(10 ** rng.uniform(-12, -6) * rng.choice([-1, 1]))
    times = (a + half(size) * np.array([-1, 1])) / speed if size > 0 else np.zeros(0)
    return {"speed": speed, "a": a, "size": size}, times, RTOL * times


def arc(size):
    """Angle whose cosine is short of one by a small size."""
    return 2 * np.arcsin(np.sqrt(size / 2))


def shove(rng):
    length = float(10 ** rng.uniform(-5, -3))
    most = float(10 * 10 ** rng.uniform(0.1, 2))
    return {"t0": float(rng.uniform(0.1, 0.6)), "length": length, "most": most}


def braked(shape):
    def draw(rng):
        """It lets go at its limit, and sticks when its momentum is used up."""
        given = shove(rng)
        begin = -shape.reached(given["most"] / 10)
        end = shape.stops(given["most"] / 10, begin)
        times = given["t0"] + given["length"] * np.array([begin, end])
        fastest = given["most"] * given["length"] * shape.whole
        return given, times, np.array([ROUNDING, ROUNDING + RTOL * fastest / 10])

    return draw


def free(shape):
    def draw(rng):
        given = shove(rng)
        ends = (np.array([0.0, END]) - given["t0"]) / given["length"]
        speed = given["most"] * given["length"] * (shape.area(ends[1]) - shape.area(ends[0]))
        return given, np.zeros(0), np.zeros(0), (float(speed), RTOL * abs(float(speed)))

    return draw


@dataclass
class Family:
    """Cases of one model."""

    name: str
    model: type
    draw: object
    component: str
    output: str
    unit: Path | None = None
    options: dict = field(default_factory=dict)

    @cached_property
    def system(self):
        keep = [self.output] if self.component != "body" else ["body.w"]
        return lp.assemble(self.model(), keep=keep)

    def case(self, rng):
        """A case without events close to the begin and the end of the run."""
        while True:
            known = Known(*self.draw(rng))
            ends = np.abs(np.subtract.outer(known.times, [0.0, END])).min(initial=1.0)
            if ends > 1e-7 + 100 * known.allowed.max(initial=0.0):
                inside = (known.times > 0) & (known.times < END)
                known.times, known.allowed = known.times[inside], known.allowed[inside]
                return known


def families():
    found = [
        Family("cams", Cam, cam, "cam", "cam.y"),
        Family("pulses of a shaft", Pulse, pulse, "cam", "cam.tau"),
        Family("sines", Sine, sine, "", "y"),
        Family("x**3", Cube, power, "", "y"),
        Family("x**5", Fifth, power, "", "y"),
        Family("touches of a square", Square, touch, "", "y"),
        Family("touches of a cosine", Cosine, lambda rng: touch(rng, arc), "", "y"),
    ]
    for shape in PULSES:
        name, (body, brake) = type(shape).__name__, shoved(shape)
        found += [
            Family(f"{name} on a brake", brake, braked(shape), "brake", "brake.mode"),
            Family(f"{name} on a body", body, free(shape), "body", "body.w"),
        ]
    return found


# -- what is computed ------------------------------------------------------------------------------


@dataclass
class Count:
    """What was checked, and how it went."""

    cases: int = 0
    events: int = 0
    missed: int = 0
    invented: int = 0
    refused: int = 0
    worst: float = 0.0

    def compare(self, known, received):
        """Compare instants in their order."""
        self.cases += 1
        self.events += len(known.times)
        received, i, j = np.sort(received), 0, 0
        gaps = np.diff(known.times, prepend=-1.0, append=END + 1.0)
        nearest = np.minimum(gaps[:-1], gaps[1:])
        window = np.maximum(10 * known.allowed, np.minimum(1e5 * known.allowed, nearest / 2))
        while i < len(known.times) or j < len(received):
            late = np.inf if j == len(received) else received[j]
            due, room = (known.times[i], window[i]) if i < len(known.times) else (np.inf, 0.0)
            if abs(late - due) <= room:
                self.worst = max(self.worst, abs(late - due) / known.allowed[i])
                i, j = i + 1, j + 1
            elif due < late:
                self.missed, i = self.missed + 1, i + 1
            else:
                self.invented, j = self.invented + 1, j + 1

    def weigh(self, known, speed):
        """Compare the last speed: a pulse that was not noticed leaves none."""
        self.cases, self.events = self.cases + 1, self.events + 1
        due, allowed = known.speed
        if abs(speed - due) > 1e-3 * abs(due):
            self.missed += 1
        else:
            self.worst = max(self.worst, abs(speed - due) / allowed)


def by_runs(family, cases, method, count):
    for known in cases:
        options = {"until": END, "parameters": known.parameters, "rtol": RTOL, "grid": [END]}
        try:
            run = lp.simulate(family.system, method=method, **options)
        except LumpedError:
            count.refused += 1
            continue
        if known.speed:
            count.weigh(known, run["body.w"][-1])
        else:
            mine = [
                e.time
                for e in run.events
                if e.component == family.component or not family.component
            ]
            count.compare(known, mine)


def in_lanes(family, cases, count):
    """Counts and instants by functionals: the first and last eight."""
    over = lp.ensembles.paired({n: [k.parameters[n] for k in cases] for n in cases[0].parameters})
    if cases[0].speed:
        found = lp.ensemble(
            family.system, over=over, until=END, rtol=RTOL, of={"w": fun.final("body.w")}
        )
        for known, speed in zip(cases, found["w"], strict=True):
            count.weigh(known, speed)
        return
    name = family.component or family.system.name
    numbers = [*range(8), *range(-8, 0)]
    of = {f"{k}": fun.instant(name, number=k) for k in numbers} | {"n": fun.count(name)}
    found = lp.ensemble(family.system, over=over, until=END, rtol=RTOL, of=of)
    for i, known in enumerate(cases):
        n = int(np.nan_to_num(found["n"][i]))
        places = sorted({k % n for k in numbers if -n <= k < n}) if n else []
        seen = {k % n: found[f"{k}"][i] for k in numbers if n and -n <= k < n}
        count.missed += max(len(known.times) - n, 0)
        count.invented += max(n - len(known.times), 0)
        count.cases, count.events = count.cases + 1, count.events + len(known.times)
        if n == len(known.times):
            inner = Known({}, known.times[places], known.allowed[places])
            events, cases_ = count.events, count.cases
            count.compare(inner, np.array([seen[k] for k in places]))
            count.events, count.cases = events, cases_


def as_units(family, cases, count):
    """Changes of the output of an exported unit, in FMPy's event mode."""
    import fmpy

    if family.unit is None:
        family.unit = Path(tempfile.mkdtemp()) / "known.fmu"
        lp.export_fmu(family.system, family.unit, outputs=[family.output], rtol=RTOL)
    for known in cases:
        found = fmpy.simulate_fmu(
            str(family.unit),
            start_values=known.parameters,
            stop_time=END,
            output_interval=END,
            output=[family.output],
            fmi_type="CoSimulation",
            record_events=True,
            use_event_mode=True,
            early_return_allowed=True,
        )
        t, y = found["time"], found[family.output]
        if known.speed:
            count.weigh(known, y[-1])
        else:
            jumps = (np.diff(t) < 1e-12) & (np.diff(y) != 0)
            count.compare(known, t[1:][jumps])


def main(arguments):
    number = next(int(a) for a in arguments if a.isdigit())
    words = [a for a in arguments if not a.isdigit()] or [*METHODS, "lanes", "units"]
    all_of_them = families()
    for method in words:
        rng, counts = np.random.default_rng(5), defaultdict(Count)
        begun = time.perf_counter()
        while sum(c.events for c in counts.values()) < number:
            for family in all_of_them:
                cases = [family.case(rng) for _ in range(16)]
                count = counts[family.name]
                if method == "lanes":
                    in_lanes(family, cases, count)
                elif method == "units":
                    as_units(family, cases, count)
                else:
                    by_runs(family, cases, method, count)
        print(f"{method}, {time.perf_counter() - begun:.0f} s")
        for name, c in counts.items():
            print(
                f"    {name:24s} {c.cases:5d} cases {c.events:7d} events: {c.missed} missed, "
                f"{c.invented} invented, {c.refused} refused, error {c.worst:.1e} tolerances",
                flush=True,
            )


if __name__ == "__main__":
    main(sys.argv[1:])
