"""State spaces and transfer functions as blocks, against SciPy, python-control and loops."""

import control
import numpy as np
import pytest
import scipy.signal
from checks import refused
from rows import assemble_rows

import lumped as lp
from lumped.components import (
    Inertia,
    LinearBlock,
    SampledLinearBlock,
    SampledStateSpace,
    SampledTransferFunction,
    SpeedSensor,
    SpringDamper,
    StateSpaceBlock,
    Torque,
    TransferFunction,
)
from lumped.errors import DeclarationError, LumpedError

A = np.array([[0, 1.0], [-4, -1]])
B = np.array([[0.0, 1], [1, 2]])
C = np.array([[1.0, 0], [0.5, 2], [0, 0]])
D = np.array([[0, 0.0], [1, 0], [0, 3]])
SAMPLED = np.array([[0.5, 0.2], [-0.1, 0.7]])
NUMBERS = {"above": [1.0, 0.2, 0.3], "below": [2.0, -1.0, 0.2, 0.1]}


class Both(LinearBlock):
    """Two inputs, three outputs."""

    a: lp.Input = lp.Input("1", "first")
    b: lp.Input = lp.Input("1", "second")
    p = lp.Output("1", "first")
    q = lp.Output("1", "second")
    r = lp.Output("1", "third")


class SampledBoth(SampledLinearBlock):
    """Two inputs, three outputs, in a computer."""

    a: lp.Input = lp.Input("1", "first")
    b: lp.Input = lp.Input("1", "second")
    p = lp.Output("1", "first")
    q = lp.Output("1", "second")
    r = lp.Output("1", "third")


def run_of(block, until, t, **options):
    return lp.simulate(lp.assemble(lp.compose(b=block)), until=until, grid=t, **options)


def sine(t):
    return 1.0 + np.sin(3 * np.asarray(t))


def test_a_block_of_several_signals_runs_as_lsim_does():
    t = np.linspace(0, 5, 51)
    block = Both.of(control.ss(A, B, C, D)).with_({"a": 1.0, "b": 2.0})
    start = {"b.state[0].x": 0.3, "b.state[1].x": -0.7}
    run = run_of(block, 5.0, t, start=start, method="exact")
    u = np.tile([1.0, 2.0], (len(t), 1))
    _, y, _ = scipy.signal.lsim((A, B, C, D), u, t, X0=[0.3, -0.7])
    error = max(np.abs(run[f"b.{name}"] - y[:, i]).max() for i, name in enumerate("pqr"))
    assert error < 1e-11


@pytest.mark.parametrize(
    ("above", "below"),
    [
        ([3.0], [2.0]),
        ([1.0], [0.0, 1.0, 0.5]),
        ([1.0, 2, 3], [2.0, 3, 4]),
        ([1.0, 2, 3], [2.0, 3, 4, 5]),
        ([5.0], [1.0, 2, 3, 4]),
    ],
)
def test_the_step_of_a_transfer_function_is_that_of_scipy(above, below):
    t = np.linspace(0, 6, 41)
    block = TransferFunction(numerator=above, denominator=below, u=1.0)
    run = run_of(block, 6.0, t, method="exact")
    below = np.trim_zeros(below, "f")
    if len(below) == 1:
        expected = np.full(len(t), above[0] / below[0])
    else:
        expected = scipy.signal.step((above, below), T=t)[1]
    error = np.abs(run["b.y"] - expected).max()
    assert error < 1e-10


def test_the_poles_of_a_transfer_function_are_the_zeros_of_its_denominator():
    below = [1.0, 0.8, 27.0, 9.0, 50.0]
    system = lp.assemble(
        lp.compose(b=TransferFunction(numerator=[1.0, 2.0], denominator=below, u=1.0))
    )
    found = np.sort_complex(np.linalg.eigvals(lp.linearise(system).A))
    expected = np.sort_complex(np.roots(below))
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


