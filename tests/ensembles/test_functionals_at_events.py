"""Functionals of events in the time loop, against closed forms of impacts, brakes and steps."""

import numpy as np
import pytest
from rows import in_a_row, in_rows
from test_functionals_in_runs import check, compare

import lumped as lp
from lumped import functionals as fun
from lumped.components import Backlash, Brake, Inertia, Torque
from lumped.components import translation as sliding
from lumped.ops import where

paired = lp.ensembles.paired
G = 9.81


# -- a ball ----------------------------------------------------------------------------------------

DROP = np.array([0.2, 0.5, 0.9, 1.0, 5.0])
BOUNCE = np.array([0.7, 0.8, 0.9])
MASS = 2.0


@pytest.fixture(scope="module")
def ball():
    model = in_rows(
        "weight body",
        "body.flange_b floor.flange_b",
        body=sliding.Mass(m=MASS, s=1.0, v=0.0),
        weight=sliding.Force(f=-MASS * G),
        floor=sliding.Stop(restitution=0.5),
    )
    return lp.assemble(model, keep=["body.s"])


DROPPED = {
    "over": {"floor.s_min": 1.0 - DROP, "floor.restitution": BOUNCE},
    "until": 0.9,
    "rtol": 1e-8,
}


def impacts(until=DROPPED["until"]):
    """Instants and speeds of the impacts of each ball before the end."""
    found = []
    for h in DROP:
        for e in BOUNCE:
            v = np.sqrt(2 * G * h)
            times, speeds, t = [], [], v / G
            while t <= until and len(times) < 200:
                times.append(t)
                speeds.append(v)
                v *= e
                t += 2 * v / G
            found.append((np.array(times), np.array(speeds), e))
    return found


def picked(events, number, value):
    """A number of each ball's impact; nan if there are too few."""
    found = []
    for times, speeds, e in events:
        least = number + 1 if number >= 0 else -number
        there = len(times) >= least
        found.append(value(times, speeds, e)[number] if there else np.nan)
    return np.array(found)


@pytest.mark.parametrize("number", [0, 1, -1, -2, 3, -4])
def test_single_impacts_of_a_ball(ball, number):
    events = impacts()
    instant = picked(events, number, lambda t, v, e: t)
    here = {"number": number}
    speed = "body.v"
    after = fun.at_event(speed, "floor", "open", side="after", **here)
    of = {
        "instant": (fun.instant("floor", **here), instant),
        "open": (fun.instant("floor", "open", **here), instant),
        "before": (fun.at_event(speed, "floor", **here), lambda t, v, e: -v),
        "after": (after, lambda t, v, e: e * v),
        "energy": (fun.at_event((speed, speed), "floor", **here), lambda t, v, e: v**2),
        "loss": (fun.loss("floor", **here), lambda t, v, e: 0.5 * MASS * v**2 * (1 - e**2)),
        "impulse": (fun.impulse("floor", **here), lambda t, v, e: MASS * v * (1 + e)),
    }
    of = {
        name: (one, picked(events, number, value) if callable(value) else value)
        for name, (one, value) in of.items()
    }
    found = compare(of, 1e-12, ball, **DROPPED)
    missing = np.isnan(instant)
    assert set(found.failures) == set(np.flatnonzero(missing).tolist())
    for reason in found.failures.values():
        assert "instant: this event of floor does not happen in this run" in reason
        assert "loss: " in reason


def test_sums_over_all_impacts_and_jumps_at_them(ball):
    events, until = impacts(), DROPPED["until"]
    first = np.array([v[0] if len(v) else G * until for _, v, _ in events])
    jumps = np.array([e * v[0] if len(v) else 0.0 for _, v, e in events])
    lowest = np.maximum(1.0 - np.repeat(DROP, len(BOUNCE)), 1.0 - 0.5 * G * until**2)
    count = [float(len(t)) for t, _, _ in events]
    before, after = [-v.sum() for _, v, _ in events], [(e * v).sum() for _, v, e in events]
    lost = [0.5 * MASS * (1 - e**2) * (v**2).sum() for _, v, e in events]
    pushed = [MASS * ((1 + e) * v).sum() for _, v, e in events]
    of = {
        "count": (fun.count("floor"), count),
        "open": (fun.count("floor", "open"), count),
        "closed": (fun.count("floor", "closed"), 0.0),
        "before": (fun.at_event("body.v", "floor", number=None), before),
        "after": (fun.at_event("body.v", "floor", number=None, side="after"), after),
        "loss": (fun.loss("floor"), lost),
        "impulse": (fun.impulse("floor", number=None), pushed),
        "peak": (fun.peak("body.v"), first),
        "highest": (fun.highest("body.v"), jumps),
        "lowest": (fun.lowest("body.v"), -first),
        "depth": (fun.lowest("body.s"), lowest),
        "way": (fun.integral("body.v"), lambda found: found["end"] - 1.0),
        "end": (fun.final("body.s"), lambda found: found["end"]),
    }
    found = compare(of, 1e-12, ball, **DROPPED)
    assert not found.failures


