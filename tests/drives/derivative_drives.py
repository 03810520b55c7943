"""Drives of library parts whose derivatives are compared with differences of tight runs."""

from __future__ import annotations

from rows import in_a_row, in_rows

import lumped as lp
from lumped import functionals as fun
from lumped.components import (
    Backlash,
    BearingFriction,
    Belt,
    Brake,
    Clutch,
    Coupling,
    Damper,
    ElastoBacklash,
    Fixed,
    IdealGear,
    Inertia,
    PickUp,
    SlipCoupling,
    SpringDamper,
    Stop,
    Stribeck,
    Torque,
    translation,
)
from lumped.components.translation.contact import ElastoGap, MassWithStops
from lumped.ops import cos, sin, where

DRIVES = {}


def drive(function):
    """Note a drive by the name of its function."""
    DRIVES[function.__name__] = function
    return function


@drive
def brake_with_a_ramp():
    model = in_a_row(
        push=Torque(tau=3.0),
        body=Inertia(J=1.5, w=20.0),
        brake=Brake(
            f_max=450.0,
            c_geo=0.2,
            u=where(lp.time > 0.3, where(lp.time < 0.8, 2 * (lp.time - 0.3), 1), 0),
            characteristic=((0.0, 0.4), (30.0, 0.3)),
        ),
    )
    of = [
        fun.final("body.phi"),
        fun.instant("brake", "stuck"),
        fun.integral("brake.tau", "brake.w"),
        fun.rms("body.w", between=(0.5, 1.5)),
        fun.at_time(1.0, "body.w"),
    ]
    to = ["push.tau", "body.J", "brake.f_max", "brake.c_geo", "body.w"]
    return lp.assemble(model, keep=["body.phi"]), of, to, 3.0


@drive
def stick_slip_with_stribeck():
    model = in_rows(
        "push motor shaft body bearing",
        "ground feed motor",
        feed=Damper(d=3.0),
        ground=Fixed(),
        motor=Inertia(J=2.0, w=2.0),
        push=Torque(tau=8.0),
        shaft=SpringDamper(c=60.0, d=0.2),
        body=Inertia(J=0.7, w=0.0),
        bearing=BearingFriction(characteristic=Stribeck(2.0, 5.0, 3.0, 0.1)),
    )
    of = [
        fun.final("body.w"),
        fun.highest("shaft.tau"),
        fun.instant("bearing", "forward", number=0),
        fun.integral("bearing.tau", "bearing.w"),
        fun.mean("shaft.tau", between=(0.4, 2.2)),
    ]
    to = ["shaft.c", "shaft.d", "body.J", "motor.J", "push.tau", "motor.w"]
    return lp.assemble(model), of, to, 3.0


@drive
def play_with_rigid_flanks():
    model = in_a_row(
        push=Torque(tau=2.0 * sin(9.0 * lp.time)),
        a=Inertia(J=0.2, phi=0.0),
        play=Backlash(b=0.06, restitution=0.4),
        b=Inertia(J=0.5, phi=0.0),
        oil=Damper(d=0.4),
        wall=Fixed(),
    )
    of = [
        fun.final("b.phi"),
        fun.loss("play", number=0),
        fun.impulse("play", number=1),
        fun.at_event("play.w_rel", "play", number=0),
        fun.instant("play", number=2),
    ]
    to = ["a.J", "b.J", "play.b", "play.restitution", "oil.d"]
    return lp.assemble(model, keep=["b.phi"]), of, to, 0.7


@drive
def load_that_is_picked_up():
    model = in_a_row(
        push=Torque(tau=5.0),
        motor=Inertia(J=0.4, w=3.0),
        shaft=SpringDamper(c=300.0, d=1.0),
        arm=Inertia(J=0.3, w=3.0),
        body=PickUp(J=0.6, u=where(lp.time > 0.4, 1, 0)),
    )
    of = [fun.final("arm.w"), fun.highest("shaft.tau"), fun.loss("body"), fun.final("body.w")]
    to = ["push.tau", "motor.J", "arm.J", "body.J", "shaft.c"]
    return lp.assemble(model), of, to, 0.9


@drive
def dog_clutch_at_an_instant():
    when = lp.param("s", "when it closes", 0.35)
    model = lp.compose(
        when=when,
        push=Torque(tau=4.0),
        a=Inertia(J=0.5, w=10.0),
        dog=Coupling(u=where(lp.time > when, 1, 0)),
        b=Inertia(J=0.8),
        oil=Damper(d=0.6),
        wall=Fixed(),
        connections=lambda m: lp.chain(m.push, m.a, m.dog, m.b, m.oil, m.wall),
    )
    of = [
        fun.final("b.w"),
        fun.final("b.phi"),
        fun.loss("dog"),
        fun.impulse("dog"),
        fun.integral("oil.tau", "oil.w_rel"),
    ]
    to = ["when", "push.tau", "a.J", "b.J", "oil.d", "a.w"]
    return lp.assemble(model, keep=["b.phi"]), of, to, 1.0


@drive
def mass_between_two_stops():
    model = in_a_row(
        push=translation.Force(f=30.0 * cos(5.0 * lp.time)),
        body=MassWithStops(m=2.0, s_min=-0.5, s_max=0.4, restitution=0.6, s=0.0, v=0.3),
    )
    of = [
        fun.final("body.s"),
        fun.final("body.v"),
        fun.loss("body"),
        fun.at_event("body.v", "body", number=1),
        fun.integral("body.v", "body.v"),
    ]
    to = ["body.m", "body.s_min", "body.s_max", "body.restitution", "body.v"]
    return lp.assemble(model, keep=["body.s"]), of, to, 1.0


