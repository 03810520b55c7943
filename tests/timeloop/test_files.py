"""Results and parameters in files, read back by lumped and by others' readers."""

import json
import sys

import DyMat
import numpy as np
import pandas
import pytest
import xarray
from checks import refused
from rows import assemble_row, in_rows

import lumped as lp
from lumped.components import Fixed, Inertia, SpringDamper, Torque, translation
from lumped.errors import OptionError, ParameterError, UnitError, UnknownNameError
from lumped.timeloop.results.file_formats import apart, together


@pytest.fixture(scope="module")
def run():
    drive = lp.compose(
        torque=Torque(tau=lp.ops.where(lp.time >= 0.5, 3.0, 1.0)),
        body=[Inertia(J=1.0), Inertia(J=0.5)],
        shaft=SpringDamper(c=30.0, d=0.1),
        connections=lambda m: lp.chain(m.torque, m.body[0], m.shaft, m.body[1]),
    )
    return lp.simulate(lp.assemble(drive), until=1.0, grid=40)


@pytest.fixture(scope="module")
def bounces():
    model = in_rows(
        "weight ball",
        "ground floor ball",
        weight=translation.Force(f=-2.0 * 9.81),
        ball=translation.Mass(m=2.0, s=1.0, v=0.0),
        floor=translation.Stop(restitution=0.5),
        ground=translation.Fixed(),
    )
    return lp.simulate(lp.assemble(model), until=1.0)


@pytest.mark.parametrize("ending", ["nc", "npz", "csv"])
def test_a_result_is_read_back_to_the_last_bit(run, tmp_path, ending):
    found = lp.load(run.save(tmp_path / f"run.{ending}"))
    assert (found["time"] == run.t).all()
    assert {"shaft.tau", "body[1].w", "torque.tau"} <= set(found.values)
    for name, values in found.values.items():
        assert (values == run[name]).all()
        assert found.units[name] == run.system.quantity(name).unit
    if ending != "csv":
        assert found.events == run.events != ()
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
    frame = pandas.read_csv(run.save(tmp_path / "run.csv", names))
    assert list(frame) == ["time [s]", "shaft.tau [N.m]", "body[1].w [rad/s]"]
    assert set(frame.dtypes) == {np.dtype(float)}
    assert (frame["body[1].w [rad/s]"].to_numpy() == run["body[1].w"]).all()
    numbers = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)
    assert (numbers[:, 1] == run["shaft.tau"]).all()


def test_tables_carry_units(run):
    frame, data = run.to_pandas(["shaft.tau"]), run.to_xarray(["shaft.tau"])
    assert frame.index.name == "time"
    assert (frame["shaft.tau"].to_numpy() == run["shaft.tau"]).all()
    assert frame.attrs["units"] == {"shaft.tau": "N.m"}
    assert data["shaft.tau"].attrs["units"] == "N.m"
    assert data.attrs["model"] == run.system.name


def test_the_times_of_tables_increase_and_give_what_is_after_a_jump(run, tmp_path):
    """The torque is 1 N.m before 0.5 s and 3 N.m from there on; both stand in the run."""
    assert (run.t == 0.5).sum() == 2
    frame, data = run.to_pandas(), run.to_xarray()
    read = pandas.read_csv(run.save(tmp_path / "run.csv"), index_col="time [s]")
    with xarray.open_dataset(run.save(tmp_path / "run.nc"), engine="scipy") as file:
        for index in (frame.index, data.indexes["time"], read.index, file.indexes["time"]):
            assert index.is_unique
            assert index.is_monotonic_increasing
            assert np.abs(index.to_numpy() - run.t).max() <= np.spacing(0.5)
        for table in (data, file):
            torque = table["torque.tau"]
            assert torque.sel(time=0.5).item() == 3.0
            assert torque.sel(time=0.4999, method="ffill").item() == 1.0
            assert torque.interp(time=[0.49, 0.51]).to_numpy().tolist() == [1.0, 3.0]
    for table, name in ((frame, "torque.tau"), (read, "torque.tau [N.m]")):
        assert table.loc[0.5, name] == 3.0
        assert table[name].loc[:0.5].iloc[-2] == 1.0


