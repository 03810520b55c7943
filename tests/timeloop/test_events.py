"""Events: located exactly, settled together, kept in the trajectory."""

import itertools

import numpy as np
import pytest
from scipy.optimize import brentq

import lumped as lp
from lumped.components import (
    BearingFriction,
    Brake,
    ElastoBacklash,
    Fixed,
    IdealGear,
    Inertia,
    Spring,
    Torque,
)
from lumped.components.translation import Force, Mass
from lumped.errors import EquationError, SingularModelError, StartError
from lumped.ops import cos, sin, where

EPS = np.finfo(float).eps


def one(**attributes):
    """A model that is one component with these equations."""
    equations = attributes.pop("equations")
    kind = type("Part", (lp.Component,), {"__doc__": "Under test.", **attributes})
    kind.equations = equations
    return kind()


def changes(run):
    """Events that change a mode."""
    return [event for event in run.events if event.kind != "time"]


@pytest.mark.parametrize("method", ["explicit", "implicit", "taylor"])
def test_a_condition_on_a_state_is_located_where_it_changes(method):
    def equations(self):
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == where(self.x >= 0, -4 * self.x, -self.x)

    model = one(
        x=lp.var("m", "position", start=1.0), v=lp.var("m/s", "velocity"), equations=equations
    )
    run = lp.simulate(lp.assemble(model), until=20.0, rtol=1e-10, method=method)
    received = np.array([event.time for event in run.events])
    # quarter of the fast period, then halves of the slow and the fast one in turn
    halves = np.tile([np.pi, np.pi / 2], 10)
    expected = np.pi / 4 + np.concatenate([[0], np.cumsum(halves)])
    expected = expected[expected < 20]
    error = np.abs(received - expected).max()
    print(f"{len(received)} events, error {error:.1e} s")
    assert len(received) == len(expected)
    assert error < 1e-8
    assert {(e.before, e.after) for e in run.events} == {
        ("x >= 0", "x < 0"),
        ("x < 0", "x >= 0"),
    }


def test_a_short_dip_below_a_border_is_not_passed_over():
    def equations(self):
        yield lp.der(self.x) == where(sin(lp.time) >= -0.999, 1.0, 0.0)

    run = lp.simulate(
        lp.assemble(one(x=lp.var("1", "counted time"), equations=equations)), until=60.0
    )
    half = np.arccos(0.999)
    middles = 1.5 * np.pi + 2 * np.pi * np.arange(9)
    expected = np.sort(np.concatenate([middles - half, middles + half]))
    received = np.array([event.time for event in run.events])
    print(f"{len(received)} events; time outside {run['x'][-1]:.6f} s")
    assert len(received) == len(expected)
    assert np.abs(received - expected).max() < 1e-12 * 60
    assert abs(run["x"][-1] - (60.0 - 18 * half)) < 1e-11


def test_both_sides_of_a_jump_of_a_state_are_kept():
    def equations(self):
        yield lp.der(self.x) == 1.0
        yield lp.when(self.x >= 1.0, {self.x: 0.25 * self.x})

    run = lp.simulate(
        lp.assemble(one(x=lp.var("1", "sawtooth"), equations=equations)), until=3.0, grid=30
    )
    received = [event.time for event in run.events]
    expected = [1.0, 1.75, 2.5]
    assert np.allclose(received[::1][: len(expected)], expected, atol=1e-12)
    for t in expected:
        sides = run["x"][np.isclose(run.t, t, atol=1e-9)]
        assert np.isclose(sides.max(), 1.0, atol=1e-12)
        assert np.isclose(sides.min(), 0.25, atol=1e-12)


