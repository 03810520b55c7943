"""Ranges of parameters in many runs against checks of single runs and closed forms."""

from statistics import NormalDist

import numpy as np
import pytest
import scipy

import lumped as lp
from lumped.ensembles.variants import variants_of
from lumped.errors import ParameterError

C, J = "shaft.c", "body.J"


@pytest.mark.parametrize("wrap", [dict, lp.distributions.paired])
def test_values_out_of_range_are_counted_and_the_first_is_told(system, wrap):
    c = np.full(30_000, 100.0)
    c[[7, 19, 29_999]] = -1.0, 0.0, np.nan
    inertia = np.full(30_000, 2.0)
    inertia[20_001] = np.inf
    over = wrap({C: c, J: inertia}) if wrap is lp.distributions.paired else {C: c}
    with pytest.raises(ParameterError) as caught:
        variants_of(system, over)
    text = "shaft.c = -1 N.m/rad (torsional stiffness) must be greater than 0: run 7 and 2 more"
    lines = str(caught.value).splitlines()
    assert text + " of 30000 runs" in lines[1]
    if wrap is lp.distributions.paired:
        assert "body.J = inf kg.m2 (moment of inertia) must be a finite number" in lines[2]
        assert "run 20001 of 30000 runs" in lines[2]
        assert lines[0] == "ensemble: 2 parameter faults:"


@pytest.mark.parametrize(
    ("distribution", "probability"),
    [
        (lp.normal(10.0, 5.0), NormalDist().cdf(-2.0)),
        (lp.normal(10.0, 1.5), NormalDist().cdf(-10 / 1.5)),
        (lp.uniform(-1.0, 3.0), 0.25),
        (lp.distributions.triangular(-1.0, 1.0, 3.0), 1 / 8),
        (lp.distributions.scaled(lp.normal(1.0, 0.5)), NormalDist().cdf(-2.0)),
        (lp.distributions.truncated(lp.uniform(-3.0, 3.0), -1.0, 1.0), 0.5),
        (scipy.stats.norm(10.0, 5.0), NormalDist().cdf(-2.0)),
    ],
)
def test_a_distribution_that_reaches_out_of_range_is_refused(system, distribution, probability):
    text = (
        r"shaft\.c \(torsional stiffness\) must be greater than 0 N\.m/rad; its distribution has "
        rf"other values with a probability of {probability:.3g}\n.*lumped\.distributions\.truncated"
    )
    with pytest.raises(ParameterError, match=text):
        variants_of(system, {C: distribution}, runs=1)


@pytest.mark.parametrize(
    "distribution",
    [
        lp.distributions.truncated(lp.normal(10.0, 5.0), 0.01, None),
        lp.distributions.truncated(lp.normal(10.0, 5.0), 1.0, 40.0),
        lp.uniform(0.0, 10.0),
        lp.normal(10.0, 10 / 7.5),  # 3e-14 below zero
        lp.distributions.lognormal(10.0, 2.0),
        scipy.stats.expon(),
    ],
)
def test_a_distribution_within_the_range_is_taken(system, distribution):
    received = variants_of(system, {C: distribution}, runs=1000).values
    assert (received > 0).all()


class Window(lp.Component):
    """A range within limits, the upper end of which is above the lower one."""

    low: lp.Param = lp.param("N", "lower end", 1.0)
    high: lp.Param = lp.param("N", "upper end", 2.0, above=low)
    share: lp.Param = lp.param("1", "share", 0.5, min=0.1, below=0.9)
    ratio: lp.Param = lp.param("1", "ratio", 1.0, nonzero=True)
    y = lp.Output("N", "width")

    def equations(self):
        yield self.y == self.high - self.low * self.share / self.ratio


class Frame(lp.Component):
    """Two windows, one of them bound."""

    scale: lp.Param = lp.param("1", "scale", 1.0)
    left: Window = Window()
    right: Window = Window(low=lp.ops.sqrt(scale), high=3 - scale, ratio=1 / scale)


@pytest.fixture(scope="module")
def frame():
    return lp.assemble(Frame())


