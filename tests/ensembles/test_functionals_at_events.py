"""Functionals of events in the time loop, against closed forms of impacts, brakes and steps."""

import numpy as np
import pytest
from rows import in_a_row
from test_functionals_in_runs import check

import lumped as lp
from lumped import functionals as fun
from lumped.components import Backlash, Brake, Inertia, Torque
from lumped.components import translation as sliding
from lumped.ops import sin, where

paired = lp.ensembles.paired
G = 9.81


# -- a ball ----------------------------------------------------------------------------------------

DROP = np.array([0.2, 0.5, 0.9, 1.0, 5.0])
BOUNCE = np.array([0.7, 0.8, 0.9])
MASS = 2.0


@pytest.fixture(scope="module")
def ball():
    model = lp.compose(
        body=sliding.Mass(m=MASS, s=1.0, v=0.0),
        weight=sliding.Force(f=-MASS * G),
        floor=sliding.Stop(restitution=0.5),
        connections=lambda m: [
            lp.connect(m.weight.flange, m.body.flange_a),
            lp.connect(m.body.flange_b, m.floor.flange_b),
        ],
    )
    return lp.assemble(model, keep=["body.s"])


def dropped(ball, of, until, rtol=1e-8):
    over = {"floor.s_min": 1.0 - DROP, "floor.restitution": BOUNCE}
    return lp.ensemble(ball, over=over, until=until, of=of, rtol=rtol)


def impacts(until):
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


UNTIL = 0.9


@pytest.mark.parametrize("number", [0, 1, -1, -2, 3, -4])
def test_single_impacts_of_a_ball(ball, number):
    of = {
        "instant": fun.instant("floor", number=number),
        "open": fun.instant("floor", "open", number=number),
        "before": fun.at_event("body.v", "floor", number=number),
        "after": fun.at_event("body.v", "floor", "open", number=number, side="after"),
        "energy": fun.at_event(("body.v", "body.v"), "floor", number=number),
        "loss": fun.loss("floor", number=number),
        "impulse": fun.impulse("floor", number=number),
    }
    events, found = impacts(UNTIL), dropped(ball, of, UNTIL)
    expected = {
        "instant": picked(events, number, lambda t, v, e: t),
        "open": picked(events, number, lambda t, v, e: t),
        "before": picked(events, number, lambda t, v, e: -v),
        "after": picked(events, number, lambda t, v, e: e * v),
        "energy": picked(events, number, lambda t, v, e: v**2),
        "loss": picked(events, number, lambda t, v, e: 0.5 * MASS * v**2 * (1 - e**2)),
        "impulse": picked(events, number, lambda t, v, e: MASS * v * (1 + e)),
    }
    for name, value in expected.items():
        check(f"{name}, number {number}", found[name], value, 1e-12)
    missing = np.isnan(expected["instant"])
    assert set(found.failures) == set(np.flatnonzero(missing).tolist())
    for reason in found.failures.values():
        assert "instant: this event of floor does not happen in this run" in reason
        assert "loss: " in reason


def test_sums_over_all_impacts_and_jumps_at_them(ball):
    of = {
        "count": fun.count("floor"),
        "open": fun.count("floor", "open"),
        "closed": fun.count("floor", "closed"),
        "before": fun.at_event("body.v", "floor", number=None),
        "after": fun.at_event("body.v", "floor", number=None, side="after"),
        "loss": fun.loss("floor"),
        "impulse": fun.impulse("floor", number=None),
        "peak": fun.peak("body.v"),
        "highest": fun.highest("body.v"),
        "lowest": fun.lowest("body.v"),
        "depth": fun.lowest("body.s"),
        "way": fun.integral("body.v"),
        "end": fun.final("body.s"),
    }
    events, found = impacts(UNTIL), dropped(ball, of, UNTIL)
    first = np.array([v[0] if len(v) else G * UNTIL for _, v, _ in events])
    jumps = np.array([e * v[0] if len(v) else 0.0 for _, v, e in events])
    lowest = np.maximum(1.0 - np.repeat(DROP, len(BOUNCE)), 1.0 - 0.5 * G * UNTIL**2)
    assert found["count"].tolist() == [len(t) for t, _, _ in events]
    assert (found["open"] == found["count"]).all()
    assert (found["closed"] == 0).all()
    assert not found.failures
    check("before", found["before"], [-v.sum() for _, v, _ in events], 1e-12)
    check("after", found["after"], [(e * v).sum() for _, v, e in events], 1e-12)
    lost = [0.5 * MASS * (1 - e**2) * (v**2).sum() for _, v, e in events]
    check("loss", found["loss"], lost, 1e-12)
    pushed = [MASS * ((1 + e) * v).sum() for _, v, e in events]
    check("impulse", found["impulse"], pushed, 1e-12)
    check("peak at the jump", found["peak"], first, 1e-12)
    check("lowest at the jump", found["lowest"], -first, 1e-12)
    check("highest after it", found["highest"], jumps, 1e-12)
    check("depth", found["depth"], lowest, 1e-12)
    check("way", found["way"], found["end"] - 1.0, 1e-12)


