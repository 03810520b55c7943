"""S-N curves from tests, against the example that ASTM E739 prints, and against known scatter."""

import numpy as np
import pytest
from scipy import stats

from lumped.errors import OptionError
from lumped.life import fit_sn_curve

EXAMPLE = [
    *((0.01636, 168), (0.01609, 200), (0.00675, 1000), (0.00682, 1180), (0.00179, 4730)),
    *((0.00160, 8035), (0.00165, 5254), (0.00053, 28617), (0.00054, 32650)),
]
"""Plastic strain amplitude and cycles to failure (8.3.1 of the standard)."""


def test_the_example_of_the_standard_has_its_published_line():
    found = fit_sn_curve(EXAMPLE, unit="1")
    assert found.curve.slope == pytest.approx(1.45144, abs=5e-6)
    # lg N = A + B lg amplitude with A = -0.24474: the cycles at the amplitude 1
    at_one = np.log10(found.curve.cycles) + found.curve.slope * np.log10(found.curve.knee)
    assert at_one == pytest.approx(-0.24474, abs=5e-6)
    assert found.slope_interval == pytest.approx((1.2974, 1.6054), abs=6e-5)


def test_line_and_scatter_are_those_of_another_regression():
    found = fit_sn_curve(EXAMPLE, unit="1", confidence=0.9)
    x, y = np.log10(np.array(EXAMPLE)).T
    line = stats.linregress(x, y)
    half = stats.t.ppf(0.95, len(x) - 2) * line.stderr
    wanted = (-line.slope - half, -line.slope + half)
    assert found.slope_interval == pytest.approx(wanted, rel=1e-10)
    rest = y - line.intercept - line.slope * x
    assert found.deviation == pytest.approx(np.sqrt((rest @ rest) / (len(x) - 2)), rel=1e-10)
    assert "9 tests" in repr(found)


def test_the_band_holds_the_true_line_as_often_as_it_says():
    """500 series of tests whose true line is known; 90 % of the bands hold it everywhere."""
    rng = np.random.default_rng(3)
    amplitudes = np.repeat([100e6, 140e6, 200e6, 300e6], 3)
    true = 6.0 - 5.0 * np.log10(amplitudes / 100e6)
    held = 0
    for _ in range(500):
        cycles = 10 ** (true + rng.normal(0.0, 0.2, len(true)))
        found = fit_sn_curve(list(zip(amplitudes, cycles, strict=True)), confidence=0.9)
        at = np.array([100e6, 125e6, 160e6, 200e6, 250e6, 300e6])
        low, high = found.band(at)
        line = 10 ** (6.0 - 5.0 * np.log10(at / 100e6))
        held += bool(((low <= line) & (line <= high)).all())
    # over all amplitudes from zero to infinity 450; over those of the tests a little more
    assert 435 <= held <= 480


@pytest.mark.parametrize(
    ("tests", "options", "match"),
    [
        ([(1e8, 1e5), (2e8, 1e4)], {}, "2 tests at 2 amplitudes"),
        ([(1e8, 1e5), (1e8, 1e4), (1e8, 1e4)], {}, "3 tests at 1 amplitudes"),
        ([(1e8, 1e4), (2e8, 1e5), (3e8, 1e6)], {}, "slope is -"),
        ([(1e8, 1e5), (2e8, -1.0), (3e8, 1e4)], {}, r"tests\[1\]"),
        (EXAMPLE, {"confidence": 1.0, "unit": "1"}, "confidence = 1"),
    ],
)
def test_slips_are_named(tests, options, match):
    with pytest.raises(OptionError, match=match):
        fit_sn_curve(tests, **options)


def test_nothing_is_said_beyond_the_tests():
    found = fit_sn_curve([("90 MPa", 1e5), ("70 MPa", 5e5), ("60 MPa", 9e5)])
    with pytest.raises(OptionError, match=r"from 6e\+07 to 9e\+07 Pa"):
        found.band(50e6)