def test_values_of_a_when_are_those_just_before_and_chains_run_in_one_instant():
    def equations(self):
        for name in ("a", "b", "count"):
            yield lp.der(getattr(self, name)) == 0
        yield lp.when(lp.time >= 1.0, {self.a: self.b, self.b: self.a})
        yield lp.when(self.a >= 2.0, {self.count: self.count + 1.0})
        yield lp.when(self.count >= 1.0, {self.count: self.count + 10.0})

    quantities = {
        "a": lp.var("1", "first", start=1.0),
        "b": lp.var("1", "second", start=2.0),
        "count": lp.var("1", "counted"),
    }
    run = lp.simulate(lp.assemble(one(equations=equations, **quantities)), until=2.0)
    received = [run[name][-1] for name in ("a", "b", "count")]
    assert received == [2.0, 1.0, 11.0]
    assert {event.time for event in run.events} == {1.0}


AT_THE_START = {
    "x >= 1": (lambda m: m.x >= 1.0, 0),
    "x >= 2": (lambda m: m.x >= 2.0, 0),
    "3 x >= 6": (lambda m: 3 * m.x >= 0.1 * 60, 0),
    "x <= 2": (lambda m: m.x <= 2.0, 0),
    "held >= 2": (lambda m: m.held >= 2.0, 0),
    "held > 2": (lambda m: m.held > 2.0, 0),
    "x > 1": (lambda m: m.x > 1.0, 0),
    "x > 2": (lambda m: m.x > 2.0, 1),
    "x >= 2.5": (lambda m: m.x >= 2.5, 1),
    "time >= 0": (lambda m: lp.time >= 0.0, 0),
    "time >= held - 2": (lambda m: lp.time >= m.held - 2.0, 0),
    "time > held - 2": (lambda m: lp.time > m.held - 2.0, 1),
    "time >= 0.5": (lambda m: lp.time >= 0.5, 1),
}


@pytest.mark.parametrize("text", AT_THE_START)
@pytest.mark.parametrize("method", ["explicit", "implicit", "taylor"])
def test_a_condition_true_from_the_start_does_nothing_one_that_becomes_true_acts(text, method):
    condition, expected = AT_THE_START[text]

    def equations(self):
        yield lp.der(self.x) == 1.0
        yield lp.der(self.held) == 0
        yield lp.der(self.y) == 0
        yield lp.when(condition(self), {self.y: self.y + 1.0})

    quantities = {
        "x": lp.var("1", "rises", start=2.0),
        "held": lp.var("1", "rests", start=2.0),
        "y": lp.var("1", "count"),
    }
    system = lp.assemble(one(equations=equations, **quantities))
    run = lp.simulate(system, until=1.0, method=method)
    assert run["y"][-1] == expected
    # "x <= 2" ends at once
    assert len(changes(run)) == (expected or text == "x <= 2") * (text != "time >= 0.5")


def test_a_sampled_signal_changes_at_its_instants_only():
    def equations(self):
        yield lp.der(self.next) == 0
        yield lp.der(self.held) == 0
        yield lp.when(lp.time > self.next, {self.next: self.next + 0.1, self.held: sin(lp.time)})

    quantities = {"next": lp.var("s", "next instant"), "held": lp.var("1", "held value")}
    run = lp.simulate(lp.assemble(one(equations=equations, **quantities)), until=2.05, grid=997)
    received = run["held"]
    last = np.floor(run.t / 0.1 + 1e-9) * 0.1
    # at an instant itself both sides stand in the record
    inside = np.abs(run.t - last) > 1e-9
    error = np.abs(received - np.sin(last))[inside].max()
    print(f"error {error:.1e}")
    assert error < 1e-11


