"""Cases with dry friction and brakes."""

import lumped as lp
from lumped import functionals as fun
from lumped.ops import sin, where

from .case import Case, Cases, free, given, held, one, rub

case = Cases()


@case
def block_to_rest(p):
    d = given(p)

    def equations(self):
        grip = self.mu * self.m * self.g
        yield lp.der(self.x) == self.v
        yield self.m * lp.der(self.v) == -self.d * self.v - self.f
        yield self.power == self.f * self.v
        yield rub(self.f, self.v, grip)

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
        yield rub(self.f, self.v, kinetic, static)

    system = one(equations, d, x=held(), v=held(), f=free(), power=free())
    of = {
        "x_mid": fun.at_time(1.45, "x"),
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
        yield rub(self.f, self.v, self.Fk, self.Fs)

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
        yield rub(self.f, self.slip, self.Fk, self.Fs)

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
        yield rub(self.tau, self.w, grip)

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
            yield rub(self.tau, self.w, self.M)

    model = lp.compose(
        a=Brakes(J=p["Ja"], M=p["Ma"], w0=p["wa"]), b=Brakes(J=p["Jb"], M=p["Mb"], w0=p["wb"])
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
                drag = self.f if i == 5 else 0
                m = self.m5 if i == 5 else self.m
                yield m * lp.der(v[i]) == pull[i] - pull[i - 1] - drag
            yield self.power == self.f * self.v5
            yield self.wall == pull[0]
            yield rub(self.f, self.v5, self.Fc)

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
