"""Explicit and implicit steps in turn, as a run becomes stiff and soft again."""

import itertools
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from machine_scenes import by_engines
from scipy.integrate import solve_ivp
from stiff_in_turn import EDGES, UNTIL, VALUES, InTurn, end, moved

import lumped as lp
from lumped.kernel import choice
from lumped.timeloop import run_by_steps

EXPLICIT = {"steps": "explicit", "taylor": "taylor"}


def used(run):
    return [used.method for used in run.statistics.methods]


# -- the fastest eigenvalue ------------------------------------------------------------------------


def found_fastest(matrix, scales):
    """What the power iteration makes of a matrix."""
    n = len(matrix)
    row, column = np.nonzero(matrix)
    pattern = SimpleNamespace(nonzeros=len(row), row=row, column=column)
    work = {name: np.zeros(n) for name in ("right", "size")}
    run = SimpleNamespace(
        plant=SimpleNamespace(states=n),
        matrix=SimpleNamespace(pattern=pattern, slopes=matrix[row, column], **work),
        atol=scales,
        fast=np.zeros(n),
        fastest=0.0,
    )
    choice._begin_fastest(run)
    return run.fastest


@pytest.mark.parametrize("seed", range(20))
def test_the_size_of_the_fastest_of_a_few_eigenvalues(seed):
    """Pairs of complex and single ones, mixed by a random basis, in units of any size."""
    rng = np.random.default_rng(seed)
    blocks = np.zeros((6, 6))
    size = 10.0 ** rng.uniform(-2, 6)
    for k, angle in ((0, rng.uniform(0, 2 * np.pi)), (2, rng.uniform(0, 2 * np.pi))):
        here = size * 3.0 ** (-k)
        blocks[k, k] = blocks[k + 1, k + 1] = here * np.cos(angle)
        blocks[k, k + 1], blocks[k + 1, k] = -here * np.sin(angle), here * np.sin(angle)
    blocks[4, 4] = -size * 0.1
    if seed % 2:  # a single one is the fastest
        blocks[4, 4] = -size * 4.0
    basis = rng.normal(size=(6, 6))
    units = 10.0 ** rng.uniform(-3, 3, 6)
    matrix = units[:, None] * (basis @ blocks @ np.linalg.inv(basis)) / units
    expected = np.abs(np.linalg.eigvals(blocks)).max()
    assert found_fastest(matrix, 1e-9 * units) == pytest.approx(expected, rel=1e-3)


def test_an_undamped_vibration_is_as_fast_as_its_frequency_in_any_unit():
    for w in (1e-3, 1.0, 1e3, 1e6):
        matrix = np.array([[0.0, 1.0], [-(w**2), 0.0]])
        assert found_fastest(matrix, np.full(2, 1e-9)) == pytest.approx(w, rel=1e-9)


def test_where_nothing_holds_a_motion_back_all_eigenvalues_are_zero():
    assert found_fastest(np.array([[0.0, 1.0], [0.0, 0.0]]), np.full(2, 1e-9)) == 0.0


# -- there and back --------------------------------------------------------------------------------


class Belt(lp.Component):
    """Two masses on a belt, on springs without dampers; they stick and slip."""

    v: lp.Param = lp.param("m/s", "speed of the belt", 0.2)
    k: lp.Param = lp.param("N/m", "spring to the ground", 1.0)
    k_c: lp.Param = lp.param("N/m", "spring between them", 1.2)
    x_1: lp.Var = lp.var("m", "place", 0.5)
    x_2: lp.Var = lp.var("m", "place", 0.3)
    u_1: lp.Var = lp.var("m/s", "speed")
    u_2: lp.Var = lp.var("m/s", "speed")
    w_1: lp.Var = lp.var("m/s", "slip")
    w_2: lp.Var = lp.var("m/s", "slip")
    f_1: lp.Var = lp.var("N", "friction")
    f_2: lp.Var = lp.var("N", "friction")
    m_1: lp.Var = lp.var("1", "mode")
    m_2: lp.Var = lp.var("1", "mode")

    def equations(self):
        """Friction that falls with the slip (Galvanetto)."""
        one = self.x_1, self.u_1, self.w_1, self.f_1, self.m_1, self.x_2, 1.0
        two = self.x_2, self.u_2, self.w_2, self.f_2, self.m_2, self.x_1, 1.3
        for x, u, w, f, m, other, most in (one, two):
            yield lp.der(x) == u
            yield w == u - self.v
            yield lp.der(u) == -self.k * x - self.k_c * (x - other) - f
            slip = most / (1 + 3 * abs(w))
            yield lp.hold(f, w, forward=slip, backward=-slip, upper=most, lower=-most, position=m)


