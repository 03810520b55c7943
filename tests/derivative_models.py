"""The reference cases of tests/data/derivatives as models of lumped.

Each function takes the parameters of a file and gives a `Case`: parts of the library where it has
them, else a component of its own with the words of the file as equations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import lumped as lp
from lumped import functionals as fun
from lumped.components import (
    ElastoBacklash,
    IdealGear,
    Inertia,
    OneWayClutch,
    SlipCoupling,
    SpringDamper,
    Stop,
    Torque,
)
from lumped.ops import cos, sin, sqrt, where

TURN = 6.283185307179586


@dataclass(frozen=True)
class Case:
    """One reference case.

    Attributes
    ----------
    system : System
        The model.
    until : float
        End of the run, s.
    of : dict
        Functionals by their names in the file. A pair is a function of numbers, and the
        functionals and parameters that these are.
    to : dict
        Names here of parameters of the file, where they differ.
    runs : dict
        Ends of the run for functionals that look at another part, s.
    until_by : dict
        Derivatives of the end of the run by parameters.
    """

    system: lp.System
    until: float
    of: Mapping[str, object]
    to: Mapping[str, str] = field(default_factory=dict)
    runs: Mapping[str, float] = field(default_factory=dict)
    until_by: Mapping[str, float] = field(default_factory=dict)


def given(p):
    """Parameters with the values of a file."""
    return {key: lp.param("1", key, value) for key, value in p.items()}


def one(equations, data, keep=(), initial=None, **variables):
    """A system of one component, called Body."""
    body = {"equations": equations, "__doc__": "See equations.", **data, **variables}
    if initial is not None:
        body["initial_equations"] = initial
    return lp.assemble(type("Body", (lp.Component,), body)(), keep=list(keep))


def held(start=0.0):
    """A state."""
    return lp.var("1", "state", start=start, state="always")


def free():
    """A quantity."""
    return lp.var("1", "quantity")


CASES: dict[str, Callable[[Mapping[str, float]], Case]] = {}


def case(function):
    """Note a case by the name of its function."""
    CASES[function.__name__] = function
    return function


# -- smooth ------------------------------------------------------------------------------------


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
    of = {
        "torque_rms": fun.rms("torque"),
        "power_mean_sq": fun.mean("power", "power"),
    }
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
        "torque_start": fun.at(0.0, "tau"),
        "w_start": fun.at(0.0, "w2"),
    }
    return Case(system, 0.8, of)


# -- instants ----------------------------------------------------------------------------------


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


# -- borders -----------------------------------------------------------------------------------


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


# -- impacts -----------------------------------------------------------------------------------


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
        "h_before": fun.at(0.5, "h"),
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
    return Case(ball(p), 2.0, {"sum_h2": fun.at([0.25 * k for k in range(9)], "h", "h")})


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


# -- contact -----------------------------------------------------------------------------------


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
        "t_other_flank": fun.instant("play", "phi_rel - phi_rel0 > b / 2", number=0),
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
            [fun.at(0.0, "v"), fun.final("v"), "m"],
        ),
    }
    return Case(system, 1.2, of)


# -- friction ----------------------------------------------------------------------------------


@case
def block_to_rest(p):
    d = given(p)

    def equations(self):
        grip = self.mu * self.m * self.g
        yield lp.der(self.x) == self.v
        yield self.m * lp.der(self.v) == -self.d * self.v - self.f
        yield self.power == self.f * self.v
        yield lp.hold(self.f, self.v, forward=grip, backward=-grip, upper=grip, lower=-grip)

    system = one(equations, d, x=held(), v=held(d["v0"]), f=free(), power=free())
    of = {
        "x_rest": fun.final("x"),
        "t_rest": fun.instant("Body", "stuck"),
        "v_end": fun.final("v"),
        "heat": fun.integral("power"),
        "int_v2": fun.integral("v", "v"),
    }
    return Case(system, 5.0, of)


@case
def force_step_breaks_loose(p):
    d = given(p)

    def equations(self):
        kinetic, static = self.mu * self.m * self.g, self.mus * self.m * self.g
        t = lp.time
        first = where(t >= 0.5, where(t >= 1.0, 0, 1), 0)
        second = where(t >= 1.5, where(t >= 2.0, 0, 1), 0)
        yield lp.der(self.x) == self.v
        yield self.m * lp.der(self.v) == self.F * (first - second) - self.f
        yield self.power == self.f * self.v
        yield lp.hold(
            self.f, self.v, forward=kinetic, backward=-kinetic, upper=static, lower=-static
        )

    system = one(equations, d, x=held(), v=held(), f=free(), power=free())
    of = {
        "x_mid": fun.at(1.45, "x"),
        "t_stop_1": fun.instant("Body", "stuck", number=0),
        "x_end": fun.final("x"),
        "t_stop_2": fun.instant("Body", "stuck", number=1),
        "heat": fun.integral("power"),
        "t_break": fun.instant("Body", "forward"),
    }
    return Case(system, 2.5, of)


@case
def static_limit_touched(p):
    d = given(p)

    def equations(self):
        yield lp.der(self.x) == self.v
        yield self.m * lp.der(self.v) == self.F0 * sin(self.Om * lp.time) - self.f
        yield lp.hold(
            self.f, self.v, forward=self.Fk, backward=-self.Fk, upper=self.Fs, lower=-self.Fs
        )

    system = one(equations, d, x=held(), v=held(), f=free())
    return Case(system, 2.0, {"x_end": fun.final("x")})


@case
def belt_stick_slip(p):
    d = given(p)

    def equations(self):
        yield lp.der(self.x) == self.v
        yield self.slip == self.v - self.vb
        yield self.m * lp.der(self.v) == -self.k * self.x - self.f
        yield self.power == self.f * self.slip
        yield lp.hold(
            self.f, self.slip, forward=self.Fk, backward=-self.Fk, upper=self.Fs, lower=-self.Fs
        )

    system = one(equations, d, x=held(), v=free(), slip=held(), f=free(), power=free())
    release = [fun.instant("Body", "backward", number=k) for k in (2, 3)]
    of = {
        "x_end": fun.final("x"),
        "v_end": fun.final("v"),
        "t_release_n": release[1],
        "period": (lambda a, b: b - a, release),
        "heat": fun.integral("power"),
        "x_peak": fun.highest("x"),
    }
    return Case(system, 6.0, of)


@case
def brake_holds(p):
    d = given(p)

    def equations(self):
        rise = where(lp.time >= self.tr, 1, lp.time / self.tr)
        grip = self.mu * self.R * self.F * rise
        yield lp.der(self.phi) == self.w
        yield self.J * lp.der(self.w) == self.ML - self.tau
        yield self.power == self.tau * self.w
        yield lp.hold(self.tau, self.w, forward=grip, backward=-grip, upper=grip, lower=-grip)

    system = one(equations, d, phi=held(), w=held(d["w0"]), tau=free(), power=free())
    of = {
        "phi_end": fun.final("phi"),
        "t_stop": fun.instant("Body", "stuck"),
        "w_end": fun.final("w"),
        "heat": fun.integral("power"),
        "tau_hold": fun.final("tau"),
    }
    return Case(system, 4.0, of)


@case
def clutch_lock_up(p):
    d = given(p)

    def equations(self):
        grip = self.mu * self.z * self.R * self.rho * lp.time
        yield self.J1 * lp.der(self.wa) == self.M1 - self.tau
        yield self.J2 * lp.der(self.wb) == self.tau - self.d * self.wb
        yield self.slip == self.wa - self.wb
        yield self.power == self.tau * self.slip
        yield lp.hold(self.tau, self.slip, forward=grip, backward=-grip, upper=grip, lower=-grip)

    system = one(
        equations,
        d,
        wa=free(),
        wb=held(),
        slip=held(d["w1"]),
        tau=free(),
        power=free(),
    )
    of = {
        "t_lock": fun.instant("Body", "stuck"),
        "slip_energy": fun.integral("power"),
        "w_lock": fun.at_event("wb", "Body", "stuck"),
        "slip_angle": fun.integral("slip"),
        "w_end": fun.final("wb"),
        "tau_clutch_end": fun.final("tau"),
    }
    return Case(system, 3.0, of)


@case
def gear_shift(p):
    d = given(p)

    def equations(self):
        shifted = lp.time >= self.ts
        yield self.J1 * lp.der(self.w1) == self.M1 - self.t1 - self.t2
        yield self.J2 * lp.der(self.w2) == self.i1 * self.t1 + self.i2 * self.t2 - self.ML
        yield lp.der(self.phi2) == self.w2
        yield self.s1 == self.w1 - self.i1 * self.w2
        yield self.s2 == self.w1 - self.i2 * self.w2
        yield self.power == self.t2 * self.s2
        yield lp.hold(self.t1, self.s1, engaged=lp.time < self.ts)
        yield lp.hold(
            self.t2,
            self.s2,
            engaged=shifted,
            forward=self.Mk,
            backward=-self.Mk,
            upper=self.Mk,
            lower=-self.Mk,
        )

    system = one(
        equations,
        d,
        w1=free(),
        w2=lp.var("1", "speed", start=d["w20"], state="always"),
        s1=held(),
        s2=free(),
        phi2=held(),
        t1=free(),
        t2=free(),
        power=free(),
    )
    of = {
        "w2_end": fun.final("w2"),
        "phi2_end": fun.final("phi2"),
        "t_lock": fun.instant("Body", "stuck", number=-1),
        "slip_energy": fun.integral("power"),
        "tau_clutch_end": fun.final("t2"),
    }
    return Case(system, 3.0, of)


@case
def one_way_clutch(p):
    d = given(p)
    model = lp.compose(
        **d,
        push=Torque(tau=d["M0"] * cos(d["Om"] * lp.time)),
        a=Inertia(J=d["J1"], w=d["w0"]),
        clutch=OneWayClutch(u=0.0),
        body=Inertia(J=d["J2"], w=d["w0"]),
        drag=Drag(d=d["d"]),
        connections=lambda m: [
            *lp.chain(m.push, m.a, m.clutch, m.body),
            lp.connect(m.body.flange_b, m.drag.flange),
        ],
    )
    of = {
        "t_over_1": fun.instant("clutch", "forward", number=0),
        "t_engage_1": fun.instant("clutch", "stuck", number=0),
        "t_over_2": fun.instant("clutch", "forward", number=1),
        "t_engage_2": fun.instant("clutch", "stuck", number=1),
        "w1_end": fun.final("a.w"),
        "w2_end": fun.final("body.w"),
        "slip": fun.integral("clutch.w_rel"),
    }
    return Case(lp.assemble(model), 4.0, of)


class Drag(lp.Component):
    """Viscous drag of a shaft against the ground."""

    flange = lp.Flange()
    d: lp.Param = lp.param("N.m.s/rad", "damping", min=0)

    def equations(self):
        yield self.flange.tau == self.d * lp.der(self.flange.phi)


@case
def simultaneous_decoupled(p):
    class Brakes(lp.Component):
        """Two flywheels with a brake each."""

        J: lp.Param = lp.param("kg.m2", "inertia")
        M: lp.Param = lp.param("N.m", "torque")
        w0: lp.Param = lp.param("rad/s", "speed")
        w: lp.Var = lp.var("rad/s", "speed", state="always", start=w0)
        phi: lp.Var = lp.var("rad", "angle", state="always")
        tau: lp.Var = lp.var("N.m", "torque")
        square: lp.Var = lp.var("rad2/s2", "square of the speed")

        def equations(self):
            yield lp.der(self.phi) == self.w
            yield self.J * lp.der(self.w) == -self.tau
            yield self.square == self.w**2
            yield lp.hold(
                self.tau, self.w, forward=self.M, backward=-self.M, upper=self.M, lower=-self.M
            )

    model = lp.compose(
        a=Brakes(J=p["Ja"], M=p["Ma"], w0=p["wa"]),
        b=Brakes(J=p["Jb"], M=p["Mb"], w0=p["wb"]),
    )
    to = {"Ja": "a.J", "wa": "a.w0", "Ma": "a.M", "Jb": "b.J", "wb": "b.w0", "Mb": "b.M"}
    of = {
        "t_a": fun.instant("a", "stuck"),
        "t_b": fun.instant("b", "stuck"),
        "phi_a": fun.final("a.phi"),
        "phi_b": fun.final("b.phi"),
        "sum_sq": (lambda a, b: a + b, [fun.integral("a.square"), fun.integral("b.square")]),
    }
    return Case(lp.assemble(model), 7.0, of, to)


@case
def simultaneous_coupled_clutches(p):
    d = given(p)
    model = lp.compose(
        **d,
        push=Torque(tau=d["Md"]),
        a=Inertia(J=d["J1"], w=d["w1"]),
        first=SlipCoupling(kinetic=d["M1"], static=d["M1"], u=1.0),
        b=Inertia(J=d["J2"], w=d["w2"]),
        second=SlipCoupling(kinetic=d["M2"], static=d["M2"], u=1.0),
        c=Inertia(J=d["J3"], w=d["w3"]),
        connections=lambda m: lp.chain(m.push, m.a, m.first, m.b, m.second, m.c),
    )
    system = lp.assemble(model, keep=["first.phi_rel", "second.phi_rel"])
    of = {
        "t_lock_1": fun.instant("first", "stuck"),
        "t_lock_2": fun.instant("second", "stuck"),
        "w_end": fun.final("c.w"),
        "phi_12": (lambda v: -v, [fun.final("first.phi_rel")]),
        "phi_23": (lambda v: -v, [fun.final("second.phi_rel")]),
        "heat": (
            lambda a, b: a + b,
            [fun.integral(f"{n}.tau", f"{n}.w_rel") for n in ("first", "second")],
        ),
    }
    return Case(system, 3.0, of)


@case
def ten_masses_friction(p):
    d = given(p)

    class Chain(lp.Component):
        """Ten masses on springs; dry friction at the fifth."""

        locals().update(d)
        f: lp.Var = lp.var("N", "friction")
        power: lp.Var = lp.var("W", "of the friction")
        wall: lp.Var = lp.var("N", "force on the wall")
        for i in range(1, 11):
            locals()[f"x{i}"] = held()
            locals()[f"v{i}"] = held()
        del i

        def equations(self):
            x = [0, *(getattr(self, f"x{i}") for i in range(1, 11))]
            v = [0, *(getattr(self, f"v{i}") for i in range(1, 11))]
            pull = [getattr(self, f"k{i}") * (x[i] - x[i - 1]) for i in range(1, 11)] + [self.F0]
            for i in range(1, 11):
                yield lp.der(x[i]) == v[i]
                rub = self.f if i == 5 else 0
                m = self.m5 if i == 5 else self.m
                yield m * lp.der(v[i]) == pull[i] - pull[i - 1] - rub
            yield self.power == self.f * self.v5
            yield self.wall == pull[0]
            yield lp.hold(
                self.f, self.v5, forward=self.Fc, backward=-self.Fc, upper=self.Fc, lower=-self.Fc
            )

    of = {
        "x10_end": fun.final("x10"),
        "x5_end": fun.final("x5"),
        "v10_end": fun.final("v10"),
        "t_slip_1": fun.instant("Chain", "forward", number=0),
        "t_stick_1": fun.instant("Chain", "stuck", number=0),
        "heat": fun.integral("power"),
        "wall_force_end": fun.final("wall"),
    }
    return Case(lp.assemble(Chain()), 4.0, of)


@case
def zero_influence(p):
    d = given(p)

    class Rest(lp.Component):
        """Brake that is never pressed, and an elastic stop that is never reached."""

        flange = lp.Flange()
        mu_b: lp.Param = lp.param("1", "friction")
        cs: lp.Param = lp.param("N.m/rad", "stiffness")
        phi_s: lp.Param = lp.param("rad", "where the stop is")
        w: lp.Var = lp.var("rad/s", "speed")
        push: lp.Var = lp.var("N.m", "torque of the stop")
        tau: lp.Var = lp.var("N.m", "torque of the brake")

        def equations(self):
            dent = self.flange.phi - self.phi_s
            yield self.w == lp.der(self.flange.phi)
            yield self.push == where(dent > 0, self.cs * dent, 0)
            yield self.flange.tau == self.push + self.tau
            grip = self.mu_b * 1000.0
            yield lp.hold(
                self.tau,
                self.w,
                forward=grip,
                backward=-grip,
                upper=grip,
                lower=-grip,
                engaged=lp.time > 100.0,
            )

    model = lp.compose(
        **d,
        push=Torque(tau=d["M"]),
        a=Inertia(J=d["J1"], phi=d["phi0"]),
        shaft=SpringDamper(c=d["c"], d=d["d"]),
        b=Inertia(J=d["J2"], phi=d["phi0"]),
        clutch=SlipCoupling(kinetic=d["mu"] * 500.0, static=d["mu"] * 500.0, u=1.0),
        body=Inertia(J=d["J3"]),
        rest=Rest(mu_b=d["mu_b"], cs=d["cs"], phi_s=d["phi_s"]),
        alone=Inertia(J=d["J4"], w=3.0, phi=d["phi0"]),
        idle=Torque(tau=0.0),
        connections=lambda m: [
            lp.connect(m.idle.flange, m.alone.flange_a),
            *lp.chain(m.push, m.a, m.shaft, m.b, m.clutch, m.body),
            lp.connect(m.b.flange_b, m.rest.flange),
        ],
    )
    system = lp.assemble(model, keep=["b.phi"])
    of = {
        "w2_end": fun.final("b.w"),
        # the shaft counts its twist from a to b
        "twist_peak": fun.peak("shaft.phi_rel"),
        "phi2_end": fun.final("b.phi"),
    }
    return Case(system, 0.5, of)
