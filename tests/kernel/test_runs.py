"""Runs by LLVM, by C and in Python: the same bits; and closed forms."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from linkages import double_rocker, four_bar
from machine_scenes import SCENES, by_engines
from rows import assemble_row

import lumped as lp
from benchmarks.hybrid import Coupled, rubbing
from lumped.components import (
    Fixed,
    Inertia,
    Spring,
    SpringDamper,
    Torque,
)
from lumped.errors import SolverError
from lumped.timeloop.plants.executable import Executable, executable

ALL = ("llvm", "c", "python")


def assert_same(first, *others):
    """The same bits in all that runs hold."""
    for other in others:
        assert other.events == first.events
        one, two = first.statistics, other.statistics
        assert (one.method, one.steps, one.rejected) == (two.method, two.steps, two.rejected)
        assert one.evaluations == two.evaluations
        assert len(first.pieces) == len(other.pieces)
        for a, b in zip(first.pieces, other.pieces, strict=True):
            for received, expected in ((b.t, a.t), (b.x, a.x), (b.settings, a.settings)):
                np.testing.assert_array_equal(received, expected)


def undamped():
    """Four inertias in a row under constant torques, without damping."""
    return lp.compose(
        body=[Inertia(J=J) for J in (30.0, 24.0, 3.0, 54.0)],
        shaft=[Spring(c=c) for c in (2.6e5, 9e4, 9e4)],
        load=[Torque(tau=tau) for tau in (3600.0, 0.0, -7200.0, 3600.0)],
        connections=lambda m: [
            *(c for i in range(3) for c in lp.chain(m.body[i], m.shaft[i], m.body[i + 1])),
            *(lp.connect(m.load[i].flange, m.body[i].flange_a) for i in range(4)),
        ],
    )


@pytest.mark.parametrize("name", SCENES)
def test_the_five_machines_run_alike(name):
    assert_same(*by_engines(lambda: SCENES[name](rtol=1e-8, grid=100, method="steps")))


@pytest.mark.parametrize("method", ["steps", "implicit"])
@pytest.mark.parametrize("grid", [None, 200, [0.0, 0.3, 0.3, 1.7, 2.0]])
def test_a_smooth_drive_takes_the_same_steps(method, grid):
    system = lp.assemble(undamped())
    options = {"until": 2.0, "rtol": 1e-7, "grid": grid, "method": method}
    assert_same(*by_engines(lambda: lp.simulate(system, **options)))


def test_the_implicit_method_knows_how_a_single_rate_depends_on_time():
    """A torque linear in time: the rate depends on no state, and every step is exact."""
    system = assemble_row(drive=Torque(tau=0.3 - 0.7 * lp.time), body=Inertia(J=2.0))
    options = {"until": 2.0, "rtol": 1e-10, "method": "implicit"}
    a, b = by_engines(lambda: lp.simulate(system, **options))
    assert_same(a, b)
    assert b.statistics.steps < 20
    assert b["body.w"][-1] == pytest.approx((0.3 * 2 - 0.7 * 2) / 2, rel=1e-13)


def stiff(bodies):
    """Bodies on stiff shafts with dampers, driven slowly."""

    def connections(m):
        yield from lp.chain(
            m.drive, *(p for pair in zip(m.body, m.shaft, strict=True) for p in pair), m.wall
        )

    return lp.compose(
        drive=Torque(tau=10 * lp.ops.sin(lp.time)),
        body=[Inertia(J=1e-3) for _ in range(bodies)],
        shaft=[SpringDamper(c=1e4, d=100.0) for _ in range(bodies)],
        wall=Fixed(),
        connections=connections,
    )


@pytest.mark.parametrize("bodies", [3, 30])
def test_a_stiff_drive_changes_over_to_the_implicit_method(bodies):
    """Events or not: its matrices are sparse, so that there is no limit to their size."""
    system = lp.assemble(stiff(bodies))
    a, b = by_engines(lambda: lp.simulate(system, method="steps", until=3.0, rtol=1e-8))
    assert a.statistics.method == "explicit then implicit"
    assert b.statistics.method == "explicit then implicit"
    assert_same(a, b)


@pytest.mark.parametrize("grid", [None, 500])
def test_coupled_clutches(grid):
    system = lp.assemble(Coupled())
    runs = by_engines(lambda: lp.simulate(system, method="steps", until=1.5, grid=grid), ALL)
    assert len(runs[0].events) > 2
    assert_same(*runs)


class Counter(lp.Component):
    """Ramps that one state starts and another resets: jumps that make conditions true."""

    y: lp.Var = lp.var("1", "ramp", 0.0, state="always")
    count: lp.Var = lp.var("1", "number of resets", 0.0, state="always")

    def equations(self):
        yield lp.der(self.y) == 3 + lp.ops.where(self.count >= 4, 2, 0)
        yield lp.der(self.count) == 0
        yield lp.when(self.y >= 1, {self.y: self.y - 1, self.count: self.count + 1})


def test_jumps_of_states():
    system = lp.assemble(Counter())
    a, b = by_engines(lambda: lp.simulate(system, method="steps", until=3.0, rtol=1e-9))
    assert_same(a, b)
    expected = 4 + np.floor(5 * (3.0 - 4 / 3))
    assert b["count"][-1] == expected


@pytest.mark.parametrize("turning", [True, False])
def test_closed_linkages_and_states_that_change_places(turning):
    part = four_bar(w=10.0) if turning else double_rocker(w=3.0)
    system = lp.assemble(part)
    until = 2.0 if turning else 6.0
    a, b = by_engines(lambda: lp.simulate(system, method="steps", until=until, rtol=1e-9))
    assert (len(a.events) > 0) == (not turning)
    assert_same(a, b)


def test_changes_without_end_are_named():
    """A relay without hysteresis: J w' = -sign(w) switches itself for ever."""
    w = lp.var("rad/s", "speed", 1.0, state="always")

    class Relay(lp.Component):
        speed: lp.Var = w

        def equations(self):
            yield lp.der(self.speed) == lp.ops.where(self.speed > 0, -1.0, 1.0)

    def stopped():
        with pytest.raises(SolverError) as caught:
            lp.simulate(lp.assemble(Relay()), method="steps", until=3.0)
        return str(caught.value), caught.value.partial

    (told, a), (text, b) = by_engines(stopped)
    assert text == told
    assert b.t[-1] == pytest.approx(a.t[-1], rel=1e-9)


