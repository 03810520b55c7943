"""Models, runs and errors that travel to other processes and go on there."""

import copy
import functools
import multiprocessing
import pickle
import subprocess
import sys

import numpy as np
import pytest
from test_copies import WAYS, Drive, composed, linear, made, same

import lumped as lp
from lumped.components import (
    Torque,
)
from lumped.errors import Interrupted, LumpedError, OptimisationError, OptionError, SolverError
from lumped.ops import table


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("model", [composed, linear, Drive])
def test_a_copied_system_runs_to_the_same_last_bit(way, model):
    system = lp.assemble(model(), keep=["b.phi"] if model is Drive else ())
    options = {"until": 1.0, "method": "steps", "rtol": 1e-7}
    run = lp.simulate(system, **options)
    for twin in (WAYS[way](system), lp.assemble(WAYS[way](model()), keep=system.origin[2])):
        other = lp.simulate(twin, **options)
        assert other.t.tobytes() == run.t.tobytes()
        assert other.x.tobytes() == run.x.tobytes()
        assert other.events == run.events
    again = WAYS[way](run)
    for name in run:
        assert again[name].tobytes() == run[name].tobytes()
    on = lp.modes(again.system, at=again.point(1.0))
    assert (on.hertz == lp.modes(system, at=run.point(1.0)).hertz).all()
    assert again.plot([*run][:1]).axes[0].get_lines()


def test_a_copied_run_with_other_leading_states_goes_on():
    """A pendulum in Cartesian coordinates changes its states; each piece has its own system."""

    class Pendulum(lp.Component):
        x = lp.var("m", "horizontal", 1.0)
        y = lp.var("m", "vertical")
        v = lp.var("m/s", "horizontal speed")
        u = lp.var("m/s", "vertical speed")
        S = lp.var("N", "force")

        def equations(self):
            yield lp.der(self.x) == self.v
            yield lp.der(self.y) == self.u
            yield lp.der(self.v) == -self.S * self.x
            yield lp.der(self.u) == -self.S * self.y - 9.81
            yield self.x**2 + self.y**2 == 1.0

    run = lp.simulate(lp.assemble(Pendulum()), until=2.0)
    assert len({id(piece.system) for piece in run.pieces}) > 1
    for way in WAYS.values():
        twin = way(run)
        assert (twin["S"] == run["S"]).all()
        assert len({id(p.system) for p in twin.pieces}) == len({id(p.system) for p in run.pieces})


def test_other_processes_that_are_started_anew_compute_the_same():
    system = lp.assemble(linear().with_({"b.w": 1.0}))
    expected = lp.simulate(system, until=1.0, method="steps")
    simulate = functools.partial(lp.simulate, until=1.0, method="steps")
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        there = pool.map(simulate, [system, lp.assemble(Drive())])
        with pytest.raises(SolverError) as error:
            pool.apply(lp.simulate, (system,), {"until": 1.0, "method": "steps", "max_steps": 2})
    assert there[0].x.tobytes() == expected.x.tobytes()
    assert (there[0]["wheel.tau"] == expected["wheel.tau"]).all()
    assert error.value.partial.t[-1] < 1.0
    assert there[1].events == lp.simulate(lp.assemble(Drive()), until=1.0).events


def test_a_model_from_a_script_is_read_by_another(tmp_path):
    script = tmp_path / "write.py"
    script.write_text(
        "import pickle, sys\n"
        "import lumped as lp\n"
        "from lumped.components import Fixed, Inertia, Spring\n"
        "class Rig(lp.Component):\n"
        "    '''A body on a spring.'''\n"
        "    c: lp.Param = lp.param('N.m/rad', 'stiffness', 4.0)\n"
        "    body: Inertia = Inertia(J=1.0, w=1.0)\n"
        "    spring: Spring = Spring(c=c)\n"
        "    wall: Fixed = Fixed()\n"
        "    def connections(self):\n"
        "        yield from lp.chain(self.body, self.spring, self.wall)\n"
        "run = lp.simulate(lp.assemble(Rig()), until=1.0, method='exact')\n"
        "pickle.dump((Rig(c=9.0), run), open(sys.argv[1], 'wb'))\n"
    )
    file = tmp_path / "rig.pickle"
    subprocess.run([sys.executable, script, file], check=True)
    rig, run = pickle.loads(file.read_bytes())
    assert run["body.w"][-1] == pytest.approx(np.cos(2.0), rel=1e-9)
    twin = lp.simulate(lp.assemble(rig), until=1.0, method="exact")
    assert twin["body.w"][-1] == pytest.approx(np.cos(3.0), rel=1e-9)


def test_without_cloudpickle_a_model_that_can_be_imported_still_travels(monkeypatch):
    monkeypatch.setitem(sys.modules, "cloudpickle", None)
    assert same(pickle.loads(pickle.dumps(Drive())), Drive())
    with pytest.raises(OptionError, match=r"pickle Model.*pip install lumped\[cluster\]"):
        pickle.dumps(composed())
    assert copy.deepcopy(lp.assemble(linear())).state_names


def test_a_long_table_and_parts_by_reference_travel():
    rows = 3000
    tau = table(np.linspace(0.0, 1.0, rows).tolist(), np.sin(np.arange(rows)).tolist())
    one = Drive(motor=Torque(tau=tau))
    rig = Drive()
    for model in (one, rig.with_({"shaft.c": 30.0}), rig.shaft):
        assert same(pickle.loads(pickle.dumps(model)), model)
    reference = pickle.loads(pickle.dumps(rig.shaft.tau))
    run = made()["Trajectory"]
    assert (run[reference] == run["shaft.tau"]).all()


def test_errors_travel_with_what_they_hold():
    run = made()["Trajectory"]
    errors = [kind("text") for kind in subclasses(LumpedError) if kind is not OptimisationError]
    errors += [OptimisationError("text", "status"), Interrupted("text", run)]
    errors += [SolverError("text", run)]
    for error in errors:
        twin = pickle.loads(pickle.dumps(error))
        assert (type(twin), str(twin)) == (type(error), "text")
        assert same(getattr(twin, "partial", None), getattr(error, "partial", None))
        assert getattr(twin, "status", "") == getattr(error, "status", "")


def subclasses(kind):
    found = kind.__subclasses__()
    return [*found, *(one for below in found for one in subclasses(below))]