@pytest.mark.parametrize("rtol", [1e-8, 1e-9, 1e-10, 1e-11])
def test_undamped_masses_that_stick_and_slip_need_no_more_steps_than_explicit_ones(rtol):
    system = lp.assemble(Belt())
    options = {"until": 200.0, "rtol": rtol, "grid": [0.0, 200.0]}
    auto, explicit = (lp.simulate(system, method=m, **options) for m in ("auto", "explicit"))
    assert len(auto.events) > 60
    assert auto.statistics.steps < 1.1 * explicit.statistics.steps


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-9])
@pytest.mark.parametrize("method", EXPLICIT)
def test_each_part_of_a_run_is_made_by_the_method_that_suits_it(method, rtol):
    """Free and held parts for themselves, each from the closed form, by their own methods."""
    system = lp.assemble(InTurn())
    grid = [0.0, UNTIL]
    run = lp.simulate(system, until=UNTIL, rtol=rtol, method=method, grid=grid)
    assert used(run) == 2 * [EXPLICIT[method], "implicit"]
    begins = [used.begin for used in run.statistics.methods]
    assert begins[1:] == pytest.approx(EDGES, abs=0.03)
    steps, x = 0, (0.1, 0.0)
    for k, (begin, stop) in enumerate(itertools.pairwise((0.0, *EDGES, UNTIL))):
        part = lp.simulate(
            system,
            begin=begin,
            until=stop,
            start={"phi": x[0], "w": x[1]},
            rtol=rtol,
            method="implicit" if k % 2 else EXPLICIT[method],
            grid=[begin, stop],
        )
        steps += part.statistics.steps
        damping = VALUES["d" if k % 2 else "free"]
        x = np.real(moved(*x, stop - begin, VALUES["J"], VALUES["c"], damping, VALUES["tau"]))
    print(f"{method}, {rtol:g}: {run.statistics.steps} steps, {steps} in parts")
    assert run.statistics.steps < 1.15 * steps + 60
    expected = end(**VALUES).real
    error = np.abs(np.array([run["phi"][-1], run["w"][-1]]) - expected).max()
    assert error < 10 * rtol * 0.1


class Relaxation(lp.Component):
    """Van der Pol's equation: slow and stiff, but for short and soft leaps."""

    stiff: lp.Param = lp.param("1", "stiffness", 300.0)
    x: lp.Var = lp.var("1", "position", 2.0)
    v: lp.Var = lp.var("1/s", "speed", 0.0)

    def equations(self):
        """The slow time is the unit."""
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == self.stiff**2 * ((1 - self.x**2) * self.v - self.x)


@cache
def relaxed():
    """The same by SciPy at a tenth of a second each."""
    stiff, times = 300.0, np.linspace(0.0, 3.0, 31)

    def rate(t, y):
        return [y[1], stiff**2 * ((1 - y[0] ** 2) * y[1] - y[0])]

    def slope(t, y):
        grows = stiff**2 * (-2 * y[0] * y[1] - 1)
        return [[0.0, 1.0], [grows, stiff**2 * (1 - y[0] ** 2)]]

    span = (0.0, times[-1])
    options = {"jac": slope, "rtol": 1e-9, "atol": [1e-11, 1e-9]}
    return times, solve_ivp(rate, span, [2.0, 0.0], "Radau", times, **options).y[0]


@pytest.mark.parametrize("method", EXPLICIT)
def test_leaps_without_instants_are_explicit_and_follow_scipy(method):
    times, expected = relaxed()
    system, steps = lp.assemble(Relaxation()), {}
    for name in (method, "implicit"):
        options = {"until": 3.0, "rtol": 1e-8, "grid": times}
        run = lp.simulate(system, method=name, **options)
        steps[name] = run.statistics.steps
        if name == method:
            assert used(run) == [EXPLICIT[method], "implicit", *3 * [EXPLICIT[method], "implicit"]]
            error = np.abs(run["x"] - expected).max()
    assert steps[method] < 0.8 * steps["implicit"]
    assert error < 1e-5


def test_engines_make_the_same_steps_in_turn():
    system = lp.assemble(InTurn())
    options = {"until": 2.1, "rtol": 1e-6, "grid": 20, "method": "steps"}
    runs = by_engines(lambda: lp.simulate(system, **options), ("llvm", "c", "python"))
    assert used(runs[0]) == ["explicit", "implicit", "explicit"]
    for run in runs[1:]:
        assert run.statistics.methods == runs[0].statistics.methods
        np.testing.assert_array_equal(run.x, runs[0].x)


def test_a_run_says_which_methods_it_used_and_when():
    system = lp.assemble(InTurn())
    run = lp.simulate(system, until=UNTIL, method="steps")
    assert run.statistics.method == "explicit and implicit"
    assert "explicit and implicit: DOP853, and Rodas5P where" in repr(run)
    short = lp.simulate(system, until=1.5, method="steps")
    assert short.statistics.method == "explicit then implicit"
    at = np.array([0.5, 1.5, 2.5, 3.5])
    assert run.statistics.is_implicit(at).tolist() == [False, True, False, True]


def test_a_long_run_takes_series_when_it_is_explicit_again(monkeypatch):
    """The look for series falls into implicit steps; the next one, twice as late, does not."""
    system = lp.assemble(InTurn(cubic=1e3))  # no closed form
    options = {"begin": 0.5, "rtol": 1e-8, "grid": [0.5]}
    first = lp.simulate(system, until=EDGES[1], method="steps", **options).statistics
    assert first.method == "explicit then implicit"
    monkeypatch.setattr(run_by_steps, "_LONG", first.steps + first.rejected - 2)
    run = lp.simulate(system, until=UNTIL, method="auto", **options)
    assert used(run) == ["explicit", "implicit", "explicit", "taylor", "implicit"]
    assert "in the end Taylor's series" in run.statistics.why
