"""Rules that every component of the library obeys, found by walking the package."""

import inspect

import numpy as np
import pytest
from library_rigs import FIELDS, LIBRARY, declared, every, rig, values

import lumped as lp
import lumped.components
from lumped.components import translation
from lumped.errors import DeclarationError, UnknownNameError
from lumped.language.declared import has_parts, text_of
from lumped.language.quantity import Quantity
from lumped.language.switch import Hold, When

UNITS = {
    *("1", "s", "Hz", "W"),
    *("rad", "rad/s", "rad/s2", "N.m", "kg.m2", "N.m/rad", "N.m.s/rad"),
    *("m", "m/s", "m/s2", "N", "kg", "N/m", "N.s/m"),
    *("V", "A", "Ohm", "H", "F", "N.m/A", "N.m/A2", "V.s", "A.s"),
    *("1/s", "1/s2", "rad/(s.N.m)"),
    *("K", "J/K", "W/K", "1/K"),
    *("m2", "kg/m3", "Pa"),
    *("m3", "1/m3", "m2/s", "kg/m", "N.s"),
}


@pytest.mark.parametrize(
    "module",
    [
        "inertia",
        "compliance",
        "gearing.gears",
        "sources",
        "control.sensors",
        "electric.circuit",
        "electric.motors",
    ],
)
def test_the_walk_finds_the_modules(module: str) -> None:
    received = {cls.__module__ for cls in LIBRARY}
    expected = f"lumped.components.{module}"
    assert expected in received


@every(LIBRARY)
def test_a_user_finds_it_where_the_library_says(cls: type[lp.Component]) -> None:
    slides = cls.__module__.startswith(translation.__name__)
    place = translation if slides else lumped.components
    received = getattr(place, cls.__name__)
    expected = cls
    assert received is expected
    assert cls.__name__ in place.__all__


@pytest.mark.parametrize("place", [lumped.components, translation], ids=["library", "translation"])
def test_public_names_are_sorted_and_unique(place: object) -> None:
    received = list(place.__all__)
    expected = sorted(set(received))
    assert received == expected


def brought(item: object) -> int:
    """Number of equations of one item: a hold determines its reaction, and its mode if named."""
    if isinstance(item, Hold):
        return 1 if item.position is None else 2
    if isinstance(item, When):
        return 0
    return len(item) if isinstance(item, tuple) else 1


@every([cls for cls in LIBRARY if not has_parts(cls)])
def test_it_brings_one_equation_per_variable_output_and_port(cls: type[lp.Component]) -> None:
    received = sum(map(brought, cls(**FIELDS.get(cls, {})).equations()))
    expected = sum(len(declared(cls, kind)) for kind in (lp.Var, lp.Output, lp.Port))
    assert received == expected


@every(LIBRARY)
def test_it_assembles_with_a_body_at_each_port(cls: type[lp.Component]) -> None:
    system = lp.assemble(rig(cls, np.random.default_rng(1)))
    received = np.isfinite(lp.start_point(system).x).all()
    expected = True
    assert received == expected


@every(LIBRARY)
def test_each_quantity_has_a_text_and_a_unit_of_the_si(cls: type[lp.Component]) -> None:
    quantities = list(declared(cls, Quantity).values())
    for port in declared(cls, lp.Port).values():
        quantities += [port.potential, port.flow]
    received = {quantity.unit for quantity in quantities}
    expected = UNITS
    assert received <= expected
    assert all(quantity.text.strip() for quantity in quantities)


@every(LIBRARY)
def test_its_equations_join_quantities_of_the_same_kind(cls: type[lp.Component]) -> None:
    checked = lp.check_units(cls(**FIELDS.get(cls, {}), **values(cls, np.random.default_rng(1))))
    assert checked or has_parts(cls)


@every(LIBRARY)
def test_its_docstring_states_its_law(cls: type[lp.Component]) -> None:
    received = text_of(cls)
    expected = "="
    assert expected in received


@every(LIBRARY)
def test_type_checkers_see_each_quantity_that_it_can_be_given(cls: type[lp.Component]) -> None:
    given = [declared(cls, kind) for kind in (lp.Param, lp.Var, lp.Input)]
    received = {name for base in cls.__mro__ for name in vars(base).get("__annotations__", {})}
    expected = {name for quantities in given for name in quantities}
    assert expected <= received


@every(LIBRARY)
def test_its_signature_has_the_names_that_its_constructor_knows(cls: type[lp.Component]) -> None:
    received = set(inspect.signature(cls).parameters)
    expected = set()
    for name in {*dir(cls), *received}:
        try:
            cls(**{name: 1.0})
        except UnknownNameError:
            continue
        except DeclarationError as error:
            if "is an output" in str(error):
                continue
        expected.add(name)
    assert received == expected