def test_a_controller_designed_there_closes_the_loop_here_as_feedback_does_there():
    plant = {"a": Inertia(J=2.0), "s": SpringDamper(c=300.0, d=0.4), "l": Inertia(J=5.0)}
    row, plant = "motor a s l sensor", plant | {"sensor": SpeedSensor()}
    opened = assemble_rows(row, **plant, motor=Torque(tau=0.0))
    there = lp.linearise(opened, inputs=["motor.tau"], outputs=["sensor.w"]).to_control()
    designed = control.tf([3.0, 4.0], [0.02, 1.0, 0.1])
    for block in (TransferFunction.of(designed), StateSpaceBlock.of(-control.ss(designed))):
        sign = 1.0 if isinstance(block, StateSpaceBlock) else -1.0
        law = -designed if sign > 0 else designed
        joints = ("sensor.w c.u", "c.y motor.tau")
        closed = assemble_rows(row, *joints, **plant, motor=Torque(), c=block)
        found = np.linalg.eigvals(lp.linearise(closed).A)
        poles = control.feedback(there, control.ss(law), sign=1).poles()
        poles = poles[np.abs(poles) > 1e-8]  # the angle of the whole drive
        found = found[np.abs(found) > 1e-8]
        assert len(found) == len(poles)
        error = max(np.abs(found - pole).min() / abs(pole) for pole in poles)
        print(f"error {error:.1e}")
        assert error < 1e-9


def test_a_sampled_block_computes_what_a_loop_does():
    T_s, n = 0.1, 30
    block = SampledBoth.of(control.ss(SAMPLED, B, C, D, dt=T_s))
    block = block.with_({"a": 1 + lp.ops.sin(3 * lp.time), "b": 2.0, "start_time": 0.25})
    t = 0.25 + T_s * (np.arange(-1, n) + 0.4)
    run = run_of(block, t[-1], t)
    x, rows = np.zeros(2), [np.zeros(3)]
    for k in range(n):
        u = np.array([sine(0.25 + k * T_s), 2.0])
        rows.append(C @ x + D @ u)
        x = SAMPLED @ x + B @ u
    error = max(np.abs(run[f"b.{m}"] - np.array(rows)[:, i]).max() for i, m in enumerate("pqr"))
    assert error < 1e-12


def test_one_signal_through_a_sampled_state_space_and_a_sampled_transfer_function():
    T_s, n = 0.1, 25
    law = control.tf(NUMBERS["above"], NUMBERS["below"], dt=T_s)
    u = 1 + lp.ops.sin(3 * lp.time)
    t = T_s * (np.arange(n) + 0.3)
    # in powers of 1/z, a degree less above is a delay of one sample
    expected = scipy.signal.lfilter(
        [0, *NUMBERS["above"]], NUMBERS["below"], sine(T_s * np.arange(n))
    )
    for block in (SampledTransferFunction.of(law), SampledStateSpace.of(control.ss(law))):
        error = np.abs(run_of(block.with_({"u": u}), t[-1], t)["b.y"] - expected).max()
        print(f"{type(block).__name__}: {error:.1e}")
        assert error < 1e-12


@pytest.mark.parametrize(
    ("block", "hints"),
    [
        (TransferFunction(numerator=[1, 0, 0], denominator=[1, 2]), ["b (", "degree 2", "filter"]),
        (TransferFunction(numerator=[1], denominator=[0, 0]), ["b (", "denominator is zero"]),
        (TransferFunction(numerator=[np.nan], denominator=[1]), ["numerator = ", "finite"]),
        (StateSpaceBlock(A=[[1]], B=[[1, 2]], C=[[1]], D=[[0]]), ["B (1, 1)", "LinearBlock"]),
        (StateSpaceBlock(A=5), ["A = 5", "rows of finite numbers"]),
        (SampledStateSpace(A=[["x"]], T_s=0.1), ["A = ", "rows of finite numbers"]),
    ],
)
def test_what_is_no_block_is_told_with_its_path(block, hints):
    refused(LumpedError, lambda: lp.assemble(lp.compose(b=block.with_({"u": 1.0}))), *hints)


@pytest.mark.parametrize(
    ("take", "hints"),
    [
        (lambda: TransferFunction.of(control.tf([1], [1, 2], dt=0.1)), ["SampledTransferFunction"]),
        (lambda: SampledStateSpace.of(control.ss(A, B, C, D)), ["continuous", "StateSpaceBlock"]),
        (lambda: StateSpaceBlock.of(control.ss(A, B, C, D, dt=True)), ["no sample time"]),
        (lambda: TransferFunction.of(3), ["3 has no num"]),
        (lambda: StateSpaceBlock.of(control.tf([1], [1, 2])), ["control.ss"]),
        (
            lambda: TransferFunction.of(control.tf([[[1], [2]]], [[[1, 1], [1, 2]]])),
            ["2 inputs and 1 outputs"],
        ),
    ],
)
def test_a_system_of_another_kind_is_refused(take, hints):
    refused(DeclarationError, take, *hints)
