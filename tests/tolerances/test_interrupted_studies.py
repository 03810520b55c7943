"""Ctrl-C during reliability and scatter: what is known is kept, what was not run never counts."""

import numpy as np
import pytest
from interrupts import interrupting
from scipy.stats import norm

import lumped as lp
from lumped import functionals as fun
from lumped.errors import Interrupted
from lumped.tolerances.failure.limit import Limit
from tests.tolerances.drives import MEANS, STDS, normals, pulled


@pytest.fixture(scope="module")
def pull():
    return lp.assemble(pulled())


def test_samples_after_an_interrupt_are_not_counted(pull, monkeypatch):
    beta = (24 - MEANS.sum()) / np.linalg.norm(STDS)
    call = {"above": 12.0, "over": normals(), "until": 1.0, "workers": 1}
    interrupting(monkeypatch, 7)
    with pytest.raises(Interrupted, match="interrupted after") as caught:
        lp.reliability(pull, fun.final("a.w"), search="importance", runs=100_000, **call)
    known = caught.value.partial
    assert known.evaluations < 100_000
    assert known.sampled.failed == 0
    assert known.interval[0] < norm.sf(beta) < known.interval[1]


def test_levels_reached_before_an_interrupt_are_kept(pull, monkeypatch):
    beta = (24 - MEANS.sum()) / np.linalg.norm(STDS)
    call = {"above": 12.0, "over": normals(), "until": 1.0, "workers": 1}
    interrupting(monkeypatch, 60)
    with pytest.raises(Interrupted, match="interrupted after") as caught:
        lp.reliability(pull, fun.final("a.w"), search="subset", runs=1000, **call)
    *_, last = caught.value.partial
    assert last.value < 12
    exact = norm.sf((2 * last.value - MEANS.sum()) / np.linalg.norm(STDS))
    assert norm.sf(beta) < last.probability == pytest.approx(exact, rel=0.5)


@pytest.mark.parametrize("search", ["form", "sorm"])
def test_a_search_that_is_interrupted_says_so(pull, monkeypatch, search):
    def press(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(Limit, "slopes", press)
    call = {"above": 12.0, "over": normals(), "until": 1.0, "search": search}
    with pytest.raises(Interrupted, match=r"above 12 rad/s: interrupted after 0 eval") as caught:
        lp.reliability(pull, fun.final("a.w"), **call)
    assert caught.value.partial is None


def test_a_scatter_that_is_interrupted_holds_its_first_runs(pull, monkeypatch):
    call = {"of": [fun.final("a.w")], "over": normals(), "until": 1.0, "workers": 1}
    interrupting(monkeypatch, 4)
    with pytest.raises(Interrupted, match=r"after \d+ of 50000 runs") as caught:
        lp.scatter(pull, runs=50_000, **call)
    known = caught.value.partial
    assert 0 < len(known.values) < 50_000
    assert not known.failures
    assert known.values[:, 0] == pytest.approx(known.points.sum(axis=1) / 2, rel=1e-6)
    interrupting(monkeypatch, 1)
    with pytest.raises(Interrupted) as caught:
        lp.scatter(pull, runs=500, **call)
    assert caught.value.partial is None