# -- a brake ---------------------------------------------------------------------------------------


def test_a_brake_brings_a_body_to_rest():
    """Heat is the energy of the body; where it does not stop, this instant is missing."""
    model = in_a_row(
        body=Inertia(J=0.5, phi=0.0, w=20.0),
        brake=Brake(f_max=10.0, characteristic=((0.0, 0.5),), u=1.0),
    )
    system = lp.assemble(model, keep=["body.phi"])
    force, until = np.array([12.0, 20.0, 40.0, 9.0, 1.0]), 2.0
    of = {
        "rest": fun.instant("brake", "stuck"),
        "any": fun.instant("brake"),
        "last": fun.instant("brake", number=-1),
        "never": fun.instant("brake", "backward"),
        "count": fun.count("brake"),
        "heat": fun.integral("brake.tau", "brake.w"),
        "after": fun.integral("brake.tau", "brake.w", between=(1.9, until)),
        "angle": fun.final("body.phi"),
        "speed": fun.final("body.w"),
        "before": fun.at_event("brake.tau", "brake", "stuck"),
        "behind": fun.at_event("brake.tau", "brake", "stuck", side="after"),
        "most": fun.peak("brake.tau"),
        "least": fun.lowest("brake.tau"),
        "lowest w": fun.lowest("body.w"),
    }
    found = lp.ensemble(system, over={"brake.f_max": force}, until=until, of=of, rtol=1e-8)
    tau = 0.5 * force
    stop = 0.5 * 20.0 / tau
    stops = stop < until
    t = np.minimum(stop, until)
    late = np.clip(t, 1.9, None) - 1.9
    for name in ("rest", "any", "last"):
        check(name, found[name], np.where(stops, stop, np.nan), 1e-12)
    assert np.isnan(found["never"]).all()
    assert found["count"].tolist() == stops.astype(float).tolist()
    check("heat", found["heat"], 20.0 * tau * t - tau**2 * t**2, 1e-12)
    assert found["heat"][stops] == pytest.approx(0.5 * 0.5 * 20.0**2, rel=1e-12)
    speed = 20.0 - tau / 0.5 * t
    begin = 20.0 - tau / 0.5 * 1.9
    check("late heat", found["after"], tau * late * (begin + speed) / 2 * (late > 0), 1e-12)
    check("angle", found["angle"], 20.0 * t - tau * t**2, 1e-12)
    check("speed", found["speed"], speed, 1e-12)
    assert (found["speed"][stops] == 0).all()
    check("before", found["before"], np.where(stops, tau, np.nan), 1e-12)
    check("behind", found["behind"], np.where(stops, 0.0, np.nan), 1e-12)
    check("most", found["most"], tau, 1e-12)
    check("least", found["least"], np.where(stops, 0.0, tau), 1e-12)
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
    of = {
        "w": fun.final("body.w"),
        "phi": fun.final("body.phi"),
        "momentum": fun.integral("drive.tau"),
        "part": fun.integral("drive.tau", between=(0.25, 0.75)),
        "count": fun.count("drive.tau"),
        "first": fun.instant("drive.tau"),
        "second": fun.instant("drive.tau", number=1),
        "last": fun.instant("drive.tau", number=-1),
        "but one": fun.instant("drive.tau", number=-2),
        "third": fun.instant("drive.tau", number=-3),
        "speed": fun.at_event("body.w", "drive.tau", number=1),
        "fixed": fun.instant("other.tau"),
        "torque": fun.at_time(0.5, "other.tau"),
    }
    system = lp.assemble(Pulse(), keep=["body.phi"])
    found = lp.ensemble(system, over=paired({"on": on, "off": off}), until=1.0, of=of, rtol=1e-9)

    def since(t, end=1.0, begin=0.0):
        return np.maximum(end - np.maximum(t, begin), 0.0)

    def speed(t):
        own = 5.0 * (since(on, t) - since(off, t))
        return (own + np.maximum(t - 0.5, 0)) / 2

    check("speed", found["w"], speed(1.0), 1e-13)
    angle = (5.0 * (since(on) ** 2 - since(off) ** 2) + 0.25) / 4
    check("angle", found["phi"], angle, 1e-13)
    check("momentum", found["momentum"], 5.0 * (since(on) - since(off)), 1e-13)
    part = 5.0 * (since(on, 0.75, 0.25) - since(off, 0.75, 0.25))
    check("momentum in a part", found["part"], part, 1e-13)
    both = np.sort([on, off], axis=0)
    both[(both <= 0) | (both > 1.0)] = np.nan
    both[1, both[0] == both[1]] = np.nan  # they are one
    both.sort(axis=0)
    count = (~np.isnan(both)).sum(axis=0)
    assert (found["count"] == count).all()
    check("first", found["first"], both[0], 1e-15)
    check("second", found["second"], both[1], 1e-15)
    check("last", found["last"], np.where(count == 2, both[1], both[0]), 1e-15)
    check("but one", found["but one"], np.where(count == 2, both[0], np.nan), 1e-15)
    check("third", found["third"], np.nan, 1e-15)
    there = np.where(count == 2, both[1], np.nan)
    check("speed at the second", found["speed"], np.where(count == 2, speed(there), np.nan), 1e-13)
    assert (found["fixed"] == 0.5).all()
    assert (found["torque"] == 1.0).all()


