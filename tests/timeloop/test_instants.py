"""Impacts, rests and freewheels at single instants, against closed forms."""

import numpy as np
import pytest
from rows import assemble_row, in_rows

import lumped as lp
from lumped.components import (
    Backlash,
    Brake,
    Fixed,
    Inertia,
    OneWayClutch,
    SpringDamper,
    Torque,
    translation,
)
from lumped.errors import SolverError

G = 9.81


# -- freewheels ------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(12))
def test_a_freewheel_beside_a_play_never_turns_backwards(seed):
    rng = np.random.default_rng(seed)
    size, rate = rng.uniform(1, 5), rng.uniform(2, 15)
    speed_a, J, speed_b = rng.normal(), rng.uniform(0.3, 2), rng.normal()
    model = lp.compose(
        a=Inertia(J=1.0, w=float(speed_a), phi=0.0),
        b=Inertia(J=float(J), w=float(speed_b), phi=0.0),
        wheel=OneWayClutch(u=0.0),
        play=Backlash(b=0.1),
        load=Torque(tau=float(size) * lp.ops.sin(float(rate) * lp.time)),
        connections=lambda m: [*lp.chain(m.a, m.wheel, m.b, m.load), *lp.chain(m.a, m.play, m.b)],
    )
    run = lp.simulate(lp.assemble(model), until=4.0, grid=1000)
    assert run["wheel.w_rel"].min() > -1e-9
    impulse = float(size / rate) * (1 - np.cos(float(rate) * run.t))
    momentum = run["a.w"] + float(J) * run["b.w"]
    assert momentum - impulse == pytest.approx(speed_a + J * speed_b, abs=1e-6)


@pytest.mark.parametrize("reverse", [False, True])
def test_freewheels_that_face_each_other_make_two_shafts_one(reverse):
    wheels = {"one": OneWayClutch(u=0.0), "two": OneWayClutch(u=0.0)}
    if reverse:
        wheels = dict(reversed(wheels.items()))
    model = in_rows(
        "a.flange_a one.flange_a two.flange_b drive",
        "b.flange_a one.flange_b two",
        a=Inertia(J=1.3, w=2.0),
        b=Inertia(J=0.7, w=-1.0),
        **wheels,
        drive=Torque(tau=5.0 * lp.ops.sin(9.0 * lp.time)),
    )
    run = lp.simulate(lp.assemble(model), until=2.0, grid=200)
    expected = (1.3 * 2.0 - 0.7 + 5.0 / 9.0 * (1 - np.cos(9.0 * run.t))) / 2.0
    after = run.t > 0
    for name in ("a.w", "b.w"):
        assert run[name][after] == pytest.approx(expected[after], abs=1e-6)  # they yield a little


def test_a_brake_at_rest_beside_a_freewheel_holds_until_its_limit():
    """The freewheel bears no torque that opens it: the brake alone holds up to 2 N.m."""
    model = in_rows(
        "drive body brake",
        "body wheel.flange_b",
        "wall wheel",
        drive=Torque(tau=lp.time),
        body=Inertia(J=1.0),
        brake=Brake(characteristic=((0.0, 1.0),), f_max=2.0, u=1.0),
        wheel=OneWayClutch(u=0.0),
        wall=Fixed(),
    )
    run = lp.simulate(lp.assemble(model), until=4.0)
    (opens,) = [e.time for e in run.events if e.component == "brake" and e.after == "forward"]
    assert opens == pytest.approx(2.0, abs=1e-6)
    assert run["body.w"][-1] == pytest.approx(0.5 * (4.0 - 2.0) ** 2, rel=1e-6)


# -- impacts ---------------------------------------------------------------------------------------


class Thrown(lp.Component):
    """Point mass of 1 kg, thrown on a rough floor."""

    x = lp.var("m", "way", 0.0)
    y = lp.var("m", "height", 0.1)
    u: lp.Var = lp.var("m/s", "speed along the floor", 3.0)
    v = lp.var("m/s", "speed away from the floor", -2.0)
    pull = lp.var("N", "force of the floor, reversed")
    rub = lp.var("N", "friction")
    mu: lp.Param = lp.param("1", "friction coefficient", 0.3)
    e: lp.Param = lp.param("1", "restitution", 0.0)

    def equations(self):
        yield lp.der(self.x) == self.u
        yield lp.der(self.y) == self.v
        yield lp.der(self.u) == -self.rub
        yield lp.der(self.v) == -G - self.pull
        yield lp.hold(self.pull, self.v, gap=self.y, restitution=self.e)
        most = -self.mu * self.pull
        yield lp.hold(self.rub, self.u, forward=most, backward=-most, upper=most, lower=-most)


FALL = np.sqrt(4 + 2 * G * 0.1)
HIT = (FALL - 2) / G


