"""Models put together in a wrong way: refused, or warned of where they can be computed."""

import math
import warnings
from xml.etree import ElementTree

import numpy as np
import pytest
from checks import refused
from rows import in_a_row

import lumped as lp
from lumped.components import (
    BearingFriction,
    Belt,
    Clutch,
    Fixed,
    Inertia,
    NonlinearSpring,
    Planetary,
    Spring,
    SpringDamper,
    Torque,
    TorqueSensor,
)
from lumped.errors import (
    ConnectError,
    DeclarationError,
    EquationError,
    ModelWarning,
    OptionError,
    ParameterError,
    SingularModelError,
    UnknownNameError,
)
from lumped.exchange.c_tables import _quote


def built(connections, **parts):
    return lambda: lp.assemble(lp.compose(connections=connections, **parts))


# -- parts that do nothing -----------------------------------------------------------------------


def two(**parts):
    return {"a": Inertia(J=1.0), "b": Inertia(J=2.0), **parts}


def test_a_part_connected_to_nothing_is_warned_of():
    make = built(lambda m: lp.chain(m.a, m.b), **two(flywheel=Inertia(J=3.0)))
    with pytest.warns(ModelWarning, match=r"^Model: flywheel \(Inertia\) is connected to nothing"):
        make()


@pytest.mark.parametrize(
    ("connections", "part", "named"),
    [
        (lambda m: [lp.connect(m.a.flange_b, m.s.flange_a, m.s.flange_b)], Spring(c=1.0), "flange"),
        (lambda m: lp.chain(m.a, m.s, m.a), Spring(c=1.0), "flange_a and flange_b"),
        (lambda m: lp.chain(m.a, m.b, m.s, m.a), Spring(c=1.0), "flange_a and flange_b"),
        (lambda m: lp.chain(m.a, m.s, m.a), Clutch(f_max=1.0, u=1.0), "flange_a and flange_b"),
        (
            lambda m: [lp.connect(m.a.flange_b, m.s.flange, m.s.support)],
            Torque(tau=1.0),
            "flange and support",
        ),
    ],
)
def test_a_part_with_both_ends_in_one_place_is_warned_of(connections, part, named):
    with pytest.warns(ModelWarning) as caught:
        built(connections, a=Inertia(J=1.0), b=Inertia(J=2.0), s=part)()
    (text,) = [str(w.message) for w in caught if "does nothing" in str(w.message)]
    assert text.startswith(f"Model: s ({type(part).__name__}) does nothing: its {named}")
    assert caught[0].filename == __file__


def test_sound_models_are_not_warned_of():
    def parallel(m):
        return [*lp.chain(m.a, m.s, m.b), *lp.chain(m.a, m.t, m.b)]

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        lp.assemble(lp.compose(a=Inertia(J=1.0)))  # alone, but all there is
        lp.assemble(lp.compose(a=Inertia(J=1.0), b=Inertia(J=2.0)))  # nothing is connected
        built(parallel, **two(s=Spring(c=1.0), t=Spring(c=2.0)))()
        built(lambda m: lp.chain(m.a, m.s, m.b), **two(s=TorqueSensor()))()
        friction = BearingFriction(characteristic=((0.0, 1.0),))
        built(lambda m: lp.chain(m.a, m.s, m.b), **two(s=friction))()
        locked = Planetary(ratio=3.0)
        built(
            lambda m: [
                lp.connect(m.a.flange_a, m.p.sun, m.p.carrier),
                lp.connect(m.b.flange_a, m.p.ring),
            ],
            **two(p=locked),
        )()


def test_a_model_that_is_refused_is_not_warned_of_too():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        refused(
            SingularModelError,
            built(
                lambda m: lp.chain(m.wall, m.a, m.b, m.end),
                **two(wall=Fixed(), end=Fixed(), alone=Inertia(J=1.0)),
            ),
        )


# -- constructors --------------------------------------------------------------------------------


@pytest.mark.parametrize("tau", [lambda t: t, [0, 1], (0.0, 1.0), np.array([0.0, 1.0]), None])
def test_an_input_says_what_it_may_be(tau):
    text = refused(DeclarationError, lambda: Torque(tau=tau))
    assert text.startswith("Torque(tau=...): ")
    for word in ("N.m (driving torque)", "lumped.time", "lumped.ops.table", "connection"):
        assert word in text


@pytest.mark.parametrize("J", [None, True, np.True_, 1j, np.complex128(1), [1.0], 10**400, Inertia])
def test_what_is_no_number_is_no_parameter(J):
    refused(DeclarationError, lambda: Inertia(J=J), "number in kg.m2 (moment of inertia)")


@pytest.mark.parametrize("J", [np.float32(2), np.int8(2), np.array(2.0), 2, "2 kg.m2"])
def test_all_kinds_of_numbers_are_parameters(J):
    assert Inertia(J=J)._values["J"] == 2.0


