"""Natural frequencies of two inertias on a shaft: ``f = sqrt(c (1/J_1 + 1/J_2)) / 2 pi``."""

import numpy as np
import pytest
from rows import assemble_row

import lumped as lp
from lumped.components import Inertia, Spring, Torque
from lumped.errors import OptionError

RATED = 100 * np.pi  # 50 turns for each second


def diagram(hertz, orders, reach=(0.1, 3.0)):
    """Of a drive with a given natural frequency, over shares of the rated speed."""
    shaft = Spring(c=(2 * np.pi * hertz) ** 2 / (1 / 2.0 + 1 / 6.0))
    ends = {"motor": Torque(tau=0.0), "rotor": Inertia(J=2.0)}
    drive = assemble_row(**ends, shaft=shaft, load=Inertia(J=6.0))
    return lp.campbell(drive, speeds=RATED * np.array(reach), orders=orders)


def separation(found, between, **options):
    return lp.vibration.separation(found, between=between, **options)


@pytest.mark.parametrize(("hertz", "passed"), [(44.9, True), (45.1, False), (54.9, False)])
def test_ten_per_cent_of_a_speed_are_asked_by_name(hertz, passed):
    found = separation(diagram(hertz, [1]), (RATED, RATED), margin="API 617")
    (row,) = found.results
    assert row.value == pytest.approx(abs(hertz / 50 - 1), rel=1e-9)
    assert (row.permitted, row.passed) == (0.1, passed)
    assert "API 617 read in Wang, Feese and Pettinato (2012)" in repr(found)


@pytest.mark.parametrize(
    ("rule", "share", "passed"),
    [
        ("KR propulsion", 0.79, True),
        ("KR propulsion", 0.81, False),
        ("KR generating set", 0.81, True),
        ("KR generating set", 0.91, False),
        ("KR propulsion", 1.09, False),
        ("KR propulsion", 1.11, True),
    ],
)
def test_major_critical_speeds_keep_out_of_a_range_about_the_rated_speed(rule, share, passed):
    """Of six cylinders of four strokes order 3: critical where ``3 n = f``."""
    found = separation(diagram(150 * share, [3]), (RATED, RATED), margin=rule)
    assert found.results[0].value == pytest.approx(abs(share - 1), rel=1e-9)
    assert found.passed == passed
    assert "KR Rules for Steel Ships 2025" in repr(found)
    with pytest.raises(OptionError, match="about the rated speed"):
        separation(diagram(150 * share, [3]), (0.9 * RATED, RATED), margin=rule)


def test_a_margin_may_follow_the_order():
    """A frequency of 46.5 Hz is critical for order 1 at 93 %, for order 2 at 46.5 %."""
    found = diagram(46.5, [1, 2], reach=(0.1, 2.0))
    own = {1: 0.05, 2: 0.1}
    told = separation(found, (RATED, RATED), margin=own.get, source="contract")
    rows = {row.quantity: row for row in told.results}
    first, second = rows["mode 1, order 1"], rows["mode 1, order 2"]
    assert (first.value, first.permitted) == (pytest.approx(0.07, rel=1e-9), 0.05)
    assert (second.value, second.permitted) == (pytest.approx(0.535, rel=1e-9), 0.1)
    assert told.passed
    assert {row.source for row in told.results} == {"contract"}
    assert not separation(found, (RATED, RATED), margin=lambda order: 0.08).passed
    for wrong in (1.5, None):
        with pytest.raises(OptionError, match=rf"margin = {wrong} of order 2 must be between"):
            separation(found, (RATED, RATED), margin=lambda order, wrong=wrong: wrong)


def test_numbers_of_a_user_are_marked_as_such():
    (row,) = separation(diagram(30.0, [1]), (RATED, RATED)).results
    assert row.source == "user's number"


def test_the_frequency_of_the_line_excites_at_every_speed():
    """At 92 Hz: 84 % above the line, 8 % below its double."""
    line = {"line": 50.0, "twice the line": 100.0}
    found = diagram(92.0, [1])
    told = separation(found, (0.5 * RATED, RATED), margin="API 617", frequencies=line)
    rows = {row.quantity: row for row in told.results}
    assert rows["mode 1, line"].value == pytest.approx(0.84, rel=1e-9)
    assert rows["mode 1, twice the line"].value == pytest.approx(0.08, rel=1e-9)
    assert [row.passed for row in told.results] == [False, True, True]
    assert not told.notes
    nameless = separation(found, (RATED, RATED), frequencies=[92.0])
    assert nameless.results[0].quantity == "mode 1, 92 Hz"
    assert nameless.results[0].value < 1e-9
    for wrong, options in ((found.critical, {}), (found, {"margin": lambda order: 0.1})):
        with pytest.raises(OptionError, match="frequencies need the natural frequencies of a"):
            separation(wrong, (RATED, RATED), frequencies=[50.0], **options)
    with pytest.raises(OptionError, match="frequency -50 Hz must be positive"):
        separation(found, (RATED, RATED), frequencies=[-50.0])


def test_a_frequency_that_rises_with_the_speed_is_met_in_operation_only():
    """``c = 800 + 12 w`` between 25 Hz and 50 Hz of the shaft meets 8 Hz, not 20 Hz."""
    drive = assemble_row(
        motor=Torque(tau=0.0), rotor=Inertia(J=2.0), shaft=Spring(c=800.0), load=Inertia(J=6.0)
    )

    def point(w):
        return lp.start_point(drive, parameters={"shaft.c": 800.0 + 12.0 * w})

    speeds = RATED * np.linspace(0.1, 2.0, 40)
    found = lp.campbell(drive, speeds=speeds, orders=[9], at=point)

    def hertz(w):
        return np.sqrt((800.0 + 12.0 * w) * (1 / 2.0 + 1 / 6.0)) / (2 * np.pi)

    middle = hertz(0.75 * RATED)
    told = separation(found, (0.5 * RATED, RATED), frequencies=[middle, 20.0])
    rows = {row.quantity: row for row in told.results}
    assert rows[f"mode 1, {middle:g} Hz"].utilisation == np.inf
    far = rows["mode 1, 20 Hz"]
    assert far.value == pytest.approx(1 - hertz(RATED) / 20.0, rel=1e-4)
    assert far.speed == pytest.approx(RATED)
    on_lines = "between the 40 speeds of the diagram natural frequencies are taken on lines"
    assert told.notes[-1] == on_lines


def test_a_rule_without_text_is_refused_with_the_list():
    with pytest.raises(OptionError, match=r"API 617.*KR propulsion.*KR generating set"):
        separation(diagram(30.0, [1]), (RATED, RATED), margin="API 618")
