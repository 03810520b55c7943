"""What a scatter refuses, how it reads tables, prints and draws."""

import math
import re

import numpy as np
import pytest
from checks import refused

import lumped as lp
from lumped import functionals as fun
from lumped.ensembles.laws import Parameter
from lumped.errors import OptionError, ParameterError, SolverError, UnitError, UnknownNameError
from lumped.tolerances import scene_of, toleranced
from tests.tolerances.drives import braked, pair, wheel

NORMAL = {"one.tau": lp.normal(20.0, 2.0)}


@pytest.fixture(scope="module")
def driven():
    return wheel()


@pytest.fixture(scope="module")
def found(driven):
    return lp.scatter(driven, over=NORMAL, of=fun.final("body.w"), until=1.0, runs=200)


WRONG = {
    OptionError: [
        ({"over": {"one.tau": lp.normal(20.0, -2.0)}}, r"one\.tau: std = -2 N\.m must be greater"),
        ({"over": {"one.tau": [1.0, 2.0]}}, "over = .*a distribution of each parameter is needed"),
        ({"until": None}, "a system is simulated; give until="),
        ({"runs": 0}, "runs = 0"),
        ({"workers": 0}, "workers = 0"),
        ({"of": fun.frequency(0)}, r"frequency\(0\) is no functional of a run"),
        (
            {"search": "derivatives", "sampling": "sobol"},
            "sampling is for samples and chaos",
        ),
        ({"gradients": False}, "gradients=False is for search='chaos', not for 'samples'"),
    ],
    ParameterError: [
        (
            {"over": {"body.J": lp.normal(4.0, 1.0)}},
            r"1 parameter fault:\n.*body\.J .* must be greater than 0.*probability of 3\.17e-05",
        ),
    ],
    UnknownNameError: [({"over": {"on.tau": lp.normal(1, 1)}}, r".*one\.tau")],
}


@pytest.mark.parametrize(
    ("kind", "given", "text"), [(kind, *row) for kind, rows in WRONG.items() for row in rows]
)
def test_wrong_calls_are_refused_by_name(driven, kind, given, text):
    call = {"until": 1.0, "over": NORMAL, "of": fun.final("body.w")} | given
    with pytest.raises(kind) as caught:
        lp.scatter(driven, **call)
    start = "" if kind is UnknownNameError else "scatter: "
    assert re.match(start + text, str(caught.value))


def test_wrong_calls_for_modes_are_refused_by_name():
    modes, over = lp.modes(pair()), {"s.c": lp.normal(1e3, 1.0)}
    with pytest.raises(OptionError, match="scatter: until: options of runs belong to a system"):
        lp.scatter(modes, over=over, of=fun.frequency(0), until=1)
    with pytest.raises(OptionError, match=r"scatter: frequency\(1\): the modes are 0 to 0"):
        lp.scatter(modes, over=over, of=fun.frequency(1))


def test_limits_quantiles_and_labels_are_checked(found):
    own = found["final(body.w)"]
    refused(OptionError, own.share, "final(body.w): give a limit, above= or below=")
    refused(UnitError, lambda: own.share(above="3 N.m"), "rad/s")
    refused(OptionError, lambda: own.quantile(1.0), "quantile(1): a number between 0 and 1")
    with pytest.raises(OptionError, match=r"causes of final\(body\.w\): none of 200 values"):
        own.causes(above=100.0)
    refused(UnknownNameError, lambda: found["final(body.v)"], "'final(body.v)' was not asked for")
    assert list(found) == ["final(body.w)"]


def test_what_decides_a_verdict():
    """Two torques of which one scatters twice as much decide a limit together."""
    found = lp.scatter(
        wheel(),
        over={"one.tau": lp.normal(20.0, 2.0), "two.tau": lp.normal(12.0, 1.0)},
        of={"w": fun.final("body.w")},
        until=1.0,
        runs=4000,
    )
    causes = dict(found["w"].causes(above=8.0))
    # of 1 where a z1 + b z2 > 0, a^2 + b^2 = 1: variance of P(z1) = Phi(a z1 / b), over 1/4
    expected = {
        name: 4 * (math.asin(r * r) / (2 * math.pi))
        for name, r in (("one.tau", 2 / math.sqrt(5)), ("two.tau", 1 / math.sqrt(5)))
    }
    assert causes == pytest.approx(expected, abs=0.05)


def test_all_runs_that_fail_are_an_error_and_some_are_told():
    scene = scene_of(
        wheel(), over={"body.J": lp.uniform(1.0, 2.0)}, of=[fun.final("body.w")], until=1.0
    )
    values = scene.values(np.array([[1.0], [-1.0], [2.0]]))
    assert np.isnan(values[:, 0]).tolist() == [False, True, False]
    assert list(scene.failures) == [1]
    assert "body.J = -1 kg.m2" in scene.failures[1]
    assert values[[0, 2], 0] == pytest.approx([32.0, 16.0], rel=1e-9)
    refused(ParameterError, lambda: scene.curvatures(np.array([-1.0])), "body.J = -1")

    over, of = {"brake.f_max": lp.uniform(8.0, 9.0)}, fun.instant("brake", "stuck")
    with pytest.raises(SolverError, match=r"scatter: all 20 runs fail\. Run 0: .*event"):
        lp.scatter(braked(), over=over, of=of, until=0.1, runs=20)


