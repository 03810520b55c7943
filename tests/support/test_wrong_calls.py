"""Public functions called in a wrong way: each is answered by an error of lumped that says so."""

import inspect

import numpy as np
import pytest
import refusals
from public_names import FUNCTIONS
from rows import in_rows

import lumped as lp
from lumped.components import Inertia, SpringDamper, Torque
from lumped.errors import LumpedError, OptionError, UnitError, UnknownNameError

NAN, INF = float("nan"), float("inf")


def drive():
    return in_rows(
        "t motor shaft load",
        motor=Inertia(J=1.0),
        shaft=SpringDamper(c=100.0, d=1.0),
        load=Inertia(J=2.0),
        t=Torque(tau=3.0),
    )


@pytest.fixture(scope="module")
def model():
    return drive()


@pytest.fixture(scope="module")
def system(model):
    return lp.assemble(model)


@pytest.fixture(scope="module")
def run(system):
    return lp.simulate(system, until=0.1)


def message(action, kind=OptionError):
    return refusals.message(action, kind)


# -- what stands in place of a system ------------------------------------------------------------

WITH_SYSTEM = [
    name
    for name, function in FUNCTIONS.items()
    if "system" in inspect.signature(function).parameters
]


def rest_of(function):
    """Anything for the other arguments that must be given."""
    parameters = list(inspect.signature(function).parameters.values())[1:]
    return {p.name: None for p in parameters if p.default is p.empty and p.kind != p.VAR_KEYWORD}


def test_all_analyses_of_a_system_are_walked_through():
    assert {"simulate", "modes", "equilibrium", "gradient", "export_fmu", "sweep"} < {*WITH_SYSTEM}


@pytest.mark.parametrize("name", WITH_SYSTEM)
def test_a_model_in_place_of_a_system_is_told_to_be_assembled(name, model):
    function = FUNCTIONS[name]
    text = message(lambda: function(model, **rest_of(function)))
    assert text.startswith(f"{name}: system = Model(")
    assert "assemble it first, system = lumped.assemble(model)" in text


@pytest.mark.parametrize("name", WITH_SYSTEM)
@pytest.mark.parametrize("wrong", [None, "drive", 3.0, Inertia])
def test_what_is_no_system_is_refused_everywhere(name, wrong):
    function = FUNCTIONS[name]
    assert "a system from lumped.assemble is needed" in message(
        lambda: function(wrong, **rest_of(function))
    )


@pytest.mark.parametrize("name", [n for n in WITH_SYSTEM if n != "sweep"])
def test_an_option_that_does_not_exist_is_named_everywhere(name, system):
    function = FUNCTIONS[name]
    text = message(lambda: function(system, **rest_of(function), parametrs={}))
    assert "parametrs" in text


def test_a_run_in_place_of_a_system_is_told_where_its_system_is(run):
    assert "its attribute `system`" in message(lambda: lp.modes(run))


def test_a_point_of_another_system_is_refused(system):
    other = lp.start_point(lp.assemble(drive()))
    for action in (
        lambda: lp.modes(system, at=other),
        lambda: lp.linearise(system, at=other),
        lambda: lp.simulate(system, until=1.0, start=other),
        lambda: lp.frequency_response(system, inputs=[], outputs=[], hertz=[1.0], at=other),
    ):
        assert "belongs to another system" in message(action)
    assert "an operating point of this system" in message(
        lambda: lp.vibration.root_locus(system, along={"shaft.d": [1.0, 2.0]}, at=lambda d: other)
    )


# -- lists of names ------------------------------------------------------------------------------


def takes_names(hint):
    return isinstance(hint, str) and hint.replace(" | None", "") == "Iterable[Name]"


LISTS = [
    (name, p.name)
    for name, function in FUNCTIONS.items()
    for p in inspect.signature(function).parameters.values()
    if takes_names(p.annotation)
] + [("simulate", "free")]  # one of the options of runs, which all have in common


def test_all_lists_of_names_are_walked_through():
    assert {("linearise", "inputs"), ("sensitivity", "by"), ("simulate", "free")} < {*LISTS}
    assert len(LISTS) > 20


@pytest.mark.parametrize(("name", "option"), LISTS)
def test_a_text_in_place_of_a_list_of_names_gets_its_brackets(name, option, model, system, run):
    function = FUNCTIONS[name]
    first = next(iter(inspect.signature(function).parameters))
    modes = lp.modes(system)
    known = {
        "system": system,
        "model": model,
        "modes": modes,
        "what": modes,
        "point": lp.start_point(system),
        "run": run,
    }
    if first == "response":
        known["response"] = lp.frequency_response(
            system, inputs=["t.tau"], outputs=["shaft.tau"], hertz=[1.0]
        )
    if function in (lp.vibration.order_sensitivity, lp.vibration.critical_sensitivity):
        known["response"] = lp.vibration.order_response(
            system, speeds=[3.0], of=["shaft.tau"], excitations={"t.tau": {1: 1.0}}
        )
    for given in ("t.tau", model.t.tau):
        text = message(
            lambda given=given: function(
                **{**rest_for(function, first), first: known[first], option: given}
            )
        )
        assert f"{option} = " in text
        assert "a list of names is needed. Write [" in text


