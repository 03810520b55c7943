from pathlib import Path

import fatpack
import numpy as np
import pytest
import rainflow as published

from lumped.errors import OptionError
from lumped.life import SNCurve, rainflow

DATA = Path(__file__).parents[1] / "data" / "torsional" / "06_rainflow_miner"
STRESS = 16 / (np.pi * 0.1**3)
CURVES = {
    "damage_elementary": "elementary",
    "damage_original_miner": "original",
    "damage_haibach": "haibach",
}


def history(number):
    return np.loadtxt(DATA / f"history{number}.csv", delimiter=",", skiprows=1)[:, 1]


def results(number):
    lines = (DATA / f"history{number}_result.csv").read_text().splitlines()[1:]
    return {name: float(value) for name, value in (line.split(",") for line in lines)}


def test_the_example_of_the_standard_is_counted_as_published():
    found = rainflow([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    counted = {r: found.counts[found.ranges == r].sum() for r in np.unique(found.ranges)}
    assert counted == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


@pytest.mark.parametrize("number", [1, 2])
def test_histories_have_the_counts_and_damages_of_their_tables(number):
    found, wanted = rainflow(history(number)), results(number)
    assert len(found.turning_points) == wanted["turning_points"]
    assert found.total == wanted["cycles_total"]
    assert found.ranges.max() == pytest.approx(wanted["largest_range_Nm"], rel=1e-12)
    classes = np.loadtxt(DATA / f"history{number}_rainflow.csv", delimiter=",", skiprows=1)
    ends, cycles = found.classes(20)
    assert ends[1:] == pytest.approx(classes[:, 2], rel=1e-9)
    assert (cycles == classes[:, 3]).all()
    for name, below in CURVES.items():
        curve = SNCurve(knee=60e6, cycles=2e6, slope=5.0, below=below)
        assert found.damage(curve, scale=STRESS) == pytest.approx(wanted[name], rel=1e-9)
    name = "equivalent_torque_amplitude_Nm_at_1e6_cycles_slope_5"
    assert found.equivalent(5.0) == pytest.approx(wanted[name], rel=1e-9)
    closed = rainflow(history(number), rule="four")
    assert closed.total == wanted["four_point_closed_cycles"]
    assert len(closed.residue) == wanted["four_point_residue_points"]


@pytest.mark.parametrize("number", [1, 2, 3])
def test_the_package_rainflow_counts_the_same(number):
    values = history(number)
    found = rainflow(values)
    wanted = sorted(row[:3] for row in published.extract_cycles(values))
    own = sorted(zip(found.ranges, found.means, found.counts, strict=True))
    assert (np.array(own) == np.array(wanted)).all()


@pytest.mark.parametrize("number", [1, 2, 3])
def test_the_package_fatpack_closes_the_same_cycles(number):
    values = history(number)
    found = rainflow(values, rule="four")
    classes = 1_000_000  # to which it rounds
    reversals, _ = fatpack.find_reversals(values, k=classes)
    cycles, residue = fatpack.find_rainflow_cycles(reversals)
    assert len(cycles) == found.total
    assert residue == pytest.approx(found.residue, abs=2 * np.ptp(values) / classes)
    wanted = np.sort(np.abs(np.diff(cycles, axis=1)).ravel())
    assert np.sort(found.ranges) == pytest.approx(wanted, abs=2 * np.ptp(values) / classes)


def test_a_sine_is_one_range():
    t = np.linspace(0.0, 10.0, 10_001)
    found = rainflow(3.0 + 2.0 * np.cos(2 * np.pi * t))
    assert found.total == pytest.approx(10.0)
    assert found.ranges == pytest.approx(4.0)
    assert found.means == pytest.approx(3.0)
    # one curve, half the life for each 2^(1/5) of the amplitude
    curve = SNCurve(knee=1.0, cycles=1e6, slope=5.0)
    assert found.damage(curve) == pytest.approx(10 * 2.0**5 / 1e6)
    assert found.equivalent(5.0, cycles=10.0) == pytest.approx(2.0)


def test_what_never_turns_has_one_half_cycle():
    assert rainflow([0.0, 1.0, 2.0]).total == 0.5
    still = rainflow([1.0, 1.0, 1.0])
    assert (still.total, still.equivalent(5.0)) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("action", "match"),
    [
        (lambda: rainflow([1.0]), "at least two"),
        (lambda: rainflow([1.0, np.nan]), "finite"),
        (lambda: SNCurve(knee=1.0, cycles=1e6, slope=0.0), "slope = 0"),
        (lambda: SNCurve(knee=1.0, cycles=1e6, slope=3.0, below="miner"), "below"),
        (lambda: rainflow([0, 1]).classes(0), "at least 1"),
        (lambda: rainflow([0, 1]).equivalent(-1.0), "positive"),
        (lambda: rainflow([0, 1]).damage(SNCurve(1.0, 1e6, 5.0), scale=0.0), "scale"),
    ],
)
def test_slips_are_named(action, match):
    with pytest.raises(OptionError, match=match):
        action()
