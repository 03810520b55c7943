"""Events: located exactly, settled together, kept in the trajectory."""

import itertools

import numpy as np
import pytest
from rows import assemble_one, assemble_row, assemble_rows, in_a_row, one

import lumped as lp
from lumped.components import Brake, ElastoBacklash, Fixed, Inertia, Spring
from lumped.components.translation import Mass
from lumped.errors import EquationError, SingularModelError, StartError
from lumped.ops import cos, sin, where


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
    assert received == pytest.approx(expected, abs=1e-8)
    assert {(e.before, e.after) for e in run.events} == {("x >= 0", "x < 0"), ("x < 0", "x >= 0")}


def test_both_sides_of_a_jump_of_a_state_are_kept():
    def equations(self):
        yield lp.der(self.x) == 1.0
        yield lp.when(self.x >= 1.0, {self.x: 0.25 * self.x})

    run = lp.simulate(
        assemble_one(x=lp.var("1", "sawtooth"), equations=equations), until=3.0, grid=30
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
    run = lp.simulate(assemble_one(equations=equations, **quantities), until=2.0)
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
    system = assemble_one(equations=equations, **quantities)
    run = lp.simulate(system, until=1.0, method=method)
    assert run["y"][-1] == expected
    # "x <= 2" ends at once
    assert len(changes(run)) == (expected or text == "x <= 2") * (text != "time >= 0.5")


def contradicting(self):
    yield lp.der(self.x) == 1.0
    yield self.y == where(self.y >= 1.0, 0.5 - self.x, 1.5 - 1e-3 * self.x)


def test_conditions_that_contradict_themselves_are_named():
    quantities = {"x": lp.var("1", "time"), "y": lp.var("1", "without a value")}
    with pytest.raises(StartError, match="no set of modes fits"):
        lp.simulate(assemble_one(contradicting, **quantities), until=2.0)


@pytest.mark.parametrize(
    ("kind", "law", "text"),
    [
        (EquationError, lambda m: lp.hold(m.y, m.x, upper=1.0), "give forward="),
        (
            EquationError,
            lambda m: lp.hold(m.y, m.x, forward=-1.0, backward=1.0, upper=-1.0, lower=1.0),
            r"hold\(y, .*upper = -1.0 must be at least lower = 1.0",
        ),
        # y follows, so it is no state
        (SingularModelError, lambda m: lp.when(m.x >= 1.0, {m.y: 0.0}), "state='always'"),
    ],
)
def test_limits_and_changes_that_make_no_sense_are_refused(kind, law, text):
    def equations(self):
        yield lp.der(self.x) == 1.0
        if kind is SingularModelError:
            yield self.y == 2 * self.x
        yield law(self)

    quantities = {"x": lp.var("1", "speed"), "y": lp.var("1", "reaction or follower")}
    with pytest.raises(kind, match=text):
        assemble_one(equations, **quantities)


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
    system = assemble_rows(
        "crank slider.turn",
        "slider.slide mass.flange_a push",
        crank=Inertia(J=1.0, w=3.0, phi=0.5),
        mass=Mass(m=0.5),
        slider=RodSlider(),
        push=SwitchedForce(),
    )
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
    assert np.abs(received).max() < 1e-12
    assert len(late) > 6
    assert max(late) < 1e-10
    assert drift < 1e-8


def test_a_drive_vibrates_against_a_brake_that_holds_and_freely_once_it_lets_go():
    system = assemble_row(
        rotor=Inertia(J=1.0),
        shaft=Spring(c=100.0),
        drum=Inertia(J=2.0),
        brake=Brake(f_max=100.0, u=where(lp.time >= 1.0, 0.0, 1.0)),
    )
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
    run = lp.simulate(assemble_one(equations=equations, **quantities), until=1.1)
    told = [(round(e.time, 9), e.kind, e.before, e.after) for e in run.events]
    assert told == [
        (0.25, "time", "time >= 0 and time < 0.25", "time >= 0.25 and time < 1"),
        (0.4, "time", "time < 0.4", "time >= 0.4"),
        (0.5, "time", "time < 0.5, time <= 0.5", "time >= 0.5, time > 0.5"),
        (1.0, "time", "time >= 0.25 and time < 1", "time >= 1 and time < 1.25"),
    ]


def test_a_play_tells_its_flanks():
    """A body of 1 kg.m2 in a play of 0.2 rad between springs that turns at 1 rad/s: 0.1 s each."""
    play, body = ElastoBacklash(c=4e4, b=0.2), Inertia(J=1.0, phi=0.0, w=1.0)
    model = in_a_row(wall=Fixed(), play=play, body=body)
    run = lp.simulate(lp.assemble(model), until=0.5, rtol=1e-9)
    contact = np.pi / 200  # half a period at 200 rad/s
    begins = [0.1, 0.1 + contact, 0.3 + contact, 0.3 + 2 * contact]
    words = ["in the play", "front flank", "in the play", "back flank", "in the play"]
    assert [(e.before, e.after) for e in run.events] == [*itertools.pairwise(words)]
    assert [e.time for e in run.events] == pytest.approx(begins, abs=1e-7)
    assert {e.kind for e in run.events} == {"condition"}