@pytest.mark.parametrize("side", ["before", "after"])
def test_extremes_hold_both_sides_of_a_jump(side):
    of = {
        "highest": fun.highest("body.a"),
        "lowest": fun.lowest("body.a"),
        "event": fun.at_event("body.a", "drive.tau", side=side),
        "part": fun.peak("body.a", between=(0.31, 0.49)),
    }
    on = np.array([0.2, 0.3, 0.4])
    system = lp.assemble(Pulse())
    found = lp.ensemble(system, over=paired({"on": on, "off": on + 0.1}), until=1.0, of=of)
    check("highest", found["highest"], 2.5, 1e-14)
    check("lowest", found["lowest"], 0.0, 1e-14)
    check("at the jump", found["event"], 2.5 * (side == "after"), 1e-14)
    check("part", found["part"], [0.0, 2.5, 2.5], 1e-14)


def test_extremes_hold_the_value_at_the_end():
    of = {"final": fun.final("body.a"), "highest": fun.highest("body.a")}
    over = paired({"on": [0.999, 1.0], "off": [2.0, 2.0]})
    found = lp.ensemble(lp.assemble(Pulse()), over=over, until=1.0, of=of)
    assert (found["highest"] >= found["final"]).all()


# -- impacts at the begin, and of two flanks -------------------------------------------------------


