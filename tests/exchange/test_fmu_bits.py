"""Exported models make the same run as `simulate`, to the last bit."""

import numpy as np
import pytest
from bits import Unit, reachable, states_of_run, states_of_unit
from machine_scenes import SCENES, asked
from random_drives import RandomDrive
from stiff_in_turn import UNTIL, InTurn
from test_friction_random import CROWDED, Net

import lumped as lp
from lumped.components import Fixed, Inertia, SpringDamper, Torque
from lumped.ops import sin, where
from lumped.timeloop.clocks import clocks

METHODS = ("auto", "implicit")


def assert_same(folder, system, times, *, method="auto", version="2.0", start=None, rtol=1e-6):
    path = folder / "unit.fmu"
    options = {"version": version, "kind": "co_simulation", "method": method}
    if not path.exists():
        lp.export_fmu(system, path, start=start or {}, **options)
    if any(clock.moves and not clock.even for clock in clocks(system)):
        system = system.without_foresight()
    times = reachable(times)
    expected, run = states_of_run(system, times, method=method, rtol=rtol, start=start or {})
    received = states_of_unit(path, system, times, rtol=rtol)
    np.testing.assert_array_equal(received, expected)
    return run


@pytest.mark.parametrize(("seed", "freewheels"), [(100, 0.0), *((i, 0.4) for i in CROWDED[:2])])
def test_random_nets_of_friction(tmp_path, seed, freewheels):
    net = Net(seed, freewheels)
    count = len(net.J)
    w, rates = net.rng.uniform(-3.0, 3.0, count), net.rng.uniform(2.0, 9.0, count)
    if freewheels:
        w, rates = np.ones(count), 3.0 + np.arange(count)
    drives = [q * sin(b * lp.time) for q, b in zip(net.Q.tolist(), rates.tolist(), strict=True)]
    system = lp.assemble(net.model(w.tolist(), drives))
    assert_same(tmp_path, system, np.linspace(0.0, 2.0, 21))


@pytest.mark.parametrize(("seed", "method"), [(0, "auto"), (2, "implicit")])
def test_random_drives(tmp_path, seed, method):
    drive = RandomDrive(seed)
    names = [f"body{i}.phi" for i in range(len(drive.shafts))]
    system = lp.assemble(drive.model(), keep=names)
    times = np.linspace(0.0, 1.5, 61)
    assert_same(tmp_path, system, times, method=method, version="3.0")


@pytest.mark.parametrize(
    ("name", "method"),
    [*((name, "auto") for name in SCENES), ("coiler, gears", "implicit"), ("shear", "implicit")],
)
def test_the_five_machines(tmp_path, name, method):
    system, options = asked(name)
    system = lp.assemble(system.model.with_(dict(options.get("parameters") or {})))
    times, start = np.linspace(0.0, options["until"], 101), options.get("start")
    assert_same(tmp_path, system, times, method=method, start=start, rtol=1e-8)


def chain_of(bodies, drive):
    return lp.compose(
        drive=Torque(tau=drive),
        body=[Inertia(J=1e-3) for _ in range(bodies)],
        shaft=[SpringDamper(c=1e4, d=100.0) for _ in range(bodies)],
        wall=Fixed(),
        connections=lambda m: lp.chain(
            m.drive, *(p for pair in zip(m.body, m.shaft, strict=True) for p in pair), m.wall
        ),
    )


@pytest.mark.parametrize("method", METHODS)
def test_a_stiff_drive_with_many_states(tmp_path, method):
    """By itself the unit changes over to implicit steps, with sparse factors."""
    system = lp.assemble(chain_of(60, 10.0 * sin(lp.time)))
    assert len(system.state_names) >= 120
    run = assert_same(tmp_path, system, np.linspace(0.0, 3.0, 31), method=method)
    assert run.statistics.method.endswith("implicit")


def test_a_drive_that_is_stiff_and_soft_in_turn(tmp_path):
    """By itself the unit changes over to implicit steps and back, again and again."""
    system = lp.assemble(InTurn(cubic=1e3))
    run = assert_same(tmp_path, system, np.linspace(0.0, UNTIL, 41))
    methods = [used.method for used in run.statistics.methods]
    assert methods == 2 * ["explicit", "implicit"]


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_communication_points_at_instants_and_many_in_one_step(tmp_path, version):
    """Before, at and after an instant; a point at an instant shows what holds after it."""
    torque = where(lp.time >= 0.5, where(lp.time >= 1.0, 0.3, -2.0), 1.0)
    system = lp.assemble(chain_of(3, torque))
    close = [0.5 - 1e-9, 0.5, 0.5 + 1e-9, 0.75, 1.0]
    times = np.sort(np.concatenate([np.linspace(0.0, 0.4, 401), close]))
    assert_same(tmp_path, system, times, version=version)
    assert_same(tmp_path, system, np.array([0.0, 1.0]), version=version)


# -- what only a unit does -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    path = tmp_path_factory.mktemp("driven") / "unit.fmu"
    system = lp.assemble(chain_of(2, 1.0))
    lp.export_fmu(system, path, version="2.0", inputs=["drive.tau"])
    return path, system


def test_a_unit_that_is_set_back_goes_the_same_way_again(driven):
    path, system = driven
    unit = Unit(path, stop=1.0)
    names = system.state_names

    def steps(times):
        found = []
        for begin, end in zip(times[:-1].tolist(), times[1:].tolist(), strict=True):
            unit.step(begin, end)
            found.append(unit.get(names))
        return np.array(found)

    first, second = reachable(np.linspace(0, 0.5, 6)), reachable(np.linspace(0.5, 1.0, 51))
    before = steps(first)
    kept = unit.fmu.getFMUState()
    stored = unit.fmu.serializeFMUState(kept)
    once = steps(second)
    unit.fmu.setFMUState(kept)
    np.testing.assert_array_equal(steps(second), once)
    unit.fmu.setFMUState(unit.fmu.deSerializeFMUstate(stored))
    np.testing.assert_array_equal(steps(second), once)
    unit.fmu.freeFMUState(kept)
    unit.fmu.reset()
    unit.fmu.setupExperiment(startTime=0.0, stopTime=1.0)
    unit.fmu.enterInitializationMode()
    unit.fmu.exitInitializationMode()
    np.testing.assert_array_equal(steps(first), before)
    np.testing.assert_array_equal(steps(second), once)
    unit.close()
