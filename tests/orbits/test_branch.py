"""Branches of periodic motions, against tables, closed forms and independent solutions."""

import numpy as np
import pytest
from torsional_cases import RPM, columns

import lumped as lp
from lumped.errors import OptionError
from tests.orbits.test_orbit_range import CASE, Hardening

LOW, HIGH = 180 * RPM, 380 * RPM


def driven_at(n, **changes):
    """The motion of the cubic spring at a speed, from rest."""
    system = lp.assemble(Hardening())
    period = 2 * np.pi / n
    given = {"n": n, **changes}
    return lp.periodic(system, period=period, parameters=given, warm_up=60 * period)


@pytest.fixture(scope="module")
def hard():
    return lp.orbits.branch(driven_at(LOW), along={"n": (LOW, HIGH)}, turns=1)


def test_folds_of_a_cubic_spring_are_those_of_the_table(hard):
    folds = columns(CASE, "duffing_hard_folds.csv", texts=("what",))["speed_exact_rpm"][:2]
    found = np.sort([point.value / RPM for point in hard.named("fold")])
    assert found == pytest.approx(folds, rel=2e-10)  # the digits of the table
    assert [point.kind for point in hard.points] == ["fold", "fold"]
    first, second = (point.number for point in hard.points)
    assert (hard.largest[first + 1 : second] > 1).all()
    assert (hard.largest[:first] < 1).all()
    assert (hard.largest[second + 1 :] < 1).all()
    assert all("was asked for is reached" in end for end in hard.ends)


def test_motions_of_a_sweep_that_jumps_are_those_of_the_stable_parts(hard):
    """Points of the table are from sweeps up and down, each begun where the last settled."""
    table = columns(CASE, "duffing_hard_branches.csv", texts=("sweep",))
    upper, lower = (point.value for point in hard.points)
    for k in range(0, len(table["n_rpm"]), 4):
        n, up = table["n_rpm"][k] * RPM, table["sweep"][k] == "up"
        stable = [orbit for orbit in hard.at(n) if orbit.stable]
        assert len(stable) == (2 if lower < n < upper else 1)
        amplitudes = [abs(orbit.harmonics("x", 2)[2]) for orbit in stable]
        found = max(amplitudes) if up else min(amplitudes)
        assert found == pytest.approx(table["first_harmonic_exact_rad"][k], rel=1e-7)


def test_the_table_and_the_picture_tell_what_is_passed(hard):
    text = repr(hard)
    unstable = int((hard.largest > 1 + 1e-6).sum())
    assert f"{len(hard.values)} periodic motions" in text
    assert f"{unstable} of them unstable" in text
    assert text.count("fold") == 2
    assert "<table" in hard._repr_html_() or "<pre" in hard._repr_html_()
    axes = hard.plot("x").axes[0]
    labels = [line.get_label() for line in axes.get_lines()]
    assert {"stable", "unstable", "fold"} <= set(labels)
    figure = hard.plot("x", backend="plotly")
    assert {"stable", "unstable", "fold"} <= {trace.name for trace in figure.data}


def test_a_branch_ends_after_as_many_motions_as_asked_for(hard):
    begin = hard.orbit(len(hard.values) // 2)
    few = lp.orbits.branch(begin, along={"n": (LOW, HIGH)}, turns=1, step=0.01, most=3)
    assert few.ends == ("3 motions were found; more with most=",) * 2
    assert len(few.values) == 2 * 3 + 1
    assert few.values[3] == pytest.approx(hard.values[len(hard.values) // 2], rel=1e-12)


def test_wrong_beginnings_are_refused_by_name(hard):
    orbit = hard.orbit(0)
    for options, text in (
        ({"along": {}}, "one parameter and its range"),
        ({"along": {"n": (LOW, HIGH)}}, "is a period of the functions of time for n as it is"),
        ({"along": {"n": (LOW, HIGH)}, "turns": 2}, "no period of it"),
        ({"along": {"n": (HIGH, LOW)}, "turns": 1}, "least, then greatest"),
        ({"along": {"n": (HIGH, 2 * HIGH)}, "turns": 1}, "outside of"),
        ({"along": {"n": (LOW, HIGH)}, "turns": 1, "step": 0.0}, "step = 0"),
    ):
        with pytest.raises(OptionError, match=text):
            lp.orbits.branch(orbit, **options)
    with pytest.raises(OptionError, match="crosses at a fold"):
        hard.switch(hard.points[0])
    with pytest.raises(OptionError, match="not on this branch"):
        hard.at(2 * HIGH)