def test_a_run_is_out_of_range_if_its_own_check_says_so(frame):
    """Ranges with and without ends, of bound parameters, and by other parameters."""
    random = np.random.default_rng(1)
    names = ["scale", "left.low", "left.high", "left.share", "left.ratio", "right.share"]
    values = random.choice([-1.0, 0.0, 0.1, 0.5, 0.9, 1.0, 1.9, 2.0, 1e101, np.nan], (300, 6))
    own = np.array([frame.parameters[name] for name in names])
    values = np.where(random.random(values.shape) < 0.7, own, values)
    received, expected = {}, {}
    parameters = frame.structure.parameters
    theta = parameters.defaults.copy()
    found = parameters.outside(theta, frame.places(names), values)
    for text, runs in found:
        for run in runs:
            received.setdefault(int(run), set()).add(text.partition(" = ")[0])
        assert (np.diff(runs) > 0).all()
    for i, row in enumerate(values):
        try:
            frame.theta(dict(zip(names, row, strict=True)))
        except ParameterError as error:
            lines = str(error).splitlines()[1:]
            expected[i] = {line.strip().partition(" = ")[0] for line in lines}
    assert 50 < len(expected) < 290
    assert received == expected
    for text, runs in found:
        with pytest.raises(ParameterError) as caught:
            frame.theta(dict(zip(names, values[runs[0]], strict=True)))
        assert text in str(caught.value)


def test_a_range_that_depends_on_another_varied_parameter_is_checked_run_by_run(frame):
    over = lp.distributions.paired(
        {"left.low": [0.0, 3.0, 5.0, 6.0], "left.high": [1.0, 4.0, 5.0, 5.5]}
    )
    text = (
        r"left\.high = 5 N \(upper end\) must be greater than left\.low = 5 N \(lower end\): run 2 "
        r"and 1 more of 4 runs"
    )
    with pytest.raises(ParameterError, match=text):
        variants_of(frame, over)
    with pytest.raises(ParameterError, match=r"left\.high = 2 N .* left\.low = 5 N"):
        variants_of(frame, {"left.low": [0.0, 5.0]})
    received = variants_of(frame, {"left.low": [0.0, 5.0]}, parameters={"left.high": 6.0})
    assert received.values.tolist() == [[0.0], [5.0]]
    with pytest.raises(ParameterError, match=r"right\.high = -1 N .* right\.low = 2 N"):
        variants_of(frame, {"scale": [1.0, 4.0]})


def test_drawn_values_out_of_a_range_that_depends_on_others_are_counted(frame):
    over = {"left.low": lp.uniform(0.0, 4.0), "left.high": lp.uniform(3.0, 5.0)}
    u = np.random.default_rng(9).random((1000, 2))
    low, high = (4.0 * u[:, 0], 3.0 + 2.0 * u[:, 1])
    wrong = np.flatnonzero(high <= low)
    text = f"left.low = {low[wrong[0]]:g} N (lower end): run {wrong[0]} and {len(wrong) - 1} more"
    with pytest.raises(ParameterError) as caught:
        variants_of(frame, over, runs=1000, seed=9)
    assert text in str(caught.value)
    assert "lumped.distributions.truncated(distribution, low, high)" in str(caught.value)


def test_both_ends_of_a_range_are_told(frame):
    text = r"left\.share \(share\) must be at least 0\.1 and less than 0\.9; .* probability of 0\.2"
    with pytest.raises(ParameterError, match=text):
        variants_of(frame, {"left.share": lp.uniform(0.0, 1.0)}, runs=3)


def test_a_negative_value_is_scaled_within_its_range(frame):
    """A factor above one makes a negative value smaller."""
    over = {"left.low": lp.distributions.scaled(lp.uniform(0.5, 2.0))}
    u = np.random.default_rng(0).random((20, 1))
    received = variants_of(frame, over, runs=20, parameters={"left.low": -2.0}).values
    assert received == pytest.approx(-2.0 * (0.5 + 1.5 * u), rel=1e-15)
