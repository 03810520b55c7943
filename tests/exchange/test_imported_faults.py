"""Units of FMI that fail or cannot be used, and what cannot be done with them."""

import shutil
import zipfile

import numpy as np
import pytest
from c_units import STAIR, UNITS, c_unit
from imported_drives import T_S, drive, unit_of

import lumped as lp
from lumped import errors
from lumped.components import from_fmu


def test_what_needs_equations_is_refused_by_name(exported, tmp_path):
    system = drive(unit_of(exported), held=False)
    final = lp.functionals.final("rotor.w")
    for ask in (
        lambda: lp.gradient(system, of=[final], by=["rotor.J"], until=0.1),
        lambda: lp.sensitivity(system, of=["rotor.w"], by=["rotor.J"], until=0.1),
        lambda: lp.periodic(system, period=T_S),
        lambda: lp.equilibrium(system),
        lambda: lp.export_fmu(system, tmp_path / "x.fmu"),
    ):
        with pytest.raises(errors.OptionError, match=r"pi asks unit 'pi_3.0.fmu'"):
            ask()
    assert "held: pi" in str(lp.linearise(system))


LATE = """
#include <stdbool.h>
static void begin(void) { memset(v, 0, sizeof v); }
static int step(void) {
  if (to < 0.5) return 0;
  switch ((int)v[0]) {
    case 1: abort();
    case 2: *(volatile int*)0 = 1;
    case 3: tell(0, %s3, %s"the valve %s", "is stuck"); return 3;
    case 4: v[9] = 0.0 / 0.0; return 0;
    case 5: return -1;
    case 6: exit(7);
  }
  return 0; }
static bool at_event(double* next) { return false; }
static void output(void) { v[1] = v[9]; }
"""
CHOICE = {
    "3.0": '<Float64 name="fault" valueReference="0" causality="parameter" variability="fixed" '
    'start="0"/><Float64 name="y" valueReference="1" causality="output"/>',
    "2.0": '<ScalarVariable name="fault" valueReference="0" causality="parameter" '
    'variability="fixed"><Real start="0"/></ScalarVariable>'
    '<ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>',
}


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_unit_that_fails_is_named_and_what_was_computed_is_kept(tmp_path, version):
    code = LATE.replace("%s3, %s", '"u", 3, "c", ' if version == "2.0" else '3, "c", ', 1)
    if version == "3.0":
        code = code.replace('"the valve %s", "is stuck"', '"the valve is stuck"')
    path = c_unit(tmp_path, "late", CHOICE[version], code, version=version)
    system = lp.assemble(lp.compose(valve=from_fmu(path, T_s=0.1)))
    faults = {
        1.0: "its binary crashed .SIGABRT",
        2.0: "its binary crashed .SIGSEGV",
        3.0: "It said: the valve is stuck",
        4.0: "its output y is nan",
        6.0: "its binary crashed .exit code 7",
    }
    if version == "3.0":
        faults[5.0] = "it asks to end the simulation"
    for fault, text in faults.items():
        with pytest.raises(errors.SolverError, match=text) as caught:
            lp.simulate(system, until=1.0, parameters={"valve.fault": fault})
        assert "at t = 0.5 s valve asks unit 'late.fmu'" in str(caught.value)
        assert caught.value.partial.t[-1] == 0.5
        assert len(caught.value.partial.t) > 100
    assert lp.simulate(system, until=1.0).t[-1] == 1.0
    swept = lp.sweep(
        system,
        over={"valve.fault": [0.0, 1.0, 0.0, 3.0]},
        until=1.0,
        of={"y": lp.functionals.final("valve.y")},
    )
    assert np.array_equal(np.isnan(swept["y"]), [False, True, False, True])
    assert "SIGABRT" in str(swept)


def without(name):
    return lambda folder: folder / name


def other_platform(folder):
    with zipfile.ZipFile(folder / "pi_2.0.fmu") as held:
        text = held.read("modelDescription.xml")
    path = folder / "windows.fmu"
    with zipfile.ZipFile(path, "w") as made:
        made.writestr("modelDescription.xml", text)
        made.writestr("binaries/win64/PI.dll", b"")
    return path


def text_file(folder):
    path = folder / "text.fmu"
    path.write_text("no unit")
    return path


def with_an_absolute_path(folder):
    path = shutil.copy(folder / "pi_2.0.fmu", folder / "leaving.fmu")
    with zipfile.ZipFile(path, "a") as made:
        made.writestr("/etc/absolute.txt", "x")
    return path


@pytest.mark.parametrize(
    ("path", "options", "text"),
    [
        (with_an_absolute_path, {}, "leaving.fmu cannot be unpacked"),
        (without("none.fmu"), {}, "there is no file"),
        (text_file, {}, "cannot be read as a unit of FMI"),
        (other_platform, {}, "has binaries for win64, not for linux64"),
        (without("pi_3.0.fmu"), {"kind": "both"}, "'both'"),
        (without("pi_3.0.fmu"), {"units": {"wantd": "rad/s"}}, "'wantd'.*wanted"),
        (without("pi_3.0.fmu"), {"outputs": ["mesured"]}, "'mesured'.*measured"),
        (without("pi_3.0.fmu"), {"gain": 3.0}, "PI has no 'gain'"),
        (without("pi_3.0.fmu"), {"k": "3 N.m"}, "must be of the kind N.m.s/rad"),
    ],
)
def test_bad_input_is_told(exported, path, options, text):
    with pytest.raises(errors.LumpedError, match=text):
        from_fmu(path(exported), **options)


def test_a_unit_without_a_step_needs_one_and_one_with_clocks_is_refused(exported, tmp_path):
    with pytest.raises(errors.ParameterError, match="T_s"):
        lp.assemble(lp.compose(pi=from_fmu(exported / "pi_3.0.fmu", wanted=1.0, measured=0.0)))
    variables = (
        '<Clock name="tick" valueReference="9" causality="input" intervalVariability="constant"'
    )
    path = c_unit(tmp_path, "ticking", CHOICE["3.0"] + variables + ' intervalDecimal="1"/>', STAIR)
    with pytest.raises(errors.DeclarationError, match=r"has clocks .tick."):
        from_fmu(path)
    unknown = CHOICE["3.0"].replace('name="y"', 'name="y" unit="furlong"')
    path = c_unit(
        tmp_path,
        "furlong",
        unknown,
        STAIR,
        units=UNITS.replace("rpm", "furlong", 1).replace(
            '<BaseUnit s="-1" rad="1" factor="0.10471975511965977"/>', ""
        ),
    )
    with pytest.raises(errors.DeclarationError, match="'furlong'"):
        from_fmu(path)
    assert from_fmu(path, units={"y": "kN"}) is not None
