"""Exported models without events, their description, their C sources and what is refused."""

import shutil
import subprocess
import xml.etree.ElementTree as Xml
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmus import fmpy, runs
from opened import Opened
from rows import assemble_row, in_a_row
from scipy.linalg import expm

import lumped as lp
from lumped.components import (
    BearingFriction,
    DCMotor,
    Fixed,
    Ground,
    IdealGear,
    Inertia,
    LinearTorque,
    Position,
    Spring,
    SpringDamper,
    Torque,
    VoltageSource,
)
from lumped.errors import ExportError, OptionError, UnknownNameError
from lumped.exchange.c_compiler import zig_compiler
from lumped.exchange.interface import rate_unit
from lumped.ops import where


class Drive(lp.Component):
    """Three masses and a gear: motor, pinion, load."""

    w_0: lp.Param = lp.param("rad/s", "speed of the load at the start", 2.0)
    ratio: lp.Param = lp.param("1", "gear ratio", 3.0, nonzero=True)
    motor: Torque = Torque(tau=40.0)
    rotor: Inertia = Inertia(J=0.5, w=3.0 * w_0)
    shaft: SpringDamper = SpringDamper(c=4000.0, d=2.0)
    pinion: Inertia = Inertia(J=0.3)
    gear: IdealGear = IdealGear(ratio=ratio)
    wheel: SpringDamper = SpringDamper(c=9000.0, d=5.0)
    load: Inertia = Inertia(J=2.0, w=w_0)

    def connections(self):
        parts = (self.rotor, self.shaft, self.pinion, self.gear, self.wheel, self.load)
        yield from lp.chain(self.motor.flange, *parts)


def exact(t, w_0, J=2.0, tau=40.0, ratio=3.0):
    """Speeds of rotor and load by the matrix exponential, angles from zero."""
    M = np.diag([0.5, 0.3, J])
    one, two = np.array([1.0, -1.0, 0.0]), np.array([0.0, 1.0 / ratio, -1.0])
    C = 4000.0 * np.outer(one, one) + 9000.0 * np.outer(two, two)
    D = 2.0 * np.outer(one, one) + 5.0 * np.outer(two, two)
    A = np.zeros((7, 7))
    A[:3, 3:6] = np.eye(3)
    A[3:6, :3], A[3:6, 3:6] = -np.linalg.solve(M, C), -np.linalg.solve(M, D)
    A[3, 6] = tau / 0.5
    start = np.array([0, 0, 0, 3.0 * w_0, 0.0, w_0, 1.0])
    return np.array([(expm(A * s) @ start)[[3, 5]] for s in t]).T


def test_a_geared_drive_moves_as_the_matrix_exponential_says(tmp_path):
    """Start values follow from parameters that are set before the run."""
    system = lp.assemble(Drive())
    for changed in ({}, {"w_0": 5.0, "load.J": 3.0, "motor.tau": -10.0}):
        options = {"inputs": ["motor.tau"], "outputs": ["wheel.tau"], "start_values": changed}
        terms = [changed.get(k, v) for k, v in (("w_0", 2.0), ("load.J", 2.0), ("motor.tau", 40.0))]
        for version, kind, found in runs(system, tmp_path, until=1.0, **options):
            rotor, load = exact(found["time"], *terms)
            error = max(
                np.abs(found["rotor.w"] - rotor).max() / np.abs(rotor).max(),
                np.abs(found["load.w"] - load).max() / np.abs(load).max(),
            )
            print(f"{version} {kind}: {error:.1e}")
            assert error < 1e-6


