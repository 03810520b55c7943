"""Cases of events whose instants are known in closed form: models, and what happens in them.

The tolerance of an instant is the error of the state, `RTOL` of its value, over the speed of the
margin; where the margin depends on the time alone, `ROUNDING`.
"""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.optimize import brentq
from scipy.special import erf

import lumped as lp
from lumped.components import Brake, CamSwitch, Inertia, PulseTorque, Torque
from lumped.ops import cos, exp, interpolate, sin, tanh, where

RTOL, ROUNDING, END = 1e-8, 1e-11, 1.0


# -- pulses of time and models ---------------------------------------------------------------------


class Shape:
    """A pulse of height one; `u` is the time from its middle over its length.

    `law` is the expression of `lumped`, `area` the integral from the far left, `whole` all of it,
    `reached` the distance from its middle at which the pulse is so many times as low.
    """

    def stops(self, times, begin):
        """When what it moves from `begin` on, against a friction so many times as low, stops."""

        def momentum(u):
            return times * (self.area(u) - self.area(begin)) - (u - begin)

        return brentq(momentum, -begin, -begin + times * self.whole + 1, xtol=1e-14, rtol=1e-14)


class Gaussian(Shape):
    whole = np.sqrt(np.pi)

    def law(self, u):
        return exp(-(u**2))

    def area(self, u):
        return np.sqrt(np.pi) / 2 * (1 + erf(u))

    def reached(self, times):
        return np.sqrt(np.log(times))


class Lorentzian(Shape):
    whole = np.pi

    def law(self, u):
        return 1 / (1 + u**2)

    def area(self, u):
        return np.pi / 2 + np.arctan(u)

    def reached(self, times):
        return np.sqrt(times - 1)


class Triangle(Shape):
    whole = 1.0

    def law(self, u):
        return interpolate(u, [-2.0, -1.0, 0.0, 1.0, 2.0], [0.0, 0.0, 1.0, 0.0, 0.0])

    def area(self, u):
        x = np.clip(u, -1.0, 1.0)
        return 0.5 + x - x * np.abs(x) / 2

    def reached(self, times):
        return 1 - 1 / times


class Product(Shape):
    """``(1 + tanh u) (1 - tanh u)``."""

    whole = 2.0

    def law(self, u):
        return (1 + tanh(u)) * (1 - tanh(u))

    def area(self, u):
        return 1 + np.tanh(u)

    def reached(self, times):
        return np.arccosh(np.sqrt(times))


PULSES = Gaussian(), Lorentzian(), Triangle(), Product()


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


class LateSine(Moved):
    """Its amplitude grows as ``sin(time)``, so that it passes first after long steps."""

    def condition(self, x):
        return -self.u * sin(x) > self.size


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


def late_sine(rng):
    """Roots of ``sin(t) sin(speed t - a) - size`` beside each of its maxima."""
    while True:
        speed, a = float(10 ** rng.uniform(0.5, 3)), float(rng.uniform(0, 6))
        size = float(np.sin(rng.uniform(0.6, 0.95)))

        def margin(t, speed=speed, a=a, size=size):
            return np.sin(t) * np.sin(speed * t - a) - size

        def rate(t, speed=speed, a=a):
            return np.cos(t) * np.sin(speed * t - a) + speed * np.sin(t) * np.cos(speed * t - a)

        half = np.pi / 2 / speed
        middles = (a + np.pi / 2 + 2 * np.pi * np.arange(-1, speed / 6)) / speed
        middles = middles[(middles > half) & (middles < END + half)]
        tops = [brentq(rate, t - half, t + half, xtol=1e-16) for t in middles]
        if tops and min(abs(margin(t)) for t in tops) > 1e-6:
            break
    ends = [(t - half, t, t + half) for t in tops if margin(t) > 0]
    pairs = [(brentq(margin, x, y), brentq(margin, y, z)) for x, y, z in ends]
    times = np.array(pairs).ravel()
    return {"speed": speed, "a": a, "size": size}, times, RTOL * (1 / np.abs(rate(times)) + times)


def power(rng):
    speed = float(10 ** rng.uniform(-1, 3))
    a = float(rng.uniform(0.05, 0.95)) * speed
    given = {"speed": speed, "a": a, "size": float(10 ** rng.uniform(-2, 2) * rng.choice([-1, 1]))}
    return given, np.array([a / speed]), RTOL * np.array([a / speed])


def touch(rng):
    """Two instants close to each other, or none: it misses by as little."""
    speed = float(10 ** rng.uniform(-0.5, 1.5))
    a = float(rng.uniform(0.05, 0.95)) * speed
    size = float(10 ** rng.uniform(-12, -6) * rng.choice([-1, 1]))
    times = (a + np.sqrt(size) * np.array([-1, 1])) / speed if size > 0 else np.zeros(0)
    return {"speed": speed, "a": a, "size": size}, times, RTOL * times


def touch_in_turns(rng):
    """The same in every turn: ``1 - cos(x) == 2 sin(x / 2)**2``."""
    given, times, _ = touch(rng)
    if len(times):
        half, turns = 2 * np.arcsin(np.sqrt(given["size"] / 2)), 2 * np.pi * np.arange(-5, 6)
        times = (given["a"] + np.add.outer(turns, [-half, half])).ravel() / given["speed"]
    return given, times, RTOL * np.abs(times)


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
    draw: Callable
    component: str
    output: str

    @cached_property
    def system(self):
        keep = [self.output] if self.component != "body" else ["body.w"]
        return lp.assemble(self.model(), keep=keep)

    @cached_property
    def fmu(self):
        self.folder = tempfile.TemporaryDirectory()  # gone with the family
        file = Path(self.folder.name) / "known.fmu"
        lp.export_fmu(self.system, file, outputs=[self.output], rtol=RTOL)
        return str(file)

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
        Family("late sines", LateSine, late_sine, "", "y"),
        Family("x**3", Cube, power, "", "y"),
        Family("x**5", Fifth, power, "", "y"),
        Family("touches of a square", Square, touch, "", "y"),
        Family("touches of a cosine", Cosine, touch_in_turns, "", "y"),
    ]
    for shape in PULSES:
        name, (body, brake) = type(shape).__name__, shoved(shape)
        found += [
            Family(f"{name} on a brake", brake, braked(shape), "brake", "brake.position"),
            Family(f"{name} on a body", body, free(shape), "body", "body.w"),
        ]
    return found
