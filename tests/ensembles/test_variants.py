"""Parameters of many runs against numpy, itertools, closed forms and checks of single runs."""

import itertools
import math
from statistics import NormalDist

import numpy as np
import pint
import pytest
import scipy
from rows import in_a_row

import lumped as lp
from lumped.components import Fixed, Inertia, Spring
from lumped.ensembles.variants import variants_of
from lumped.errors import OptionError, ParameterError, UnitError, UnknownNameError

MODEL = in_a_row(ground=Fixed(), shaft=Spring(c=100.0), body=Inertia(J=2.0))
C, J = "shaft.c", "body.J"


@pytest.fixture(scope="module")
def system():
    return lp.assemble(MODEL)


# -- given values ----------------------------------------------------------------------------------


def test_a_grid_has_every_combination_and_the_last_varies_fastest(system):
    axes = {C: [50.0, 100.0, 200.0], J: np.array([1, 2]), "shaft.phi_rel0": ("1 deg", 0.25)}
    received = variants_of(system, axes)
    expected = list(itertools.product(axes[C], axes[J], [math.pi / 180, 0.25]))
    assert received.names == (C, J, "shaft.phi_rel0")
    assert received.shape == (3, 2, 2)
    assert received.values == pytest.approx(np.array(expected), rel=1e-15)


@pytest.mark.parametrize(
    "values",
    [
        [50.0, 2000.0],
        ["50 N.m/rad", "2 kN.m/rad"],
        [50, "2 kN.m/rad"],
        np.array([[50.0], [2000.0]]),
        pint.UnitRegistry().Quantity(np.array([0.05, 2.0]), "kN.m/rad"),
        [pint.UnitRegistry().Quantity(0.05, "kN.m/rad"), np.float32(2000.0)],
    ],
)
def test_values_may_have_units(system, values):
    expected = pytest.approx(np.array([[50.0], [2000.0]]), rel=1e-15)
    assert variants_of(system, {C: values}).values == expected
    assert variants_of(system, lp.distributions.paired({MODEL.shaft.c: values})).values == expected
    if values.__class__ is list:
        assert variants_of(system, [{C: value} for value in values]).values == expected


@pytest.mark.parametrize("value", [50.0, "50 N.m/rad", np.float64(50.0)])
def test_one_value_is_a_grid_of_one(system, value):
    received = variants_of(system, {C: value, J: [1.0, 3.0]})
    assert received.shape == (1, 2)
    assert received.values.tolist() == [[50.0, 1.0], [50.0, 3.0]]


def test_the_parameters_of_each_run_are_those_given(system):
    rows = [(50.0, 1.0), (70.0, 3.0), (60.0, 2.0)]
    ways = [
        [{C: c, J: inertia} for c, inertia in rows],
        ({C: c, J: inertia} for c, inertia in rows),
        [{MODEL.shaft.c: c, MODEL.body.J: inertia} for c, inertia in rows],
        [{C: 50.0, J: 1.0}, {J: 3.0, MODEL.shaft.c: 70.0}, {MODEL.body.J: 2.0, C: 60.0}],
        lp.distributions.paired({C: [50.0, 70.0, 60.0], J: np.array([1, 3, 2])}),
    ]
    for way in ways:
        received = variants_of(system, way)
        assert received.names == (C, J)
        assert received.shape == (3,)
        assert received.values.tolist() == [list(row) for row in rows]


# -- drawn values ----------------------------------------------------------------------------------


def test_drawn_values_are_quantiles_of_the_numbers_that_numpy_draws(system):
    over = {
        MODEL.shaft.c: lp.uniform(80.0, 130.0),
        "body.J": lp.normal(2.0, 0.1),
        "shaft.phi_rel0": scipy.stats.gumbel_r(0.1, 0.02),
    }
    received = variants_of(system, over, runs=500, seed=42)
    u = np.random.default_rng(42).random((500, 3))
    assert received.names == (C, J, "shaft.phi_rel0")
    assert received.shape == (500,)
    assert (received.values[:, 0] == 80.0 + (130.0 - 80.0) * u[:, 0]).all()
    expected = [NormalDist(2.0, 0.1).inv_cdf(v) for v in u[:, 1]]
    assert received.values[:, 1] == pytest.approx(expected, rel=1e-14)
    expected = 0.1 - 0.02 * np.log(-np.log(u[:, 2]))
    assert received.values[:, 2] == pytest.approx(expected, rel=1e-12)


TWO = {C: lp.normal(100.0, 3.0), J: lp.uniform(1.0, 3.0)}
SAMPLINGS = ["random", "latin", "sobol", "halton"]


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("runs", [1, 3, 64, 100])
def test_the_same_seed_gives_the_same_numbers(system, sampling, runs):
    draws = [
        variants_of(system, TWO, runs=runs, seed=seed, sampling=sampling) for seed in (5, 5, 6)
    ]
    assert draws[0].values.shape == (runs, 2)
    assert (draws[0].values == draws[1].values).all()
    assert (draws[0].values != draws[2].values).all()


