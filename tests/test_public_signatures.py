"""Public functions are called in one way, and their docstrings say all of it."""

import ast
import dataclasses
import inspect
import re
import textwrap
from collections.abc import Callable
from typing import Any, get_args, get_type_hints

import pytest
from public_names import CLASSES, FUNCTIONS

import lumped as lp
from lumped.simulation import RunOptions

MODULES = {
    f"{module.__name__.rpartition('.')[2]}.{name}": getattr(module, name)
    for module in (lp.functionals, lp.ops, lp.profiles, lp.transmissions)
    for name in module.__all__
    if inspect.isfunction(getattr(module, name))
}
ALL = FUNCTIONS | MODULES

WITHOUT_NAME = {
    "param": {"default"},  # unit, text and value declare a quantity
    "var": {"start"},
    "schematic": {"path"},  # what is drawn, and where to
    "functionals.instant": {"after"},  # an event: its component, and what comes after it
    "functionals.at_event": {"after"},
    "functionals.count": {"after"},
    "triangular": set(),  # three numbers in the order of their sizes
    "truncated": set(),  # what is cut off, and where
}
"""Options that may be given without their names, and why."""

RTOL = 1e-6
TIGHTER = {
    "identify": 1e-8,  # near its end a search compares runs that hardly differ
    "optimise": 1e-8,
    "pareto": 1e-8,
    "periodic": 1e-10,  # what is missing adds up over all periods that follow
    "periodic_range": 1e-10,
    "check_orders": 1e-10,
}
"""Defaults of `rtol` that differ, each with a reason, which also stands in the docstring."""

MAKE_RUNS = {
    *("ensemble", "gradient", "gradient_ensemble", "identify", "inverse", "optimise", "pareto"),
    *("reliability", "scatter", "scene_of", "sensitivity", "simulate", "sobol_indices", "sweep"),
    *("to_jax", "value_and_gradient", "work_precision"),
}

WORDS = {
    "of": r"functional|names?\b|\(name|str\b|iterable|Distribution|expression|tuple|mapping of str",
    "by": r"iterable of names|names",
    "over": r"mapping\b|iterable of mappings",
    "vary": r"mapping of name to \(low, high\)",
    "along": r"mapping of name to",
    "shaft": r"name\b",
    "speed": r"float|quantity",
    "speeds": r"array_like|iterable of float|\(float, float\)|tuple|float",
    "at": r"OperatingPoint|callable|optional",
    "start": r"mapping|number|OperatingPoint|float",
    "searches": r"int",
    "search": r"\{",
    "seed": r"int",
}
"""One word, one meaning: what the type of an argument of this name says."""
GONE = {"to", "output", "outputs", "functional", "guess", "starts", "names", "mode", "setting"}
"""Words that had several meanings."""
TERMS = {
    *("frequency_response.outputs", "linearise.outputs", "export_fmu.outputs"),
    *("compare_response.output",),  # from inputs to outputs, as control engineers say
    *("triangular.mode", "functionals.frequency.mode", "functionals.damping.mode"),
}

BRIEF: dict[str, set[str]] = {}
"""Sections that are still missing."""


def parameters(name: str) -> list[inspect.Parameter]:
    return list(inspect.signature(ALL[name]).parameters.values())


def sections(thing: object) -> set[str]:
    return set(re.findall(r"^(\w+)\n---+$", inspect.getdoc(thing) or "", re.MULTILINE))


def raises(function: Callable[..., Any]) -> bool:
    source = textwrap.dedent(inspect.getsource(inspect.unwrap(function)))
    return any(isinstance(node, ast.Raise) for node in ast.walk(ast.parse(source)))


# -- calls ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ALL)
def test_options_are_given_by_name(name):
    received = {
        p.name
        for p in parameters(name)
        if p.kind is p.POSITIONAL_OR_KEYWORD and p.default is not p.empty
    }
    assert received == WITHOUT_NAME.get(name, set())


@pytest.mark.parametrize("name", [name for name in FUNCTIONS if name not in WITHOUT_NAME])
def test_at_most_one_thing_beside_the_first_is_given_without_its_name(name):
    assert sum(p.kind is p.POSITIONAL_OR_KEYWORD for p in parameters(name)) <= 2


