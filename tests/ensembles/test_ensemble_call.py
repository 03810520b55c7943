"""The call of an ensemble: failures, refusals, options, and what it gives back."""

import numpy as np
import pytest
from oscillator import UNTIL, C, closed_form
from rows import in_a_row

import lumped as lp
from lumped import functionals as fun
from lumped.components import Brake, Fixed, Inertia, Torque
from lumped.errors import OptionError, ParameterError, SolverError, UnknownNameError
from lumped.many_runs.native_runs import NativeRuns
from lumped.ops import log, sqrt

X = {"x": fun.final("shaft.phi_rel")}


def ran(system, **options):
    given = {"over": {"shaft.c": C}, "until": UNTIL, "of": X, "rtol": 1e-9, **options}
    return lp.ensemble(system, **given)


# -- failures --------------------------------------------------------------------------------------


class Fussy(lp.Component):
    """A state that runs to infinity or whose rate is no number, and a root that may be none."""

    k: lp.Param = lp.param("1/s", "growth", 0.5)
    p: lp.Param = lp.param("1", "whose logarithm is taken", 1.0)
    x: lp.Var = lp.var("1", "what grows", 1.0, state="always")
    y: lp.Var = lp.var("1", "a root")

    def equations(self):
        yield lp.der(self.x) == self.k * self.x**2 + log(self.p)
        yield self.y == sqrt(2 - self.x)


@pytest.fixture(scope="module")
def fussy():
    return lp.assemble(Fussy())


def test_runs_that_fail_are_set_apart_with_their_reasons(fussy):
    """The state is 1 / (1 - k t); it is infinite at t = 1 / k."""
    over = lp.ensembles.paired({"k": [0.1, 0.5, 1.2, 0.9, 0.3], "p": [1.0, 1.0, 1.0, 1.0, -2.0]})
    of = {"x": fun.final("x"), "y": fun.final("y")}
    found = lp.ensemble(fussy, over=over, until=1.0, of=of, rtol=1e-9)
    expected = np.where([1, 1, 0, 1, 0], 1 / (1 - found["k"]), np.nan)
    error = np.nanmax(np.abs(found["x"] / expected - 1))
    assert error < 1e-7
    assert (np.isnan(found["x"]) == np.isnan(expected)).all()
    assert set(found.failures) == {2, 3, 4}
    assert "t = 0.8333" in found.failures[2]
    assert found.failures[3] == "y: not a number"
    assert "derivative of x is not a finite number at t = 0 s" in found.failures[4]
    assert np.isfinite(found["y"]).tolist() == [True, True, False, False, False]
    assert "3 failed" in repr(found)
    for i in (2, 4):
        point = dict(zip(found.names, found.points[i].tolist(), strict=True))
        with pytest.raises(SolverError) as alone:
            lp.simulate(fussy, until=1.0, parameters=point, method="steps", rtol=1e-9)
        assert found.failures[i] == str(alone.value)


def test_an_extreme_of_what_is_no_number_is_told(fussy):
    """The root is no number from t = 1 / (2 k) on; before it falls to zero."""
    of = {"late": fun.highest("y", between=(0.9, 1.0)), "lowest": fun.lowest("y")}
    found = lp.ensemble(fussy, over={"k": [0.1, 0.9]}, until=1.0, of=of)
    assert np.isnan(found.values[1]).all()
    assert "late: not a number" in found.failures[1]


def test_only_some_reasons_are_looked_for_and_others_refer_to_them(fussy):
    p = np.linspace(-50.0, 50.0, 101)
    of = {"x": fun.final("x")}
    found = lp.ensemble(fussy, over={"p": p}, until=0.1, of=of, parameters={"k": 0.1})
    assert sorted(found.failures) == np.flatnonzero(p <= 0).tolist()
    assert found.failures[50].startswith("as run 0: ")
    assert "run 0 and 19 more: " in repr(found)


def test_where_all_runs_fail_there_is_one_error_that_says_why_once(fussy):
    with pytest.raises(SolverError) as caught:
        lp.ensemble(fussy, over={"k": [3.0, 2.0, 4.0]}, until=1.0, of=[fun.final("x")])
    text = str(caught.value)
    assert text.startswith("ensemble: all 3 runs fail. Run 0: Fussy: the ")
    assert text.count("t = 0.3333") == 1