def collided(ratio, restitution):
    """A wheel that drives a mass against a wall through a gear and a rack."""

    class Wall(lp.Component):
        """Stop at a position of the flange."""

        flange = lp.LinearFlange()
        e: lp.Param = lp.param("1", "restitution", restitution)
        gap: lp.Var = lp.var("m", "distance to the wall")
        v: lp.Var = lp.var("m/s", "its rate")
        f: lp.Var = lp.var("N", "reaction")

        def equations(self):
            yield self.gap == 1.0 - self.flange.s
            yield self.v == lp.der(self.gap)
            yield self.flange.f == -self.f
            yield lp.hold(self.f, self.v, gap=self.gap, restitution=self.e)

    from lumped.components import RackAndPinion

    return lp.compose(
        wheel=Inertia(J=0.3, w=2.0 * ratio),
        gear=IdealGear(ratio=ratio),
        shaft=Inertia(J=0.2),
        spring=Spring(c=50.0, phi_rel=0.0),
        pinion=Inertia(J=0.1, w=2.0),
        rack=RackAndPinion(radius=0.5),
        mass=Mass(m=4.0, s=0.0),
        wall=Wall(),
        connections=lambda m: [
            *lp.chain(m.wheel, m.gear, m.shaft, m.spring, m.pinion, m.rack),
            lp.connect(m.rack.flange_b, m.mass.flange_a),
            lp.connect(m.mass.flange_b, m.wall.flange),
        ],
    )


@pytest.mark.parametrize("restitution", [0.0, 0.4])
def test_an_impact_stops_what_is_rigidly_joined_and_nothing_else(restitution):
    run = lp.simulate(lp.assemble(collided(3.0, restitution)), until=1.2, rtol=1e-10)
    hit = next(event for event in run.events if event.component == "wall")
    after = np.flatnonzero(run.t == hit.time)[-1]
    before = np.flatnonzero(run.t == hit.time)[0]
    # uniform motion at 2 rad/s and 1 m/s until the wall is reached after 1 s
    assert abs(hit.time - 1.0) < 1e-9
    v = run["mass.v"]
    assert abs(v[before] - 1.0) < 1e-9
    assert abs(v[after] + restitution) < 1e-9
    assert abs(run["pinion.w"][after] + 2 * restitution) < 1e-9
    # the wheel is behind the spring and does not feel the blow
    assert abs(run["wheel.w"][after] - run["wheel.w"][before]) < 1e-12
    expected = 0.5 * (4.0 * 1.0**2 + 0.1 * 2.0**2) * (1 - restitution**2)
    print(f"loss {hit.loss:.9f} J, expected {expected:.9f} J")
    assert abs(hit.loss - expected) < 1e-9 * expected


def energy(run):
    w = [
        0.5 * J * run[f"{name}.w"] ** 2
        for name, J in (("wheel", 0.3), ("shaft", 0.2), ("pinion", 0.1))
    ]
    return sum(w) + 0.5 * 4.0 * run["mass.v"] ** 2 + 0.5 * 50.0 * run["spring.phi_rel"] ** 2


def test_energy_of_a_rattling_drive_is_what_its_impacts_leave():
    run = lp.simulate(lp.assemble(collided(-2.0, 0.7)), until=100.0, rtol=1e-10)
    received = energy(run)
    lost = np.array([[event.time, event.loss] for event in run.events if event.loss])
    expected = received[0] - np.array([lost[lost[:, 0] < t, 1].sum() for t in run.t])
    inside = ~np.isin(run.t, lost[:, 0])
    error = np.abs(received - expected)[inside].max() / received[0]
    print(f"{len(lost)} impacts, {lost[:, 1].sum():.4f} J lost, error of the energy {error:.1e}")
    assert len(lost) >= 2
    assert error < 1e-8


