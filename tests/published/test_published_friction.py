"""Friction oscillators of Siconos and code_aster against their exact solutions."""

import pytest

import lumped as lp
from benchmarks.published.friction import OSCILLATORS


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("case", OSCILLATORS, ids=lambda case: case.source)
def test_turns_rest_and_instants_are_exact(case, rtol):
    run = case.simulate(lp.assemble(case.model()), rtol)
    assert case.error(run) <= 100 * rtol


def test_a_run_is_more_exact_than_the_reference_of_siconos():
    case = next(case for case in OSCILLATORS if case.theirs)
    run = case.simulate(lp.assemble(case.model()), 1e-8)
    assert case.error(run) < 1e-5 * case.theirs