class Saturated(lp.Component):
    """A spring whose torque never reaches its limit."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    limit: lp.Param = lp.param("N.m", "limit of the torque", 50.0, above=0)
    twist: lp.Var = lp.var("rad", "twist", 0.0)
    tau: lp.Var = lp.var("N.m", "torque on flange b")

    def equations(self):
        yield self.twist == self.flange_b.phi - self.flange_a.phi
        yield self.tau == self.limit * self.twist / sqrt(1 + self.twist**2)
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau


def test_starts_are_searched_for_with_the_parameters_of_each_run():
    """The torque at the start gives the twist; where it is beyond the limit there is no start."""
    model = in_a_row(ground=Fixed(), shaft=Saturated(), body=Inertia(J=1e9, w=0.0))
    limit = np.array([40.0, 25.0, 60.0, 31.0])
    of, over = {"twist": fun.final("shaft.twist")}, {"shaft.limit": limit}
    start = {"shaft.tau": 30.0}
    found = lp.ensemble(lp.assemble(model), over=over, until=1e-3, of=of, start=start)
    assert set(found.failures) == {1}
    assert "shaft.tau" in found.failures[1]
    good = limit > 30
    share = 30 / limit[good]
    assert found["twist"][good] == pytest.approx(share / np.sqrt(1 - share**2), rel=1e-8)


# -- refusals --------------------------------------------------------------------------------------

WRONG = [
    ({"over": {"shaft.k": C}}, UnknownNameError, r"no parameter 'shaft\.k'\. Nearest: shaft\.c"),
    ({"over": {"shaft.c": [1.0, -1.0]}}, ParameterError, "must be greater than 0: run 1 of 2"),
    ({"over": {}}, OptionError, "nothing to vary"),
    ({"of": [fun.final("shaft.x")]}, UnknownNameError, r"no quantity 'shaft\.x'"),
    ({"of": [fun.instant("brake")]}, OptionError, "'brake' has no events. Nothing else has"),
    ({"of": []}, OptionError, "name what to take from each run"),
    ({"of": {}}, OptionError, "name what to take from each run"),
    ({"of": fun.final("shaft.tau")}, OptionError, "or a list, each"),
    ({"of": {"x": lambda run: 1.0}}, OptionError, r"of\['x'\] = .* lumped.functionals"),
    ({"of": [fun.frequency(0)]}, OptionError, "no functional of a run"),
    ({"of": [fun.impulse("shaft")]}, OptionError, "'shaft' has no events"),
    ({"of": [fun.peak("body.w", between=(0.5, 0.8))]}, OptionError, "the runs last from 0 to 0.7"),
    ({"of": [fun.at_time(0.8, "body.w")]}, OptionError, "the runs last from 0 to 0.7 s"),
    (
        {"of": [fun.at_time(0.2, "body.w")], "begin": 0.3},
        OptionError,
        "the runs last from 0.3 to 0.7",
    ),
    ({"until": -1.0}, OptionError, "the end must be a positive, finite time"),
    ({"begin": 0.7}, OptionError, "the end must be after the begin"),
    ({"rtol": 2.0}, OptionError, "tolerance must lie between"),
    ({"atol": 0.0}, OptionError, "absolute tolerance must be positive"),
    ({"method": "exact"}, OptionError, "method"),
    ({"method": "fast"}, OptionError, "method = 'fast'"),
    ({"max_steps": 0}, OptionError, "at least one step"),
    ({"workers": 0}, OptionError, "at least one thread"),
    ({"client": 5}, OptionError, "a client from dask.distributed is needed"),
    ({"grid": 5}, OptionError, "no option 'grid'"),
    ({"runs": 5}, OptionError, "runs = 5 is for distributions"),
    ({"start": {"body.x": 1.0}}, UnknownNameError, r"no quantity 'body\.x'"),
    ({"parameters": {"body.K": 1.0}}, UnknownNameError, r"no parameter 'body\.K'"),
    ({"parameters": {"body.J": -1.0}}, ParameterError, r"body\.J = -1 kg\.m2"),
]


@pytest.mark.parametrize(("options", "kind", "text"), WRONG)
def test_what_makes_no_sense_is_refused_before_the_first_run(
    system, monkeypatch, options, kind, text
):
    monkeypatch.setattr(NativeRuns, "run", None)
    with pytest.raises(kind, match=text):
        ran(system, **options)


def test_modes_that_a_component_has_not_are_refused():
    model = in_a_row(body=Inertia(J=1.0, w=1.0), brake=Brake(f_max=1.0, u=1.0))
    system, given = lp.assemble(model), {"over": {"body.J": [1.0]}, "until": 1.0}
    with pytest.raises(OptionError, match="modes of brake are: backward, forward, free, stuck"):
        lp.ensemble(system, of=[fun.instant("brake", "open")], **given)
    with pytest.raises(OptionError, match=r"'brak' has no events\. Nearest: brake"):
        lp.ensemble(system, of=[fun.count("brak")], **given)


# -- what it takes and gives -----------------------------------------------------------------------


def test_functionals_in_a_list_are_labelled_by_what_they_are(system):
    of = [fun.final("shaft.phi_rel"), fun.peak(system.model.body.w, between=(0.1, 0.2))]
    found = ran(system, of=of)
    assert found.labels == ("final(shaft.phi_rel)", "peak(body.w, 0.1 to 0.2 s)")
    named = ran(system, of=dict(zip("ab", of, strict=True)))
    assert named.labels == ("a", "b")
    assert (named.values == found.values).all()
    assert (found["final(shaft.phi_rel)"] == found.values[:, 0]).all()
    with pytest.raises(OptionError, match=r"there is no 'c'\. Nearest: shaft\.c"):
        named["c"]


def test_functionals_that_differ_have_labels_that_differ(system):
    of = [fun.at_time([0.1, 0.2, 0.3, last], "body.w") for last in (0.4, 0.6)]
    assert len(ran(system, of=of).labels) == 2


def test_parameters_hold_in_all_runs_unless_they_vary(system):
    given = {"body.J": 4.0, "shaft.c": 1.0}
    found = ran(system, parameters=given)
    assert found["x"] == pytest.approx(closed_form(C, 4.0), rel=1e-7)
    faster = ran(system, start={"body.w": "2 rad/s"})
    assert faster["x"] == pytest.approx(2 * closed_form(C), rel=1e-7)


def test_drawn_runs_are_those_of_their_seed(system):
    over = {"shaft.c": lp.uniform(50.0, 200.0)}
    found = ran(system, over=over, runs=40, seed=5)
    expected = 50 + 150 * np.random.default_rng(5).random(40)
    assert found["shaft.c"] == pytest.approx(expected, rel=1e-14)
    assert found["x"] == pytest.approx(closed_form(found["shaft.c"]), abs=1e-8)


def test_runs_may_begin_at_any_time():
    model = in_a_row(drive=Torque(tau=2.0 * lp.time), body=Inertia(J=1.0, w=0.0))
    of = {
        "w": fun.final("body.w"),
        "at": fun.at_time([1.0, 1.5], "body.a"),
        "mean": fun.mean("drive.tau"),
        "part": fun.integral("drive.tau", between=(1.2, 1.5)),
        "lowest": fun.lowest("body.a"),
    }
    J = np.array([0.5, 2.0])
    over, system = {"body.J": J}, lp.assemble(model)
    found = lp.ensemble(system, over=over, begin=1.0, until="2 s", of=of)
    expected = [3 / J, 5 / J, [3.0, 3.0], [0.81, 0.81], 2 / J]
    assert pytest.approx(np.array(expected), rel=1e-12) == found.values.T


def test_tables_quantiles_and_texts(system):
    found = ran(system, over={"shaft.c": C, "body.J": [1.0, 4.0]})
    assert len(found) == 14
    assert found.shape == (7, 2)
    expected = closed_form(C[:, None], np.array([1.0, 4.0]))
    assert found["x"].reshape(found.shape) == pytest.approx(expected, rel=1e-7)
    assert found.quantile("x", [0.0, 0.25, 1.0]) == pytest.approx(
        np.quantile(expected, [0.0, 0.25, 1.0]), rel=1e-7
    )
    head, _, _, row = repr(found).splitlines()
    assert head.startswith("14 runs, 0 failed; ")
    assert row.split()[0] == "x"
    *numbers, unit = row.split()[1:]
    assert unit == "rad"
    numbers = [float(text) for text in numbers]
    told = [np.min, np.median, np.max, np.mean, lambda x: np.std(x, ddof=1)]
    assert numbers == pytest.approx([f(expected) for f in told], rel=1e-5)


def test_a_frame_holds_parameters_results_and_reasons(system):
    pytest.importorskip("pandas")
    found = ran(system, over={"shaft.c": [1.0, 1e7]}, max_steps=60, rtol=1e-6)
    frame = found.to_pandas()
    assert list(frame.columns) == ["shaft.c", "x", "failure"]
    assert frame["failure"][0] == ""
    assert "max_steps" in frame["failure"][1]
    assert (frame["x"].to_numpy()[:1] == found["x"][:1]).all()


def test_quantiles_leave_out_runs_without_a_result_and_say_if_there_is_none(system):
    of = {**X, "w": fun.final("body.w")}
    found = ran(system, of=of, over={"shaft.c": [1.0, 1e7, 4.0]}, max_steps=60, rtol=1e-6)
    expected = np.median(closed_form(np.array([1.0, 4.0])))
    assert found.quantile("x", 0.5) == pytest.approx(expected, rel=1e-5)
    none = lp.ensembles.Ensemble(**{**vars(found), "values": np.full_like(found.values, np.nan)})
    with pytest.raises(OptionError, match=r"no run has 'x'\. .*max_steps = 60"):
        none.quantile("x", 0.5)