def test_a_contact_opens_where_its_force_vanishes():
    """A mass on a vibrating table lifts off where ``sin(w t) == g / (a w^2)``."""

    class Table(lp.Component):
        """Table that follows a sine, below a body that may lift off."""

        flange = lp.LinearFlange()
        gap: lp.Var = lp.var("m", "height over the table")
        v: lp.Var = lp.var("m/s", "its rate")
        f: lp.Var = lp.var("N", "reaction")

        def equations(self):
            yield self.gap == self.flange.s - 0.01 * sin(40 * lp.time)
            yield self.v == lp.der(self.gap)
            yield self.flange.f == self.f
            yield lp.hold(self.f, self.v, gap=self.gap)

    model = lp.compose(
        body=Mass(m=2.0, s=0.0, v=0.4),
        weight=Force(f=-2.0 * 9.81),
        table=Table(),
        connections=lambda m: [lp.connect(m.body.flange_a, m.weight.flange, m.table.flange)],
    )
    run = lp.simulate(lp.assemble(model), until=0.2, rtol=1e-10)
    lift, land = (event.time for event in changes(run)[:2])
    expected = np.arcsin(9.81 / (0.01 * 1600)) / 40
    assert abs(lift - expected) < 1e-9
    s, v = 0.01 * np.sin(40 * expected), 0.4 * np.cos(40 * expected)

    def height(t):
        return s + v * (t - expected) - 0.5 * 9.81 * (t - expected) ** 2 - 0.01 * np.sin(40 * t)

    expected = brentq(height, expected + 0.02, 0.2, xtol=1e-14)
    print(f"lifts at {lift:.9f} s, lands at {land:.9f} s, errors {land - expected:.1e} s")
    assert abs(land - expected) < 1e-8


def test_a_hold_without_inertia_on_one_side_is_refused():
    class Grip(lp.Component):
        """Dry friction between two flanges."""

        flange_a = lp.Flange()
        flange_b = lp.Flange()
        w: lp.Var = lp.var("rad/s", "relative speed")
        tau: lp.Var = lp.var("N.m", "friction")

        def equations(self):
            yield self.w == lp.der(self.flange_b.phi - self.flange_a.phi)
            yield self.flange_b.tau == self.tau
            yield self.flange_a.tau == -self.tau
            yield lp.hold(self.tau, self.w, forward=1.0, backward=-1.0, upper=1.0, lower=-1.0)

    model = lp.compose(
        wall=Fixed(),
        spring=Spring(c=10.0),
        grip=Grip(),
        body=Inertia(J=1.0),
        drive=Torque(tau=1.0),
        connections=lambda m: lp.chain(m.wall, m.spring, m.grip, m.body, m.drive),
    )
    with pytest.raises(SingularModelError, match="grip holds and slides"):
        lp.assemble(model)


def test_conditions_that_contradict_themselves_are_named():
    def contrary(self):
        yield lp.der(self.x) == 1.0
        yield self.y == where(self.y >= 1.0, 0.5 - self.x, 1.5 - 1e-3 * self.x)

    quantities = {"x": lp.var("1", "time"), "y": lp.var("1", "without a value")}
    system = lp.assemble(one(equations=contrary, **quantities))
    with pytest.raises(StartError, match="no set of modes fits"):
        lp.simulate(system, until=2.0)


def test_limits_without_a_law_beyond_them_are_refused():
    def equations(self):
        yield lp.der(self.x) == 0
        yield lp.hold(self.y, self.x, upper=1.0)

    quantities = {"x": lp.var("1", "speed"), "y": lp.var("1", "reaction")}
    with pytest.raises(EquationError, match="give forward="):
        lp.assemble(one(equations=equations, **quantities))


def test_limits_that_leave_nothing_between_them_are_refused():
    def equations(self):
        yield lp.der(self.x) == 0
        yield lp.hold(self.y, self.x, forward=-1.0, backward=1.0, upper=-1.0, lower=1.0)

    quantities = {"x": lp.var("1", "speed"), "y": lp.var("1", "reaction")}
    with pytest.raises(
        EquationError, match=r"hold\(y, .*upper = -1.0 must be at least lower = 1.0"
    ):
        lp.assemble(one(equations=equations, **quantities))


def test_a_change_of_a_quantity_that_is_no_state_is_refused():
    def equations(self):
        yield lp.der(self.x) == 1.0
        yield self.y == 2 * self.x
        yield lp.when(self.x >= 1.0, {self.y: 0.0})

    quantities = {"x": lp.var("1", "state"), "y": lp.var("1", "follower")}
    with pytest.raises(SingularModelError, match="state='always'"):
        lp.assemble(one(equations=equations, **quantities))


