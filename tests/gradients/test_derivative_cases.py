"""Derivatives of runs with events against closed forms: the files in tests/data/derivatives."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from checks import refused
from derivative_models import CASES

import lumped as lp
from lumped.errors import SolverError

FOLDER = Path(__file__).parents[1] / "data" / "derivatives"
FILES = {path.stem: yaml.safe_load(path.read_text()) for path in sorted(FOLDER.glob("*.yaml"))}
RTOL = 1e-10


def test_every_file_has_a_model():
    assert len(FILES) == 36
    assert set(CASES) == set(FILES)


def ask(method, system, of, to, until, rtol, **options):
    """Values and derivatives of functionals, shapes (len(of),) and (len(of), len(to))."""
    if method == "gradient":
        found = lp.gradient(system, of=of, by=to, until=until, rtol=rtol, **options)
        return found.values, found.derivatives
    found = lp.sensitivity(system, of=of, by=to, until=until, rtol=rtol, **options)
    return found.values, found.slopes


def answers(method, name, rtol=RTOL, only=None, **options):
    """Value and derivatives by name of each functional of a case; `only` chooses some of both."""
    file = FILES[name]
    numbers = {key: entry["value"] for key, entry in file["parameters"].items()}
    case = CASES[name](numbers)
    found = {}
    pairs = only or {key: list(numbers) for key in case.of}
    for label, names in pairs.items():
        entry = case.of[label]
        law, of = entry if isinstance(entry, tuple) else (lambda y: y, [entry])
        inner = [f for f in of if not isinstance(f, str)]
        to = [case.to.get(n, n) for n in names]
        until = case.runs.get(label, case.until)
        moved = [case.until_by.get(n, 0.0) for n in names]
        end = ["until"] * any(moved)
        values, slopes = ask(method, case.system, inner, [*to, *end], until, rtol, **options)
        if end:
            slopes = slopes[:, :-1] + np.outer(slopes[:, -1], moved)
        values = iter(zip(values, slopes, strict=True))
        arguments, rows = [], []
        for f in of:
            if isinstance(f, str):
                arguments.append(numbers[f])
                rows.append(np.array([float(n == f) for n in names]))
            else:
                value, row = next(values)
                arguments.append(value)
                rows.append(row)
        partial = [
            np.imag(law(*[a + 1e-30j * (i == k) for i, a in enumerate(arguments)])) / 1e-30
            for k in range(len(arguments))
        ]
        slopes = sum(d * row for d, row in zip(partial, rows, strict=True))
        found[label] = float(law(*arguments)), dict(zip(names, slopes, strict=True))
    return found


def deviations(file, label, value, slopes):
    """Of the value and of each derivative, by the measure of the files."""
    expected = file["expected"]
    known = expected["values"][label]
    everything = [abs(v) for own in expected["derivatives"].values() for v in own.values()]
    own = expected["derivatives"][label]
    size = max(map(abs, own.values()))
    least = 1e-3 * size or 1e-7 * max(everything)
    found = {"value": abs(value - known) / (abs(known) or 1.0)}
    for name, slope in slopes.items():
        found[name] = abs(slope - own[name]) / max(abs(own[name]), least)
    return found


PLAIN = [n for n in FILES if n in CASES and "derivatives" in FILES[n]["expected"]]


@pytest.mark.parametrize("method", ["gradient", "sensitivity"])
@pytest.mark.parametrize("name", PLAIN)
def test_values_and_derivatives_are_those_of_the_file(name, method):
    file = FILES[name]
    known = file["expected"]["derivatives"]
    labels = CASES[name]({k: e["value"] for k, e in file["parameters"].items()}).of
    only = {label: list(known[label]) for label in labels if label in known}
    worst = {}
    for label, (value, slopes) in answers(method, name, only=only).items():
        worst[label] = deviations(file, label, value, slopes)
    bad = {
        (label, key): error
        for label, own in worst.items()
        for key, error in own.items()
        if not error <= 1e-6
    }
    largest = max(max(own.values()) for own in worst.values())
    print(f"\n{name} {method}: largest deviation {largest:.1e}")
    assert not bad


@pytest.mark.parametrize("method", ["gradient", "sensitivity"])
@pytest.mark.parametrize(
    ("name", "instant"), [("grazing", "t = 1.57079"), ("static_limit_touched", "t = 0.785398")]
)
def test_a_border_that_is_only_touched_is_refused_with_the_instant(name, instant, method):
    names = list(FILES[name]["parameters"])
    refused(
        SolverError,
        lambda: answers(method, name, only={"x_end": names}),
        instant,
        "Body",
        "touches",
    )


def test_a_curve_over_time_is_refused_at_a_touch_too():
    case = CASES["grazing"]({k: e["value"] for k, e in FILES["grazing"]["parameters"].items()})
    options = {"of": ["x"], "by": ["w"], "until": 2.0, "rtol": 1e-8}
    refused(SolverError, lambda: lp.sensitivity(case.system, **options), "touches")


@pytest.mark.parametrize("method", ["gradient", "sensitivity"])
def test_a_stop_that_is_hit_slowly_has_large_derivatives(method):
    near = FILES["grazing"]["expected"]["near"]
    for entry in near[:3]:
        numbers = {k: e["value"] for k, e in FILES["grazing"]["parameters"].items()}
        case = CASES["grazing"](numbers | {"x0": 1.0 + entry["x0_minus_xs"]})
        of, to = list(case.of.values()), ["x0"]
        value, slope = ask(method, case.system, of, to, 2.0, 1e-12)
        assert value[0] == pytest.approx(entry["x_end"], rel=1e-7)
        assert slope[0, 0] == pytest.approx(entry["d_x_end_by_x0"], rel=1e-5)


ONE_SIDED = [n for n in FILES if "one_sided_only" in FILES[n]["expected"]]


@pytest.mark.parametrize("name", ONE_SIDED)
def test_where_sides_differ_there_is_no_derivative_but_each_side_has_one(name):
    labels = FILES[name]["expected"]["one_sided_only"]
    numbers = {k: e["value"] for k, e in FILES[name]["parameters"].items()}
    only = {k: list(labels[k]) for k in CASES[name](numbers).of if k in labels}
    for method in ("gradient", "sensitivity"):
        refused(SolverError, lambda m=method: answers(m, name, only=only), "both sides", "t = ")
    for side in ("left", "right"):
        found = answers("sensitivity", name, only=only, side=side)
        for label, (_, slopes) in found.items():
            expected = [labels[label][parameter][side] for parameter in slopes]
            assert list(slopes.values()) == pytest.approx(expected, rel=1e-6, abs=1e-9)
        if "t_last" in labels:
            later = max if side == "right" else min
            first, second = found["t_lock_1"][1], found["t_lock_2"][1]
            for parameter, expected in labels["t_last"].items():
                slope = later(first[parameter], second[parameter])
                assert slope == pytest.approx(expected[side], rel=1e-6, abs=1e-9), parameter
