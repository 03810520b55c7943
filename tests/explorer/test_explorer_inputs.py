"""What comes from the page or from files is checked, and the state of a page can be kept."""

import threading
import time

import numpy as np
import pytest

import lumped as lp
from lumped.compiler.parameter_file import parameter_text, parameters_in
from lumped.errors import LumpedError, OptionError, ParameterError, UnitError, UnknownNameError
from lumped.explorer.computing import Computing, Found
from lumped.explorer.measured import read_measured
from lumped.explorer.sliders import slider, sliders
from lumped.explorer.state import from_query, query
from lumped.explorer.study import Moment, Study
from lumped.explorer.views import View


@pytest.fixture(name="system")
def of_two_masses(two_mass):
    return lp.assemble(two_mass)


# -- sliders -------------------------------------------------------------------------------------


def test_positive_parameters_have_a_logarithmic_slider(system):
    found = slider(system, system.theta(None), "shaft.c")
    assert (found.low, found.high) == (30.0, 3000.0)
    assert found.ends == pytest.approx((np.log10(30.0), np.log10(3000.0)))
    assert found.value(np.log10(95.0)) == pytest.approx(95.0)
    exact = [found.value(found.position(x)) for x in (30.0, 300.0, 3000.0)]
    assert exact == [30.0, 300.0, 3000.0]
    assert (found.text, found.unit) == ("torsional stiffness", "N.m/rad")


def test_ends_may_have_units(system):
    found = slider(system, system.theta(None), "shaft.c", ("0.1 kN.m/rad", "500 N.m/rad"))
    assert (found.low, found.high, found.is_ratio) == (100.0, 500.0, False)
    assert found.value(250.0) == 250.0


def test_a_parameter_of_any_sign_has_even_steps(driven_mass):
    system = lp.assemble(driven_mass)
    found = slider(system, system.theta({"drive.tau": -3.0}), "drive.tau")
    assert (found.low, found.high, found.is_ratio) == (-6.0, 0.0, False)
    zero = slider(system, system.theta({"drive.tau": 0.0}), "drive.tau")
    assert (zero.low, zero.high) == (-1.0, 1.0)


@pytest.mark.parametrize("position", [1.0, 4.0, np.nan, np.inf, -np.inf, 1e300, -1e300])
def test_positions_beyond_the_ends_are_refused(system, position):
    found = slider(system, system.theta(None), "shaft.c")
    with pytest.raises(ParameterError, match=r"shaft\.c = .* goes from 30 to 3000"):
        found.value(position)


def ended(low: float | str, high: float | str) -> dict:
    return {"shaft.c": (low, high)}


@pytest.mark.parametrize(
    ("wanted", "fault", "text"),
    [
        (ended(400.0, 200.0), OptionError, "goes from 400 to 200"),
        (ended(400.0, 500.0), OptionError, "the value of the model, 300 N.m/rad, lies beyond"),
        (ended(-1.0, 500.0), ParameterError, r"end of the slider of shaft\.c = -1 N.m/rad"),
        ({"shaft.c": (1.0,)}, OptionError, "give both ends"),
        (ended("1 kg", "2 kg"), UnitError, "must be of the kind N.m/rad"),
        (ended(float("nan"), 500.0), ParameterError, "shaft.c"),
        (["shaft.k"], UnknownNameError, r"shaft\.k"),
        ([], OptionError, "at least one"),
        (["shaft.c", "shaft.c"], OptionError, "named twice"),
    ],
)
def test_wrong_sliders_are_told(system, wanted, fault, text):
    with pytest.raises(fault, match=text):
        sliders(system, system.theta(None), wanted)


# -- state ---------------------------------------------------------------------------------------


