"""Wrong calls of designs whose parameters scatter."""

import pytest
from robust_drives import BREAKS, Bar, oscillator, pushed

import lumped as lp
from lumped import functionals as fun
from lumped.errors import OptimisationError, OptionError


@pytest.mark.parametrize(
    "wrong",
    [
        lambda p: p == 1e-4,
        lambda p: p != 1e-4,
        lambda p: p >= 1e-4,
        lambda p: p < 1e-4,
        lambda p: p > 1e-4,
        bool,
        lambda p: 1e-6 <= p <= 1e-4,
    ],
)
def test_only_at_most_is_a_condition(wrong):
    with pytest.raises(OptionError, match=r"final\(excess\) above 0.*only with `<=`"):
        wrong(BREAKS)


def test_a_condition_is_neither_true_nor_false():
    with pytest.raises(OptionError, match="several as a list"):
        bool(BREAKS <= 1e-4)


@pytest.mark.parametrize("most", [0.0, 1.0, -1e-4, True, "1 %"])
def test_a_condition_needs_a_probability(most):
    with pytest.raises(OptionError, match="greater than 0 and less than 1"):
        most >= BREAKS  # noqa: B015


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"minimise": {"d": 1.0, BREAKS: 10.0}}, "no weight among others"),
        ({"subject_to": {fun.peak("T"): (None, 0.1)}}, "a condition such as"),
        ({"searches": 2, "subject_to": BREAKS <= 0.1}, "there is one search"),
        ({"subject_to": BREAKS}, "is needed"),
        ({"vary": {"T": (1e3, 1e4)}, "subject_to": BREAKS <= 0.1}, "T is in `vary` and scatters"),
        (
            {"vary": {"d": (0.03, 0.05)}, "subject_to": BREAKS <= 1e-6},
            r"Worst violated: probability\(final\(excess\) above 0\) = 0.\d+, at most 1e-06",
        ),
    ],
)
def test_wrong_calls_are_named(options, text):
    given = {"until": 1.0, "vary": {"d": (0.02, 0.3)}, "minimise": "d"} | options
    with pytest.raises((OptionError, OptimisationError), match=text):
        lp.optimise(lp.assemble(Bar(d=0.05)), **given)


def test_a_run_that_was_made_has_no_probability():
    run = lp.simulate(pushed(), until=1.0)
    fails = lp.probability(fun.final("body.w"), above=6.0, over={"motor.tau": lp.normal(10, 1)})
    for options in ({"subject_to": fails <= 0.1, "minimise": "body.J"}, {"minimise": fails}):
        with pytest.raises(OptionError, match="Give the system and until="):
            lp.optimise(run, vary={"body.J": (1.0, 3.0)}, **options)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: lp.probability(fun.final("y"), over={}), "give one limit"),
        (lambda: lp.probability(fun.final("y"), above=1, below=0, over={}), "give one limit"),
        (lambda: lp.probability(fun.final("y"), above=1, over={}, runs=10), "at least 100"),
        (lambda: lp.tolerances.mean_plus(fun.final("y"), 3.0, over={}, runs=2), "at least 16"),
        (lambda: lp.tolerances.quantile(fun.final("y"), 1.5, over={}), "less than 1"),
        (lambda: lp.tolerances.quantile(fun.final("y"), 0.99, over={}, runs=64), "of 1000 runs 10"),
    ],
)
def test_what_cannot_be_asked_for_is_named(make, text):
    with pytest.raises(OptionError, match=text):
        make()


def test_a_front_of_modes_has_no_end():
    hertz = {fun.frequency(0): -1.0}
    with pytest.raises(OptionError, match="pareto: until: options of runs belong to a system"):
        lp.optimisation.pareto(
            lp.modes(oscillator()),
            until=1.0,
            vary={"shaft.c": (100.0, 5e3)},
            minimise=("shaft.c", hertz),
        )
