"""Gradients of runs whose states are kept at some steps only: the same bits in less memory."""

import tracemalloc

import numpy as np
import pytest
from derivative_drives import DRIVES

import lumped as lp
from lumped import functionals as fun
from lumped.components import Inertia, SpringDamper, Torque
from lumped.gradients import legs
from lumped.timeloop.results.recorder import SparingRecorder


@pytest.fixture
def sparing(monkeypatch):
    """Bounds so small that hardly a state is kept."""

    def begin(kept=300, made=500):
        monkeypatch.setattr(legs, "_KEPT_BYTES", kept)
        monkeypatch.setattr(legs, "_MADE_BYTES", made)

    return begin


def chain(count):
    parts = {f"a{i}": Inertia(J=1.0 + 0.01 * i) for i in range(count)}
    parts |= {f"s{i}": SpringDamper(c=1e3, d=0.1) for i in range(count - 1)}
    order = [f"{kind}{i}" for i in range(count) for kind in "as"][:-1]
    model = lp.compose(
        load=Torque(tau=1.0),
        **parts,
        connections=lambda m: lp.chain(m.load, *(getattr(m, name) for name in order)),
    )
    return lp.assemble(model)


def same(one, other):
    names = ("values", "derivatives", "errors")
    return all((getattr(one, name) == getattr(other, name)).all() for name in names)


@pytest.mark.parametrize("method", ["explicit", "implicit"])
@pytest.mark.parametrize("name", DRIVES)
def test_drives_with_events_have_the_same_bits(name, method, sparing):
    system, of, to, until = DRIVES[name]()
    options = {"of": of, "by": to, "until": until, "method": method}
    whole = lp.gradient(system, **options)
    for made in (500, 4000):  # parts of a smooth part at once, and several of them
        sparing(made=made)
        found = lp.gradient(system, **options)
        assert len(found.run.t) < len(whole.run.t)
        assert found.run.steps == whole.run.steps
        assert same(found, whole)


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_a_smooth_drive_has_the_same_bits(method, sparing):
    system = chain(3)
    of = [
        fun.final("a0.w"),
        fun.peak("s0.tau"),
        fun.rms("s0.tau"),
        fun.integral("s1.tau", between=(0.3, 1.7)),
        fun.at_time(1.234, "a2.w"),
    ]
    options = {"by": ["a0.J", "s0.c"], "until": 3.0, "method": method}
    whole = lp.gradient(system, of=of, **options)
    for kept, made in ((300, 25_000_000), (50_000_000, 500), (300, 500), (3000, 3000)):
        sparing(kept, made)
        assert same(lp.gradient(system, of=of, **options), whole)


def peak(action):
    """Most memory that an action takes at once, bytes."""
    tracemalloc.start()
    try:
        action()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_memory_does_not_grow_with_the_states_of_all_steps(sparing):
    system = chain(40)
    options = {"by": ["a0.J"], "method": "explicit"}
    n, found = len(system.state_names), {}

    def differentiate(until):
        of = [fun.final("a0.w"), fun.peak("s0.tau"), fun.rms("s1.tau")]
        return lp.gradient(system, of=of, until=until, **options).run.steps

    steps = np.array([differentiate(until) for until in (30.0, 120.0)])
    states = 8 * n * np.diff(steps)[0]
    for bound in ("large", "small"):
        if bound == "small":
            sparing(200_000, 100_000)
        found[bound] = [peak(lambda t=until: differentiate(t)) for until in (30.0, 120.0)]
    growth = {bound: (late - early) / states for bound, (early, late) in found.items()}
    assert growth["large"] > 1.0
    assert growth["small"] < 0.35


def test_every_second_state_goes_when_there_is_no_room():
    system = chain(2)
    n = len(system.state_names)
    recorder = SparingRecorder(lp.start_point(system), 100.0, 8 * n * 40)
    recorder.open(system)
    t = np.arange(101.0)
    x = np.outer(t, np.ones(n))
    for begin in range(0, 101, 7):
        own = slice(begin, begin + 7)
        recorder.add(t[own], x[own], np.zeros((len(t[own]), 0)))
    (piece,) = recorder.pieces()
    assert (piece.ends == t).all()
    assert (piece.x[:, 0] == piece.t).all()
    assert piece.t[0] == 0
    assert piece.t[-1] == 100
    assert 20 <= len(piece.t) <= 42
    assert set(t[::4]) <= set(piece.t)
