"""A run gives the bits that a newly assembled system gives, whatever ran before or runs beside."""

import itertools
import random
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from threading import Barrier

import numpy as np
import pytest
from linkages import double_rocker
from machine_scenes import SCENES

import lumped as lp
from lumped.components import Clutch, CrankSlider, Inertia, SpringDamper, Torque
from lumped.errors import Interrupted, LumpedError
from lumped.ops import sin, where
from lumped.timeloop.run_by_steps import RunBySteps

THREADS = 6


class Smooth(lp.Component):
    """Two masses on a damped shaft; its damping follows from its stiffness."""

    c: lp.Param = lp.param("N.m/rad", "stiffness", 4e3, above=0)
    a: Inertia = Inertia(J=0.5)
    shaft: SpringDamper = SpringDamper(c=c, d=1e-3 * c)
    b: Inertia = Inertia(J=2.0)
    motor: Torque = Torque(tau=20.0)

    def connections(self):
        """In a row."""
        yield from lp.chain(self.motor, self.a, self.shaft, self.b)


class Switched(lp.Component):
    """A torque that changes at given instants, a clutch that sticks, and a crank."""

    at: lp.Param = lp.param("s", "instant of the step", 0.1)
    rate: lp.Param = lp.param("rad/s", "rate of the torque", 40.0)
    drive: Torque = Torque(
        tau=where(lp.time >= at, 3.0, 9.0) + where(sin(rate * lp.time) > 0.5, 1, 0)
    )
    motor: Inertia = Inertia(J=0.4, w=5.0)
    clutch: Clutch = Clutch(f_max=8.0, u=1.0)
    wheel: Inertia = Inertia(J=1.0)
    crank: CrankSlider = CrankSlider(r=0.1, L=0.4, m=2.0)

    def connections(self):
        """In a row."""
        yield from lp.chain(self.drive, self.motor, self.clutch, self.wheel, self.crank)


def common(until):
    """Options that each kind of run has, in all combinations of methods and output."""
    methods, grids = ("steps", "explicit", "implicit"), ([until], 15, None)
    return [{"until": until, "method": m, "grid": g} for m in methods for g in grids]


CALLS = {
    Smooth: [
        *({**o, "parameters": p} for o in common(0.2) for p in ({}, {"c": 6e3}, {"motor.tau": 7})),
        *(
            {"until": 0.2, "method": m, "start": {"a.w": w}}
            for m in ("taylor", "auto")
            for w in (0, 3)
        ),
        {"until": 0.2, "method": "taylor", "parameters": {"c": 6e3}},
        {"until": 0.2, "method": "taylor", "rtol": 1e-9, "grid": [0.1, "150 ms"]},
        {"until": 0.2, "method": "taylor", "rtol": 1e-9, "atol": 1e-7, "begin": 0.05},
        {"until": 0.2, "method": "explicit", "max_steps": 3},
        {"until": 0.2, "parameters": {"c": -1.0}},
        {"until": 0.2, "parameters": {"a.J": 0.0}},
        {"until": 0.2, "parameters": {"shaft.c": 1.0}},
        {"until": 0.2, "grid": [0.1, 0.3]},
    ],
    Switched: [
        *({**o, "parameters": p} for o in common(0.3) for p in ({}, {"at": 0.2, "motor.J": 0.5})),
        {"until": 0.3, "parameters": {"rate": 60.0}, "begin": 0.02},
        {"until": 0.3, "parameters": {"rate": 60.0, "crank.r": 0.15}, "rtol": 1e-8},
        {"until": 0.3, "start": {"motor.w": 1.0, "wheel.w": 1.0}},
        {"until": 0.3, "method": "steps", "max_steps": 5},
        {"until": 0.3, "parameters": {"crank.r": 0.5}},
    ],
    double_rocker: [
        *({**o, "until": 1.0} for o in common(1.0)),
        {"until": 2.0, "method": "steps", "rtol": 1e-7},
    ],
}
MODELS = {Smooth: Smooth, Switched: Switched, double_rocker: lambda: double_rocker(w=3.0)}
kinds = pytest.mark.parametrize("kind", CALLS, ids=lambda kind: kind.__name__)


def content(run):
    """All of a run but the time that it took."""
    pieces = [[(v.shape, v.tobytes()) for v in (p.t, p.x, p.settings)] for p in run.pieces]
    return pieces, run.events, replace(run.statistics, seconds=0.0), run.theta.tobytes()


def outcome(system, options):
    """What a call gives, or its error and the run so far."""
    try:
        return content(lp.simulate(system, **options))
    except LumpedError as error:
        partial = getattr(error, "partial", None)
        return type(error), str(error), None if partial is None else content(partial)


@cache
def fresh(kind):
    """What each call gives as the first one of a system."""
    return [outcome(lp.assemble(MODELS[kind]()), options) for options in CALLS[kind]]


@kinds
def test_runs_in_any_order_are_those_of_new_systems(kind):
    expected, system = fresh(kind), lp.assemble(MODELS[kind]())
    assert len({repr(e) for e in expected}) > len(expected) // 2
    order = [*range(len(expected))] * 2
    random.Random(4).shuffle(order)
    for k in [*order, *np.repeat(order[:6], 3).tolist()]:
        assert outcome(system, CALLS[kind][k]) == expected[k], CALLS[kind][k]


@kinds
def test_threads_that_run_different_calls_find_what_new_systems_find(kind):
    expected, system = fresh(kind), lp.assemble(MODELS[kind]())
    barrier = Barrier(THREADS)

    def work(seed):
        order = random.Random(seed).choices(range(len(expected)), k=15)
        barrier.wait()
        return [(k, outcome(system, CALLS[kind][k])) for k in order]

    with ThreadPoolExecutor(THREADS) as pool:
        for k, received in itertools.chain(*pool.map(work, range(THREADS))):
            assert received == expected[k], CALLS[kind][k]


@pytest.mark.parametrize("name", SCENES)
def test_a_machine_runs_again_as_it_ran_first(name):
    first = SCENES[name](grid=20, method="steps")
    point, until = first.point(0.0), float(first.t[-1])
    options = {"until": until, "start": point, "grid": 20, "method": "steps"}
    again = [lp.simulate(point.system, **options) for _ in range(2)]
    lp.simulate(point.system, **{**options, "until": 0.5 * until, "grid": None})
    again.append(lp.simulate(point.system, **options))
    assert len({repr(content(run)) for run in again}) == 1


def test_later_runs_and_changed_results_leave_other_runs_alone():
    system = lp.assemble(Switched())
    options = {"until": 0.3, "method": "steps", "grid": 30}
    first = lp.simulate(system, **options)
    expected = content(first)
    second = lp.simulate(system, **options)
    lp.simulate(system, **options, parameters={"at": 0.15})
    assert content(first) == content(second) == expected
    for piece in second.pieces:
        for values in (piece.t, piece.x, piece.settings):
            values[:] = -1.0
    second.theta[:] = -1.0
    assert content(lp.simulate(system, **options)) == content(first) == expected


def test_an_interrupted_run_leaves_the_next_one_alone(monkeypatch):
    system = lp.assemble(Smooth())
    options = {"until": 0.2, "method": "steps", "grid": 30}
    expected = content(lp.simulate(system, **options))

    def interrupted(_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(RunBySteps, "_drain", interrupted)
        with pytest.raises(Interrupted):
            lp.simulate(system, **options)
    assert content(lp.simulate(system, **options)) == expected