def test_many_jumps_at_one_instant_are_told_apart_and_put_together_again():
    t = np.array([0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 2.0, 3.0])
    moved = apart(t)
    assert (np.diff(moved) > 0).all()
    assert moved[[1, 2, 6, 7]].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert (together(moved) == t).all()


@pytest.mark.parametrize("ending", ["nc", "npz"])
def test_a_loaded_run_has_its_events_and_its_plot(bounces, tmp_path, ending):
    """A ball falls from 1 m on a floor that gives back half the speed."""
    found = lp.load(bounces.save(tmp_path / f"run.{ending}"))
    assert found.events == bounces.events
    first = next(event for event in found.events if event.loss)
    assert first.time == pytest.approx(np.sqrt(2 / 9.81), rel=1e-9)
    assert first.loss == pytest.approx(0.75 * 2.0 * 9.81, rel=1e-6)
    assert first.component == "floor"
    for drawn, own in zip(found.plot().axes, bounces.plot().axes, strict=True):
        assert drawn.get_ylabel() == own.get_ylabel()
        for a, b in zip(drawn.get_lines(), own.get_lines(), strict=True):
            assert (a.get_label(), a.get_xydata().tolist()) == (
                b.get_label(),
                b.get_xydata().tolist(),
            )
    (panel,) = found.plot(["ball.s"]).axes
    assert (panel.get_lines()[0].get_ydata() == bounces["ball.s"]).all()


def test_a_csv_without_states_draws_what_it_has(bounces, tmp_path):
    found = lp.load(bounces.save(tmp_path / "run.csv", ["ball.v", "ball.s"]))
    labels = [axis.get_lines()[0].get_label() for axis in found.plot().axes]
    assert labels == ["ball.v", "ball.s"]
    refused(UnknownNameError, lambda: found.plot(["ball.x"]), "'ball.x' was not saved")


def test_names_are_answered_by_runs_points_and_files(run, tmp_path):
    point, found = run.point(0.2), lp.load(run.save(tmp_path / "run.npz"))
    for one in (run, point, found):
        assert "shaft.tau" in one
        assert "shaft.c" not in one
        assert "shaft.x" not in one
        assert {"shaft.tau", "body[1].w"} <= set(one)
        assert all(np.isfinite(one[name]).all() for name in one)
        np.testing.assert_array_equal(
            one[["shaft.tau", "body[1].w"]].T, [one["shaft.tau"], one["body[1].w"]]
        )
        with pytest.raises(UnknownNameError, match=r"run\[\[\.\.\.\]\] takes a list of several"):
            one["shaft.tau", "body[1].w"]
        with pytest.raises(UnknownNameError, match="0 is neither a name nor a reference"):
            one[0]
    assert run.table(["shaft.tau", "body[1].w"]).shape == (len(run.t), 2)


