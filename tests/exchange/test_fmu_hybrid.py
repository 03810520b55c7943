"""Exported models with events: friction, impacts, contact, jumps of states, linkages."""

import numpy as np
import pytest
from bits import Unit
from fmus import LIMITED, compare, fmpy, runs
from linkages import double_rocker, four_bar, rocker_angle
from rows import assemble_row, assemble_rows, in_a_row
from specification import build, read

import lumped as lp
from lumped.components import (
    Backlash,
    Fixed,
    Inertia,
    SampleHold,
    SpeedSensor,
    SpringDamper,
    Torque,
    translation,
)
from lumped.errors import SolverError
from lumped.ops import where


def instants(found):
    """Where events were recorded: rows at the same time."""
    t = found["time"]
    return np.unique(t[1:][np.diff(t) == 0])


def test_clutches_follow_the_reference_and_change_at_its_instants(tmp_path):
    case = read("rot_coupled_clutches")
    speeds = [name for name in case.columns if name.endswith(".w")]
    system = lp.assemble(build(case))
    options = {"until": case.stop, "start": case.start, "outputs": speeds}
    run = compare(system, tmp_path, **options)
    changes = np.unique([e.time for e in run.events])
    assert len(changes) >= 7
    smooth = np.abs(case.t[:, None] - changes).min(axis=1) > 1e-5
    for version, kind, found in runs(system, tmp_path, record_events=True, points=1000, **options):
        for name in speeds:
            near = np.interp(case.t, found["time"], found[name])
            error = np.abs(near - case.columns[name])[smooth].max() / np.ptp(case.columns[name])
            assert error < 1e-4, f"{version} {kind} {name}: {error:.1e}"
        if kind == "ModelExchange":
            late = max(np.abs(instants(found) - t).min() for t in changes[changes > 0])
            print(f"{len(changes)} instants of change, the farthest off by {late:.1e} s")
            assert late < 1e-8


HEIGHT, G = 1.3, 9.81
FALL = np.sqrt(2 * HEIGHT / G)
"""How long a ball falls at first, s."""


def ball(restitution):
    return assemble_rows(
        "floor mass",
        "floor weight",
        floor=translation.Stop(restitution=restitution),
        mass=translation.Mass(m=1.0, s=HEIGHT, v=0.0),
        weight=translation.Force(f=-G),
    )


def bounces(e, count):
    """Their first instants, s."""
    return FALL * (1 + 2 * e * (1 - e ** np.arange(count)) / (1 - e))


def test_bounces_in_a_play_that_grow_ever_shorter_end(tmp_path):
    """A disc in a play is thrown to and fro; every time its bounces accumulate."""
    model = in_a_row(
        drive=Torque(tau=5.0 * lp.ops.sin(20.0 * lp.time)),
        rotor=Inertia(J=0.3),
        play=Backlash(b=0.03, restitution=0.3),
        disc=Inertia(J=0.2),
        shaft=SpringDamper(c=80.0, d=0.3),
        wall=Fixed(),
    )
    run = compare(lp.assemble(model), tmp_path, until=1.0, versions=("2.0",))
    assert len(run.events) > 30


def test_a_closed_linkage_turns_with_its_rocker(tmp_path):
    """Freudenstein's closed form, and the energy."""
    system = lp.assemble(four_bar(w=10.0))
    outputs = ["rocker.phi", "rocker.w"]
    for _, kind, found in runs(system, tmp_path, until=1.0, versions=("2.0",), outputs=outputs):
        expected = rocker_angle(np.asarray(found["crank.phi"]))
        error = np.abs(np.exp(1j * found["rocker.phi"]) - np.exp(1j * expected)).max()
        energy = 2.0 * found["crank.w"] ** 2 + 3.0 * found["rocker.w"] ** 2
        print(f"{kind}: {error:.1e} rad, energy {np.ptp(energy) / energy[0]:.1e}")
        assert error < 1e-6
        assert np.ptp(energy) < 1e-6 * energy[0]


def reasons(path, **options):
    """What a unit of each kind says last when its run up to 2 s fails."""
    for kind in ("ModelExchange", "CoSimulation"):
        told = []
        with pytest.raises(fmpy.fmi1.FMICallException):
            fmpy.simulate_fmu(
                str(path),
                fmi_type=kind,
                stop_time=2.0,
                logger=lambda *message, told=told: told.append(message[-1].decode()),
                **options,
            )
        yield told[-1]


