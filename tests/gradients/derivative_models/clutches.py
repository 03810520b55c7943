"""Cases with clutches."""

from rows import in_rows

import lumped as lp
from lumped import functionals as fun
from lumped.components import Inertia, OneWayClutch, SlipCoupling, SpringDamper, Torque
from lumped.ops import cos, where

from .case import Case, Cases, free, given, held, one, rub

case = Cases()


@case
def clutch_lock_up(p):
    d = given(p)

    def equations(self):
        grip = self.mu * self.z * self.R * self.rho * lp.time
        yield self.J1 * lp.der(self.wa) == self.M1 - self.tau
        yield self.J2 * lp.der(self.wb) == self.tau - self.d * self.wb
        yield self.slip == self.wa - self.wb
        yield self.power == self.tau * self.slip
        yield rub(self.tau, self.slip, grip)

    system = one(equations, d, wa=free(), wb=held(), slip=held(d["w1"]), tau=free(), power=free())
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
        yield rub(self.t2, self.s2, self.Mk, engaged=shifted)

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
    model = in_rows(
        "push a clutch body drag",
        **d,
        push=Torque(tau=d["M0"] * cos(d["Om"] * lp.time)),
        a=Inertia(J=d["J1"], w=d["w0"]),
        clutch=OneWayClutch(u=0.0),
        body=Inertia(J=d["J2"], w=d["w0"]),
        drag=Drag(d=d["d"]),
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
            yield rub(self.tau, self.w, self.mu_b * 1000.0, engaged=lp.time > 100.0)

    model = in_rows(
        "idle alone",
        "push a shaft b clutch body",
        "b rest",
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
    )
    system = lp.assemble(model, keep=["b.phi"])
    of = {
        "w2_end": fun.final("b.w"),
        # the shaft counts its twist from a to b
        "twist_peak": fun.peak("shaft.phi_rel"),
        "phi2_end": fun.final("b.phi"),
    }
    return Case(system, 0.5, of)