@pytest.mark.parametrize("name", FUNCTIONS)
def test_what_is_examined_comes_first(name):
    known = {"system", "model", "modes", "run", "orbit", "point", "response"}
    names = [p.name for p in parameters(name)]
    assert not known & {*names[1:]} or names[0] in known


def test_there_is_one_default_of_the_tolerance():
    received = {
        name: p.default for name in ALL for p in parameters(name) if p.name in ("rtol", "tolerance")
    }
    assert {name for name, value in received.items() if value == RTOL} > {"simulate", "gradient"}
    others = {name: value for name, value in received.items() if value != RTOL}
    assert others == TIGHTER | {"equilibrium": 1e-10}  # `tolerance`, of what is left of derivatives


@pytest.mark.parametrize("name", TIGHTER)
def test_a_tighter_tolerance_has_its_reason_in_the_docstring(name):
    assert re.search(r"tighter\s+than elsewhere[:.] ", inspect.getdoc(ALL[name]), re.IGNORECASE)


def test_the_options_of_runs_are_the_same_everywhere():
    options = get_type_hints(RunOptions, include_extras=True)
    defaults = {name: get_args(hint)[1] for name, hint in options.items()}
    for name in MAKE_RUNS:
        received = {p.name: p for p in parameters(name) if p.name in options}
        assert {key: p.default for key, p in received.items()} == defaults
        assert {p.kind for p in received.values()} == {inspect.Parameter.KEYWORD_ONLY}
        assert "**options : RunOptions" in inspect.getdoc(ALL[name])
    others = {name for name in ALL for p in parameters(name) if p.name == "method"}
    assert others - MAKE_RUNS == {"export_fmu"}  # in whose unit there are fewer


# -- docstrings ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [name for name in ALL if not name.startswith("ops.")])
def test_a_docstring_says_what_is_taken_returned_and_raised(name):
    function = ALL[name]
    expected = {"Returns"}
    expected |= {"Parameters"} if parameters(name) else set()
    expected |= {"Raises"} if raises(function) else set()
    assert expected - sections(function) == BRIEF.get(name, set())


@pytest.mark.parametrize("name", [name for name in MODULES if name.startswith("ops.")])
def test_a_mathematical_function_says_what_it_is(name):
    function = MODULES[name]
    assert inspect.getdoc(function)
    assert not raises(function) or "Raises" in sections(function)


@pytest.mark.parametrize("name", [name for name in ALL if "Parameters" in sections(ALL[name])])
def test_the_docstring_names_all_parameters(name):
    block = inspect.getdoc(ALL[name]).partition("Parameters\n----------\n")[2].partition("\n\n")[0]
    heads = re.findall(r"^(\S.*?)(?: : .*)?$", block, re.MULTILINE)
    received = {word for head in heads for word in re.findall(r"\w+", head)}
    if "**options" in heads:
        received |= set(RunOptions.__annotations__)
    assert {p.name for p in parameters(name)} <= received


def types_of(name: str) -> dict[str, str]:
    """What a docstring says each argument is."""
    block = inspect.getdoc(ALL[name]).partition("Parameters\n----------\n")[2].partition("\n\n")[0]
    heads = re.findall(r"^(\S.*?) : (.*)$", block, re.MULTILINE)
    return {word: kind for head, kind in heads for word in re.findall(r"\w+", head)}


@pytest.mark.parametrize("name", ALL)
def test_a_word_means_the_same_everywhere(name):
    assert not {f"{name}.{p.name}" for p in parameters(name) if p.name in GONE} - TERMS
    for word, kind in types_of(name).items():
        assert re.match(WORDS.get(word, ""), kind), f"{word} : {kind}"


@pytest.mark.parametrize("name", CLASSES)
def test_results_have_the_words_of_calls(name):
    kind = CLASSES[name]
    fields = {f.name for f in dataclasses.fields(kind)} if dataclasses.is_dataclass(kind) else set()
    assert not fields & {"to", "functional"}
    assert "by" not in fields or not fields.isdisjoint({"derivatives", "eigenvalues"})


@pytest.mark.parametrize("name", CLASSES)
def test_a_class_says_what_it_holds(name):
    kind = CLASSES[name]
    assert kind.__doc__
    if dataclasses.is_dataclass(kind) or "__init__" in vars(kind):
        assert {"Attributes", "Parameters"} & sections(kind)