def test_a_crank_at_its_dead_centre_ends_the_run_with_a_reason(tmp_path):
    path = tmp_path / "swinging.fmu"
    result = lp.export_fmu(lp.assemble(double_rocker(w=3.0)), path, version="2.0")
    assert "dead centre" in repr(result)
    for reason in reasons(path, output_interval=1e-4):
        assert "should lead instead of crank.phi" in reason


def test_two_settings_of_a_state_at_one_instant_end_the_run_with_both_names(tmp_path):
    class Counter(lp.Component):
        """Counts, and starts anew, when an angle comes to one."""

        angle: lp.Var = lp.var("1", "rises with the time")
        x: lp.Var = lp.var("1", "count", 1.0)

        def equations(self):
            yield lp.der(self.angle) == 1.0
            yield lp.der(self.x) == 0
            yield lp.when(self.angle >= 1.0, {self.x: self.x + 1})
            yield lp.when(2 * self.angle >= 2.0, {self.x: 0.0})

    system = lp.assemble(lp.compose(counter=Counter()))
    with pytest.raises(SolverError) as caught:
        lp.simulate(system, until=2.0)
    path = tmp_path / "counter.fmu"
    lp.export_fmu(system, path, version="2.0")
    for reason in reasons(path):
        assert reason.partition(" s ")[2] == str(caught.value).partition(" s ")[2]
        assert "t = 1" in reason


def test_a_steady_start_holds_in_the_positions_of_the_parameters_set(tmp_path):
    # 3 before the limiter: the lag starts with what passes, and follows 3 exp(-t) below the limit
    system = lp.assemble(LIMITED)
    for highest in (1.0, 2.0, 5.0):
        changed = {"start_values": {"limiter.y_max": highest}}
        for version, kind, found in runs(system, tmp_path, until=0.4, points=4, **changed):
            assert found["lag.x"][0] == pytest.approx(min(3.0, highest), rel=1e-9), (version, kind)
            if highest < 3.0 * np.exp(-0.4):
                assert found["lag.x"] == pytest.approx(np.full(5, highest), rel=1e-6)


def test_steps_stop_at_the_events_of_a_ball_if_they_may(tmp_path):
    """The bounces of the closed form, told one by one; speeds before and after each."""
    e, path = 0.8, tmp_path / "ball.fmu"
    system, hits = ball(e), bounces(e, 3)
    lp.export_fmu(system, path, version="3.0", kind="co_simulation")
    names = system.state_names
    for handled in (False, True):
        unit = Unit(path, stop=2.0, rtol=1e-10, event_mode=handled, early_return=True)
        found, time = [], 0.0
        while time < 2.0:
            event, ended, early, reached = unit.fmu.doStep(time, 2.0 - time)
            assert not ended
            assert event == (early and handled)
            assert early == (reached < 2.0)
            before = unit.get(names)
            if event:
                unit.fmu.enterEventMode()
                again, ended, _, jumped, *_ = unit.fmu.updateDiscreteStates()
                assert (again, ended, jumped) == (False, False, True)
                unit.fmu.enterStepMode()
            after, time = unit.get(names), reached
            if early:
                found.append((reached, before, after))
        unit.close()
        late = np.abs(np.array([t for t, *_ in found]) - hits).max()
        print(f"{late:.1e} s")
        assert late < 1e-8
        place = next(i for i, n in enumerate(names) if n.endswith((".v", ".v_rel")))
        for k, (_, before, after) in enumerate(found):
            down = e**k * G * FALL
            expected = (down if handled else e * down, e * down)
            assert (abs(before[place]), abs(after[place])) == pytest.approx(expected, rel=1e-7)


def test_a_unit_that_stops_at_instants_makes_the_same_run(tmp_path):
    """A torque that changes with the time, and FMPy in its event mode."""
    torque = where(lp.time >= 0.5, where(lp.time >= 1.05, 0.3, -2.0), 1.0)
    system = assemble_row(drive=Torque(tau=torque), body=Inertia(J=0.5))
    path = tmp_path / "timed.fmu"
    lp.export_fmu(system, path, version="3.0", kind="co_simulation")
    found = fmpy.simulate_fmu(
        str(path),
        stop_time=1.6,
        output_interval=0.2,
        output=["body.w"],
        use_event_mode=True,
        early_return_allowed=True,
    )
    t = found["time"]
    assert np.abs(instants(found) - [0.5, 1.05]).max() < 1e-12
    expected = (
        np.minimum(t, 0.5) - 2 * np.clip(t - 0.5, 0, 0.55) + 0.3 * np.maximum(t - 1.05, 0)
    ) / 0.5
    assert np.abs(found["body.w"] - expected).max() < 1e-9
    for stop in (None, 0.5, 0.8, 1.05):  # and goes on beyond the stop time, also from an instant
        unit = Unit(path, stop=stop)
        for begin, end in ((0.0, 0.5), (0.5, 0.8), (0.8, 1.05), (1.05, 1.6)):
            unit.step(begin, end)
        assert unit.get(["body.w"]) == pytest.approx([expected[-1]], abs=1e-9)
        unit.close()


