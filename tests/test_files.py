"""Results and parameters in files, read back by lumped and by others' readers."""

import json

import DyMat
import numpy as np
import pandas
import pytest
import xarray

import lumped as lp
from lumped.components import Inertia, SpringDamper, Torque
from lumped.errors import OptionError, ParameterError, UnitError, UnknownNameError


@pytest.fixture(scope="module")
def run():
    drive = lp.compose(
        torque=Torque(tau=lp.ops.where(lp.time >= 0.5, 3.0, 1.0)),
        body=[Inertia(J=1.0), Inertia(J=0.5)],
        shaft=SpringDamper(c=30.0, d=0.1),
        connections=lambda m: lp.chain(m.torque, m.body[0], m.shaft, m.body[1]),
    )
    return lp.simulate(lp.assemble(drive), until=1.0, grid=40)


@pytest.mark.parametrize("ending", ["nc", "npz", "csv"])
def test_a_result_is_read_back_to_the_last_bit(run, tmp_path, ending):
    found = lp.load(run.save(tmp_path / f"run.{ending}"))
    assert (found["time"] == run.t).all()
    assert {"shaft.tau", "body[1].w", "torque.tau"} <= set(found.values)
    for name, values in found.values.items():
        assert (values == run[name]).all()
        assert found.units[name] == run.system.quantity(name).unit
    if ending != "csv":
        assert found.model == run.system.name
        assert found.parameters == run.system.parameters
        assert found.parameter_units["shaft.c"] == "N.m/rad"
        assert found.texts["shaft.tau"] == run.system.quantity("shaft.tau").text


def test_the_fingerprint_is_that_of_the_equations(run, two_mass, tmp_path):
    def mark(model, parameters=None):
        made = lp.simulate(lp.assemble(model), until=0.1, parameters=parameters)
        return lp.load(made.save(tmp_path / "x.npz")).fingerprint

    assert mark(two_mass) == mark(two_mass, {"shaft.c": 7.0})
    stiffer = two_mass.with_({"shaft": SpringDamper(c=1.0, d=1.0)})
    assert mark(two_mass) != mark(stiffer)


def test_others_read_the_same(run, tmp_path):
    names = ["shaft.tau", "body[1].w"]
    dymola = DyMat.DyMatFile(str(run.save(tmp_path / "run.mat")))
    assert (dymola.abscissa("shaft.tau", valuesOnly=True) == run.t).all()
    for name in names:
        assert (dymola.data(name) == run[name]).all()
    assert dymola.data("shaft.c").tolist() == [30.0, 30.0]
    assert dymola.description("shaft.tau") == "torque on flange b [N.m]"
    with xarray.open_dataset(run.save(tmp_path / "run.nc"), engine="scipy") as data:
        assert (data["shaft.tau"].to_numpy() == run["shaft.tau"]).all()
        assert data["shaft.tau"].attrs["units"] == "N.m"
    frame = pandas.read_csv(run.save(tmp_path / "run.csv", names), skiprows=[1])
    assert list(frame) == ["time", *names]
    assert (frame["body[1].w"].to_numpy() == run["body[1].w"]).all()


def test_tables_carry_units(run):
    frame, data = run.to_pandas(["shaft.tau"]), run.to_xarray(["shaft.tau"])
    assert frame.index.name == "time"
    assert (frame["shaft.tau"].to_numpy() == run["shaft.tau"]).all()
    assert frame.attrs["units"] == {"shaft.tau": "N.m"}
    assert data["shaft.tau"].attrs["units"] == "N.m"
    assert data.attrs["model"] == run.system.name


def test_files_that_cannot_be_are_refused(run, tmp_path):
    with pytest.raises(OptionError, match=r"run\.xls: the ending must be one of \.nc"):
        run.save(tmp_path / "run.xls")
    (tmp_path / "other.csv").write_text("a;b\n1;2\n")
    with pytest.raises(OptionError, match="no result that lumped wrote"):
        lp.load(tmp_path / "other.csv")
    with pytest.raises(UnknownNameError, match=r"'shaft\.ta' was not saved.*shaft\.tau"):
        lp.load(run.save(tmp_path / "run.npz"))["shaft.ta"]


@pytest.mark.parametrize("ending", ["toml", "json"])
def test_parameters_go_out_and_in(run, tmp_path, ending):
    system = run.system
    path = lp.write_parameters(system, tmp_path / f"p.{ending}", {"shaft.c": 1 / 3})
    found = lp.read_parameters(system, path)
    assert found == system.parameters | {"shaft.c": 1 / 3}
    again = lp.simulate(system, until=1.0, grid=40, parameters=found)
    direct = lp.simulate(system, until=1.0, grid=40, parameters={"shaft.c": 1 / 3})
    assert np.array_equal(again["shaft.tau"], direct["shaft.tau"])


def test_edited_files_are_converted_and_checked(run, tmp_path):
    system, path = run.system, tmp_path / "p.toml"
    path.write_text('"body[0].J" = "2 t.cm2"\n[shaft]\nc = "1 kN.m/rad"\nd = 2\n')
    found = lp.read_parameters(system, path)
    assert found == pytest.approx({"body[0].J": 0.2, "shaft.c": 1000.0, "shaft.d": 2.0})
    for text, error, match in (
        ('"shaft.c" = "3 kg"', UnitError, r"shaft\.c = '3 kg'"),
        ('"shaft.e" = 1', UnknownNameError, r"shaft\.e"),
        ('"shaft.c" = [1]', ParameterError, r"p\.toml: shaft\.c = \[1\]"),
        ('"body[0].J" = -1', ParameterError, r"body\[0\]\.J = -1 kg\.m2"),
        ("shaft = ", OptionError, r"p\.toml"),
    ):
        path.write_text(text)
        with pytest.raises(error, match=match):
            lp.read_parameters(system, path)
    with pytest.raises(OptionError, match=r"\.toml or \.json"):
        lp.write_parameters(system, tmp_path / "p.yaml")
    (tmp_path / "p.json").write_text(json.dumps({"shaft": {"c": 7}}))
    assert lp.read_parameters(system, tmp_path / "p.json") == {"shaft.c": 7.0}
