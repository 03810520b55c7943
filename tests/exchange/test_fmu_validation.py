"""Descriptions of exported models are valid: the five machines, and names of any text."""

import zipfile

import pytest
from fmus import fmpy, validate_fmu
from machine_scenes import SCENES, asked
from rows import in_a_row

import lumped as lp
from lumped.components import Backlash, Fixed, Inertia, Spring, Torque
from lumped.errors import OptionError


@pytest.fixture(autouse=True)
def _sources_only(tmp_path, monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))


@pytest.mark.parametrize("name", SCENES)
def test_units_of_the_five_machines_are_valid(tmp_path, name):
    system, options = asked(name)
    start = options.get("start") or {}
    given = system.parameters
    outputs = [n for n in system.names() if n.endswith(".tau") and n not in given][:5]
    path = tmp_path / "machine.fmu"
    for version in ("2.0", "3.0"):
        lp.export_fmu(system, path, version=version, start=start, outputs=outputs)
        assert validate_fmu(str(path)) == []
        facts = fmpy.read_model_description(str(path))
        assert facts.variableNamingConvention == "structured"
        assert len(facts.outputs) == len(outputs) > 0
        assert len(facts.derivatives) == len(system.state_names)
        for unknown in (*facts.outputs, *facts.derivatives, *facts.initialUnknowns):
            assert unknown.dependencies is not None
        if version == "3.0":
            assert all(u.dependencies for u in facts.eventIndicators)


def pair(name="a"):
    return in_a_row(**{name: Inertia(J=1.0), "s": Spring(c=3.0), "b": Inertia(J=2.0)})


def names_of(path):
    return [v.name for v in fmpy.read_model_description(str(path)).modelVariables]


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_names_of_any_text_are_valid(tmp_path, version):
    path, model = tmp_path / "pair.fmu", pair()
    formula = (model.a.w - model.b.w) * 2
    lp.export_fmu(lp.assemble(model), path, version=version, outputs=[formula])
    assert validate_fmu(str(path)) == []
    assert "'(a.w - b.w) * 2'" in names_of(path)
    lp.export_fmu(lp.assemble(pair("größe")), path, version=version)
    assert validate_fmu(str(path)) == []
    assert "größe.w" in names_of(path)


def test_states_that_may_jump_are_told(tmp_path):
    path = tmp_path / "unit.fmu"
    stopped = in_a_row(
        body=Inertia(J=1.0, w=1.0), play=Backlash(b=0.03, restitution=0.3), wall=Fixed()
    )
    for version in ("2.0", "3.0"):
        for model, jumps in ((stopped, True), (pair(), False)):
            system = lp.assemble(model)
            lp.export_fmu(system, path, version=version)
            assert validate_fmu(str(path)) == []
            with zipfile.ZipFile(path) as archive:
                told = archive.read("modelDescription.xml").decode().count('reinit="true"')
            assert told == jumps * len(system.state_names)
            assert system.state_names


def test_an_input_given_as_a_number_is_no_output_too(tmp_path):
    driven = in_a_row(drive=Torque(tau=2.0), body=Inertia(J=1.0))
    system, options = lp.assemble(driven), {"outputs": ["drive.tau"]}
    with pytest.raises(OptionError, match=r"'drive\.tau' cannot be an output: it is a param"):
        lp.export_fmu(system, tmp_path / "driven.fmu", **options)
    with pytest.raises(OptionError, match=r"'drive\.tau' cannot be an output: it is an inp"):
        lp.export_fmu(system, tmp_path / "driven.fmu", inputs=["drive.tau"], **options)