class Sampled(lp.Component):
    """A speed w = t, sampled every 0.1 s, and thresholds that it passes at a sample and between."""

    passed: lp.Var = lp.var("1", "thresholds passed")
    drive: Torque = Torque(tau=2.0)
    body: Inertia = Inertia(J=2.0, w=0.0)
    sensor: SpeedSensor = SpeedSensor()
    hold: SampleHold = SampleHold(T_s=0.1)

    def connections(self):
        yield from lp.chain(self.drive, self.body, self.sensor)
        yield lp.connect(self.sensor.w, self.hold.u)

    def equations(self):
        yield self.passed == sum(where(self.body.w > limit, 1.0, 0.0) for limit in (0.3, 0.75))


NAMES = ["hold.y", "passed", "body.w"]


@pytest.fixture(scope="module")
def clocked(tmp_path_factory):
    path = tmp_path_factory.mktemp("clocked") / "clocked.fmu"
    options = {"version": "3.0", "kind": "co_simulation", "outputs": NAMES}
    lp.export_fmu(lp.assemble(Sampled()), path, **options)
    return path


@pytest.mark.parametrize("early", [True, False])
def test_events_at_communication_points_are_told_there(clocked, early):
    """Also if the point is off by a rounding; all that happens at an instant is one event."""
    unit = Unit(clocked, stop=2.0, event_mode=True, early_return=early)
    samples = [float(np.nextafter(k / 10, (0.0, k / 10, 2.0)[k % 3])) for k in range(1, 11)]
    between = [0.65, 0.75, 0.95]
    begin = 0.0
    for end in sorted([*samples, *between]):
        event, ended, left, reached = unit.fmu.doStep(begin, end - begin)
        assert (ended, left, reached) == (False, False, pytest.approx(end, rel=1e-15))
        assert event is (end in samples or end == 0.75)
        y, passed, w = unit.get(NAMES)
        assert (y, w) == pytest.approx((np.ceil(10 * end - 1e-9) / 10 - 0.1, end), abs=1e-12)
        assert passed == (end > 0.31) + (end > 0.76)
        if event:
            unit.fmu.enterEventMode()
            unit.fmu.updateDiscreteStates()
            y, passed, w = unit.get(NAMES)
            unit.fmu.enterStepMode()
        assert (y, w) == pytest.approx((np.floor(10 * end + 1e-9) / 10, end), abs=1e-12)
        assert passed == (end > 0.29) + (end > 0.74)
        begin = reached
    unit.close()


def test_an_event_inside_a_step_is_told_only_if_the_step_may_end_there(clocked):
    """With the event mode alone the unit handles it, and tells that at the end of the step."""
    unit = Unit(clocked, stop=2.0, event_mode=True, early_return=False)
    assert unit.fmu.doStep(0.0, 0.25) == (False, False, False, 0.25)
    assert unit.get(["hold.y"]) == pytest.approx([0.2], abs=1e-12)
    assert unit.fmu.doStep(0.25, 0.25) == (True, False, False, 0.5)
    assert unit.get(["hold.y"]) == pytest.approx([0.4], abs=1e-12)
    unit.close()
    unit = Unit(clocked, stop=2.0, event_mode=False, early_return=True)
    event, ended, left, reached = unit.fmu.doStep(0.0, 0.25)
    assert (event, ended, left) == (False, False, True)
    assert reached == pytest.approx(0.1, rel=1e-14)
    assert unit.get(["hold.y"]) == pytest.approx([0.1], abs=1e-12)
    event, ended, left, reached = unit.fmu.doStep(reached, 0.2 - reached)
    assert (event, ended, left, reached) == (False, False, False, 0.2)
    assert unit.get(["hold.y"]) == pytest.approx([0.2], abs=1e-12)
    unit.close()
