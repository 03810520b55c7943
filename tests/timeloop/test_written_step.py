"""Steps that are written out for one system: the same bits as steps in loops."""

import numpy as np
import pytest
from ensemble_runs import Alone, assert_same_bits
from linkages import four_bar
from rows import in_a_row, in_rows

import lumped as lp
from lumped import functionals as fun
from lumped.components import (
    Brake,
    CrankSlider,
    Fixed,
    Inertia,
    SpringDamper,
    Torque,
)
from lumped.kernel.engine import LANES
from lumped.many_runs.native_runs import NativeRuns
from lumped.ops import sin, where
from lumped.timeloop.plants import written_step
from lumped.timeloop.plants.executable import executable
from lumped.timeloop.plants.parts import parts_of
from lumped.timeloop.run_options import run_plan

FAR = 3e6
"""An angle whose sine is asked of the C library."""


def crank(phi):
    return in_a_row(
        drive=Torque(tau=5.0 + 3.0 * sin(7.0 * lp.time)),
        rotor=Inertia(J=0.4, phi=phi, w=2.0),
        shaft=SpringDamper(c=300.0, d=0.5),
        wheel=Inertia(J=0.3),
        crank=CrankSlider(r=0.1, L=0.4, m=2.0),
    )


MODELS = {
    "crank": lambda: crank(0.3),
    "far angles": lambda: crank(FAR),
    "crank that comes to far angles": lambda: crank(1e6 - 10.0),
    "linkage": lambda: four_bar(w=3.0),
    "brake and jumps": lambda: in_rows(
        "drive body brake",
        "body shaft wall",
        drive=Torque(tau=where(lp.time < 0.5, 4.0, -1.0)),
        body=Inertia(J=0.5, phi=0.0, w=1.0),
        brake=Brake(f_max=2.0, u=1.0, characteristic=((0.0, 1.0),)),
        shaft=SpringDamper(c=40.0, d=0.1),
        wall=Fixed(),
    ),
}


def assert_same(one, other):
    np.testing.assert_array_equal(one.t, other.t)
    np.testing.assert_array_equal(one.x, other.x)
    assert [e.time for e in one.events] == [e.time for e in other.events]
    assert one.statistics.steps == other.statistics.steps


def addresses(step):
    """That of its machine code, after none."""
    step.compile()
    found = step.function.address
    assert found
    for address in (0, found):
        step.function.address = step.function.wide_address = address
        yield address


@pytest.mark.parametrize("name", MODELS)
def test_a_run_has_the_same_bits(name):
    system = lp.assemble(MODELS[name]())
    options = {"until": 2.0, "rtol": 1e-7, "method": "explicit"}
    step = executable(system).written_step(1)
    one, other = [lp.simulate(system, **options) for _ in addresses(step)]
    assert_same(one, other)
    assert one.statistics.steps > 10


@pytest.mark.parametrize("name", ["crank", "crank that comes to far angles", "brake and jumps"])
def test_runs_with_integrals_have_the_same_bits(name):
    """One by one and side by side, whose steps look at what is integrated."""
    system = lp.assemble(MODELS[name]())
    body = "wheel" if "crank" in name else "body"
    of = {"rms": fun.rms("shaft.tau"), "peak": fun.peak("shaft.tau"), "end": fun.final(f"{body}.w")}
    points = np.linspace(0.9, 1.1, 19)[:, None] * system.parameters["shaft.c"]
    found = []
    for kind, lanes in ((Alone, 1), (NativeRuns, LANES)):
        plan = run_plan(2.0, 1e-7, {}).by_steps("ensemble")
        runs = kind(system, ("shaft.c",), system.theta(None), of, plan)
        found += [runs.run(points) for _ in addresses(runs.written_step(lanes))]
    for other in found[1:]:
        assert_same_bits(found[0], other)


def test_it_is_made_when_steps_took_as_long(monkeypatch):
    monkeypatch.setattr(written_step, "_WORTH", 100)
    monkeypatch.setattr(written_step, "load_written", lambda *_: None)
    system = lp.assemble(crank(0.3))
    rates = parts_of(system)[0]["rates"]
    step = written_step.WrittenStep(rates, len(system.state_names), LANES, None)
    for attempts, is_made in ((100 * LANES, False), (1, True)):
        step.account(attempts)
        assert bool(step.function.address) == is_made


def test_long_steps_are_not_written_out():
    bodies = {f"b{i}": Inertia(J=1.0) for i in range(80)}
    shafts = {f"s{i}": SpringDamper(c=100.0, d=0.1) for i in range(79)}
    row = " ".join(f"b{i} s{i}" for i in range(79)) + " b79"
    step = executable(lp.assemble(in_rows(row, **bodies, **shafts))).written_step(1)
    step.compile()
    assert not step.function.address
