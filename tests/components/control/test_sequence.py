"""Position switches, choices among signals and speed profiles, against closed forms."""

import numpy as np
import pytest
from rows import assemble_rows
from scipy.optimize import brentq

import lumped as lp
from lumped.components import (
    AngleSensor,
    Expression,
    Latch,
    Minimum,
    PositionSequencer,
    Sine,
    Speed,
    SpeedProfile,
    SquareRootController,
    StepSequencer,
    Switch,
)
from lumped.errors import EquationError


def fed(part, until, grid=400, **signals):
    """Run of a block whose inputs are functions of the time."""
    model = lp.compose(
        part=part,
        signals={name: Expression(value=value) for name, value in signals.items()},
        connections=lambda m: [
            lp.connect(m.signals[name].y, getattr(m.part, name)) for name in signals
        ],
    )
    return lp.simulate(lp.assemble(model), until=until, grid=grid, rtol=1e-10)


def test_the_smaller_of_two_signals_changes_where_they_meet():
    run = fed(Minimum(), 3.0, a=lp.time, b=2.0 - lp.time**2)
    assert run["part.y"] == pytest.approx(np.minimum(run.t, 2 - run.t**2), abs=1e-12)
    (meeting,) = (event.time for event in run.events if event.component == "part")
    assert meeting == pytest.approx(1.0, abs=1e-9)


def test_a_switch_takes_the_first_signal_while_the_command_is_above_one_half():
    run = fed(Switch(), 2.0, u=lp.time, a=5.0 + lp.time, b=-1.0 + 0.0 * lp.time)
    late = run["part.y"] > 0
    assert late[run.t > 0.5].all()
    assert not late[run.t < 0.5].any()
    assert run["part.y"][run.t > 0.5] == pytest.approx(5 + run.t[run.t > 0.5])


def test_a_latch_remembers_and_does_not_mind_a_signal_that_falls_back():
    # sin t rises through 0.5 at pi/6 and through 0.9 at asin 0.9, and then again each turn
    system = assemble_rows(
        "wave.y latch.u memory.u",
        wave=Sine(amplitude=1.0, frequency=1 / (2 * np.pi)),
        latch=Latch(on=0.5, off=0.9),
        memory=Latch(on=0.5),
    )
    run = lp.simulate(system, until=4 * np.pi, grid=1000, rtol=1e-10)
    turn = run.t % (2 * np.pi)
    closed = (turn > np.pi / 6) & (turn < np.arcsin(0.9))
    near = np.abs(turn[:, None] - [np.pi / 6, np.arcsin(0.9)]).min(axis=1) < 1e-6
    assert (run["latch.y"][~near] == closed[~near]).all()
    assert (run["memory.y"][~near] == (run.t > np.pi / 6)[~near]).all()
    changes = [e.time for e in run.events if "latch" in e.component]
    # falling back through 0.9 it is open already
    first = [np.pi / 6, np.arcsin(0.9), 5 * np.pi / 6]
    expected = [t + 2 * np.pi * turn for turn in range(2) for t in first]
    assert changes == pytest.approx(expected, abs=1e-8)


def test_a_latch_begins_as_it_is_told():
    latch = Latch(on=1.0, off=2.0, x=1.0)
    run = fed(latch, 3.0, u=lp.time)
    assert (run["part.y"] == np.where(run.t < 2, 1.0, 0.0))[np.abs(run.t - 2) > 1e-6].all()


def test_a_signal_that_jumps_past_both_values_leaves_a_latch_open():
    u = lp.ops.where(lp.time >= 1.0, 3.0, 0.0)
    run = fed(Latch(on=1.0, off=2.0), 2.0, u=u)
    assert run["part.y"][-1] == 0.0


class Ramp(lp.Component):
    """Rises with the time, as the time held does."""

    y = lp.Output("1", "position")
    x: lp.Var = lp.var("1", "position", state="always")

    def equations(self):
        yield lp.der(self.x) == 1.0
        yield self.y == self.x


def test_who_leaves_at_the_end_of_the_dwell_has_been_there_long_enough():
    part = PositionSequencer(targets=(0.0, 5.0), tolerance=0.25, dwell=0.25)
    system = assemble_rows("ramp.y part.measured", ramp=Ramp(), part=part)
    run = lp.simulate(system, until=1.0)
    assert run["part.step"][-1] == 1.0
    assert run["part.held"][-1] == 0.0


def steps(run, part="part"):
    """Instants at which a sequencer changes its target."""
    wanted = np.flatnonzero(np.diff(run[f"{part}.step"]))
    return run.t[wanted]


def test_a_sequencer_steps_on_after_the_way_to_each_target_and_its_dwell():
    """The error falls as ``exp(-5 t)``: it is within 0.01 after ``ln(|way| / 0.01) / 5``."""
    system = assemble_rows(
        *("part.y control.wanted", "control.y drive.w", "drive sensor"),
        "sensor.phi control.measured part.measured",
        part=PositionSequencer(targets=(1.0, -0.5, 2.0), tolerance=0.01, dwell=0.3),
        control=SquareRootController(K=5.0, a=1e30),
        drive=Speed(),
        sensor=AngleSensor(),
    )
    run = lp.simulate(system, until=8.0, grid=500, rtol=1e-11)
    at, place, expected = 0.0, 0.0, []
    for target in (1.0, -0.5, 2.0):
        way = target - place
        at += np.log(abs(way) / 0.01) / 5 + 0.3
        expected.append(at)
        place = target - np.sign(way) * 0.01 * np.exp(-5 * 0.3)
    assert steps(run) == pytest.approx(expected, abs=1e-8)
    assert run["sensor.phi"][-1] == pytest.approx(2.0, abs=1e-6)
    assert (run["part.done"] == (run["part.step"] == 3)).all()
    assert run["part.y"][-1] == 2.0