def test_tables_of_tolerances(tmp_path):
    file = tmp_path / "tolerances.csv"
    file.write_text(
        "name, nominal, tolerance, distribution\n"
        "s.c, 1 kN.m/rad, 6 %, normal\n"
        "a.J,, 100e3 kg.mm2, uniform\n"
        "b.J, 3, 0.2, triangular\n"
    )
    table = toleranced(file)
    laws = {
        name: table[name].law(Parameter(name, unit, nominal))
        for name, unit, nominal in (
            ("s.c", "N.m/rad", 900.0),
            ("a.J", "kg.m2", 2.0),
            ("b.J", "kg.m2", 5.0),
        )
    }
    q = np.array([0.5, 0.75])
    # a normal tolerance is three deviations, of 0.6745 deviations in the upper quartile
    assert laws["s.c"].quantile(q) == pytest.approx([1000.0, 1000 + 20 * 0.674489750], rel=1e-9)
    assert laws["a.J"].quantile(q) == pytest.approx([2.0, 2.05], rel=1e-12)
    assert laws["b.J"].quantile(q) == pytest.approx([3.0, 3.2 - 0.2 * math.sqrt(0.5)], rel=1e-12)
    given = toleranced({"s.c": ("1 kN.m/rad", "6 %", "normal")})
    assert given["s.c"] == table["s.c"]


def test_wrong_tables_are_refused_by_line(tmp_path):
    file = tmp_path / "tolerances.csv"
    head = "name,nominal,tolerance,distribution\n"
    for text, told in (
        ("name,nominal,tolerance\n", "has no column distribution"),
        (f"{head}s.c,1,2,gauss\n", r"line 2: s\.c has the distribution 'gauss'; take normal"),
        (f"{head}s.c,1,,normal\n", r"line 2: s\.c has no tolerance"),
        (f"{head}s.c,1,2,normal\ns.c,1,2,normal\n", r"line 3: s\.c stands twice"),
        (head, "the table is empty"),
    ):
        file.write_text(text)
        with pytest.raises(OptionError, match=told):
            toleranced(file)
    with pytest.raises(OptionError, match=r"nowhere\.csv cannot be read: No such file"):
        toleranced(tmp_path / "nowhere.csv")
    with pytest.raises(OptionError, match=r"toleranced: s\.c = 5\.0: \(nominal, tolerance, dist"):
        toleranced({"s.c": 5.0})
    of = toleranced({"s.c": (None, -3.0, "normal")})
    with pytest.raises(
        OptionError, match=r"scatter: s\.c: tolerance = -3 N\.m/rad must be greater"
    ):
        lp.scatter(lp.modes(pair()), over=of, of=fun.frequency(0))


def test_results_are_shown(found):
    text = repr(found)
    assert "scatter of 1 functionals by 1 parameters, by samples; 200 runs" in text
    assert "final(body.w): one.tau 0.99" in text
    page = found._repr_html_()
    assert "final(body.w)" in page
    assert "spread" in page
    assert "<svg" in page
    frame = found.to_pandas()
    assert frame.loc["final(body.w)", "50 %"] == found["final(body.w)"].quantile(0.5).value
    assert frame.loc["final(body.w)", "unit"] == "rad/s"


@pytest.mark.parametrize("backend", ["matplotlib", "plotly"])
def test_pictures(found, backend):
    figure = found.plot(units={"rad/s": "rpm"}, backend=backend)
    if backend == "plotly":
        told = str(figure.to_json())
    else:
        histogram, shares = figure.axes
        told = " ".join(
            [histogram.get_xlabel(), *(t.get_text() for t in histogram.get_legend().texts)]
        )
        told += " ".join(label.get_text() for label in shares.get_yticklabels())
        low, high = histogram.get_xlim()
        middle = found["final(body.w)"].quantile(0.5).value * 30 / np.pi
        assert low < middle < high
    assert "rpm" in told
    assert "50 %" in told
    assert "one.tau" in told


def test_modes_that_change_their_number_or_are_some_of_all_are_told():
    modes = lp.modes(pair())
    # overdamped from 2 sqrt(c Jr) = 69.3 N.m.s/rad on, with Jr = 1.2 kg.m2
    over = {"s.d": lp.uniform(60.0, 80.0)}
    found = lp.scatter(modes, over=over, of=fun.frequency(0), runs=300)
    lost = found.points[:, 0] > 2 * math.sqrt(1000 * 1.2)
    assert sorted(found.failures) == np.flatnonzero(lost).tolist()
    assert "there are 0 oscillating modes instead of 1" in repr(found)
    assert np.isnan(found.values[:, 0]).tolist() == lost.tolist()
    some = lp.modes(pair(), near=0.0, count=1)
    refused(OptionError, lambda: lp.scatter(some, over=over, of=fun.frequency(0)), "give all modes")