@pytest.mark.parametrize("sampling", ["random", "sobol", "halton"])
def test_more_runs_begin_with_the_same_ones(system, sampling):
    few, many = (variants_of(system, TWO, runs=n, sampling=sampling).values for n in (37, 90))
    assert (few == many[:37]).all()


def strata(values, count):
    """How many values of a uniform parameter between 1 and 3 lie in each of equal parts."""
    return np.bincount(np.floor((values - 1.0) / 2.0 * count).astype(int), minlength=count)


UNIFORM = {C: lp.uniform(1.0, 3.0), J: lp.uniform(1.0, 3.0)}


def test_a_latin_hypercube_hits_each_stratum_once(system):
    received = variants_of(system, UNIFORM, runs=100, sampling="latin").values
    for column in received.T:
        assert strata(column, 100).tolist() == 100 * [1]
    assert abs(np.corrcoef(received.T)[0, 1]) < 5 / math.sqrt(100)


@pytest.mark.parametrize("runs", [64, 100])
def test_sobol_points_hit_each_box_once(system, runs):
    """A net in base 2: each box of area 1/64 has one of 64 points, whatever its sides.

    I. M. Sobol', Distribution of points in a cube, USSR Comput. Math. Math. Phys. 7 (1967) 86-112.
    """
    received = variants_of(system, UNIFORM, runs=runs, sampling="sobol").values[:64]
    for power in range(7):
        sides = 2**power, 2 ** (6 - power)
        box = [
            np.floor((x - 1) / 2 * n).astype(int) for x, n in zip(received.T, sides, strict=True)
        ]
        assert len({*zip(*box, strict=True)}) == 64


def test_halton_points_hit_each_stratum_once(system):
    """Of the first b**m points each interval of length b**-m has one, b = 2 and 3."""
    received = variants_of(system, UNIFORM, runs=100, sampling="halton").values
    assert strata(received[:64, 0], 64).tolist() == 64 * [1]
    assert strata(received[:81, 1], 81).tolist() == 81 * [1]


def test_correlation_is_that_of_the_normal_variables_behind_other_distributions(system):
    """For uniform variables, whose correlation is that of ranks: 6/pi asin(rho/2) (Kruskal)."""
    rho, n = 0.8, 40_000
    over = lp.distributions.correlated(UNIFORM, [[1, rho], [rho, 1]])
    received = variants_of(system, over, runs=n, seed=2).values
    expected = 6 / math.pi * math.asin(rho / 2)
    assert abs(np.corrcoef(received.T)[0, 1] - expected) < 5 / math.sqrt(n)


THREE = {C: lp.normal(100.0, 3.0), J: lp.normal(2.0, 0.1), "shaft.phi_rel0": lp.normal(0.0, 1.0)}


def test_correlated_parameters_are_those_of_a_factor_written_by_hand(system):
    a, b, c = 0.5, -0.3, 0.2
    over = lp.distributions.correlated(THREE, [[1, a, b], [a, 1, c], [b, c, 1]])
    received = variants_of(system, over, runs=200, seed=3).values
    z = np.vectorize(NormalDist().inv_cdf)(np.random.default_rng(3).random((200, 3)))
    second = a * z[:, 0] + math.sqrt(1 - a**2) * z[:, 1]
    share = (c - a * b) / math.sqrt(1 - a**2)
    third = b * z[:, 0] + share * z[:, 1] + math.sqrt(1 - b**2 - share**2) * z[:, 2]
    expected = np.column_stack([100.0 + 3.0 * z[:, 0], 2.0 + 0.1 * second, third])
    assert received == pytest.approx(expected, abs=1e-11)


def test_parameters_may_follow_from_each_other_wholly(system):
    over = lp.distributions.correlated(THREE, [[1, -1, 0.6], [-1, 1, -0.6], [0.6, -0.6, 1]])
    received = variants_of(system, over, runs=1000).values
    first, second, third = ((received - [100.0, 2.0, 0.0]) / [3.0, 0.1, 1.0]).T
    assert second == pytest.approx(-first, abs=1e-9)
    assert abs(np.corrcoef(first, third)[0, 1] - 0.6) < 5 * 0.64 / math.sqrt(1000)


def test_a_factor_is_that_of_the_value_in_the_call(system):
    u = np.random.default_rng(0).random((50, 1))
    over = {C: lp.distributions.scaled(lp.uniform(0.9, 1.1))}
    for parameters, own in ((None, 100.0), ({C: "0.4 kN.m/rad"}, 400.0), ({J: 1.0}, 100.0)):
        received = variants_of(system, over, runs=50, parameters=parameters).values
        assert received == pytest.approx(own * (0.9 + 0.2 * u), rel=1e-15)


# -- what is refused -------------------------------------------------------------------------------

NORMAL = lp.normal(100.0, 3.0)


