"""Sample and hold, sampled controllers and integrators against what they compute by hand."""

import itertools

import numpy as np
import pytest
from rows import assemble_rows

import lumped as lp
from lumped.components import (
    Gain,
    Inertia,
    Integrator,
    SampledPI,
    SampleHold,
    SpeedSensor,
    Sum,
    Torque,
)

SIGNAL = 1.0 + lp.ops.sin(3 * lp.time)


def signal(t):
    return 1.0 + np.sin(3 * np.asarray(t))


def between(period, until):
    """A time inside each sampling interval."""
    return period * (np.arange(round(until / period)) + 0.37)


@pytest.mark.parametrize("order", list(itertools.permutations("abc")))
def test_a_value_passes_through_all_that_sample_then_in_any_order_of_the_parts(order):
    """As an algorithm does; one that hands on what was there before is late by a period."""
    parts = {name: SampleHold(T_s=0.1) for name in order}
    parts["a"] = SampleHold(T_s=0.1, u=SIGNAL)
    system = assemble_rows("a.y gain.u", "gain.y b.u", "b.y c.u", **parts, gain=Gain(k=2.0))
    t = between(0.1, 2.0)
    run = lp.simulate(system, until=2.0, grid=t)
    at = np.floor(t / 0.1) * 0.1
    for name, factor in (("a", 1), ("b", 2), ("c", 2)):
        error = np.abs(run[f"{name}.y"] - factor * signal(at)).max()
        print(f"{name}: {error:.1e}")
        assert error < 1e-12


@pytest.mark.parametrize("begin", [0.1, 0.3, 1.0, 1.03, 17.0, 17.0999])
def test_a_run_that_begins_later_samples_at_the_next_instant(begin):
    """Instants are ``0.05 + 0.1 k``; before the first the output is held as it was given."""
    model = lp.compose(hold=SampleHold(T_s=0.1, start_time=0.05, u=SIGNAL))
    t = begin + between(0.1, 1.0)
    run = lp.simulate(lp.assemble(model), begin=begin, until=begin + 1, grid=t)
    last = 0.05 + 0.1 * np.floor((t - 0.05) / 0.1)
    exact = np.where(last >= begin - 1e-9, signal(last), 0.0)
    assert np.abs(run["hold.y"] - exact).max() < 1e-12
    assert len(run.events) == 10


def test_a_slower_one_takes_every_third_value():
    fast, slow = SampleHold(T_s=0.25, u=SIGNAL), SampleHold(T_s=0.75, start_time=0.5)
    system = assemble_rows("fast.y slow.u", fast=fast, slow=slow)
    t = between(0.25, 5.0)
    run = lp.simulate(system, until=5.0, grid=t, start={"slow.held": -7.0})
    last = 0.5 + 0.75 * np.floor((t - 0.5) / 0.75)
    expected = np.where(t < 0.5, -7.0, signal(last))
    assert run["slow.y"] == pytest.approx(expected, abs=1e-12)


def test_sampled_controllers_in_cascade_use_the_newest_value():
    """The inner one takes what the outer one puts out at the same instant."""
    k, T_i, T_s = (2.0, 0.5), (0.4, 0.3), 0.05
    system = assemble_rows(
        "outer.y inner.wanted",
        outer=SampledPI(k=k[0], T_i=T_i[0], T_s=T_s, wanted=SIGNAL, measured=0.3),
        inner=SampledPI(k=k[1], T_i=T_i[1], T_s=T_s, measured=0.1),
    )
    t = between(T_s, 1.0)
    run = lp.simulate(system, until=1.0, grid=t)
    x, rows = [0.0, 0.0], []
    for n in range(len(t)):
        row, value = [], float(signal(n * T_s))
        for i, measured in enumerate((0.3, 0.1)):
            e = value - measured
            x[i] += T_s / T_i[i] * e
            value = k[i] * (x[i] + e)
            row.append(value)
        rows.append(row)
    expected = np.array(rows)
    received = np.stack([run["outer.y"], run["inner.y"]], axis=1)
    assert received == pytest.approx(expected, rel=1e-11)


def test_an_integrator_integrates():
    area = Integrator(u=lp.ops.cos(2 * lp.time), k=3.0, x=0.5)
    system = assemble_rows("area.y drift.u", area=area, drift=Integrator())
    run = lp.simulate(system, until=4.0, rtol=1e-10, atol=1e-12)
    assert run["area.y"] == pytest.approx(0.5 + 1.5 * np.sin(2 * run.t), abs=1e-9)
    expected = 0.5 * run.t + 0.75 * (1 - np.cos(2 * run.t))
    assert run["drift.y"] == pytest.approx(expected, abs=1e-9)


def test_a_ring_within_one_instant_is_solved_as_a_loop():
    """``y = y / 2 + 1 + t`` at each sample."""
    added, hold = Sum(b=1.0 + lp.time, k_a=0.5), SampleHold(T_s=0.1)
    system = assemble_rows("sum.y hold.u", "hold.y sum.a", sum=added, hold=hold)
    t = between(0.1, 1.0)
    run = lp.simulate(system, until=1.0, grid=t)
    assert run["hold.y"] == pytest.approx(2 * (1 + np.floor(t / 0.1) * 0.1), rel=1e-12)


def stepped(k, T_i, T_s, J, until):
    """Speed at the end, by the difference equations."""
    x, w, now = 0.0, 0.0, 0.0
    while True:
        x, e = x + T_s / T_i * (10.0 - w), 10.0 - w
        torque, now = k * (x + e), now + T_s
        if now.real > until:
            return w + (until - now + T_s) * torque / J
        w += T_s * torque / J


def test_derivatives_by_gains_and_sampling_time_are_those_of_the_difference_equations():
    rated = {"controller.k": 20.0, "controller.T_i": 0.4, "controller.T_s": 0.05, "body.J": 2.0}
    system = assemble_rows(
        *("drive body sensor", "sensor.w controller.measured", "controller.y drive.tau"),
        controller=SampledPI(k=20.0, T_i=0.4, T_s=0.05, wanted=10.0),
        drive=Torque(),
        body=Inertia(J=2.0),
        sensor=SpeedSensor(),
    )
    found = lp.sensitivity(system, of=["body.w"], by=list(rated), until=0.52, rtol=1e-10)
    for i, name in enumerate(rated):
        moved = [value + 1e-20j * (i == j) for j, value in enumerate(rated.values())]
        expected = stepped(*moved, 0.52).imag / 1e-20
        received = found["body.w", name][-1]
        print(f"{name}: {received:.8f}, by hand {expected:.8f}")
        assert received == pytest.approx(expected, rel=1e-7), name
