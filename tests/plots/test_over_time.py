"""Which curves share a panel, and which events are marked."""

import numpy as np
import pytest

from lumped.plots.over_time import draw_over_time
from lumped.plots.picture import Curve, Instants
from lumped.support.display_units import frequency_unit
from lumped.vibration.pictures import frequency_response_picture

T = np.linspace(0.0, 1.0, 101)
WAVE = np.sin(2 * np.pi * T)


def names_of(picture):
    return [[item.label for item in p.items if isinstance(item, Curve)] for p in picture.panels]


def pictured(quantities, events=(), all_of_them=True):
    return draw_over_time("drive", (T, "s"), quantities, events, all_of_them=all_of_them)


@pytest.mark.parametrize(
    ("sizes", "expected"),
    [
        ({"a": 1.0, "b": 1 / 29}, [["a", "b"]]),
        ({"a": 1.0, "b": 1 / 31}, [["a"], ["b"]]),
        ({"a": 1.0, "b": 1 / 31, "c": 0.9, "d": 1 / 35}, [["a", "c"], ["b", "d"]]),
        ({"a": 1.0, "b": 0.0}, [["a", "b"]]),
    ],
)
def test_curves_share_a_panel_down_to_a_thirtieth_of_its_range(sizes, expected):
    found = pictured({name: ("N.m", "torque", size * WAVE) for name, size in sizes.items()})
    assert names_of(found) == expected
    assert {panel.y.label for panel in found.panels} == {"torque, N.m"}


def test_a_ripple_high_above_zero_stands_alone():
    quantities = {"slip": ("rad/s", "", WAVE), "speed": ("rad/s", "", 1000.0 + WAVE)}
    assert names_of(pictured(quantities)) == [["slip"], ["speed"]]


def test_units_stand_apart():
    quantities = {"w": ("rad/s", "", WAVE), "tau": ("N.m", "", WAVE), "v": ("rad/s", "", WAVE)}
    found = pictured(quantities)
    assert names_of(found) == [["w", "v"], ["tau"]]
    assert [panel.y.label for panel in found.panels] == ["rad/s", "N.m"]


@pytest.mark.parametrize("seed", range(5))
def test_every_curve_is_seen_and_no_panel_is_superfluous(seed):
    rng = np.random.default_rng(seed)
    values = {}
    for i in range(12):
        offset, size = 10.0 ** rng.uniform(-2, 2, 2)
        values[f"q{i}"] = offset + size * WAVE
    found = pictured({name: ("m", "", y) for name, y in values.items()})
    groups = [set(group) for group in names_of(found)]
    assert set.union(*groups) == set(values)

    def share(names):
        every = np.concatenate([values[name] for name in names])
        return min(np.ptp(values[name]) for name in names) / np.ptp(every)

    assert all(share(group) >= 1 / 30 for group in groups)
    few = [group for group in groups if len(group) < 8]
    assert not any(
        share(a | b) >= 1 / 30 and len(a | b) <= 8 for i, a in enumerate(few) for b in few[:i]
    )


def test_what_is_left_out_is_told_unless_it_was_named():
    many = {f"q{i}": ("m", "", (1 + i / 100) * WAVE) for i in range(30)}
    found = pictured(many, all_of_them=False)
    assert [len(group) for group in names_of(found)] == [8]
    assert found.note == "22 more: choose with names"
    named = pictured(many)
    assert [len(group) for group in names_of(named)] == [8, 8, 8, 6]
    assert named.note == ""


def test_a_constant_has_room_around_it():
    (panel,) = pictured({"a": ("m", "", np.full(len(T), 200.0))}).panels
    assert (panel.y.low, panel.y.high) == pytest.approx((190.0, 210.0))


def marks_of(picture):
    return [item for item in picture.panels[0].items if isinstance(item, Instants)]


def test_few_kinds_of_events_are_told():
    events = [(0.1, "brake: slides", "changes of mode"), (0.5, "ball: hits", "impacts")]
    marks = marks_of(pictured({"a": ("m", "", WAVE)}, events))
    assert [(m.label, m.times.tolist()) for m in marks] == [
        ("brake: slides", [0.1]),
        ("ball: hits", [0.5]),
    ]
    assert len({m.mark for m in marks}) == 2


def test_many_kinds_are_told_by_their_sort():
    events = [(i / 10, f"part {i}", "changes of mode") for i in range(9)]
    (marks,) = marks_of(pictured({"a": ("m", "", WAVE)}, events))
    assert marks.label == "changes of mode"
    assert marks.texts == tuple(f"part {i}" for i in range(9))


def test_marks_of_many_events_thin_out_and_leave_no_gap():
    times = np.random.default_rng(1).uniform(0.0, 1.0, 5000)
    events = [(time, "ball: hits", "impacts") for time in times]
    (marks,) = marks_of(pictured({"a": ("m", "", WAVE)}, events))
    assert np.diff(marks.times).min() > 1 / 150
    nearest = np.abs(times[:, None] - marks.times[None, :]).min(axis=1)
    assert nearest.max() <= 1 / 150
    assert marks.label == f"ball: hits (5000, {len(marks.times)} marked)"


HERTZ = np.linspace(0.0, 30.0, 3001)


def phase_of(values):
    size = np.abs(values), np.angle(values)
    picture = frequency_response_picture(
        "drive", HERTZ, {("w", "rad/s"): {"tau": size}}, frequency_unit(), decibels=False
    )
    return picture.panels[1].items[0].y


def test_phases_go_on_without_jumps():
    """A delay of 0.2 s turns by 0.2 s times the frequency."""
    received = phase_of(np.exp(-2j * np.pi * HERTZ * 0.2))
    assert received == pytest.approx(-360 * HERTZ * 0.2, abs=1e-6)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_phase_of_half_a_turn_begins_at_minus_180(sign):
    """Rounding decides on which side of the axis ``-1`` lies."""
    received = phase_of(np.full(len(HERTZ), -1.0 + sign * 1e-17j))
    assert received == pytest.approx(np.full(len(HERTZ), -180.0))