MISTAKES = {
    OptionError: [
        ({}, {}, "ensemble: there is nothing to vary"),
        ([], {}, "there is nothing to vary"),
        ([{}], {}, "there is nothing to vary"),
        ({C: []}, {}, "there is nothing to vary"),
        (lp.distributions.paired({}), {}, "there is nothing to vary"),
        (5.0, {}, r"over = 5\.0: what varies is needed, such as"),
        ("shaft.c", {}, r"over = 'shaft\.c': what varies is needed"),
        ([{C: 1.0}, 2.0], {}, r"over\[1\] = 2\.0: the parameters of run 1 are needed"),
        ([{C: 1.0}, {J: 1.0}], {}, r"run 0 names shaft\.c, run 1 body\.J"),
        ({C: [1.0], MODEL.shaft.c: [2.0]}, {}, r"shaft\.c is named twice in over"),
        ({C: NORMAL, MODEL.shaft.c: NORMAL}, {"runs": 3}, r"shaft\.c is named twice in over"),
        (
            [{C: 1.0, MODEL.shaft.c: 2.0}, {C: 1.0, MODEL.shaft.c: 2.0}],
            {},
            r"each run must name the same parameters, once; run 0 names shaft\.c, shaft\.c",
        ),
        (
            {C: NORMAL, J: [1.0]},
            {"runs": 3},
            r"distributions \(of shaft\.c\) and values \(of body\.J\)\. .* lumped\..*paired",
        ),
        (
            lp.distributions.paired({C: [1.0, 2.0], J: [1.0]}),
            {},
            r"equally many values, but shaft\.c has 2, body\.J has 1\. .* parameters=",
        ),
        (lp.distributions.paired({C: NORMAL}), {}, r"but shaft\.c has a distribution"),
        ({C: NORMAL}, {}, "runs = None: how many runs to draw is needed"),
        ({C: NORMAL}, {"runs": 0}, "runs = 0: how many runs to draw is needed"),
        ({C: NORMAL}, {"runs": 2.5}, r"runs = 2\.5: how many runs"),
        ({C: NORMAL}, {"runs": 3, "seed": -1}, "seed = -1: a whole number"),
        (
            {C: NORMAL},
            {"runs": 3, "sampling": "lhs"},
            "sampling = 'lhs': one of 'random', 'latin', 'sobol', 'halton' is needed",
        ),
        ({C: [1.0]}, {"runs": 1}, "runs = 1 is for distributions, but over gives"),
        ([{C: 1.0}], {"sampling": "sobol"}, "sampling = 'sobol' is for distributions"),
        ({C: lp.normal(1.0, -1.0)}, {"runs": 3}, r"ensemble: shaft\.c: std = -1 N"),
        (
            {C: scipy.stats.norm},
            {"runs": 3},
            r"ensemble: shaft\.c = scipy\.stats\.norm: give the distribution its arguments",
        ),
    ],
    UnknownNameError: [
        ({3: [1.0]}, {}, "3 is neither a name nor a reference"),
        ({"shaft.k": [1.0]}, {}, r"no parameter 'shaft\.k'. Nearest: shaft\.c"),
        ({"shaft.k": NORMAL}, {"runs": 3}, r"no parameter 'shaft\.k'. Nearest: shaft\.c"),
        ({C: [1.0]}, {"parameters": {"body.K": 1.0}}, r"body\.K"),
    ],
    UnitError: [
        ({C: ["1 kg"]}, {}, r"shaft\.c = '1 kg': the unit must be of the kind N\.m/rad"),
    ],
    ParameterError: [
        ({C: [True]}, {}, r"shaft\.c = True: a number in N\.m/rad is needed"),
        ({C: [[1.0, 2.0], [3.0]]}, {}, r"shaft\.c = \[1\.0, 2\.0\]: a number"),
        ([{C: [1.0]}, {C: [2.0]}], {}, r"shaft\.c = \[1\.0\]: a number"),
        ({C: [10**400]}, {}, r"shaft\.c = 1000.*: a number in N\.m/rad"),
        ({C: [1.0]}, {"parameters": {J: -1.0}}, r"body\.J = -1 kg\.m2"),
    ],
}


@pytest.mark.parametrize(
    ("kind", "over", "options", "text"),
    [(kind, *row) for kind, rows in MISTAKES.items() for row in rows],
)
def test_mistakes_are_told_before_the_first_run(system, over, options, kind, text):
    with pytest.raises(kind, match=text):
        variants_of(system, over, **options)


def test_errors_begin_with_the_analysis(system):
    for over in ({}, {C: [-1.0]}, {C: lp.normal(1.0, 1.0)}, {C: lp.normal(1.0, -1.0)}):
        runs = 3 if any(over.values()) and not isinstance(over[C], list) else None
        with pytest.raises((OptionError, ParameterError), match=r"^sweep: "):
            variants_of(system, over, runs=runs, analysis="sweep")
