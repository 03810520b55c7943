"""Units of FMI as components, against equations, closed forms and other solvers."""

import pickle

import numpy as np
import pytest
from imported_drives import PI, T_S, drive, unit_of

import lumped as lp
from lumped import errors
from lumped.components import SampledPI, from_fmu
from lumped.exchange import unit_process
from lumped.kernel import engine


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("kind", ["co_simulation", "model_exchange"])
def test_a_controller_as_a_unit_does_what_its_equations_do(exported, version, kind):
    options = {"until": 1.0, "grid": np.arange(0.5, 100) * T_S, "rtol": 1e-12}
    system = drive(unit_of(exported, version, kind), held=False)
    run = lp.simulate(system, **options)
    expected = lp.simulate(drive(PI(wanted=10.0), held=True), **options)
    error = np.abs(run["rotor.w"] - expected["rotor.w"]).max()
    assert error < 1e-9
    assert system.quantity("pi.M").unit == "N.m"
    assert system.quantity("pi.measured").unit == "rad/s"


class Sampling(lp.Component):
    """A controller in a computer, with the names of the other."""

    wanted: lp.Input = lp.Input("rad/s", "wanted speed")
    measured: lp.Input = lp.Input("rad/s", "measured speed")
    M = lp.Output("N.m", "torque")
    law = SampledPI(T_s=T_S, k=5.0, T_i=0.5)

    def connections(self):
        yield lp.connect(self.wanted, self.law.wanted)
        yield lp.connect(self.measured, self.law.measured)
        yield lp.connect(self.law.y, self.M)


def test_a_unit_that_samples_at_its_own_events_takes_the_inputs_of_the_instant(tmp_path):
    options = {"until": 1.0, "grid": np.arange(0.5, 100) * T_S, "rtol": 1e-12}
    expected = lp.simulate(drive(Sampling(wanted=10.0), held=False), **options)
    path = tmp_path / "sampling.fmu"
    signals = {"inputs": ["wanted", "measured"], "outputs": ["M"]}
    lp.export_fmu(lp.assemble(Sampling(wanted=0.0, measured=0.0)), path, **signals)
    for kind in ("co_simulation", "model_exchange"):
        unit = from_fmu(path, kind=kind, T_s=T_S, wanted=10.0)
        run = lp.simulate(drive(unit, held=False), **options)
        error = np.abs(run["rotor.w"] - expected["rotor.w"]).max()
        print(f"{kind}: largest deviation {error:.1e} rad/s")
        assert error < 1e-9


def test_parameters_of_a_unit_have_their_names_and_values(exported):
    equations, system = drive(PI(wanted=10.0), held=True), drive(unit_of(exported), held=False)
    for changes in ({"pi.k": 8.0}, {"pi.k": 3.0, "pi.T_i": 0.2}, {"pi.wanted": -4.0}):
        runs = [
            lp.simulate(s, until=0.5, rtol=1e-10, parameters=changes) for s in (equations, system)
        ]
        assert abs(runs[0]["rotor.w"][-1] - runs[1]["rotor.w"][-1]) < 1e-9
    gains = np.linspace(1, 9, 5)
    options = {"until": 0.5, "rtol": 1e-10, "of": {"w": lp.functionals.final("rotor.w")}}
    swept = [lp.sweep(s, over={"pi.k": gains}, **options)["w"] for s in (equations, system)]
    assert np.abs(swept[0] - swept[1]).max() < 1e-8


@pytest.mark.parametrize("kind", ["co_simulation", "model_exchange"])
def test_a_run_goes_on_where_its_unit_was(exported, kind):
    system = drive(unit_of(exported, kind=kind), held=False)
    whole = lp.simulate(system, until=1.0, rtol=1e-12)
    point = pickle.loads(pickle.dumps(whole.point(0.505)))
    rest = lp.simulate(point.system, start=point, until=1.0, rtol=1e-12)
    last = lp.simulate(point.system, start=rest.point(0.8), until=1.0, rtol=1e-12)
    errors = [abs(run["rotor.w"][-1] - whole["rotor.w"][-1]) for run in (rest, last)]
    assert max(errors) < 1e-9
    late = [
        lp.simulate(s, begin=1.0, until=1.5)["rotor.w"][-1]
        for s in (system, drive(PI(wanted=10.0), held=True))
    ]
    assert abs(late[0] - late[1]) < 1e-5
    assert late[0] > 5