def test_a_quantity_that_runs_to_infinity():
    """Y' = y^2 from 1 has its pole at 1 s."""

    class Pole(lp.Component):
        y: lp.Var = lp.var("1", "grows", 1.0, state="always")

        def equations(self):
            yield lp.der(self.y) == self.y**2

    def stopped():
        with pytest.raises(SolverError, match=r"(step size shrank|not a finite number)") as caught:
            lp.simulate(lp.assemble(Pole()), method="steps", until=3.0, rtol=1e-8, grid=None)
        return caught.value.partial

    a, b = by_engines(stopped)
    assert b.t[-1] == pytest.approx(1.0, abs=1e-6)
    np.testing.assert_array_equal(a.t, b.t)


def test_functions_are_compiled_when_that_pays_and_give_the_same_bits(monkeypatch, tmp_path):
    """Interpreted, compiled within a run, compiled before, and taken from the cache."""
    monkeypatch.setenv("LUMPED_CACHE", str(tmp_path))
    options = {"method": "steps", "until": 5.0, "rtol": 1e-9, "grid": 50}
    system = lp.assemble(rubbing(3))
    interpreted = lp.simulate(system, **options)
    plant = executable(system).plant
    assert not plant.rates.address
    monkeypatch.setattr("lumped.timeloop.plants.executable.WORTH", 0)
    monkeypatch.setattr(Executable, "attempts", 3)
    changing = lp.simulate(system, **options)
    assert plant.rates.address
    assert plant.look.address
    compiled = lp.simulate(system, **options)
    again = lp.assemble(rubbing(3))
    cached = lp.simulate(again, **options)
    assert executable(again).plant.rates.address
    assert_same(interpreted, changing, compiled, cached)


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_threads_make_the_same_runs_as_one(method):
    """Eight at once, of one system, with different parameters; the first and the hundredth."""
    system = lp.assemble(Coupled())
    name = next(n for n in system.parameters if n.endswith(".J"))

    def run(k):
        value = {name: 1.0 + 0.01 * (k % 5)}
        return lp.simulate(system, until=1.5, grid=50, method=method, parameters=value)

    with ThreadPoolExecutor(8) as pool:
        threaded = list(pool.map(run, range(100)))
    expected = [run(k) for k in range(5)]
    for k, found in enumerate(threaded):
        assert_same(expected[k % 5], found)


@pytest.mark.parametrize("grid", [None, 50])
def test_how_often_the_loop_comes_back_changes_nothing(grid, monkeypatch):
    """After each step, with room for one piece of output and the changes of one instant."""
    system = lp.assemble(rubbing(3))
    whole = lp.simulate(system, method="steps", until=5.0, grid=grid)
    monkeypatch.setattr(Executable, "attempts", 1)
    monkeypatch.setattr("lumped.timeloop.run_by_steps._PIECES", 1)
    monkeypatch.setattr("lumped.timeloop.run_by_steps._CHANGES", 0)
    monkeypatch.setattr("lumped.timeloop.run_by_steps._ROWS", 5)
    monkeypatch.setattr("lumped.timeloop.run_by_steps._ROOM", 5)
    parts = lp.simulate(system, method="steps", until=5.0, grid=grid)
    assert parts.events == whole.events
    assert len(parts.events) > 5
    np.testing.assert_array_equal(parts.t, whole.t)
    np.testing.assert_array_equal(parts.x, whole.x)
    assert [len(p.t) for p in parts.pieces] == [len(p.t) for p in whole.pieces]
    for one, other in zip(parts.pieces, whole.pieces, strict=True):
        np.testing.assert_array_equal(one.settings, other.settings)


def test_reports_of_failed_runs_keep_what_was_computed():
    system = lp.assemble(undamped())

    def stopped():
        with pytest.raises(SolverError, match="max_steps = 50") as caught:
            lp.simulate(system, method="steps", until=2.0, max_steps=50, grid=None)
        return caught.value.partial

    a, b = by_engines(stopped)
    assert 50 <= b.statistics.steps + b.statistics.rejected <= 51
    assert len(b.t) == b.statistics.steps + 1
    np.testing.assert_array_equal(a.x[: len(b.t)], b.x)
