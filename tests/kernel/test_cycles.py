"""The count of cycles in the language of the time loop, and the damage of each."""

import ctypes
import itertools

import numpy as np
import pytest
from compiled_c import compile_c

import lumped as lp
from lumped.functionals.damage_law import DamageLaw, MeanStress
from lumped.kernel import engine
from lumped.kernel.cycles import count_all
from lumped.timeloop.cycle_count import count_cycles, damage_of_cycles

ROWS = ((40.0, 1e-7, 9.0), (60.0, 1e-7 * 1.5**9, 5.0), (100.0, 1e-7 * 1.5**9 * (5 / 3) ** 5, 3.0))
MEANS = {
    "none": (0, 0.0),
    "Goodman": (1, 700.0),
    "Gerber": (2, 700.0),
    "Smith, Watson, Topper": (3, 0.0),
    "Walker": (4, 0.65),
    "FKM": (5, 0.3),
}
MEANS = {rule: MeanStress(*given) for rule, given in MEANS.items()}


def by_three_points(load):
    """Cycles as begin, end and weight, as ASTM E1049-85, 5.4.4 words it: read, form X and Y."""
    reversals = [load[0]]
    for value in load[1:]:
        if len(reversals) > 1 and (reversals[-1] - reversals[-2]) * (value - reversals[-1]) > 0:
            reversals[-1] = value
        elif value != reversals[-1]:
            reversals.append(value)
    found, left = [], []
    for value in reversals:
        left.append(value)
        while len(left) > 2:
            x, y = abs(left[-1] - left[-2]), abs(left[-2] - left[-3])
            if x < y:
                break
            holds_start = len(left) == 3
            found.append((left[-3], left[-2], 0.5 if holds_start else 1.0))
            left = left[1:] if holds_start else [*left[:-3], left[-1]]
    return found + [(a, b, 0.5) for a, b in itertools.pairwise(left)]


def at_mean_zero(rule, amplitude, mean):
    """The rules as they are printed."""
    number = MEANS[rule][1]
    top, ratio = mean + amplitude, (mean - amplitude) / (mean + amplitude)
    if rule == "Goodman":
        return amplitude / (1 - max(mean, 0) / number)
    if rule == "Gerber":
        return amplitude / (1 - (max(mean, 0) / number) ** 2)
    if rule == "Smith, Watson, Topper":
        return np.sqrt(max(top, 0) * amplitude)
    if rule == "Walker":
        return amplitude * (2 / (1 - ratio)) ** (1 - number) if top > 0 else 0.0
    if rule == "FKM":
        if ratio > 1:
            return amplitude * (1 - number)
        if ratio <= 0:
            return amplitude + number * mean
        factor = (1 + number) / (1 + number / 3)
        if ratio < 0.5:
            return factor * (amplitude + number / 3 * mean)
        return factor * (1 + number) * amplitude
    return amplitude


def damage(amplitude, extends_down):
    """Share of life of one cycle at mean zero: straight lines in logarithmic scales."""
    if amplitude < ROWS[0][0] and not extends_down:
        return 0.0
    points = np.log([row[:2] for row in ROWS])
    k = max(int(np.searchsorted(points[:, 0], np.log(amplitude), "right")) - 1, 0)
    return np.exp(points[k, 1] + ROWS[k][2] * (np.log(amplitude) - points[k, 0]))


@pytest.fixture
def count_in_c(tmp_path, monkeypatch):
    """The count alone as the engine "c", whose time loop would take seconds to compile."""
    function = compile_c({"count_all": count_all}, tmp_path).count_all
    function.restype, function.argtypes = ctypes.c_int64, [ctypes.c_void_p] * 2
    monkeypatch.setitem(engine._ready, "c", {"count_all": function})


@pytest.mark.usefixtures("count_in_c")
@pytest.mark.parametrize("digits", [0, 1, 12])
def test_three_engines_count_alike_and_as_the_standard_words_it(digits):
    rng = np.random.default_rng(digits)
    law, cycles = DamageLaw(ROWS, True, MEANS["FKM"], 1.7), 0
    for count in (2, 3, 5, 40, 300):
        load = np.round(rng.normal(size=count) * 30, digits)
        found = []
        for name in ("llvm", "c", "python"):
            with engine.using(name):
                found.append(count_cycles(load, law))
        assert len({one.damage for one in found}) == 1
        for one in found:
            pairs = load[one.cycles].tolist()
            cut = [(*pair, w) for pair, w in zip(pairs, one.weights.tolist(), strict=True)]
            assert cut == by_three_points(load.tolist())
        cycles += len(one.weights)
    assert cycles > 90


def test_a_load_that_never_turns_has_no_cycle():
    for load in ([3.0], [3.0, 3.0, 3.0]):
        found = count_cycles(np.array(load), DamageLaw(ROWS))
        assert found.damage == found.weights.sum() == 0
        assert found.turning.tolist() == [0]


@pytest.mark.parametrize("rule", MEANS)
@pytest.mark.parametrize("extends_down", [True, False])
def test_damage_of_cycles_with_a_mean_and_its_slopes(rule, extends_down):
    rng = np.random.default_rng(5)
    ranges, means = rng.uniform(20, 400, 200), rng.uniform(-300, 300, 200)
    weights = rng.choice([0.5, 1.0], 200)
    scale = 0.8
    law = DamageLaw(ROWS, extends_down, MEANS[rule], scale)
    total, found = damage_of_cycles(ranges, means, weights, law)

    def expected(ranges, means):
        amplitudes = [
            at_mean_zero(rule, *pair)
            for pair in zip(scale * ranges / 2, scale * means, strict=True)
        ]
        return weights * [damage(a, extends_down) if a else 0.0 for a in amplitudes]

    np.testing.assert_allclose(found[:, 0], expected(ranges, means), rtol=1e-12)
    assert total == pytest.approx(found[:, 0].sum(), rel=1e-14)
    h, size = 1e-4, np.abs(found[:, 1:]).max()
    by_range = (expected(ranges + h, means) - expected(ranges - h, means)) / (2 * h)
    by_mean = (expected(ranges, means + h) - expected(ranges, means - h)) / (2 * h)
    error = np.abs(found[:, 1:] - np.column_stack([by_range, by_mean])).max() / size
    assert error < 1e-7


def test_beyond_the_ultimate_strength_one_cycle_breaks():
    law = DamageLaw(ROWS, True, MEANS["Goodman"])
    total, _ = damage_of_cycles(*np.array([[100.0], [700.0], [1.0]]), law)
    assert total == np.inf


def test_equal_to_the_sum_of_the_recorded_cycles():
    load = np.random.default_rng(1).normal(size=4000) * 50
    law = DamageLaw(ROWS, False, MEANS["Gerber"], 1.3)
    counted = count_cycles(load, law)
    begin, end = load[counted.cycles].T
    given = np.abs(end - begin), 0.5 * (begin + end), counted.weights
    assert damage_of_cycles(*given, law)[0] == counted.damage
    curve = lp.life.SNCurve(40.0, 1e7, 5.0, unit="1")
    cycles = lp.life.rainflow(load)
    expected = (cycles.counts * (cycles.ranges / 2 / 40) ** 5 / 1e7).sum()
    assert count_cycles(load, curve.law()).damage == pytest.approx(expected, rel=1e-12)