def test_an_interrupt_leaves_no_answer_behind(exported, monkeypatch):
    system = drive(unit_of(exported), held=False)
    expected = lp.simulate(system, until=0.3)["rotor.w"]
    read, calls = unit_process.read, []

    def interrupted(stream):
        calls.append(stream)
        if len(calls) == 12:
            raise KeyboardInterrupt
        return read(stream)

    monkeypatch.setattr(unit_process, "read", interrupted)
    with pytest.raises(errors.Interrupted) as caught:
        lp.simulate(system, until=0.3)
    assert abs(caught.value.partial.t[-1] - 11 * T_S) < 1e-9
    assert np.array_equal(lp.simulate(system, until=0.3)["rotor.w"], expected)


def test_a_certificate_runs_a_unit_again(exported):
    run = lp.simulate(drive(unit_of(exported), held=False), until=0.3, certify=True)
    assert run.certificate["rotor.w"].relative < 1e-5


def test_all_engines_ask(exported):
    system = drive(unit_of(exported, "2.0"), held=False)
    found = []
    for name in ("llvm", "c", "python"):
        with engine.using(name):
            found.append(lp.simulate(system, until=0.1, grid=5)["rotor.w"])
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[0], found[2])


def test_a_drive_as_a_unit_is_the_drive(tmp_path):
    system = drive(PI(wanted=10.0), held=False)
    run = lp.simulate(system, until=1.0, rtol=1e-11, grid=50)
    names = ["rotor.w", "roll.w", "shaft.tau"]
    lp.export_fmu(system, tmp_path / "drive.fmu", outputs=names, rtol=1e-10)
    for kind in ("co_simulation", "model_exchange"):
        unit = from_fmu(tmp_path / "drive.fmu", kind=kind, T_s=0.02, rtol=1e-12)
        times = run.t[:-1] + 1e-3
        again = lp.simulate(lp.assemble(lp.compose(unit=unit)), until=1.0, grid=times)
        for name in names:
            given = again[f"unit.{name.replace('.', '_')}"]
            error = np.abs(given - run[name][:-1]).max() / np.abs(run[name]).max()
            print(f"{kind} {name}: {error:.1e} of its largest value")
            assert error < 1e-9


class Ball(lp.Component):
    """Falls from 1 m and bounces; ``h'' = -g``."""

    h: lp.Var = lp.var("m", "height", 1.0, state="always")
    v: lp.Var = lp.var("m/s", "its rate", state="always")
    g: lp.Param = lp.param("m/s2", "gravity", 9.81)
    e: lp.Param = lp.param("1", "restitution", 0.7)

    def equations(self):
        yield lp.der(self.h) == self.v
        yield lp.der(self.v) == -self.g
        yield lp.when(self.h < 0, {self.v: -self.e * self.v, self.h: 0.0})


def height(t, g=9.81, e=0.7):
    """Height after any number of bounces."""
    begin, h, v = 0.0, 1.0, 0.0
    while True:
        hit = (v + np.sqrt(v * v + 2 * g * h)) / g
        if begin + hit >= t:
            return h + v * (t - begin) - g * (t - begin) ** 2 / 2
        begin, h, v = begin + hit, 0.0, e * (g * hit - v)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_state_events_of_a_unit_between_samples(tmp_path, version):
    lp.export_fmu(lp.assemble(Ball()), tmp_path / "ball.fmu", version=version)
    times = np.arange(1, 40) * 0.05
    exact = [height(t) for t in times]
    for kind in ("co_simulation", "model_exchange"):
        path, signals = tmp_path / "ball.fmu", {"outputs": ["h"], "T_s": 0.05}
        unit = from_fmu(path, kind=kind, rtol=1e-12, **signals)
        run = lp.simulate(lp.assemble(lp.compose(unit=unit)), until=2.0, grid=times + 0.02)
        error = np.abs(run["unit.h"] - exact).max()
        print(f"{version} {kind}: {error:.1e} m after {len(run.events)} samples")
        assert error < 1e-8