def test_a_link_restores_sliders_and_values(system):
    base = {"a.J": 2.5}
    what = Study(system, base)
    shown = sliders(system, system.theta(base), {"shaft.c": (100.0, 400.0), "a.J": (1.0, 3.0)})
    values = {"a.J": 2.0, "shaft.c": 123.456789012345678, "b.J": 1.0}
    text = query(what, shown, values)
    found, restored = from_query(what, shown, text)
    assert found == shown
    assert restored == {name: values[name] for name in ("a.J", "shaft.c")}
    added, _ = from_query(what, shown[:1], text)
    assert [each.name for each in added] == ["shaft.c", "a.J"]


@pytest.mark.parametrize(
    ("text", "fault", "told"),
    [
        ("shaft.c=abc", ParameterError, "shaft.c = 'abc'"),
        ("shaft.c=-5", ParameterError, "must be greater than 0"),
        ("shaft.c=nan", ParameterError, r"shaft\.c"),
        ("shaft.c=1e5", ParameterError, "its slider goes from 30 to 3000"),
        ("shaft.c=100&shaft.c=200", OptionError, "twice"),
        ("shaft.q=1", UnknownNameError, r"shaft\.q"),
        ("_sliders=__import__('os')", UnknownNameError, "__import__"),
    ],
)
def test_wrong_links_are_told(system, text, fault, told):
    with pytest.raises(fault, match=told):
        from_query(Study(system), sliders(system, system.theta(None), ["shaft.c"]), text)


@pytest.mark.parametrize("name", ["two.toml", "two.json"])
def test_parameter_files_pass_through_texts(system, name, tmp_path):
    values = {"shaft.c": 1 / 3, "a.J": 7.0, "b.J": 1.0}
    text = parameter_text(system, name, values)
    received = parameters_in(system, name, text.encode())
    assert {key: received[key] for key in values} == values
    (tmp_path / name).write_text(text, encoding="utf-8")
    assert lp.compiler.parameter_file.read_parameters(system, tmp_path / name) == received


# -- measured curves -----------------------------------------------------------------------------


def test_measured_curves_are_read_in_their_units(system):
    held = b"time [ms],shaft.tau [kN.m]\r\n0,0.1\r\n10,-0.25\r\n"
    found = read_measured(system, "rig.csv", held)
    assert found.t == pytest.approx([0.0, 0.01])
    assert found.curves["shaft.tau"] == pytest.approx([100.0, -250.0])


def test_what_a_run_saves_can_be_laid_over(system, tmp_path):
    run = lp.simulate(system, until=0.1, start={"shaft.phi_rel": 0.01}, grid=20)
    run.save(tmp_path / "run.csv", ["shaft.tau", "a.w"])
    found = read_measured(system, "run.csv", (tmp_path / "run.csv").read_bytes())
    assert found.curves["a.w"].tolist() == run["a.w"].tolist()


def test_curves_of_a_universal_file_can_be_laid_over(system, tmp_path):
    run = lp.simulate(system, until=0.1, start={"shaft.phi_rel": 0.01}, grid=20)
    file = lp.exchange.write_uff(tmp_path / "run.uff", run, nodes={"shaft.tau": 1, "a.w": 2})
    found = read_measured(system, "run.uff", file.read_bytes())
    assert found.t.tolist() == run.t.tolist()
    assert found.curves["shaft.tau"].tolist() == run["shaft.tau"].tolist()
    shapes = lp.exchange.write_uff(tmp_path / "shapes.unv", lp.modes(system), nodes={"a.phi": 1})
    with pytest.raises(OptionError, match="no curve over time"):
        read_measured(system, "shapes.unv", shapes.read_bytes())
    with pytest.raises(OptionError, match=r"end in \.csv, \.uff or \.unv"):
        read_measured(system, "run.mat", b"")