def rest_for(function, first):
    """Values of the right kind for the arguments that must be given."""
    fitting = {
        "until": 1.0,
        "of": lp.functionals.final("shaft.tau"),
        "path": "nowhere",
        "hertz": [1.0],
        "inputs": [],
        "outputs": [],
        "speeds": [3.0],
        "by": ["motor.J"],
        "critical": lp.vibration.CriticalSpeed(3.0, 1.0, 0, 1.0),
        "over": {"motor.J": [1.0]} if function is lp.gradients.gradient_ensemble else ["motor.J"],
    }
    found = {name: fitting[name] for name in rest_of(function) if name != first}
    gradients = lp.gradients
    lists = (lp.gradient, gradients.gradient_ensemble, lp.to_jax)
    one = {lp.vibration.order_sensitivity: "shaft.tau", lp.reliability: lp.functionals.frequency(0)}
    if function in one:
        return found | {"of": one[function]}
    if function is not gradients.value_and_gradient and "of" in found:
        found["of"] = [found["of"]] if function in lists else ["shaft.tau"]
    return found


@pytest.mark.parametrize("wrong", [5, [1], [None], {"t.tau": 1.0}, [["t.tau"]]])
def test_what_is_no_list_of_names_is_refused(wrong, system):
    assert "a list of names is needed" in message(lambda: lp.linearise(system, inputs=wrong))


def test_iterators_of_names_are_read_once(system):
    found = lp.linearise(system, inputs=(n for n in ["t.tau"]), outputs=iter(["shaft.tau"]))
    assert (found.inputs, found.outputs) == (("t.tau",), ("shaft.tau",))


def test_an_input_named_twice_is_refused(system):
    assert "t.tau is named twice" in message(
        lambda: lp.linearise(system, inputs=["t.tau", "t.tau"])
    )


# -- numbers, choices, mappings ------------------------------------------------------------------


@pytest.mark.parametrize("wrong", ["a", None, NAN, INF, -1.0, 0.0, [1.0], 1j, True, {}])
@pytest.mark.parametrize("option", ["until", "rtol"])
def test_numbers_that_make_no_sense_are_refused(wrong, option, system):
    fault = UnitError if (wrong, option) == ("a", "until") else OptionError
    text = message(lambda: lp.simulate(system, **{"until": 1.0, option: wrong}), fault)
    assert f"{option} = " in text


@pytest.mark.parametrize("value", ["a", None, [1.0], 1j, True, NAN, INF, 1e101, np.array([1.0])])
def test_values_of_parameters_and_start_values_are_refused_with_their_path(value, system):
    for given in ({"parameters": {"motor.J": value}}, {"start": {"motor.w": value}}):
        text = message(lambda given=given: lp.simulate(system, until=1.0, **given), LumpedError)
        assert "motor.J = " in text or "motor.w = " in text


@pytest.mark.parametrize(
    "action",
    [
        lambda s: lp.identify(s, vary={"motor.J": (0.5, 2.0)}, t=[0, 1], measured={"motor.w": "a"}),
        lambda s: lp.sweep(s, over={"motor.J": [1.0]}, until=1.0, of={"motor.w": 5}),
        lambda s: lp.optimisation.motion(
            lp.start_point(s),
            drive="t.tau",
            stations={"motor.w": 5},
            duration=1.0,
            minimise=lp.functionals.integral("t.tau"),
        ),
    ],
)
def test_members_of_dictionaries_are_named(action, system):
    assert "['motor.w'] = " in message(lambda: action(system))


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"level": 1.0}, "level = 1"),
        ({"level": "a"}, "level = 'a'"),
        ({"sigma": {"motor.w": "a"}}, "sigma of motor.w = 'a'"),
        ({"parameters": {"motor.J": None}}, "motor.J = None"),
        ({"start": {"motor.w": [1.0]}}, "motor.w = [1.0]"),
    ],
)
def test_identify_names_what_is_wrong(options, text, system):
    call = {"vary": {"motor.J": (0.5, 2.0)}, "t": [0.1, 0.2], "measured": {"motor.w": [1.0, 2.0]}}
    assert text in message(lambda: lp.identify(system, **call, **options), LumpedError)


def test_identify_takes_parameters_with_units(system):
    t = np.linspace(0.01, 0.1, 10)
    run = lp.simulate(system, until=0.1, grid=[0.0, *t], parameters={"load.J": 0.5})
    found = lp.identify(
        system,
        vary={"motor.J": (0.5, 2.0)},
        t=t,
        measured={"motor.w": run["motor.w"][1:]},
        parameters={"load.J": "5000 kg.cm2", "motor.J": "0.8 kg.m2"},
    )
    assert found.parameters["motor.J"] == pytest.approx(1.0, rel=1e-4)


