"""Numbers of the sources, and what a report says of a machine."""

import copy
import pickle
import re
from importlib import import_module

import pytest

from lumped.errors import UnknownNameError
from lumped.models import MACHINES, MARKS, machine
from lumped.models.sources import Given, constants
from lumped.support.units import dimension


def test_a_number_counts_as_a_float_and_keeps_its_words():
    number = Given(2.5, "kg", "P", "crank pin")
    assert number == 2.5
    assert type(2 * number) is float
    for twin in (copy.deepcopy(number), pickle.loads(pickle.dumps(number))):
        assert (twin, twin.unit, twin.mark, twin.text) == (2.5, "kg", "P", "crank pin")
    with pytest.raises(KeyError):
        Given(1.0, "1", "Q", "unknown mark")


@pytest.mark.parametrize("name", MACHINES)
def test_every_number_has_a_unit_a_mark_and_words(name):
    found = constants(name)
    assert len(found) > 15
    for number in found:
        assert number.mark in MARKS
        assert number.unit == "1" or dimension(number.unit) is not None
        assert len(number.text.split()) > 1 or number.text.islower(), number.text
        assert not re.search(r"\b[A-Z]+_[A-Z_]+\b", number.text), number.text
    marks = [list(MARKS).index(number.mark) for number in found]
    assert marks == sorted(marks)


def test_numbers_in_tuples_and_tables_are_told():
    texts = {n.text: float(n) for n in constants("carrousel_coiler")}
    assert texts["fixed point of the strip, height above the turret's axis"] == 1.8
    texts = {n.text: float(n) for n in constants("pilger_mill")}
    assert texts["crank pin, set F"] == 5244.44
    assert texts["counterweight after the optimisation, m2"] == 7228.0


@pytest.mark.parametrize("name", MACHINES)
def test_every_machine_tells_its_source_findings_and_assumptions(name):
    about = machine(name).ABOUT
    for texts in (about.source, about.findings, about.assumptions):
        assert texts
        assert all(text.endswith(".") for text in texts)
    assert any("copy" in text or "lost" in text for text in about.source)
    for caption in about.captions.values():
        assert len(caption.split()) >= 4


@pytest.mark.parametrize("name", MACHINES)
def test_each_caption_has_a_figure_and_each_figure_a_caption(name):
    drawn = vars(import_module(f"lumped.models.{name}.figures"))
    names = {key.removeprefix("draw_") for key in drawn if key.startswith("draw_")}
    assert names == set(machine(name).ABOUT.captions)


@pytest.mark.parametrize("name", MACHINES)
def test_measures_are_the_same_quantities_for_a_changed_machine(name):
    changes = {
        "carrousel_coiler": {"drive.rotor.J": 900.0},
        "diesel_genset": {"coupling.psi": 0.8},
        "eccentric_shear": {"motor.J": 30e3},
        "marine_turbine": {"propeller.J": 3e5},
        "pilger_mill": {"mill.m2": 8000.0},
        "reversing_mill": {"upper.motor.J": 20.0},
        "rotary_arm": {"arm.m_x": 25_000.0},
        "turbine_generator": {"turbine.lpb_gen.c": 2e8},
    }[name]
    own, changed = machine(name).measures(), machine(name).measures(changes)
    assert [m[:2] for m in own] == [m[:2] for m in changed]
    values = {m.quantity: (m.value, n.value) for m, n in zip(own, changed, strict=True)}
    assert any(a != b for a, b in values.values())


@pytest.mark.parametrize("name", MACHINES)
def test_a_change_of_what_a_machine_does_not_have_is_refused(name):
    with pytest.raises(UnknownNameError, match=r"has no parameter 'no\.such'"):
        machine(name).measures({"no.such": 3.0})