@pytest.mark.parametrize("ending", ["nc", "npz", "csv"])
def test_a_file_that_is_cut_off_anywhere_is_refused(run, tmp_path, ending):
    path = run.save(tmp_path / f"run.{ending}", ["shaft.tau", "body[1].w"])
    whole = path.read_bytes()
    ends = {0, 1, 3, 10, len(whole) - 1, *range(0, len(whole), len(whole) // 40)}
    lines = [i + 1 for i, byte in enumerate(whole) if byte == ord("\n")]
    if ending == "csv":
        ends |= set(lines[:-1])
    for end in ends:
        path.write_bytes(whole[:end])
        with pytest.raises(
            OptionError, match=rf"run\.{ending}: this is no result that lumped wrote"
        ):
            lp.load(path)


@pytest.mark.parametrize("ending", ["nc", "npz"])
def test_a_file_with_a_damaged_bit_is_refused_or_says_the_same(run, tmp_path, ending):
    path = run.save(tmp_path / f"run.{ending}", ["shaft.tau", "body[1].w"])
    whole, rng, refused = path.read_bytes(), np.random.default_rng(5), 0
    for place in rng.integers(0, len(whole), 150):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << rng.integers(0, 8)
        path.write_bytes(damaged)
        try:
            found = lp.load(path)
        except OptionError:
            refused += 1
            continue
        assert list(found) == ["shaft.tau", "body[1].w"]
        assert (found["shaft.tau"] == run["shaft.tau"]).all()
        assert (found.t == run.t).all()
        assert found.events == run.events
        assert found.parameters == run.system.parameters
    assert refused > 100


@pytest.mark.parametrize("ending", ["nc", "npz", "csv"])
def test_a_foreign_file_is_refused(run, tmp_path, ending):
    path = tmp_path / f"run.{ending}"
    for held in (b"", b"PK\x03\x04", b"CDF\x01" + bytes(20), b"a,b\n1,2\n\r\n", bytes(range(256))):
        path.write_bytes(held)
        refused(OptionError, lambda: lp.load(path), "this is no result that lumped wrote")
    refused(FileNotFoundError, lambda: lp.load(tmp_path / f"absent.{ending}"), "absent")


def test_letters_of_other_alphabets(tmp_path):

    run = lp.simulate(
        assemble_row(ω_1=Inertia(J=1.0, w=1.0), shaft=SpringDamper(c=1.0, d=0.1), wall=Fixed()),
        until=0.1,
    )
    for ending in ("nc", "npz", "csv"):
        found = lp.load(run.save(tmp_path / f"run.{ending}"))
        assert (found["ω_1.w"] == run["ω_1.w"]).all()
    assert found.units["ω_1.w"] == "rad/s"
    with pytest.raises(OptionError, match=r"ω_1.*: a \.mat file has no such letters"):
        run.save(tmp_path / "run.mat")
    assert not (tmp_path / "run.mat").exists()


WRITERS = {
    "run.nc": lambda run, path: run.save(path),
    "run.npz": lambda run, path: run.save(path),
    "run.csv": lambda run, path: run.save(path),
    "run.mat": lambda run, path: run.save(path),
    "p.toml": lambda run, path: lp.exchange.write_parameters(run.system, path),
    "p.json": lambda run, path: lp.exchange.write_parameters(run.system, path),
    "page.html": lambda run, path: lp.drawing.report_html(run.system, path),
    "unit.fmu": lambda run, path: lp.export_fmu(run.system, path),
}


@pytest.mark.skipif(sys.platform == "win32", reason="there is no limit for files")
@pytest.mark.parametrize("name", WRITERS)
def test_a_full_disk_leaves_what_was_there_and_nothing_else(run, tmp_path, name, monkeypatch):
    import resource

    monkeypatch.setattr("lumped.exchange.platforms.own_compiler", lambda: None)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # half of it would be written too
    path = tmp_path / name
    path.write_bytes(b"before")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, limits[1]))
    try:
        with pytest.raises(OSError, match=name) as error:
            WRITERS[name](run, path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    print(error.value)
    assert path.read_bytes() == b"before"
    assert [file.name for file in tmp_path.iterdir()] == [name]
    path.chmod(0o640)
    WRITERS[name](run, path)
    assert path.stat().st_size > 100
    assert path.stat().st_mode & 0o777 == 0o640
    assert [file.name for file in tmp_path.iterdir()] == [name]


def test_a_folder_that_does_not_exist_is_named(run, tmp_path):
    refused(FileNotFoundError, lambda: run.save(tmp_path / "no" / "run.csv"), "no/run.csv")


def test_a_link_goes_on_to_point_to_its_file(run, tmp_path):
    (tmp_path / "far").mkdir()
    target, link = tmp_path / "far" / "run.csv", tmp_path / "run.csv"
    target.touch()
    link.symlink_to(target)
    run.save(link)
    assert link.is_symlink()
    assert lp.load(target)["shaft.tau"].tolist() == run["shaft.tau"].tolist()


@pytest.mark.parametrize("package", ["pandas", "xarray"])
def test_a_missing_extra_is_named(run, tmp_path, monkeypatch, package):
    found = lp.load(run.save(tmp_path / "run.npz"))
    monkeypatch.setitem(sys.modules, package, None)
    for one in (run, found):
        with pytest.raises(OptionError, match=rf"needs {package}: pip install lumped\[data\]"):
            getattr(one, f"to_{package}")()


def test_files_that_cannot_be_are_refused(run, tmp_path):
    with pytest.raises(OptionError, match=r"run\.xls: the ending must be one of \.nc"):
        run.save(tmp_path / "run.xls")
    (tmp_path / "other.csv").write_text("a;b\n1;2\n")
    refused(OptionError, lambda: lp.load(tmp_path / "other.csv"), "no result that lumped wrote")
    with pytest.raises(UnknownNameError, match=r"'shaft\.ta' was not saved.*shaft\.tau"):
        lp.load(run.save(tmp_path / "run.npz"))["shaft.ta"]


@pytest.mark.parametrize("ending", ["toml", "json"])
def test_parameters_go_out_and_in(run, tmp_path, ending):
    system = run.system
    path = lp.exchange.write_parameters(
        system, tmp_path / f"p.{ending}", parameters={"shaft.c": 1 / 3}
    )
    found = lp.exchange.read_parameters(system, path)
    assert found == system.parameters | {"shaft.c": 1 / 3}
    again = lp.simulate(system, until=1.0, grid=40, parameters=found)
    direct = lp.simulate(system, until=1.0, grid=40, parameters={"shaft.c": 1 / 3})
    assert np.array_equal(again["shaft.tau"], direct["shaft.tau"])


@pytest.mark.parametrize("ending", ["nc", "npz", "csv", "mat"])
def test_a_file_of_no_quantity_is_refused(run, tmp_path, ending):
    path = tmp_path / f"run.{ending}"
    for action in (lambda: run.save(path, []), lambda: run.to_pandas([])):
        with pytest.raises(OptionError, match="name at least one quantity"):
            action()
    assert not path.exists()


def test_edited_files_are_converted_and_checked(run, tmp_path):
    system, path = run.system, tmp_path / "p.toml"
    path.write_text('"body[0].J" = "2 t.cm2"\n[shaft]\nc = "1 kN.m/rad"\nd = 2\n')
    found = lp.exchange.read_parameters(system, path)
    assert found == pytest.approx({"body[0].J": 0.2, "shaft.c": 1000.0, "shaft.d": 2.0})
    for text, error, match in (
        ('"shaft.c" = "3 kg"', UnitError, r"shaft\.c = '3 kg'"),
        ('"shaft.e" = 1', UnknownNameError, r"shaft\.e"),
        ('"shaft.c" = [1]', ParameterError, r"p\.toml: shaft\.c = \[1\]"),
        ('"body[0].J" = -1', ParameterError, r"body\[0\]\.J = -1 kg\.m2"),
        ("shaft = ", OptionError, r"p\.toml is no TOML"),
    ):
        path.write_text(text)
        with pytest.raises(error, match=match):
            lp.exchange.read_parameters(system, path)
    with pytest.raises(OptionError, match=r"\.toml or \.json"):
        lp.exchange.write_parameters(system, tmp_path / "p.yaml")
    for held, match in (
        (b'{"shaft.c": 1', r"p\.json is no JSON"),
        (b"\xff\xfe\x00", r"p\.json is no JSON"),
        (b"[1, 2]", r"p\.json: names with values are needed, not \[1, 2\]"),
        (b"[" * 100_000, r"p\.json is no JSON"),
    ):
        (tmp_path / "p.json").write_bytes(held)
        with pytest.raises(OptionError, match=match):
            lp.exchange.read_parameters(system, tmp_path / "p.json")
    for name, text in (
        ("p.toml", '"shaft.c" = 1.0\n[shaft]\nc = 2.0\n'),
        ("p.json", '{"shaft.c": 1.0, "shaft": {"c": 2.0}}'),
        ("p.json", '{"shaft": {"c": 1.0, "c": 2.0}}'),
    ):
        (tmp_path / name).write_text(text)
        with pytest.raises(OptionError, match=r"shaft\.c is given twice, 1\.0 and 2\.0"):
            lp.exchange.read_parameters(system, tmp_path / name)
    (tmp_path / "p.json").write_text(json.dumps({"shaft": {"c": 7}}))
    assert lp.exchange.read_parameters(system, tmp_path / "p.json") == {"shaft.c": 7.0}
