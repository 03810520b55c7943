"""Steps of a run in stretches, and functions between their ends."""

import casadi as ca
import numpy as np
import pytest
from derivative_drives import DRIVES
from scipy.linalg import expm

import lumped as lp
from lumped.components import Inertia, SpringDamper
from lumped.gradients import legs
from lumped.gradients.readings.samples import sample_steps, values_at
from lumped.gradients.steps import steps_of
from lumped.gradients.stretches import stretches
from lumped.simulation.simulate import simulate
from lumped.timeloop.plants.many_points import ManyPoints


def stiff_run():
    """A run that turns to implicit steps, what it looks at, and the speed of `a` in closed form."""
    J_a, J_b, c, d, w = 0.5, 2.0, 800.0, 3e4, 3.0
    system = lp.assemble(
        lp.compose(
            a=Inertia(J=J_a, w=w),
            shaft=SpringDamper(c=c, d=d),
            b=Inertia(J=J_b),
            connections=lambda m: lp.chain(m.a, m.shaft, m.b),
        )
    )
    run = simulate(system, until=0.5, grid=None, rtol=1e-9)
    look = ManyPoints(ca.Function("look", system.inputs, [system.expressions(["a.w"])]))
    A = np.array([[-d / J_a, d / J_a, c / J_a], [d / J_b, -d / J_b, -c / J_b], [-1.0, 1.0, 0.0]])
    return run, look, lambda t: (expm(A * t) @ np.array([w, 0.0, 0.0]))[0]


def test_values_at_times_in_any_order_over_a_change_of_the_method():
    run, look, speed = stiff_run()
    assert 0 < run.statistics.methods[1].begin < 0.5
    own = legs.legs_of(run)
    # the latest first: the last of the shorter steps is an explicit one
    times = np.concatenate([np.linspace(0.49, 1e-5, 23), own[0].t[[-1, 0]]])
    steps, numbers = steps_of(run.system, ()), np.zeros(len(times), dtype=int)
    found = values_at(run, own, steps, look, numbers, times)[:, 0]
    error = np.abs(found - [speed(t) for t in times]).max()
    print(f"\nlargest error of a speed of 3 rad/s: {error:.1e}")
    assert error < 1e-6


def test_samples_over_a_change_of_the_method_follow_a_matrix_exponential():
    run, look, speed = stiff_run()
    own, error = legs.legs_of(run), 0.0
    for samples in sample_steps(own, steps_of(run.system, ()), look):
        expected = np.vectorize(speed)(samples.t)
        error = max(error, float(np.abs(samples.values[:, :, 0] - expected).max()))
    print(f"\nlargest error of a speed of 3 rad/s: {error:.1e}")
    assert error < 1e-6


@pytest.mark.parametrize("name", ["play_with_rigid_flanks", "stick_slip_with_stribeck"])
@pytest.mark.parametrize("rows", [1, 3, 17, 10**6])
def test_each_step_and_each_change_is_in_one_stretch(name, rows, monkeypatch):
    system, _, _, until = DRIVES[name]()
    own = legs.legs_of(simulate(system, until=until, grid=None))
    width = sum(len(side) for side in own[0].side(0)) + 1
    monkeypatch.setattr(legs, "_MADE_BYTES", 8 * width * rows)
    found = stretches(own)
    steps, changes = [], []
    for stretch in found:
        span = stretch.span(own)
        assert stretch.ends == len(span.t)
        assert (np.diff(span.t)[span.is_step == 0] == 0).all()
        steps += span.t[:-1][span.is_step == 1].tolist()
        changes += span.t[:-1][span.is_step == 0].tolist()
    assert steps == [t for leg in own for t in leg.t[:-1].tolist()]
    assert changes == [leg.t[0] for leg in own[1:]]
    for number, leg in enumerate(own):
        for t in leg.t.tolist():
            places = [stretch.place(own, number, t) for stretch in found]
            (place,) = (p for p in places if p is not None)
            (stretch,) = (s for s, p in zip(found, places, strict=True) if p is not None)
            assert stretch.span(own).t[place] == t
    assert len(found) == 1 if rows == 10**6 else len(found) > 1