class Electric(lp.Component):
    """Direct-current motor behind a voltage, with friction, spring and load."""

    ground: Ground = Ground()
    source: VoltageSource = VoltageSource(v=24.0)
    motor: DCMotor = DCMotor(J=0.02, k=0.5, R=0.8, L=0.01)
    friction: BearingFriction = BearingFriction(characteristic=((0, 0.5), (50, 0.9)))
    shaft: SpringDamper = SpringDamper(c=800.0, d=0.5)
    load: Inertia = Inertia(J=0.1)
    brake: LinearTorque = LinearTorque(tau_nominal=-3.0, w_nominal=30.0)

    def connections(self):
        yield lp.connect(self.source.p, self.motor.p)
        yield lp.connect(self.source.n, self.motor.n, self.ground.pin)
        parts = (self.friction, self.shaft, self.load, self.brake)
        yield from lp.chain(self.motor.flange, *parts)


def test_a_motor_follows_a_table_of_its_voltage(tmp_path):
    """The voltage jumps from outside at instants at which it jumps in the model itself."""
    late = where(lp.time >= 0.7, -12.0, 24.0)
    own = Electric().with_({"source.v": where(lp.time >= 0.3, late, 0.0)})
    run = lp.simulate(lp.assemble(own), until=1.0, grid=100, rtol=1e-11)
    rows = [(0, 0.0), (0.3, 0.0), (0.3, 24.0), (0.7, 24.0), (0.7, -12.0), (1.0, -12.0)]
    table = np.array(rows, dtype=[("time", float), ("source.v", float)])
    system = lp.assemble(Electric())
    options = {"until": 1.0, "inputs": ["source.v"], "outputs": ["motor.i"], "input": table}
    changes = [e.time for e in run.events]
    for version, kind, found in runs(system, tmp_path, **options):
        smooth = [min(abs(t - c) for c in changes) > 1e-6 for t in found["time"]]
        for name in ("motor.i", "load.w"):
            expected = run[name][np.searchsorted(run.t, found["time"] - 1e-9)]
            error = np.abs(found[name] - expected)[smooth].max() / np.abs(expected).max()
            print(f"{version} {kind} {name}: {error:.1e}")
            assert error < 1e-6


def test_states_that_follow_from_nothing_else_can_be_set(tmp_path):
    model = in_a_row(a=Inertia(J=2.0, w=1.0), shaft=Spring(c=300.0), b=Inertia(J=1.0))
    changed = {"shaft.phi_rel": 0.1, "b.w": -2.0}
    system = lp.assemble(model)
    run = lp.simulate(system, until=0.5, start=changed, grid=100, rtol=1e-11)
    for _, _, found in runs(system, tmp_path, until=0.5, start_values=changed, versions=("3.0",)):
        assert np.abs(found["b.w"] - run["b.w"]).max() < 1e-6


def test_a_drive_without_states_gives_its_functions_of_time(tmp_path):
    system = assemble_row(turn=Position(phi=lp.time**2), body=Inertia(J=2.0))
    assert not system.state_names
    for _, _, found in runs(
        system, tmp_path, until=1.0, versions=("3.0",), outputs=["body.w", "turn.flange.tau"]
    ):
        assert np.abs(found["body.w"] - 2 * found["time"]).max() < 1e-12
        assert np.abs(np.abs(found["turn.flange.tau"]) - 4.0).max() < 1e-12


# -- description -------------------------------------------------------------------------------


def described(path):
    with zipfile.ZipFile(path) as archive:
        return Xml.fromstring(archive.read("modelDescription.xml"))


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    path = tmp_path_factory.mktemp("fmu") / "drive.fmu"
    result = lp.export_fmu(
        lp.assemble(Drive()), path, inputs=["motor.tau"], outputs=["wheel.tau", "load.w"]
    )
    assert len(result.platforms) == 1
    return result