@pytest.mark.parametrize("begin", [0.0, 2.5])
def test_an_impact_at_the_begin_is_an_event(begin):
    model = lp.compose(
        body=sliding.Mass(m=MASS, s=0.0, v=-3.0),
        floor=sliding.Stop(restitution=0.5),
        connections=lambda m: [lp.connect(m.body.flange_b, m.floor.flange_b)],
    )
    of = {
        "count": fun.count("floor"),
        "instant": fun.instant("floor"),
        "loss": fun.loss("floor"),
        "before": fun.at_event("body.v", "floor"),
        "after": fun.at_event("body.v", "floor", side="after"),
        "s": fun.final("body.s"),
        "lowest": fun.lowest("body.v"),
    }
    e = np.array([0.0, 0.3, 1.0])
    over = {"floor.restitution": e}
    system = lp.assemble(model, keep=["body.s"])
    found = lp.ensemble(system, over=over, begin=begin, until=begin + 1.0, of=of)
    check("count", found["count"], 1.0, 1e-15)
    check("instant", found["instant"], begin, 1e-15)
    check("loss", found["loss"], 0.5 * MASS * 9.0 * (1 - e**2), 1e-14)
    check("before", found["before"], -3.0, 1e-15)
    check("after", found["after"], 3.0 * e, 1e-15)
    check("s", found["s"], 3.0 * e, 1e-14)


def test_a_body_between_two_flanks():
    """It flies from flank to flank; each impact leaves a part of its speed."""
    model = in_a_row(
        wall=Inertia(J=1e9, phi=0.0, w=0.0),
        play=Backlash(b=0.2, restitution=0.5),
        body=Inertia(J=0.5, phi=0.0, w=2.0),
    )
    of = {
        "count": fun.count("play"),
        "loss": fun.loss("play"),
        "second": fun.loss("play", number=1),
        "push": fun.impulse("play", number=1),
        "last": fun.loss("play", number=-1),
        "way": fun.integral("body.w"),
        "peak": fun.peak("play.phi_rel"),
        "third": fun.instant("play", number=2),
    }
    e, until = np.array([0.6, 0.8, 0.95]), 0.9
    over = {"play.restitution": e}
    found = lp.ensemble(lp.assemble(model), over=over, until=until, of=of, rtol=1e-10)
    times = 0.05 + np.cumsum([np.zeros(3), *(0.1 / e ** (k + 1) for k in range(20))], axis=0)
    count = (times < until).sum(axis=0)
    lost = 0.5 * 0.5 * 4.0 * (1 - e**2)
    assert (found["count"] == count).all()
    check("loss", found["loss"], 0.5 * 0.5 * 4.0 * (1 - e ** (2 * count)), 1e-8)
    check("second", found["second"], lost * e**2, 1e-8)
    check("impulse", found["push"], 0.5 * 2.0 * e * (1 + e), 1e-8)
    check("last", found["last"], lost * e ** (2 * count - 2), 1e-8)
    check("third", found["third"], times[2], 1e-8)
    check("peak", found["peak"], 0.1, 1e-12)


# -- teeth -----------------------------------------------------------------------------------------


class Toothed(lp.Component):
    """A wheel that slows down, and a switch at the top of each of its teeth."""

    teeth: lp.Param = lp.param("1", "number of teeth over a turn of one radian", 100.0)
    level: lp.Param = lp.param("1", "height at which it switches", 0.999)
    x: lp.Var = lp.var("rad", "angle", 0.0, state="always")
    y: lp.Var = lp.var("1", "whether it is at a top")

    def equations(self):
        yield lp.der(self.x) == 1.0 - 0.3 * self.x
        yield self.y == where(sin(self.teeth * self.x) > self.level, 1.0, 0.0)


def test_a_switch_at_the_top_of_each_tooth_misses_none():
    """Steps turn the sine by many radians, and it passes its level by a thousandth only."""
    teeth, level, until = np.linspace(20.0, 250.0, 100), 0.999, 2.0
    end = teeth * (1 - np.exp(-0.3 * until)) / 0.3
    rise = np.arcsin(level)
    falls = np.pi - rise
    expected = sum(np.floor((end - angle) / (2 * np.pi)) + 1 for angle in (rise, falls))
    of = {"switched": fun.count("Toothed")}
    found = lp.ensemble(lp.assemble(Toothed()), over={"teeth": teeth}, until=until, of=of)
    missed = expected - found["switched"]
    print(f"{int(missed.sum())} of {int(expected.sum())} events missed")
    assert not missed.any()
