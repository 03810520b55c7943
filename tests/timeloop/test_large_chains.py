"""Chains of many bodies: what follows what, and Jacobians found along directions."""

from dataclasses import replace

import numpy as np
import pytest
import scipy

import lumped as lp
from lumped.timeloop.levers import FAIR_LEVERAGE, levers
from lumped.timeloop.plants import executable as plants
from lumped.timeloop.plants.executable import evaluate_at, executable


class Point(lp.Component):
    """A mass in a plane."""

    px = lp.LinearFlange(free=True)
    py = lp.LinearFlange(free=True)
    x: lp.Var = lp.var("m", "across")
    y: lp.Var = lp.var("m", "up")

    def equations(self):
        yield self.px.s == self.x
        yield self.py.s == self.y
        yield lp.der(lp.der(self.x)) == self.px.f
        yield lp.der(lp.der(self.y)) == self.py.f - 9.81


class Rod(lp.Component):
    """A rod without mass between two points of a plane."""

    ax = lp.LinearFlange(grounded=True)
    ay = lp.LinearFlange(grounded=True)
    bx = lp.LinearFlange()
    by = lp.LinearFlange()
    pull: lp.Var = lp.var("N/m", "force over its length")

    def equations(self):
        x, y = self.bx.s - self.ax.s, self.by.s - self.ay.s
        yield x**2 + y**2 == 1.0
        yield self.bx.f == self.pull * x
        yield self.by.f == self.pull * y
        yield self.ax.f == -self.pull * x
        yield self.ay.f == -self.pull * y


def hang(count, angles):
    x, y = np.cumsum(np.sin(angles)), -np.cumsum(np.cos(angles))
    points = [Point(x=float(a), y=float(b)) for a, b in zip(x, y, strict=True)]

    def join(m):
        for i in range(count):
            after = m.rod[i + 1 : i + 2]
            yield lp.connect(m.rod[i].bx, m.point[i].px, *(rod.ax for rod in after))
            yield lp.connect(m.rod[i].by, m.point[i].py, *(rod.ay for rod in after))

    rods = [Rod() for _ in range(count)]
    return lp.compose(point=points, rod=rods, connections=lambda m: list(join(m)))


def test_bodies_of_a_long_chain_are_watched_by_their_own_states():
    """A rod at the angle a from the vertical: its end rises by tan a of what it moves across."""
    count = 45
    angles = np.linspace(-1.2, 1.3, count)
    system = lp.assemble(hang(count, angles))
    pairs, _ = levers(system, 1.0)
    assert len(pairs) == 2 * count - 1
    run = lp.simulate(system, until=1e-9, grid=[0.0])
    x = np.array([run[name][0] for name in system.state_names])
    y = np.array([run[system.structure.node_name(n)][0] for n in system.structure.implicit])
    modes = np.zeros(system.structure.mode_count)
    theta, settings = system.theta(None), np.concatenate([modes, y])
    found = FAIR_LEVERAGE * evaluate_at(system, "leverage", x, theta, 0.0, settings)
    names = [tuple(map(system.structure.node_name, pair)) for pair in pairs]
    ratios = dict(zip(names, found, strict=True))
    for i, angle in enumerate(angles):
        assert ratios[f"point[{i}].y", f"point[{i}].x"] == pytest.approx(np.tan(angle), rel=1e-9)
        if i:
            before = ratios[f"point[{i}].y", f"point[{i - 1}].x"]
            assert before == pytest.approx(-np.tan(angle), rel=1e-9)


COUNT = 12


class Mixed(lp.Component):
    """x' = cos 3t - k x + 0.1 S - x^3, S the sum of all x, with k from 1 to 4000."""

    locals().update({f"x{i}": lp.var("1", "mixed", 1.0) for i in range(COUNT)})

    def equations(self):
        x = [getattr(self, f"x{i}") for i in range(COUNT)]
        for k, own in zip(np.geomspace(1, 4000, COUNT).tolist(), x, strict=True):
            yield lp.der(own) == lp.ops.cos(3 * lp.time) - k * own + 0.1 * sum(x) - own**3


def test_a_jacobian_along_directions_makes_the_steps_of_one_in_a_table(monkeypatch):
    options = {"until": 2.0, "grid": [2.0], "rtol": 1e-7, "method": "implicit"}
    names = [f"x{i}" for i in range(COUNT)]
    k = np.geomspace(1, 4000, COUNT)
    exact = scipy.integrate.solve_ivp(
        lambda t, x: np.cos(3 * t) - k * x + 0.1 * x.sum() - x**3,
        (0.0, 2.0),
        np.ones(COUNT),
        method="Radau",
        rtol=1e-11,
        atol=1e-13,
    ).y[:, -1]
    runs = []
    for large in (0, 30_000):
        monkeypatch.setattr(plants, "_LARGE", large)
        system = lp.assemble(Mixed())
        runs.append(lp.simulate(system, **options))
        colours = executable(system)._pattern.colours
        assert colours == (0 if large else COUNT)
    along, table = ([run[name][-1] for name in names] for run in runs)
    np.testing.assert_allclose(along, exact, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(along, table, rtol=1e-10, atol=1e-13)
    assert runs[0].statistics.steps == runs[1].statistics.steps


def test_what_stages_need_is_compiled_before_a_large_jacobian(monkeypatch, tmp_path):
    """Work worth twice the rates compiles them, and not what is a hundred times as large."""
    monkeypatch.setenv("LUMPED_CACHE", str(tmp_path))
    system = lp.assemble(hang(3, np.array([0.3, 0.2, 0.1])))
    code = executable(system)
    run = code.blank_run()
    often = sum(len(code._operations[name].table) for name in ("rates", "closure"))
    run.interpreted = 2 * plants.WORTH * often
    monkeypatch.setitem(code._operations, "leverage", _repeat(code._operations["leverage"], 100))
    code.account(run)
    assert code.plant.rates.address
    assert code.plant.closure.address
    assert not code.plant.leverage.address
    run.interpreted = 200 * plants.WORTH * often
    code.account(run)
    assert code.plant.leverage.address


def _repeat(function, times):
    return replace(function, table=np.tile(function.table, (times, 1)))
