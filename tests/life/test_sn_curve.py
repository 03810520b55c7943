"""S-N curves, and how the mean of a cycle counts, against formulas written out here."""

import pickle

import numpy as np
import pytest

from lumped.errors import OptionError, UnitError
from lumped.life import SNCurve, fkm, gerber, goodman, rainflow, smith_watson_topper, walker

POINTS = [("300 MPa", 1e4), ("150 MPa", 3e5), (80e6, 4e6)]
AMPLITUDES = np.array([1e6, 40e6, 80e6, 100e6, 149e6, 150e6, 151e6, 300e6, 500e6])


def test_a_curve_through_points_is_straight_in_logarithmic_scales():
    curve = SNCurve.of_points(POINTS, below="original")
    logs = np.log([80e6, 150e6, 300e6]), np.log([4e6, 3e5, 1e4])
    lives = np.exp(np.interp(np.log(AMPLITUDES), *logs))
    lives[AMPLITUDES < 80e6] = np.inf
    last = np.log(3e5 / 1e4) / np.log(2)
    lives[-1] = 1e4 * (300 / 500) ** last
    assert curve.damage(AMPLITUDES) == pytest.approx(1 / lives, rel=1e-12)
    assert curve.slopes == pytest.approx((np.log(4e6 / 3e5) / np.log(150 / 80), last, last))


@pytest.mark.parametrize(
    ("below", "slope"), [("elementary", 5.0), ("haibach", 9.0), (7.5, 7.5), ("original", np.inf)]
)
def test_below_the_knee_holds_what_was_said(below, slope):
    curve = SNCurve(knee="60 MPa", cycles=2e6, slope=5.0, below=below)
    share = np.array([0.0, 1e-3, 0.5, 0.999])
    assert curve.damage(60e6 * share) == pytest.approx(share**slope / 2e6, rel=1e-12)
    assert curve.damage(60e6) == 1 / 2e6
    assert curve.damage(90e6) == pytest.approx(1.5**5 / 2e6, rel=1e-12)


def test_the_slope_of_haibach_is_that_of_the_lowest_line():
    curve = SNCurve.of_points(POINTS, below="haibach")
    k = np.log(4e6 / 3e5) / np.log(150 / 80)
    assert curve.damage(20e6) == pytest.approx(0.25 ** (2 * k - 1) / 4e6, rel=1e-12)


def test_curves_are_values():
    one, other = (SNCurve.of_points(points) for points in (POINTS, reversed(POINTS)))
    assert one == other == pickle.loads(pickle.dumps(one))
    assert hash(one) == hash(other)
    torques = SNCurve(knee="2 kN.m", cycles=1e6, slope=5, unit="N.m")
    assert torques.knee == 2000.0


def at_mean_zero(amplitude, mean):
    """Amplitudes by the formulas of the books, in MPa: strength 700, exponent 0.6, M = 0.3."""
    pulled, top = max(mean, 0.0), max(mean + amplitude, 0.0)
    ratio = (mean - amplitude) / (mean + amplitude) if mean != -amplitude else -np.inf
    M = 0.3
    if ratio > 1:
        haigh = amplitude * (1 - M)
    elif ratio <= 0:
        haigh = amplitude * (1 + M * mean / amplitude)
    elif ratio < 0.5:
        haigh = amplitude * (1 + M) * (1 + M / 3 * mean / amplitude) / (1 + M / 3)
    else:
        haigh = amplitude * (1 + M) ** 2 / (1 + M / 3)
    return {
        "goodman": amplitude * 700 / (700 - pulled),
        "gerber": amplitude * 700**2 / (700**2 - pulled**2),
        "swt": np.sqrt(top * amplitude),
        "walker": top**0.4 * amplitude**0.6,
        "fkm": haigh,
    }


RULES = {
    "goodman": goodman("700 MPa"),
    "gerber": gerber(700e6),
    "swt": smith_watson_topper(),
    "walker": walker(0.6),
    "fkm": fkm(0.3),
}


@pytest.mark.parametrize("name", RULES)
@pytest.mark.parametrize("mean", [-300.0, -90.0, -20.0, 0.0, 30.0, 110.0, 240.0, 400.0])
def test_the_mean_of_a_cycle_counts_as_its_rule_says(name, mean):
    amplitude = 100.0
    cycle = rainflow([mean - amplitude, mean + amplitude, mean - amplitude])
    curve = SNCurve(knee=60.0e6, cycles=2e6, slope=5.0)
    found = cycle.damage(curve, scale=1e6, mean_stress=RULES[name])
    wanted = (at_mean_zero(amplitude, mean)[name] / 60) ** 5 / 2e6
    assert found == pytest.approx(wanted, rel=1e-12)


def test_without_a_rule_means_have_no_effect():
    curve = SNCurve(knee=60.0, cycles=2e6, slope=5.0)
    assert rainflow([0, 50, 0]).damage(curve) == rainflow([300, 350, 300]).damage(curve)


STEEL = SNCurve(knee=60e6, cycles=2e6, slope=5.0)


@pytest.mark.parametrize(
    ("action", "match"),
    [
        (lambda: SNCurve(60e6, 2e6, 5.0, below=3.0), r"slope 3 below the knee .*above it, 5"),
        (lambda: SNCurve(60e6, 2e6, 0.8, below="haibach"), "slope 0.6 below the knee"),
        (lambda: SNCurve(60e6, 2e6, 5.0, below=-1.0), "below = -1 must be positive"),
        (lambda: SNCurve("60 MPa", -1.0, 5.0), "cycles = -1"),
        (lambda: SNCurve(-60e6, 1.0, 5.0), "knee = -6e[+]07 Pa"),
        (lambda: SNCurve.of_points([(60e6, 1e6)]), "at least two points"),
        (lambda: SNCurve.of_points([(60e6, 1e6), (90e6, 2e6)]), "cycles to failure fall"),
        (lambda: SNCurve.of_points([(60e6, 1e6), (60e6, 1e5)]), "amplitudes must rise"),
        (lambda: SNCurve.of_points([(60e6, 1e6), (90e6, 0.0)]), r"points\[1\]"),
        (lambda: SNCurve(60e6, 1e6, 5.0, upper=[(50e6, 1e5)]), "amplitudes must rise"),
        (lambda: SNCurve(60e6, 1e6, 5.0, upper=[50e6]), r"upper\[0\] = 5e[+]07|50000000"),
        (lambda: STEEL.damage([-1.0]), "must not be negative"),
        (lambda: goodman(0.0), "ultimate = 0 Pa"),
        (lambda: gerber("-5 MPa"), "gerber: ultimate = -5e[+]06 Pa"),
        (lambda: walker(1.2), "exponent = 1.2"),
        (lambda: fkm(1.0), "sensitivity = 1"),
        (
            lambda: rainflow([640e6, 660e6, 640e6]).damage(STEEL, mean_stress=goodman("600 MPa")),
            "mean 6.5e[+]08 Pa, which reaches the ultimate strength .Goodman",
        ),
    ],
)
def test_slips_are_named(action, match):
    with pytest.raises(OptionError, match=match):
        action()


def test_an_amplitude_has_the_unit_of_the_curve():
    with pytest.raises(UnitError, match="knee = '60 kN'"):
        SNCurve("60 kN", 2e6, 5.0)
