"""Signals, each through what it does to a free mass or angle that it drives."""

import numpy as np
import pytest
from checks import assert_close
from rows import assemble_rows
from scipy.integrate import cumulative_trapezoid

import lumped as lp
from lumped.components import (
    Constant,
    Expression,
    Inertia,
    Ramp,
    Sine,
    Speed,
    Step,
    Table,
    Torque,
    translation,
)
from lumped.errors import EquationError, ParameterError

GRID = np.linspace(0.0, 2.0, 81)


class Push(lp.Component):
    """A mass driven by a signal: m der(v) = y."""

    signal: lp.Component = Constant(k=0.0)
    force: translation.Force = translation.Force()
    mass: translation.Mass = translation.Mass(m=4.0)

    def connections(self):
        yield lp.connect(self.signal.y, self.force.f)
        yield from lp.chain(self.force, self.mass)


def run(signal, **options):
    system = lp.assemble(Push(signal=signal), keep=["mass.s"])
    return lp.simulate(system, until=2.0, rtol=1e-11, **{"grid": GRID, **options})


def test_a_constant_force_gives_a_parabola():
    found = run(Constant(k=6.0))
    assert_close(found["mass.v"], 1.5 * GRID, 1e-10, "velocity")
    assert_close(found["mass.s"], 0.75 * GRID**2, 1e-10, "position")


def test_a_step_leaves_the_mass_at_rest_before_it_and_pushes_it_after():
    found = run(Step(height=8.0, start_time=0.3))
    received = found["mass.v"]
    expected = 2.0 * np.maximum(GRID - 0.3, 0.0)
    assert_close(received, expected, 1e-14, "velocity")
    assert (received[GRID < 0.3] == 0).all()


def test_a_step_takes_both_values_at_its_instant():
    found = run(Step(height=8.0, offset=-1.0, start_time=0.3), grid=4)
    received = found["signal.y"][found.t == 0.3].tolist()
    expected = [-1.0, 7.0]
    assert received == expected


def test_a_step_at_the_begin_is_done_at_once():
    received = run(Step(height=8.0, offset=1.0))["signal.y"]
    expected = np.full(len(GRID), 9.0)
    assert (received == expected).all()


def test_a_ramp_integrates_to_its_parabola_between_constants():
    begin, length, height, offset = 0.4, 0.7, 5.0, -2.0
    found = run(Ramp(height=height, duration=length, offset=offset, start_time=begin))
    risen = np.clip(GRID - begin, 0.0, length)
    expected = offset * GRID + height * risen**2 / (2 * length)
    expected += height * np.maximum(GRID - begin - length, 0.0)
    assert_close(found["signal.y"], offset + height * risen / length, 1e-15, "signal")
    assert_close(found["mass.v"], expected / 4.0, 1e-10, "velocity")
    assert [event.time for event in found.events] == [begin, begin + length]


def test_a_ramp_without_duration_is_refused():
    with pytest.raises(ParameterError, match=r"signal\.duration = 0 s .*greater than 0"):
        lp.assemble(Push(signal=Ramp(height=1.0, duration=0.0)))


def test_a_sine_rests_at_its_offset_and_then_swings():
    begin, frequency, phase = 0.25, 1.7, 0.6
    found = run(Sine(amplitude=3.0, frequency=frequency, phase=phase, offset=0.5, start_time=begin))
    w = 2 * np.pi * frequency
    since = np.maximum(GRID - begin, 0.0)
    impulse = 0.5 * GRID + 3.0 / w * (np.cos(phase) - np.cos(w * since + phase))
    signal = 0.5 + np.where(begin <= GRID, 3.0 * np.sin(w * since + phase), 0.0)
    assert_close(found["signal.y"], signal, 1e-14, "signal")
    assert_close(found["mass.v"], impulse / 4.0, 1e-10, "velocity")


def test_a_table_integrates_to_its_trapezia_across_a_jump():
    times, values = (0.2, 0.5, 0.5, 1.3, 1.6), (1.0, 4.0, -2.0, 0.0, 3.0)
    found = run(Table(times=times, values=values), grid=80)
    before = np.interp(found.t, times[:2], values[:2])
    after = np.interp(found.t, times[2:], values[2:])
    early = sum(len(piece.t) for piece in found.pieces[:2])
    signal = np.where(np.arange(len(found.t)) < early, before, after)
    # Exact, because every corner and both sides of the jump are among the output times.
    expected = cumulative_trapezoid(signal, found.t, initial=0.0) / 4.0
    assert set(times) <= set(found.t)
    assert_close(found["signal.y"], signal, 1e-15, "signal")
    assert_close(found["mass.v"], expected, 1e-10, "velocity")


def test_a_table_without_points_is_refused():
    with pytest.raises(EquationError, match="0 times"):
        lp.assemble(Push(signal=Table()))


def test_an_expression_of_the_time_becomes_a_signal():
    found = run(Expression(value=3 * lp.ops.exp(-lp.time)))
    expected = 0.75 * (1 - np.exp(-GRID))
    assert_close(found["mass.v"], expected, 1e-10, "velocity")


def test_one_signal_drives_a_torque_and_a_speed():
    system = assemble_rows(
        *("signal.y torque.tau speed.w", "torque a", "speed b"),
        signal=Sine(amplitude=2.0, frequency=0.5),
        torque=Torque(),
        a=Inertia(J=0.5),
        speed=Speed(),
        b=Inertia(J=3.0),
    )
    found = lp.simulate(system, until=2.0, rtol=1e-11, grid=GRID)
    assert_close(found["a.w"], 4.0 / np.pi * (1 - np.cos(np.pi * GRID)), 1e-10, "speed by torque")
    assert_close(found["b.w"], 2.0 * np.sin(np.pi * GRID), 1e-14, "speed by prescription")
    assert_close(found["speed.flange.tau"], -6.0 * np.pi * np.cos(np.pi * GRID), 1e-14, "torque")