def test_the_description_names_units_roles_and_dependencies(exported):
    root = described(exported.path)
    known = {v.get("name"): v for v in root.find("ModelVariables")}
    by_reference = {v.get("valueReference"): name for name, v in known.items()}
    assert known["motor.tau"].get("causality") == "input"
    assert known["load.J"].get("variability") == "tunable"
    assert known["ratio"].get("variability") == "fixed"  # positions would jump with it
    assert known["shaft.c"].get("unit") == "N.m/rad"
    assert known["load.w"].get("causality") == "output"
    assert known["load.w"].get("displayUnit") == "rpm"
    assert known["rotor.w"].get("initial") == "calculated"  # follows from w_0
    assert known["shaft.phi_rel"].get("initial") == "exact"
    assert by_reference[known["der(load.w)"].get("derivative")] == "load.w"
    needs = {
        by_reference[e.get("valueReference")]: {
            by_reference[r] for r in (e.get("dependencies") or "").split()
        }
        for e in root.find("ModelStructure")
        if e.tag in ("Output", "ContinuousStateDerivative")
    }
    ends = {"shaft.phi_rel", "rotor.w", "pinion.w"}
    assert needs["der(rotor.w)"] == {"motor.tau", *ends}
    assert needs["der(load.w)"] == {"wheel.phi_rel", "pinion.w", "load.w"}
    assert needs["load.w"] == {"load.w"}
    units = {u.get("name"): u.find("BaseUnit").attrib for u in root.find("UnitDefinitions")}
    assert units["N.m/rad"] == {"kg": "1", "m": "2", "s": "-2", "rad": "-1"}


@pytest.mark.parametrize(
    ("unit", "rate"),
    [("rad", "rad/s"), ("rad/s", "rad/s2"), ("m/s2", "m/s3"), ("1", "1/s"), ("W/K", "W/(K.s)")],
)
def test_units_of_derivatives(unit, rate):
    assert rate_unit(unit) == rate


# -- sources -----------------------------------------------------------------------------------


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_sources_compile_without_warnings_and_agree_with_the_official_headers(tmp_path, version):
    compiler = shutil.which("cc")
    assert compiler, "a C compiler is needed"
    path = tmp_path / "drive.fmu"
    lp.export_fmu(lp.assemble(Electric()), path, version=version)
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path)
    folder, official = tmp_path / "sources", Path(fmpy.__file__).parent / "c-code"
    own = {file.name for file in folder.glob("*.c")}
    own = sorted(own - {"loop.c"} if version == "2.0" else own)  # the loop is the same in both
    strict = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-O2"]
    major = version[0]
    header = ["-I", str(official), "-include", f"fmi{major}Functions.h"]
    interface = [name for name in own if name.startswith("fmi")]
    for call in (
        [compiler, *strict, "-shared", "-fPIC", "-o", "x.so", *own, "-lm"],
        [compiler, "-std=c99", "-Wall", "-Werror", *header, "-fsyntax-only", *interface],
    ):
        done = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr


def test_without_a_compiler_the_unit_holds_sources_and_says_so(tmp_path, monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    result = lp.export_fmu(lp.assemble(Drive()), tmp_path / "drive.fmu")
    assert "No C compiler was found" in repr(result)
    with zipfile.ZipFile(result.path) as archive:
        names = archive.namelist()
    assert "sources/buildDescription.xml" in names
    assert not [name for name in names if name.startswith("binaries")]


def test_a_compiler_that_fails_is_an_error(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "false")
    with pytest.raises(ExportError, match="false refuses the sources"):
        lp.export_fmu(lp.assemble(Drive()), tmp_path / "drive.fmu")


def test_a_unit_for_several_platforms_runs_on_this_one(tmp_path):
    pytest.importorskip("ziglang")
    path = tmp_path / "spring.fmu"
    model = in_a_row(mass=Inertia(J=2.0, w=3.0), spring=Spring(c=8.0), wall=Fixed())
    begins = {"x86_64-linux": b"\x7fELF", "aarch64-darwin": b"\xcf\xfa\xed\xfe"}
    asked = tuple(begins)
    options = {"version": "3.0", "kind": "co_simulation", "platforms": asked}
    assert lp.export_fmu(lp.assemble(model), path, **options).platforms == asked
    assert set(fmpy.supported_platforms(str(path))) >= {"linux64", "darwin64", "c-code"}
    with zipfile.ZipFile(path) as archive:
        for name in archive.namelist():
            if name.startswith("binaries/"):
                content = archive.read(name)
                assert content.startswith(begins[name.split("/")[1]])
                assert b"fmi3GetDirectionalDerivative" in content
    if fmpy.platform_tuple not in asked:
        return
    found = fmpy.simulate_fmu(str(path), stop_time=1.0, output_interval=0.1, output=["mass.w"])
    assert np.abs(found["mass.w"] - 3.0 * np.cos(2.0 * found["time"])).max() < 1e-5


def test_sources_compile_for_windows(tmp_path):
    """Not linked: before its first library for Windows, Zig builds a C library for a minute."""
    pytest.importorskip("ziglang")
    path = tmp_path / "drive.fmu"
    lp.export_fmu(lp.assemble(Drive()), path, version="3.0")
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path)
    compiler = zig_compiler("x86_64-windows-gnu", "the test")
    options = ["-std=c99", "-fvisibility=hidden", "-Wall", "-Werror", "-O1", "-c"]
    for source in ("access.c", "fmi3.c", "model.c"):
        call = [*compiler, *options, source, "-o", "made.obj"]
        folder = tmp_path / "sources"
        done = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        exports = b"-export:fmi3GetDirectionalDerivative" in (folder / "made.obj").read_bytes()
        assert exports is (source == "fmi3.c")


# -- what is refused ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "error", "text"),
    [
        ({"version": "1.0"}, OptionError, "choose '3.0' or '2.0'"),
        ({"kind": "exchange"}, OptionError, "choose from model_exchange"),
        ({"rtol": 0.0}, OptionError, "rtol = 0.0"),
        ({"platforms": ["sparc"]}, OptionError, "no platform 'sparc'; choose from x86_64-linux"),
        ({"platforms": ["aarch64-linux"], "version": "2.0"}, OptionError, "linux64, win64"),
        ({"inputs": ["motor.torque"]}, UnknownNameError, "motor.torque"),
        ({"inputs": ["load.w"]}, UnknownNameError, "cannot be an input"),
        ({"inputs": ["ratio"]}, OptionError, "would need its rate of change"),
        ({"outputs": ["load.speed"]}, UnknownNameError, "load.speed"),
        ({"outputs": ["load.w", "load.w"]}, OptionError, "once"),
    ],
)
def test_bad_options_are_refused(tmp_path, options, error, text):
    with pytest.raises(error, match=text):
        lp.export_fmu(lp.assemble(Drive()), tmp_path / "drive.fmu", **options)


def test_values_out_of_range_are_refused_by_name(tmp_path):
    """What is out of range can be set anew; any other bad call ends the run."""
    path = tmp_path / "drive.fmu"
    lp.export_fmu(lp.assemble(Drive()), path, version="2.0", kind="co_simulation")
    ranges = (
        ("load.J", -1.0, r"Drive: load.J = -1 is out of range: it must be greater than 0"),
        ("shaft.c", np.nan, "must be a finite number"),
    )
    wrong = (
        ("rotor.w", 3.0, False, "cannot be set now"),
        ("der(load.w)", 3.0, False, "cannot be set now"),
        ("ratio", 2.0, True, "can be set before the run only"),
    )
    for name, value, runs_on, text in wrong:
        unit = Opened(path, "CoSimulation")
        unit.fmu.setupExperiment()
        unit.fmu.enterInitializationMode()
        for other, bad, why in ranges:
            with pytest.raises(fmpy.fmi1.FMICallException):
                unit.set({other: bad})
            assert why in unit.told[-1]
        if runs_on:
            unit.fmu.exitInitializationMode()
        with pytest.raises(fmpy.fmi1.FMICallException):
            unit.set({name: value})
        assert text in unit.told[-1]
        unit.close()