def test_numbers_over_which_an_analysis_goes_are_no_text(system):
    for wrong in ("1 Hz", True, 1j):
        for action in (
            lambda w: lp.frequency_response(system, inputs=["t.tau"], outputs=["t.tau"], hertz=w),
            lambda w: lp.campbell(system, speeds=w, orders=[1]),
            lambda w: lp.vibration.root_locus(system, along={"shaft.c": w}),
        ):
            text = message(lambda action=action, wrong=wrong: action(wrong))
            assert f" = {wrong!r}: a list of finite numbers is needed" in text


def test_instants_of_functionals_are_numbers():
    for wrong in ("motor.w", "1 s", [0.1, "a"], None, NAN):
        text = message(lambda wrong=wrong: lp.functionals.at_time(wrong, "motor.w"))
        assert text.startswith(f"at_time: time = {wrong!r}: a finite number")


def test_what_varies_needs_room_between_its_bounds(system):
    vary = {"motor.J": (1.0, 1.0)}
    least = lp.functionals.final("motor.w")
    for action in (
        lambda: lp.optimise(system, until=0.1, vary=vary, minimise=least),
        lambda: lp.optimise(lp.modes(system), vary=vary, minimise=lp.functionals.frequency(0)),
        lambda: lp.identify(system, vary=vary, t=[0.1, 0.2], measured={"motor.w": [1.0, 2.0]}),
    ):
        assert "bounds of motor.J = (1.0, 1.0) leave nothing to search" in message(action)


def test_what_cannot_be_divided_is_refused(run):
    for call in (
        {"intervals": 0},
        {"intervals": -1},
        {"minimise": {lp.functionals.final("motor.w"): "a"}},
    ):
        options = {"minimise": lp.functionals.final("motor.w"), **call}
        message(lambda options=options: lp.optimise(run, vary={"motor.J": (0.5, 2.0)}, **options))


@pytest.mark.parametrize(
    "options", [{"tolerances": [-1.0]}, {"tolerances": [2.0]}, {"methods": []}]
)
def test_a_ladder_of_tolerances_must_make_sense(options, system):
    text = message(lambda: lp.simulation.work_precision(system, until=0.1, **options))
    assert "tolerances between 1e-14 and 1" in text


def test_pictures_and_reports_check_what_they_draw(system, model, tmp_path):
    path = tmp_path / "page.html"
    assert "ending such as .svg" in message(lambda: lp.schematic(model, tmp_path / "a.foo"))
    assert "figures['a'] = 5" in message(
        lambda: lp.drawing.report_html(system, path, figures={"a": 5})
    )
    for wrong in (5, [5]):
        text = message(lambda w=wrong: lp.drawing.report_html(system, path, compared=w))
        assert f"compared = {wrong}" in text


# -- results asked for what they do not have -----------------------------------------------------


def test_results_name_what_they_do_not_have(system, run):
    of, to, until = ["shaft.tau"], ["motor.J"], 0.1
    found = lp.sensitivity(system, of=of, by=to, until=until)
    slopes = lp.gradient(system, of=[lp.functionals.final("motor.w")], by=to, until=until)
    response = lp.frequency_response(system, inputs=["t.tau"], outputs=of, hertz=[1.0])
    for result in (found, slopes, response):
        for wrong in ("shaft.tau", 3, None, ("shaft.tau",), ("a", "b", "c")):
            assert "a row of 2" in message(lambda r=result, w=wrong: r[w])
        message(lambda r=result: r["shaft.tau", "load.J"], UnknownNameError)
    for wrong in ("nothing", 3, None):
        message(lambda w=wrong: run[w], LumpedError)
        message(lambda w=wrong: run.point(0.0)[w], LumpedError)
    assert "at least one" in message(lambda: run.table([]))
    assert "at least one" in message(lambda: response.plot([]))


@pytest.mark.parametrize("mode", [-1, 1, 5, "a", 1.0, None])
def test_modes_that_do_not_exist_are_refused(mode, system):
    modes = lp.modes(system)
    found = lp.vibration.eigen_sensitivity(modes)
    for ask in (
        found.ranked,
        found.plot,
        lp.vibration.modal_energies(modes).ranked,
        lp.vibration.participation(modes).ranked,
    ):
        message(lambda ask=ask: ask(mode))
    assert "at least one" in message(lambda: modes.plot([]))


# -- the check itself ----------------------------------------------------------------------------


def test_every_public_function_with_a_system_or_a_list_is_checked():
    plain = [n for n in WITH_SYSTEM if not hasattr(FUNCTIONS[n], "__wrapped__")]
    plain += [n for n, _ in LISTS if not hasattr(FUNCTIONS[n], "__wrapped__")]
    assert not plain