# -- a brake ---------------------------------------------------------------------------------------


def test_a_brake_brings_a_body_to_rest():
    """Heat is the energy of the body; where it does not stop, this instant is missing."""
    model = in_a_row(
        body=Inertia(J=0.5, phi=0.0, w=20.0),
        brake=Brake(f_max=10.0, characteristic=((0.0, 0.5),), u=1.0),
    )
    system = lp.assemble(model, keep=["body.phi"])
    force, until = np.array([12.0, 20.0, 40.0, 9.0, 1.0]), 2.0
    tau = 0.5 * force
    stop = 0.5 * 20.0 / tau
    stops = stop < until
    t = np.minimum(stop, until)
    rest = np.where(stops, stop, np.nan)
    late = np.clip(t, 1.9, None) - 1.9
    speed, begin = 20.0 - tau / 0.5 * t, 20.0 - tau / 0.5 * 1.9
    of = {
        "rest": (fun.instant("brake", "stuck"), rest),
        "any": (fun.instant("brake"), rest),
        "last": (fun.instant("brake", number=-1), rest),
        "never": (fun.instant("brake", "backward"), np.nan),
        "count": (fun.count("brake"), stops.astype(float)),
        "heat": (fun.integral("brake.tau", "brake.w"), 20.0 * tau * t - tau**2 * t**2),
        "after": (
            fun.integral("brake.tau", "brake.w", between=(1.9, until)),
            tau * late * (begin + speed) / 2 * (late > 0),
        ),
        "angle": (fun.final("body.phi"), 20.0 * t - tau * t**2),
        "speed": (fun.final("body.w"), speed),
        "before": (fun.at_event("brake.tau", "brake", "stuck"), np.where(stops, tau, np.nan)),
        "behind": (
            fun.at_event("brake.tau", "brake", "stuck", side="after"),
            np.where(stops, 0.0, np.nan),
        ),
        "most": (fun.peak("brake.tau"), tau),
        "least": (fun.lowest("brake.tau"), np.where(stops, 0.0, tau)),
        "lowest w": (fun.lowest("body.w"), speed),
    }
    over = {"brake.f_max": force}
    found = compare(of, 1e-12, system, over=over, until=until, rtol=1e-8)
    assert found["heat"][stops] == pytest.approx(0.5 * 0.5 * 20.0**2, rel=1e-12)
    assert (found["speed"][stops] == 0).all()
    assert (found["lowest w"] >= -1e-12).all()
    assert "rest: this event of brake does not happen" in found.failures[3]
    assert "never: this event of brake does not happen" in found.failures[0]
    assert set(found.failures) == set(range(5))


# -- steps of a torque whose instants are parameters -----------------------------------------------


class Pulse(lp.Component):
    """A torque from one instant to another, and one that comes at a fixed instant."""

    on: lp.Param = lp.param("s", "first instant", 0.3)
    off: lp.Param = lp.param("s", "second instant", 0.6)
    kick: lp.Param = lp.param("N.m", "torque between them", 5.0)
    body: Inertia = Inertia(J=2.0, w=0.0, phi=0.0)
    drive: Torque = Torque(tau=where(lp.time >= on, kick, 0.0) - where(lp.time > off, kick, 0.0))
    other: Torque = Torque(tau=where(lp.time >= 0.5, 1.0, 0.0))

    def connections(self):
        yield from lp.chain(self.drive, self.body)
        yield lp.connect(self.other.flange, self.body.flange_a)


def instants_of_pulses():
    """Random instants, and those that meet each other, the begin, the fixed one and the end."""
    rng = np.random.default_rng(8)
    some = rng.uniform(-0.3, 1.3, (60, 2))
    special = [-1.0, 0.0, 0.3, 0.5, 1.0, 1.0 + 1e-6, 2.0]
    return np.concatenate([some, [(a, b) for a in special for b in special]])


def test_momentum_of_a_pulse_whose_instants_are_parameters():
    on, off = instants_of_pulses().T

    def since(t, end=1.0, begin=0.0):
        return np.maximum(end - np.maximum(t, begin), 0.0)

    def speed(t):
        own = 5.0 * (since(on, t) - since(off, t))
        return (own + np.maximum(t - 0.5, 0)) / 2

    both = np.sort([on, off], axis=0)
    both[(both <= 0) | (both > 1.0)] = np.nan
    both[1, both[0] == both[1]] = np.nan  # they are one
    both.sort(axis=0)
    count = (~np.isnan(both)).sum(axis=0)
    there = np.where(count == 2, both[1], np.nan)
    part = 5.0 * (since(on, 0.75, 0.25) - since(off, 0.75, 0.25))
    of = {
        "w": (fun.final("body.w"), speed(1.0)),
        "phi": (fun.final("body.phi"), (5.0 * (since(on) ** 2 - since(off) ** 2) + 0.25) / 4),
        "momentum": (fun.integral("drive.tau"), 5.0 * (since(on) - since(off))),
        "part": (fun.integral("drive.tau", between=(0.25, 0.75)), part),
        "speed": (fun.at_event("body.w", "drive.tau", number=1), speed(there)),
    }
    instants = {
        "count": (fun.count("drive.tau"), count.astype(float)),
        "first": (fun.instant("drive.tau"), both[0]),
        "second": (fun.instant("drive.tau", number=1), both[1]),
        "last": (fun.instant("drive.tau", number=-1), np.where(count == 2, both[1], both[0])),
        "but one": (
            fun.instant("drive.tau", number=-2),
            np.where(count == 2, both[0], np.nan),
        ),
        "third": (fun.instant("drive.tau", number=-3), np.nan),
        "fixed": (fun.instant("other.tau"), 0.5),
        "torque": (fun.at_time(0.5, "other.tau"), 1.0),
    }
    system = lp.assemble(Pulse(), keep=["body.phi"])
    over = paired({"on": on, "off": off})
    for wanted, limit in ((of, 1e-13), (instants, 1e-15)):
        compare(wanted, limit, system, over=over, until=1.0, rtol=1e-9)


