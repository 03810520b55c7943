"""Cases with impacts, play and elastic stops."""

import lumped as lp
from lumped import functionals as fun
from lumped.components import ElastoBacklash, IdealGear, Inertia, Stop, Torque
from lumped.ops import where

from .case import Case, Cases, free, given, held, one

case = Cases()


def ball(p):
    d = given(p)
    weight = d.get("m", 1.0)

    def equations(self):
        yield lp.der(self.h) == self.v
        yield weight * lp.der(self.v) == -weight * self.g - self.f
        yield lp.hold(self.f, self.v, gap=self.h, restitution=self.e)

    return one(equations, d, h=held(d["h0"]), v=held(d.get("v0", 0.0)), f=free())


@case
def ball_impacts(p):
    of = {
        "h_before": fun.at_time(0.5, "h"),
        "h_after": fun.final("h"),
        "v_after": fun.final("v"),
        **{f"t_impact_{k + 1}": fun.instant("Body", number=k) for k in range(3)},
        "int_v2": fun.integral("v", "v"),
        "loss": fun.loss("Body"),
    }
    return Case(ball(p), 2.5, of)


@case
def ball_accumulation(p):
    of = {
        "t_rest": fun.instant("Body", "closed", number=-1),
        "int_h": fun.integral("h"),
        "heat": fun.loss("Body"),
        "h_end": fun.final("h"),
    }
    return Case(ball(p), 6.0, of)


@case
def reported_sum_over_samples(p):
    return Case(ball(p), 2.0, {"sum_h2": fun.at_time([0.25 * k for k in range(9)], "h", "h")})


def oscillator_with_stop(p):
    d = given(p)

    def equations(self):
        yield self.gap == self.x + self.xs
        yield self.v == lp.der(self.gap)
        yield lp.der(self.v) == -(self.w**2) * self.x - self.f
        yield lp.hold(self.f, self.v, gap=self.gap, restitution=self.e)

    return one(equations, d, x=held(d["x0"]), gap=free(), v=held(), f=free())


@case
def near_grazing(p):
    of = {
        "x_end": fun.final("x"),
        "v_end": fun.final("v"),
        "v_contact": (lambda v: -v, [fun.at_event("v", "Body")]),
        "t_contact": fun.instant("Body"),
    }
    return Case(oscillator_with_stop(p), 2.0, of)


@case
def grazing(p):
    return Case(oscillator_with_stop(p), 2.0, {"x_end": fun.final("x")})


@case
def impact_through_gear(p):
    d = given(p)
    model = lp.compose(
        **{k: d[k] for k in ("J1", "i", "J2", "J3", "w0", "gap", "e", "M1")},
        push=Torque(tau=d["M1"]),
        motor=Inertia(J=d["J1"]),
        gear=IdealGear(ratio=d["i"]),
        arm=Inertia(J=d["J2"], phi=0.0, w=d["w0"]),
        stop=Stop(restitution=d["e"]),
        body=Inertia(J=d["J3"], phi=d["gap"], w=0.0),
        connections=lambda m: lp.chain(m.push, m.motor, m.gear, m.arm, m.stop, m.body),
    )
    system = lp.assemble(model, keep=["arm.phi", "body.phi"])
    before, after = (fun.at_event("arm.w", "stop", side=s) for s in ("before", "after"))
    of = {
        "t_1": fun.instant("stop", number=0),
        "impulse_1": fun.impulse("stop", number=0),
        "motor_impulse_1": (lambda a, b, J, i: J * i * (a - b), [before, after, "J1", "i"]),
        "loss_1": fun.loss("stop", number=0),
        "t_2": fun.instant("stop", number=1),
        "impulse_2": fun.impulse("stop", number=1),
        "phi_2_end": fun.final("arm.phi"),
        "phi_3_end": fun.final("body.phi"),
        "w_3_end": fun.final("body.w"),
    }
    return Case(system, 1.2, of)


@case
def backlash_crossing(p):
    d = given(p)
    model = lp.compose(
        **d,
        push=Torque(tau=where(lp.time < d["ts"], d["M0"], -d["M0"])),
        a=Inertia(J=d["J1"], phi=0.0),
        play=ElastoBacklash(c=d["c"], b=d["b"]),
        body=Inertia(J=d["J2"], phi=0.0),
        connections=lambda m: lp.chain(m.push, m.a, m.play, m.body),
    )
    system = lp.assemble(model, keep=["a.phi", "body.phi"])
    of = {
        "t_contact": fun.instant("play", number=0),
        "t_other_flank": fun.instant("play", "front flank", number=0),
        "phi_1": fun.final("a.phi"),
        "phi_2": fun.final("body.phi"),
        "w_2": fun.final("body.w"),
        # the play counts torque on body b, which the contact torque drives
        "torque_max": (lambda v: -v, [fun.lowest("play.tau")]),
        "torque_min": (lambda v: -v, [fun.highest("play.tau")]),
    }
    return Case(system, 0.5, of)


@case
def elastic_stop(p):
    d = given(p)

    def equations(self):
        yield lp.der(self.x) == self.v
        yield self.dent == self.x - self.s0
        push = self.k * self.dent + self.d * self.v
        yield self.f == where(self.dent > 0, where(push > 0, push, 0), 0)
        yield self.m * lp.der(self.v) == -self.f

    system = one(equations, d, x=held(), v=held(d["v0"]), dent=free(), f=free())
    of = {
        "x_end": fun.final("x"),
        "v_end": fun.final("v"),
        "t_contact": fun.instant("Body", "dent > 0"),
        "t_leave": fun.instant("Body", "k * dent + d * v <= 0"),
        "peak_force": fun.highest("f"),
        "dent": fun.highest("dent"),
        # what is left in the spring when it leaves is lost too
        "loss": (
            lambda v0, v, m: 0.5 * m * (v0**2 - v**2),
            [fun.at_time(0.0, "v"), fun.final("v"), "m"],
        ),
    }
    return Case(system, 1.2, of)