@drive
def elastic_play_with_damped_flanks():
    model = in_a_row(
        a=Inertia(J=1.0, w=2.0, phi=0.0),
        play=ElastoBacklash(c=600.0, d=6.0, b=0.02, limited=False),
        b=Inertia(J=1.5),
        spring=SpringDamper(c=200.0, d=0.5),
        wall=Fixed(),
    )
    of = [fun.final("a.w"), fun.final("b.w"), fun.peak("spring.tau"), fun.instant("play", number=1)]
    to = ["a.J", "b.J", "play.c", "play.d", "play.b", "spring.c"]
    return lp.assemble(model, keep=["a.phi"]), of, to, 0.9


@drive
def overload_of_a_slip_coupling():
    model = in_a_row(
        push=Torque(tau=20.0),
        motor=Inertia(J=0.5, w=90.0),
        coupling=SlipCoupling(kinetic=30.0, static=48.0, u=1.0),
        gear=IdealGear(ratio=3.0),
        load=Inertia(J=4.0),
        jam=Torque(tau=where(lp.time > 0.2, where(lp.time < 0.5, -330.0, -60.0), -60.0)),
    )
    of = [
        fun.final("load.w"),
        fun.integral("coupling.tau", "coupling.w_rel"),
        fun.instant("coupling", "stuck", number=-1),
        fun.lowest("load.w"),
    ]
    to = ["push.tau", "motor.J", "coupling.kinetic", "coupling.static", "gear.ratio", "load.J"]
    return lp.assemble(model), of, to, 2.5


@drive
def two_masses_and_a_stop():
    model = in_a_row(
        ground=Fixed(),
        spring=SpringDamper(c=20.0, d=0.3),
        a=Inertia(J=0.6, phi=-0.5, w=0.0),
        stop=Stop(restitution=0.5, phi_min=-0.1),
        b=Inertia(J=0.9, phi=0.3),
        back=SpringDamper(c=8.0, phi_rel0=-0.3),
        wall=Fixed(),
    )
    of = [
        fun.final("a.w"),
        fun.final("b.phi"),
        fun.loss("stop"),
        fun.impulse("stop", number=0),
        fun.highest("back.tau"),
    ]
    to = ["spring.c", "a.J", "stop.restitution", "stop.phi_min", "b.J", "a.phi", "back.c"]
    return lp.assemble(model, keep=["a.phi", "b.phi"]), of, to, 2.2


@drive
def clutch_engaged_by_its_command():
    rise = lp.param("s", "time of rise", 0.5)
    model = lp.compose(
        rise=rise,
        push=Torque(tau=20.0),
        a=Inertia(J=0.4, w=120.0),
        clutch=Clutch(
            f_max=2000.0,
            c_geo=0.1,
            u=where(lp.time < rise, lp.time / rise, 1),
            characteristic=((0.0, 0.3), (100.0, 0.25)),
        ),
        b=Inertia(J=1.8),
        oil=Damper(d=0.2),
        wall=Fixed(),
        connections=lambda m: lp.chain(m.push, m.a, m.clutch, m.b, m.oil, m.wall),
    )
    of = [
        fun.instant("clutch", "stuck"),
        fun.integral("clutch.tau", "clutch.w_rel"),
        fun.at_event("b.w", "clutch", "stuck", side="after"),
        fun.peak("clutch.tau"),
        fun.final("clutch.tau"),
    ]
    to = ["rise", "push.tau", "a.J", "b.J", "clutch.f_max", "oil.d", "a.w"]
    return lp.assemble(model), of, to, 2.0


@drive
def elastic_play_without_damping():
    model = in_a_row(
        a=Inertia(J=1.0, w=2.0, phi=0.0),
        play=ElastoBacklash(c=600.0, b=0.02),
        b=Inertia(J=1.5),
        spring=SpringDamper(c=200.0, d=0.5),
        wall=Fixed(),
    )
    of = [fun.final("a.w"), fun.final("b.w"), fun.peak("play.tau")]
    to = ["a.J", "play.c", "play.b", "spring.c"]
    return lp.assemble(model, keep=["a.phi"]), of, to, 1.7


@drive
def mass_that_falls_on_an_elastic_gap():
    model = in_rows(
        "ground gap body",
        "weight body.flange_b",
        body=translation.Mass(m=1.0, v=-1.0, s=0.1),
        gap=ElastoGap(c=1e3, d=20.0, s_rel0=0.02),
        ground=translation.Fixed(),
        weight=translation.Force(f=-5.0),
    )
    of = [fun.final("body.v"), fun.final("body.s"), fun.lowest("gap.f"), fun.rms("gap.f")]
    to = ["body.m", "gap.c", "gap.d", "gap.s_rel0", "weight.f"]
    return lp.assemble(model, keep=["body.s"]), of, to, 0.9


@drive
def belt_whose_strands_go_slack():
    model = in_a_row(
        a=Inertia(J=0.1, w=30.0),
        belt=Belt(r_a=0.1, r_b=0.2, distance=0.8, EA=2e4, F_0=20.0),
        b=Inertia(J=0.5),
    )
    of = [fun.final("a.w"), fun.final("b.w")]
    to = ["a.J", "belt.EA", "belt.F_0", "b.J"]
    return lp.assemble(model), of, to, 0.6