@pytest.mark.parametrize("side", ["before", "after"])
def test_extremes_hold_both_sides_of_a_jump(side):
    of = {
        "highest": (fun.highest("body.a"), 2.5),
        "lowest": (fun.lowest("body.a"), 0.0),
        "event": (fun.at_event("body.a", "drive.tau", side=side), 2.5 * (side == "after")),
        "part": (fun.peak("body.a", between=(0.31, 0.49)), [0.0, 2.5, 2.5]),
    }
    on = np.array([0.2, 0.3, 0.4])
    compare(of, 1e-14, lp.assemble(Pulse()), over=paired({"on": on, "off": on + 0.1}), until=1.0)


def test_extremes_hold_the_value_at_the_end():
    of = {"final": fun.final("body.a"), "highest": fun.highest("body.a")}
    over = paired({"on": [0.999, 1.0], "off": [2.0, 2.0]})
    found = lp.ensemble(lp.assemble(Pulse()), over=over, until=1.0, of=of)
    assert (found["highest"] >= found["final"]).all()


# -- impacts at the begin, and of two flanks -------------------------------------------------------


@pytest.mark.parametrize("begin", [0.0, 2.5])
def test_an_impact_at_the_begin_is_an_event(begin):
    model = in_rows(
        "body.flange_b floor.flange_b",
        body=sliding.Mass(m=MASS, s=0.0, v=-3.0),
        floor=sliding.Stop(restitution=0.5),
    )
    e = np.array([0.0, 0.3, 1.0])
    of = {
        "count": (fun.count("floor"), 1.0),
        "instant": (fun.instant("floor"), begin),
        "loss": (fun.loss("floor"), 0.5 * MASS * 9.0 * (1 - e**2)),
        "before": (fun.at_event("body.v", "floor"), -3.0),
        "after": (fun.at_event("body.v", "floor", side="after"), 3.0 * e),
        "s": (fun.final("body.s"), 3.0 * e),
    }
    of["impulse"] = fun.impulse("floor"), MASS * 3.0 * (1 + e)
    system, over = lp.assemble(model, keep=["body.s"]), {"floor.restitution": e}
    compare(of, 1e-14, system, over=over, begin=begin, until=begin + 1.0)
    run = lp.simulate(system, parameters={"floor.restitution": 0.3}, begin=begin, until=begin + 1.0)
    for functional, expected in of.values():
        assert run.value(functional) == pytest.approx(np.broadcast_to(expected, 3)[1], abs=1e-13)


def test_a_body_between_two_flanks():
    """It flies from flank to flank; each impact leaves a part of its speed."""
    model = in_a_row(
        wall=Inertia(J=1e9, phi=0.0, w=0.0),
        play=Backlash(b=0.2, restitution=0.5),
        body=Inertia(J=0.5, phi=0.0, w=2.0),
    )
    e, until = np.array([0.6, 0.8, 0.95]), 0.9
    times = 0.05 + np.cumsum([np.zeros(3), *(0.1 / e ** (k + 1) for k in range(20))], axis=0)
    count = (times < until).sum(axis=0)
    lost = 0.5 * 0.5 * 4.0 * (1 - e**2)
    of = {
        "count": (fun.count("play"), count.astype(float)),
        "loss": (fun.loss("play"), 0.5 * 0.5 * 4.0 * (1 - e ** (2 * count))),
        "second": (fun.loss("play", number=1), lost * e**2),
        "push": (fun.impulse("play", number=1), 0.5 * 2.0 * e * (1 + e)),
        "last": (fun.loss("play", number=-1), lost * e ** (2 * count - 2)),
        "third": (fun.instant("play", number=2), times[2]),
        "peak": (fun.peak("play.phi_rel"), 0.1),
    }
    over = {"play.restitution": e}
    found = compare(of, 1e-8, lp.assemble(model), over=over, until=until, rtol=1e-10)
    check("peak", found["peak"], 0.1, 1e-12)
