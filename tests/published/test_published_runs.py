"""Mechanisms and stiff problems as they are published, whole equations without hints.

Errors are relative to the published end; where a quantity passes zero, to its largest value.
"""

from functools import cache

import pytest

import lumped as lp
from benchmarks.published import stiff
from benchmarks.published.amplifier import AsPublished
from benchmarks.published.cases import MECHANISMS, STIFF
from lumped.errors import SingularModelError

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
IN_LINE = 5e-8  # where links pass a position in line, rates are interpolated from both sides
SLOW = {stiff.BEAM: (1e-8,)}  # forty full equations: the rest is in the benchmark


@cache
def assembled(problem):
    return lp.assemble(problem.model())


@pytest.mark.parametrize(
    ("problem", "rtol"),
    [
        pytest.param(problem, rtol, id=f"{problem.name}, {rtol:g}")
        for problem in (*MECHANISMS, *STIFF)
        for rtol in SLOW.get(problem, TOLERANCES)
    ],
)
def test_a_published_run_ends_as_its_reference(problem, rtol):
    run = problem.simulate(assembled(problem), rtol)
    least = IN_LINE if "four-bars in x and y" in problem.name else 2 * problem.digits
    assert problem.error_of(run) <= max(100 * rtol, least)


def test_mechanisms_keep_two_states_for_each_freedom():
    states = {p.name: assembled(p).report()["states"] for p in MECHANISMS}
    assert states == {
        "Andrews' mechanism": 2,
        "car axis": 4,
        "slider crank, elastic rod": 8,
        "double four-bar of rigid bars": 2,
        "1 four-bar in x and y": 2,
        "2 four-bars in x and y": 2,
        "10 four-bars in x and y": 2,
        "pendulum in x and y": 2,
        "four pendulums in x and y": 8,
    }


def test_a_singular_matrix_of_capacitors_is_refused_with_its_rows():
    with pytest.raises(SingularModelError, match="rank 1, not 2") as fault:
        lp.assemble(AsPublished())
    assert "der(y1), der(y2)" in str(fault.value)