class RodSlider(lp.Component):
    """Crank and connecting rod, closed implicitly by the angle of the rod."""

    turn = lp.Flange()
    slide = lp.LinearFlange()
    q: lp.Var = lp.var("rad", "angle of the rod", start=0.1)

    def equations(self):
        a, q = self.turn.phi, self.q
        yield sin(q) == 0.4 * sin(a)
        yield self.slide.s == 0.4 * cos(a) + cos(q)
        ratio = -0.4 * sin(a) - sin(q) * 0.4 * cos(a) / cos(q)
        yield self.turn.tau == -ratio * self.slide.f


class SwitchedForce(lp.Component):
    """Force that acts beyond a position only."""

    flange = lp.LinearFlange()

    def equations(self):
        yield self.flange.f == where(self.flange.s >= 1.2, -0.5, 0.0)


def test_events_of_a_linkage_that_is_closed_implicitly_keep_it_closed():
    model = lp.compose(
        crank=Inertia(J=1.0, w=3.0, phi=0.5),
        mass=Mass(m=0.5),
        slider=RodSlider(),
        push=SwitchedForce(),
        connections=lambda m: [
            lp.connect(m.crank.flange_b, m.slider.turn),
            lp.connect(m.slider.slide, m.mass.flange_a, m.push.flange),
        ],
    )
    system = lp.assemble(model)
    assert "slider.q" in system.report().implicit
    run = lp.simulate(system, until=10.0, rtol=1e-10)
    a, s = run["crank.phi"], run["mass.s"]
    received = s - (0.4 * np.cos(a) + np.sqrt(1 - (0.4 * np.sin(a)) ** 2))
    late = [abs(s[run.t == event.time] - 1.2).max() for event in changes(run)]
    # the force is conservative: 0.5 N from the position 1.2 m on
    rod = run["slider.q"]
    w = run["crank.w"]
    v = w * (-0.4 * np.sin(a) - np.sin(rod) * 0.4 * np.cos(a) / np.cos(rod))
    energy = 0.5 * w**2 + 0.25 * v**2 - 0.5 * np.maximum(s - 1.2, 0.0)
    drift = np.ptp(energy) / energy[0]
    print(
        f"{len(late)} events, gap {np.abs(received).max():.1e} m, "
        f"at {max(late):.1e} m, drift of the energy {drift:.1e}"
    )
    assert np.abs(received).max() < 1e-12
    assert len(late) > 6
    assert max(late) < 1e-10
    assert drift < 1e-8


def test_event_times_can_be_differentiated_by_parameters():
    """A margin that is used up moves by ``-(dz/dp) / (dz/dt)``."""

    def equations(self):
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == -4 * self.x
        yield lp.der(self.y) == where(self.x >= self.border, 1.0, -1.0)

    model = one(
        x=lp.var("m", "position", start=1.0),
        v=lp.var("m/s", "velocity"),
        y=lp.var("1", "what switches"),
        border=lp.param("m", "border", 0.3),
        equations=equations,
    )
    system = lp.assemble(model)
    run = lp.simulate(system, until=1.0, rtol=1e-11)
    t = run.events[0].time
    assert abs(t - 0.5 * np.arccos(0.3)) < 1e-10
    place = system.places(["border"])
    before = np.flatnonzero(run.t == t)[0]
    point = [run.x[before], run.theta, t, run.pieces[0].settings[-1]]
    margin = system.margins
    by_border = margin.jacobian()(*point, *margin(*point))[1]
    rate = system.margin_rates(*point)
    received = float(-np.asarray(by_border)[0, place[0]] / np.asarray(rate)[0, 0])
    expected = -0.5 / np.sqrt(1 - 0.3**2)
    print(f"dt/dborder = {received:.9f} s/m, error {received - expected:.1e}")
    assert abs(received - expected) < 1e-8


