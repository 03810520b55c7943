"""Cases that switch at an instant or where a state crosses a border."""

import lumped as lp
from lumped import functionals as fun
from lumped.ops import where

from .case import Case, Cases, free, given, held, one
from .smooth import oscillator

case = Cases()


@case
def fixed_time_pulse(p):
    def force(self):
        return where(lp.time >= self.t1, where(lp.time >= self.t2, 0, self.F0), 0)

    of = {
        "x_end": fun.final("x"),
        "v_end": fun.final("v"),
        "int_x2": fun.integral("x", "x"),
        "x_peak": fun.highest("x", between=(0.7, 1.4)),
    }
    return Case(oscillator(p, force), 3.0, of)


@case
def reported_after_the_event(p):
    def equations(self):
        yield lp.der(self.x) == where(lp.time < self.te, 1, 0)

    return Case(one(equations, given(p), x=held()), 2.0, {"x_end": fun.final("x")})


@case
def reported_parameter_changed_at_an_event(p):
    d = given(p)

    def equations(self):
        yield lp.der(self.x) == (self.p + where(lp.time >= 0.5, self.dp, 0)) * self.x

    return Case(one(equations, d, x=held(d["x0"])), 1.0, {"x_end": fun.final("x")})


@case
def reported_direction(p):
    d = given(p)

    def equations(self):
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == -(self.w**2) * self.x
        yield lp.der(self.y) == where(self.x > self.b, 1, 0)

    system = one(equations, d, x=held(), v=held(d["w"]), y=held())
    of = {
        "t_up": fun.instant("Body", number=0),
        "t_down": fun.instant("Body", number=1),
        "y_end": fun.final("y"),
    }
    return Case(system, 3.0, of)


@case
def reported_landing_time_by_drag(p):
    d = given(p)

    def equations(self):
        # where it has landed it goes on falling in this model; only what is before counts
        yield self.m * lp.der(self.v) == self.m * self.g - self.k * self.v**2
        yield lp.der(self.h) == where(self.h > 0, -self.v, -self.v)
        yield lp.der(self.landed) == where(self.h > 0, 0, 1)

    system = one(equations, d, v=held(), h=held(d["h0"]), landed=held())
    of = {"t_land": fun.instant("Body"), "v_land": fun.at_event("v", "Body")}
    return Case(system, 7.0, of)


@case
def reported_reset_at_level(p):
    def equations(self):
        yield lp.der(self.x) == 1
        yield lp.when(self.x >= self.q, {self.x: 0})

    of = {"x_end": fun.final("x"), "t_event": fun.instant("Body")}
    return Case(one(equations, given(p), x=held()), 1.0, of)


@case
def reported_stop_of_a_second_state(p):
    d = given(p)

    def equations(self):
        yield lp.der(self.x) == where(self.x > 0, -self.a, 0)
        yield lp.der(self.y) == where(self.x > 0, self.b, 0)

    return Case(one(equations, d, x=held(d["x0"]), y=held()), 1.0, {"y_end": fun.final("y")})


@case
def reported_two_borders_in_a_step(p):
    def equations(self):
        yield lp.der(self.x) == 1
        first = where(self.x >= self.q1, 1, where(self.x >= self.q2, 1, 0))
        yield lp.der(self.y) == first

    of = {"t_first": fun.instant("Body")}
    return Case(one(equations, given(p), x=held(), y=held()), 2.0, of)


@case
def guard_only(p):
    def equations(self):
        yield self.J * lp.der(self.w) == self.on * self.M - self.d * self.w
        yield lp.der(self.on) == 0
        yield self.power == self.M * self.w * self.on
        yield lp.when(self.w >= self.w_hi, {self.on: 0})
        yield lp.when(self.w <= self.w_lo, {self.on: 1})

    system = one(equations, given(p), w=held(), on=held(1.0), power=free())
    of = {
        "w_end": fun.final("w"),
        "t_switch_1": fun.instant("Body", "w >= w_hi", number=0),
        "t_switch_5": fun.instant("Body", "w >= w_hi", number=2),
        "energy": fun.integral("power"),
    }
    return Case(system, 10.0, of)


@case
def simultaneous_and_gate(p):
    def equations(self):
        yield self.Ja * lp.der(self.wa) == self.Ma
        yield self.Jb * lp.der(self.wb) == self.Mb
        both = where(self.wa > self.ga, where(self.wb > self.gb, self.Mc, 0), 0)
        yield self.Jc * lp.der(self.wc) == both

    system = one(equations, given(p), wa=held(), wb=held(), wc=held())
    return Case(system, 4.0, {"w_c": fun.final("wc"), "w_a": fun.final("wa")})
