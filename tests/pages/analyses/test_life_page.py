"""What docs/analyses/life.md shows is true."""

import itertools
from collections import Counter

import numpy as np
import pytest
from scipy.stats import norm

import lumped as lp
from lumped.models.reversing_mill.passes import END, LEVELS
from lumped.models.reversing_mill.stand import RATED

NAME = "analyses/life"


def cycles_by_hand(load):
    """Ranges of a history, each with its number of cycles, by three points."""
    kept = load[np.append(True, np.diff(load) != 0)]
    slope = np.sign(np.diff(kept))
    points = kept[np.concatenate([[0], np.flatnonzero(np.diff(slope)) + 1, [len(kept) - 1]])]
    cycles, held = Counter(), []
    for point in points.tolist():
        held.append(point)
        while len(held) >= 3 and abs(held[-1] - held[-2]) >= abs(held[-2] - held[-3]):
            cycles[abs(held[-2] - held[-3])] += 0.5 if len(held) == 3 else 1.0
            del held[0 if len(held) == 3 else slice(-3, -1)]
    for a, b in itertools.pairwise(held):
        cycles[abs(b - a)] += 0.5
    return np.array(list(cycles)), np.array(list(cycles.values()))


def damage_by_hand(load, scale):
    """Damage of a history with the slopes of Haibach below 60 MPa."""
    ranges, counts = cycles_by_hand(load)
    amplitudes = scale * ranges / 2
    share = amplitudes / 60e6
    return (counts * np.where(share < 1, share**9, share**5)).sum() / 2e6


def test_the_damage_of_a_coil_is_that_of_recorded_torques_counted_by_hand(names):
    passes = []
    for level in LEVELS:
        given = {"level": level, "play": 0.02}
        run = lp.simulate(names["system"], until=END, parameters=given, grid=40_000, rtol=1e-8)
        passes.append(run[names["SPINDLE"]])
    coil, scale = np.concatenate(passes), names["stress"]
    wanted = damage_by_hand(np.tile(coil, 4), scale) - damage_by_hand(np.tile(coil, 3), scale)
    error = names["worn"].damage / wanted - 1
    assert abs(error) < 1e-4
    assert names["worn"].worst == "between cases"


def test_the_damage_of_a_pass_is_that_of_its_recorded_torque(names):
    run = lp.simulate(names["system"], until=END, grid=40_000, rtol=1e-8)
    wanted = damage_by_hand(run[names["SPINDLE"]], names["stress"])
    found = names["shear"].damage(names["curve"], scale=names["stress"])
    assert found == pytest.approx(wanted, rel=1e-4)


def test_a_pass_in_reverse_is_the_mirror_of_one_forward(names):
    ways = [
        lp.simulate(names["system"], until=0.5, parameters={"level": level})[names["SPINDLE"]]
        for level in (0.7, -0.7)
    ]
    assert np.abs(ways[0] + ways[1]).max() < 1e-6 * RATED


def test_a_pass_without_play_settles_at_the_rolling_torque(names):
    run = lp.simulate(names["system"], until=1.5, parameters={"level": 0.8, "play": 0.0})
    last = run[names["SPINDLE"]][run.t > 1.5 - 3 / 6.344]  # three periods of the first mode
    assert last.mean() == pytest.approx(0.8 * RATED, rel=0.01)


@pytest.mark.parametrize("search", ["form", "sorm", "importance"])
def test_a_shaft_breaks_as_often_as_a_lognormal_damage_exceeds_one(names, search):
    rig, median, over = (names[name] for name in ("rig", "median", "over"))
    run = lp.simulate(rig, until=2.0, grid=40_000, rtol=1e-8)
    ranges, counts = cycles_by_hand(run["shaft.tau"])
    single = counts @ (3e5 * ranges / 2 / 1e8) ** 5 / 1e6
    wanted = norm.sf(-np.log(2000 * single) / np.hypot(0.5, 5 * 0.1))
    of = median / lp.functionals.final("lives")
    found = lp.reliability(rig, of, above=1.0, over=over, until=2.0, search=search)
    assert found.probability == pytest.approx(wanted, rel=0.2 if search == "importance" else 1e-3)


def test_the_life_of_the_bearing_is_that_of_its_torque_by_hand(names):
    coil = names["coil"]
    torque, w = coil["drive.gear.flange_a.tau"], coil["drive.rotor.w"]
    turned = np.trapezoid(w, coil.t)
    equivalent = (np.trapezoid(torque ** (10 / 3) * w, coil.t) / turned) ** 0.3
    load = 2.3 * (0.67 + 3.0 * 0.37) * equivalent
    mean = turned / coil.t[-1] * 30 / np.pi
    wanted = 1e6 * (2e6 / (1.5 * load)) ** (10 / 3) / (60 * mean)
    assert coil.value(names["life"]) == pytest.approx(wanted, rel=1e-4)