def test_a_drive_vibrates_against_a_brake_that_holds_and_freely_once_it_lets_go():
    model = lp.compose(
        rotor=Inertia(J=1.0),
        shaft=Spring(c=100.0),
        drum=Inertia(J=2.0),
        brake=Brake(f_max=100.0, u=where(lp.time >= 1.0, 0.0, 1.0)),
        connections=lambda m: [
            *lp.chain(m.rotor, m.shaft, m.drum),
            lp.connect(m.drum.flange_b, m.brake.flange_a),
        ],
    )
    system = lp.assemble(model)
    held = lp.modes(system)
    assert held.rigid == 0
    assert held.hertz == pytest.approx([np.sqrt(100.0) / (2 * np.pi)], rel=1e-12)
    free = lp.modes(system, at=lp.equilibrium(system, time=2.0))
    assert free.rigid == 1
    assert free.hertz == pytest.approx([np.sqrt(150.0) / (2 * np.pi)], rel=1e-12)


def test_functions_of_time_tell_the_pieces_before_and_after():
    pulses = lp.ops.interpolate(lp.time, (0.0, 0.25, 1.0), (0.0, 1.0, 0.0), period=1.0)
    kinks = lp.ops.interpolate(lp.time, (0.0, 0.4, 0.8), (0.0, 1.0, 0.0))

    def equations(self):
        yield lp.der(self.x) == where(lp.time >= 0.5, 1.0, 0.0)
        yield lp.der(self.y) == kinks + where(lp.time > 0.5, 1.0, 0.0)
        yield lp.der(self.z) == pulses

    quantities = {name: lp.var("1", name) for name in "xyz"}
    run = lp.simulate(lp.assemble(one(equations=equations, **quantities)), until=1.1)
    told = [(round(e.time, 9), e.kind, e.before, e.after) for e in run.events]
    assert told == [
        (0.25, "time", "time >= 0 and time < 0.25", "time >= 0.25 and time < 1"),
        (0.4, "time", "time < 0.4", "time >= 0.4"),
        (0.5, "time", "time < 0.5, time <= 0.5", "time >= 0.5, time > 0.5"),
        (1.0, "time", "time >= 0.25 and time < 1", "time >= 1 and time < 1.25"),
    ]


def test_a_play_tells_its_flanks():
    """A body of 1 kg.m2 in a play of 0.2 rad between springs that turns at 1 rad/s: 0.1 s each."""
    model = lp.compose(
        body=Inertia(J=1.0, phi=0.0, w=1.0),
        play=ElastoBacklash(c=4e4, b=0.2),
        wall=Fixed(),
        connections=lambda m: lp.chain(m.wall, m.play, m.body),
    )
    run = lp.simulate(lp.assemble(model), until=0.5, rtol=1e-9)
    contact = np.pi / 200  # half a period at 200 rad/s
    begins = [0.1, 0.1 + contact, 0.3 + contact, 0.3 + 2 * contact]
    words = ["in the play", "front flank", "in the play", "back flank", "in the play"]
    assert [(e.before, e.after) for e in run.events] == [*itertools.pairwise(words)]
    assert [e.time for e in run.events] == pytest.approx(begins, abs=1e-7)
    assert {e.kind for e in run.events} == {"condition"}


def test_events_of_all_kinds_survive_a_file(tmp_path):
    model = lp.compose(
        push=Torque(tau=where(lp.time >= 0.5, 0.0, 3.0)),
        body=Inertia(J=1.0),
        rub=BearingFriction(characteristic=((0.0, 1.0), (2.0, 1.0))),
        connections=lambda m: lp.chain(m.push, m.body, m.rub),
    )
    run = lp.simulate(lp.assemble(model), until=2.0)
    # 2 N.m accelerate for 0.5 s, 1 N.m brakes for a second
    assert [(e.kind, e.after) for e in run.events] == [("time", "time >= 0.5"), ("hold", "stuck")]
    assert run.events[-1].time == pytest.approx(1.5, abs=1e-9)
    assert lp.load(run.save(tmp_path / "run.nc")).events == run.events