def test_a_target_that_is_left_too_early_must_be_held_anew():
    # a sine is within 0.1 of 1 for this time, once in each turn
    reach = 2 * np.arccos(0.9)
    part, wave = PositionSequencer(targets=(1.0,), tolerance=0.1), lp.ops.sin(lp.time)
    never = fed(part.with_({"dwell": reach + 0.01}), 20.0, measured=wave)
    assert (never["part.step"] == 0).all()
    once = fed(part.with_({"dwell": reach - 0.01}), 20.0, measured=wave)
    assert steps(once) == pytest.approx([np.arcsin(0.9) + reach - 0.01], abs=1e-8)


def test_targets_next_to_each_other_take_a_dwell_each():
    part = PositionSequencer(targets=(0.0, 0.05, 0.0, -0.05), tolerance=0.1, dwell=0.25)
    run = fed(part, 3.0, measured=0.0 * lp.time)
    assert steps(run) == pytest.approx([0.25, 0.5, 0.75, 1.0], abs=1e-9)
    assert run["part.step"][-1] == 4
    assert run["part.done"][-1] == 1


def test_a_sequencer_begins_where_it_is_told():
    part = PositionSequencer(targets=(1.0, 2.0, 3.0), tolerance=0.1, dwell=0.15, step=1.0)
    run = fed(part, 5.0, measured=lp.time)
    assert run["part.y"][0] == 2.0
    assert steps(run) == pytest.approx([2.05, 3.05], abs=1e-9)


def test_a_speed_profile_brakes_to_each_lower_section_in_time():
    sections, a = ((0.0, 0.5), (2.0, 3.0), (9.0, 1.2), (10.0, 0.4), (12.0, 2.0)), 0.7
    run = fed(SpeedProfile(sections=sections, a=a), 14.0, u=lp.time - 1.0, grid=3000)

    def allowed(s):
        here = max([i for i, (begin, _) in enumerate(sections) if begin <= s], default=0)
        ahead = [
            np.sqrt(v**2 + 2 * a * (begin - s)) for begin, v in sections[here + 1 :] if begin > s
        ]
        return min([sections[here][1], *ahead])

    s = run.t - 1.0
    clear = np.abs(s[:, None] - [0.0, 2.0, 9.0, 10.0, 12.0]).min(axis=1) > 1e-6
    expected = np.array([allowed(x) for x in s])
    assert run["part.y"][clear] == pytest.approx(expected[clear], abs=1e-9)
    # what follows the profile never has to brake harder than a: d(y^2/2)/ds >= -a
    falling = np.diff(run["part.y"] ** 2 / 2)[clear[1:] & clear[:-1]]
    assert (falling >= -a * np.diff(s)[clear[1:] & clear[:-1]] - 1e-9).all()


def test_steps_begin_where_the_position_reaches_them_and_stay_when_it_falls_back():
    # u = 3 sin t reaches 1 and 2, falls back, and reaches 3.5 with the drift of the second turn
    sections = ((0.0, 0.5), (1.0, 3.0), (2.0, 1.2), (3.5, 0.4))
    u = 3 * lp.ops.sin(lp.time) + 0.1 * lp.time
    run = fed(StepSequencer(sections=sections), 9.0, u=u, clear=1.0 + 0 * lp.time, grid=900)
    highest = np.maximum.accumulate(3 * np.sin(run.t) + 0.1 * run.t)
    by_hand = np.array([v for _, v in sections])[np.searchsorted([1.0, 2.0, 3.5], highest + 1e-9)]
    assert (run["part.y"] == by_hand).mean() > 0.99  # both sides of a jump are recorded
    times = sorted({event.time for event in run.events if event.component == "part"})
    assert times == pytest.approx(
        [brentq(lambda t, s=s: 3 * np.sin(t) + 0.1 * t - s, *span) for s, span in REACHED], abs=1e-8
    )


REACHED = ((1.0, (0.0, 1.0)), (2.0, (0.3, 1.5)), (3.5, (6.5, 7.85)))


def test_a_step_that_waits_stands_until_it_is_clear_and_goes_on_only_then():
    sections = ((0.0, 1.0), (1.0, 2.0), (2.0, 3.0))
    part = StepSequencer(sections=sections, waits=(1,))
    clear = lp.ops.where(lp.time >= 2.5, 1.0, 0.0)
    run = fed(part, 3.0, u=lp.time, clear=clear, grid=600)
    inside = [(run.t > a) & (run.t < b) for a, b in ((0, 1), (1, 2.5), (2.5, 3))]
    for span, value in zip(inside, (1.0, 0.0, 3.0), strict=True):
        assert (run["part.y"][span] == value).all()
    assert run["part.step"][-1] == 2


@pytest.mark.parametrize(
    ("sections", "text"),
    [
        ((), "no rows of two numbers"),
        (((0.0, 1.0), (0.0, 2.0)), "0 -> 0"),
        (((0.0, -1.0),), "speed -1"),
        ("fast", "no rows of two numbers"),
    ],
)
def test_sections_that_make_no_sense_are_refused(sections, text):
    with pytest.raises(EquationError, match=text) as refused:
        fed(SpeedProfile(sections=sections, a=1.0), 1.0, u=lp.time)
    assert "part (SpeedProfile)" in str(refused.value)


def test_a_step_that_does_not_exist_cannot_wait():
    part = StepSequencer(sections=((0.0, 1.0), (1.0, 2.0)), waits=(2,))
    with pytest.raises(EquationError, match="no step 2; the steps are 0 to 1"):
        fed(part, 1.0, u=lp.time, clear=1.0 + 0 * lp.time)