@pytest.mark.parametrize(
    ("text", "fault", "told"),
    [
        ("time [s],shaft.tau [N.m]\n0,1\n1,x\n", OptionError, "as many numbers"),
        ("time [s],shaft.tau [N.m]\n0,1\n1\n", OptionError, "as many numbers"),
        ("shaft.tau [N.m],time [s]\n0,1\n1,2\n", OptionError, "first column is 'shaft.tau'"),
        ("time [s],shaft.tau [kg]\n0,1\n1,2\n", UnitError, "shaft.tau"),
        ("time [s],shaft.t [N.m]\n0,1\n1,2\n", UnknownNameError, "shaft.t"),
        ("time [s],shaft.tau [N.m]\n1,1\n0,2\n", OptionError, "must increase"),
        ("time [s],shaft.tau [N.m]\n0,nan\n1,2\n", OptionError, "finite"),
        ("time [s],shaft.tau [N.m]\n0,1\n", OptionError, "two instants"),
        ("", OptionError, "needed"),
    ],
)
def test_wrong_measurements_are_told(system, text, fault, told):
    with pytest.raises(fault, match=told):
        read_measured(system, "rig.csv", text.encode())


# -- the latest values win -----------------------------------------------------------------------


def test_what_is_slow_comes_later_and_only_for_the_latest_values(system):
    go, told, done = threading.Event(), [], threading.Event()

    def slow(moment: Moment, _: object) -> dict:
        go.wait(10)
        time.sleep(0.2)
        return {"x": {"x": [moment.values["shaft.c"]]}}

    def tell(moment: Moment, found: list[Found], coming: list[View]) -> None:
        told.append((moment.values["shaft.c"], [each.view.title for each in found]))
        if not coming:
            done.set()

    quick = View("curves", "quick", lambda moment, _: {"x": {"x": [moment.values["shaft.c"]]}})
    computing = Computing([quick, View("curves", "slow", slow)], tell)
    go.set()
    computing.begin(Moment(Study(system), {"shaft.c": 1.0}), ())
    assert done.wait(10)
    done.clear()
    go.clear()
    told.clear()
    for value in (2.0, 3.0, 4.0):
        computing.begin(Moment(Study(system), {"shaft.c": value}), ())
    while (4.0, ["quick"]) not in told:
        time.sleep(0.005)
    go.set()
    assert done.wait(10)
    computing.end()
    assert told[-2:] == [(4.0, ["quick"]), (4.0, ["slow"])]
    assert (2.0, ["slow"]) not in told
    assert (3.0, ["slow"]) not in told


def test_what_fails_is_told_in_words_and_the_rest_goes_on(system):
    def fails(moment: Moment, _: object) -> dict:
        raise (
            LumpedError("shaft: breaks") if moment.values["shaft.c"] < 2 else ZeroDivisionError("a")
        )

    told: dict[str, str] = {}
    done = threading.Event()

    def tell(_: Moment, found: list[Found], coming: list[View]) -> None:
        told.update({each.view.title: each.error for each in found})
        if not coming:
            done.set()

    good = View("curves", "good", lambda *_: {"x": {"x": []}})
    for value, text in ((1.0, "shaft: breaks"), (3.0, "ZeroDivisionError: a")):
        computing = Computing([View("curves", "bad", fails), good], tell)
        computing.begin(Moment(Study(system), {"shaft.c": value}), ())
        assert done.wait(10)
        done.clear()
        computing.end()
        assert told == {"bad": text, "good": ""}


# -- calls ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "fault", "told"),
    [
        ({"until": -1.0}, OptionError, "positive"),
        ({"until": 1.0, "of": []}, OptionError, "name quantities"),
        ({"of": ["shaft.q"]}, UnknownNameError, r"shaft\.q"),
        ({"inputs": ["shaft.tau"]}, UnknownNameError, r"shaft\.tau"),
        ({"parameters": {"shaft.c": -1.0}}, ParameterError, r"shaft\.c"),
        ({"sliders": "shaft.c"}, OptionError, "sliders"),
    ],
)
def test_wrong_calls_are_told(system, options, fault, told):
    with pytest.raises(fault, match=told):
        lp.explore(system, **options)
