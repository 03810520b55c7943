"""Cases without events: growth, a crank-slider, oscillators, a start in equilibrium."""

import lumped as lp
from lumped import functionals as fun
from lumped.ops import cos, sin, sqrt

from .case import Case, Cases, free, given, held, one

case = Cases()
TURN = 6.283185307179586


@case
def reported_growth(p):
    d = given(p)

    def equations(self):
        yield lp.der(self.x) == self.a * self.x

    return Case(one(equations, d, x=held(d["x0"])), 1.0, {"x_end": fun.final("x")})


@case
def reported_three_parameters_at_once(p):
    def equations(self):
        t = lp.time
        yield lp.der(self.x) == self.a * (1 - t) + self.b * t + self.c * t

    return Case(one(equations, given(p), x=held()), 1.0, {"x_end": fun.final("x")})


@case
def crank_slider_rms(p):
    # the parameter off keeps its name
    def equations(self):
        yield lp.der(self.phi) == self.w
        reach = sqrt(self.l**2 - (self.r * sin(self.phi) + self.off) ** 2)
        yield self.s == self.r * cos(self.phi) + reach
        yield self.a == lp.der(lp.der(self.s))
        yield self.torque * self.w == lp.der(self.s) * (self.m * self.a - self.F)
        yield self.power == self.torque * self.w

    system = one(
        equations, given(p), ["torque"], phi=held(), s=free(), a=free(), torque=free(), power=free()
    )
    of = {"torque_rms": fun.rms("torque"), "power_mean_sq": fun.mean("power", "power")}
    # a turn lasts 2 pi / w
    return Case(system, TURN / p["w"], of, until_by={"w": -TURN / p["w"] ** 2})


def oscillator(p, force=None, **more):
    d = given(p)

    def equations(self):
        load = 0 if force is None else force(self)
        c = getattr(self, "c", 0)
        yield lp.der(self.x) == self.v
        yield self.a == lp.der(self.v)
        yield self.m * self.a + c * self.v + self.k * self.x == load

    start = d.get("x0", 0.0)
    return one(equations, d, x=held(start), v=held(), a=free(), **more)


@case
def peak_interior_and_border(p):
    of = {
        "peak_interior": fun.highest("x"),
        "peak_end": fun.highest("x"),
        "peak_start": fun.highest("a"),
        "mean_square": fun.mean("x", "x"),
    }
    return Case(oscillator(p, lambda self: self.F), 2.0, of, runs={"peak_end": 0.3})


@case
def peak_tie(p):
    of = {"peak_abs": fun.peak("x"), "x_end": fun.final("x")}
    return Case(oscillator(p), 1.0, of)


@case
def steady_start(p):
    def equations(self):
        yield self.tau == self.c * self.twist + self.d * (self.w1 - self.w2)
        yield lp.der(self.twist) == self.w1 - self.w2
        yield self.J1 * lp.der(self.w1) == self.Ms * (1 - self.w1 / self.ws) - self.tau
        yield self.J2 * lp.der(self.w2) == self.tau - self.ML - self.dM

    def initial(self):
        yield self.w1 == self.ws * (1 - self.ML / self.Ms)
        yield self.w2 == self.w1
        yield self.twist == self.ML / self.c

    system = one(equations, given(p), (), initial, w1=held(), w2=held(), twist=held(), tau=free())
    of = {
        "w2_end": fun.final("w2"),
        "torque_end": fun.final("tau"),
        # damped, so the file means the first maximum, before the drive slows down
        "torque_peak": fun.highest("tau", between=(0.0, 0.1)),
        "torque_start": fun.at_time(0.0, "tau"),
        "w_start": fun.at_time(0.0, "w2"),
    }
    return Case(system, 0.8, of)