@pytest.mark.parametrize("e", [0.0, 0.5])
@pytest.mark.parametrize("order", [1, -1])
def test_an_impact_presses_friction(e, order):
    """Coulomb: the impulse of friction is mu times that of the floor."""

    class Turned(Thrown):
        def equations(self):
            return list(super().equations())[::order]

    run = lp.simulate(lp.assemble(Turned(e=e)), until=HIT + 1e-3, rtol=1e-9)
    after = run.t > HIT * (1 + 1e-9)
    loose = 0.0 if e else 0.3 * G  # a mass that rests on the floor goes on rubbing
    expected = 3 - 0.3 * (1 + e) * FALL - loose * (run.t[after] - HIT)
    assert run["u"][after] == pytest.approx(expected, abs=1e-8)
    lost = sum(event.loss for event in run.events)
    before, now = (9 + FALL**2) / 2, (3 - 0.3 * (1 + e) * FALL) ** 2 / 2 + (e * FALL) ** 2 / 2
    assert lost == pytest.approx(before - now, rel=1e-8)


def test_an_impact_may_stop_a_slip():
    """Friction could give more than stops the mass: it sticks."""
    run = lp.simulate(lp.assemble(Thrown(u=0.5, mu=0.3)), until=HIT + 0.01, rtol=1e-9)
    after = run.t > HIT * (1 + 1e-9)
    assert np.abs(run["u"][after]).max() == 0.0


# -- rests -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("e", [0.3, 0.5, 0.9, 0.99])
@pytest.mark.parametrize("rtol", [1e-6, 1e-11])
def test_bounces_end_at_the_limit_of_their_series(e, rtol):
    model = lp.compose(
        ball=translation.Mass(m=1.0, s=1.0),
        floor=translation.Stop(restitution=e),
        weight=translation.Force(f=-G),
        connections=lambda m: [lp.connect(m.ball.flange_a, m.floor.flange_b, m.weight.flange)],
    )
    end = np.sqrt(2 / G) * (1 + e) / (1 - e)
    run = lp.simulate(lp.assemble(model, keep=["ball.s"]), until=end + 1.0, rtol=rtol)
    assert run.events[-1].after == "closed"
    assert run.events[-1].time == pytest.approx(end, rel=1e-11)
    # down to a rise of 1e-11 m
    assert len(run.events) == pytest.approx(1 + np.log(1e-11) / (2 * np.log(e)), abs=1.5)


def test_plays_that_throw_each_other_open_come_to_rest():
    """Two plays without restitution, against Moreau's time stepping."""
    J, c, d, free = (1.4, 1.6), 110.0, 1.5, -0.06
    plays, push = (0.32, 0.015), (-14.6, 12.6, 5.8)
    model = in_rows(
        "b spring a",
        "wall outer a load",
        "b.flange_a inner",
        "a inner.flange_b",
        a=Inertia(J=J[0], w=-3.4, phi=0.0),
        b=Inertia(J=J[1], w=1.6, phi=0.0),
        spring=SpringDamper(c=c, d=d, phi_rel0=free),
        wall=Fixed(),
        outer=Backlash(b=plays[0]),
        inner=Backlash(b=plays[1]),
        load=Torque(tau=push[0] + push[1] * lp.ops.sin(push[2] * lp.time)),
    )
    run = lp.simulate(lp.assemble(model, keep=["a.phi", "b.phi"]), until=1.0)
    assert len(run.events) < 200
    x, y = stepped(J, c, d, free, plays, push, until=1.0, steps=50_000)
    assert run["a.phi"][-1] == pytest.approx(x, abs=1e-4)
    assert run["b.phi"][-1] == pytest.approx(y, abs=1e-4)


def stepped(J, c, d, free, plays, push, until, steps):
    """Moreau's time stepping: speeds are projected on those that closed flanks allow."""
    x = y = 0.0
    v, w, h = -3.4, 1.6, until / steps
    for i in range(steps):
        force = c * (x - y - free) + d * (v - w)
        v += h * (push[0] + push[1] * np.sin(push[2] * (i + 0.5) * h) - force) / J[0]
        w += h * force / J[1]
        for _ in range(40):
            if (x <= -plays[0] / 2 and v < 0) or (x >= plays[0] / 2 and v > 0):
                v = 0.0
            gap = x - y
            if (gap <= -plays[1] / 2 and v < w) or (gap >= plays[1] / 2 and v > w):
                v = w = (J[0] * v + J[1] * w) / (J[0] + J[1])
        x, y = x + h * v, y + h * w
    return x, y


def test_events_of_a_run_that_fails_end_where_its_points_do():
    load = Torque(tau=lp.ops.where(lp.time > 5.0, 1.0, 0.0))
    parts = {"wall": Fixed(), "spring": SpringDamper(c=1e4, d=0.0), "body": Inertia(J=1.0, w=1.0)}
    system = assemble_row(**parts, load=load)
    with pytest.raises(SolverError) as caught:
        lp.simulate(system, until=10.0, method="explicit", max_steps=50)
    partial = caught.value.partial
    assert partial.t[-1] < 5.0
    assert not partial.events