def test_values_without_names_are_refused():
    refused(DeclarationError, lambda: Inertia(1.0), "Inertia(J=...)")


def test_a_name_unlike_all_others_gets_the_list_that_begins_with_choices_and_parameters():
    text = refused(UnknownNameError, lambda: BearingFriction(table=((0, 1),)))
    assert "Known: characteristic, peak, " in text


@pytest.mark.parametrize("J", [1e101, -1e101, 1e-101, math.inf, math.nan])
def test_parameters_beyond_all_quantities_are_refused(J):
    refused(ParameterError, built((), a=Inertia(J=J)), "a.J = ")


# -- connections, names, models ------------------------------------------------------------------


@pytest.mark.parametrize(
    "action",
    [
        lambda m: lp.chain("a", "b"),
        lambda m: lp.chain(m.a, None),
        lambda m: lp.chain(Inertia, Inertia),
        lambda m: lp.chain([m.a, m.b]),
        lambda m: m.with_(None),
        lambda m: m.with_("a.J"),
        lambda m: m.with_({1: 2}),
        lambda m: lp.compose(a=Inertia(J=1.0), connections=5),
        lambda m: lp.compose(a=Inertia(J=1.0), initial_equations=5),
        lambda m: lp.compose(a=Inertia(J=1.0), name=5),
        lambda m: lp.compose(m.a),
        lambda m: lp.param("m", "length", "3"),
        lambda m: lp.param("m", "length", min="0"),
        lambda m: lp.param("m"),
        lambda m: lp.var("m", "length", state="sometimes"),
        lambda m: lp.var("m", "length", nominal="1"),
        lambda m: lp.Input("m"),
        lambda m: lp.Flange(3),
        lambda m: lp.Flange(free="yes"),
        lambda m: lp.lossless(3),
        lambda m: lp.lossless(m.a.flange_a.phi == 1, 3),
    ],
)
def test_building_blocks_check_what_they_are_given(action):
    model = in_a_row(a=Inertia(J=1.0), b=Inertia(J=1.0))
    refused(OptionError, lambda: list(action(model) or ()))


def test_one_end_named_twice_is_refused():
    make = built(lambda m: [lp.connect(m.a.flange_a, m.a.flange_a)], a=Inertia(J=1.0))
    refused(ConnectError, make, "named twice")


@pytest.mark.parametrize("key", ["", "a\nb", "\x01", "a]b", "a[b", 'a"b', "a'b", "a\\b", "\u2028"])
def test_keys_that_cannot_stand_in_a_name_are_refused(key):
    refused(DeclarationError, lambda: lp.compose(d={key: Inertia(J=1.0)}), repr(key))


@pytest.mark.parametrize("name", ["a b", "a.b", "1a", "_a", ""])
def test_members_need_names_that_can_be_written(name):
    refused(DeclarationError, lambda: lp.compose(**{name: Inertia(J=1.0)}))


def test_a_member_that_would_not_be_seen_is_refused():
    with pytest.raises(DeclarationError, match="_hidden: names that begin with an underscore"):
        type("Rig", (lp.Component,), {"_hidden": Inertia(J=1.0)})


@pytest.mark.parametrize("name", ["", "a\0b", "a\nb"])
def test_a_model_needs_a_name_that_can_be_written(name):
    refused(DeclarationError, lambda: lp.compose(a=Inertia(J=1.0), name=name))


@pytest.mark.parametrize("key", ["ü☃", "a.b", "a<b>&c", "a*/b", "??/", "%s%n", "../../x"])
def test_other_keys_are_found_again_and_stand_in_the_description_of_a_unit(key, tmp_path):
    system = lp.assemble(
        lp.compose(
            d={key: Inertia(J=1.0, w=1.0)},
            s=SpringDamper(c=10.0),
            wall=Fixed(),
            connections=lambda m: lp.chain(m.d[key], m.s, m.wall),
        )
    )
    name = f'd["{key}"].w'
    assert lp.simulate(system, until=0.1)[name][0] == 1.0
    assert system.model.with_({f'd["{key}"].J': 2.0}).d[key]._values["J"] == 2.0
    element = ElementTree.Element("variable", name=name)
    assert ElementTree.fromstring(ElementTree.tostring(element)).get("name") == name


def test_no_trigraph_stands_in_a_text_of_a_unit():
    assert _quote("what??/") == '"what\\?\\?/"'


# -- expressions ---------------------------------------------------------------------------------

T = lp.time


@pytest.mark.parametrize(
    "action",
    [
        lambda: T % 2,
        lambda: 2 % T,
        lambda: T // 2,
        lambda: round(T),
        lambda: divmod(T, 2),
        lambda: (T > 1) & (T < 2),
        lambda: (T > 1) | (T < 2),
        lambda: ~(T > 1),
        lambda: (T > 1) * 3.0,
        lambda: 3.0 * (T > 1),
        lambda: 1 - (T > 1),
        lambda: T + "3",
        lambda: T * 10**400,
        lambda: T * math.nan,
        lambda: lp.ops.sin("1"),
        lambda: lp.when(T > 1, [1]),
        lambda: lp.when(T > 1, None),
    ],
)
def test_what_has_no_meaning_for_symbols_is_refused(action):
    refused(EquationError, action)


@pytest.mark.parametrize("given", [5, "text", T == 1])
def test_equations_returned_instead_of_yielded_are_told(given):
    def equations(self):
        return given

    cls = type("Part", (lp.Component,), {"w": lp.var("rad/s", "speed"), "equations": equations})
    text = refused(EquationError, lambda: lp.assemble(cls()))
    assert "Yield each equation" in text or "must be an equation" in text


def test_places_and_values_of_an_interpolation_stand_behind_its_expression():
    for arguments in (([0, 1], [5, 2], T), ([0, 1], T, [5, 2])):
        text = refused(EquationError, lambda a=arguments: lp.ops.interpolate(*a))
        assert "the expression comes first, then the places and the values" in text


# -- methods that raise ----------------------------------------------------------------------------


def fails(self):
    return {}["c"]


def fails_late(self):
    yield self.x == 1
    yield self.x == lp.ops.atan2(self.x)


@pytest.mark.parametrize(
    ("method", "body", "raised"),
    [
        ("equations", fails, "KeyError: 'c'"),
        ("equations", fails_late, r"TypeError: atan2\(\) missing 1 required"),
        ("initial_equations", fails, "KeyError: 'c'"),
        ("connections", fails, "KeyError: 'c'"),
    ],
)
def test_what_a_method_of_a_component_raises_names_the_component(method, body, raised):
    def equations(self):
        yield self.x == 1

    methods = {"equations": equations, "x": lp.var("1", "known"), method: body}
    model = lp.compose(line=lp.compose(part=type("Own", (lp.Component,), methods)()))
    text = f"^line.part \\(Own\\): {method}\\(\\) raised {raised}"
    with pytest.raises(EquationError, match=text) as caught:
        lp.assemble(model)
    assert "test_wrong_building.py)" in str(caught.value)
    assert isinstance(caught.value.__cause__, KeyError | TypeError)


def test_a_law_that_raises_names_the_part_it_was_given_to():
    make = built(
        lambda m: lp.chain(m.a, m.shaft, m.b),
        **two(shaft=NonlinearSpring(characteristic=lambda phi: 1 / 0)),
    )
    text = refused(EquationError, make)
    assert text.startswith("shaft (NonlinearSpring): equations() raised ZeroDivisionError: ")


def test_losses_and_outlines_that_raise_name_their_part(tmp_path):
    class Rotor(Inertia):
        """An inertia whose methods fail: loss = 1 / 0."""

        def loss(self):
            return 1 / 0

        def outline(self):
            return 1 / 0

    system = lp.assemble(lp.compose(rotor=Rotor(J=1.0, w=1.0)))
    run = lp.simulate(system, until=0.1)
    actions = {
        "loss": lambda: lp.simulate(system, until=0.1, certify=True),
        "outline": lambda: lp.drawing.animate(run, tmp_path / "rotor.gif"),
    }
    for method, action in actions.items():
        assert refused(EquationError, action).startswith(f"rotor (Rotor): {method}() raised Zero")


@pytest.mark.parametrize("given", ["no", 0, None, "True"])
def test_a_choice_of_yes_or_no_is_no_text(given):
    sizes = {"r_a": 0.1, "r_b": 0.2, "distance": 1.0, "EA": 1e5, "F_0": 1e3}
    expected = f"Belt(crossed={given!r}): True or False is needed."
    assert refused(DeclarationError, lambda: Belt(**sizes, crossed=given)) == expected
    assert refused(DeclarationError, lambda: Belt(**sizes).with_({"crossed": given})) == expected


# -- classes ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("connection", "connections"),
        ("conections", "connections"),
        ("Connections", "connections"),
        ("equation", "equations"),
        ("initial_equation", "initial_equations"),
    ],
)
def test_a_method_that_is_almost_called_as_it_should_is_refused(name, meant):
    def method(self):
        yield from ()

    with pytest.raises(DeclarationError, match=rf"^Rig\.{name}: is the method '{meant}' meant"):
        type("Rig", (lp.Component,), {name: method})


def test_other_methods_have_names_of_their_own():
    def method(self):
        return 5

    names = ("initial", "equal", "connected", "motion_equation", "more_connections", "equations_of")
    assert type("Rig", (lp.Component,), dict.fromkeys(names, method))().equal() == 5


def test_a_component_with_a_constructor_that_assigns_is_told_to_declare():
    class Rotor(lp.Component):
        """A rotor whose J is no parameter."""

        def __init__(self, J):
            self.J = J

    text = refused(DeclarationError, lambda: Rotor(3.0))
    assert text.startswith("Rotor.__init__ assigns J. Leave __init__ out and declare J")
