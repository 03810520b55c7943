"""Derivatives of runs that are stiff and soft in turn: each step is made again by its method."""

import casadi as ca
import numpy as np
import pytest
from checks import by_complex_step
from stiff_in_turn import EDGES, UNTIL, VALUES, InTurn, end, moved

import lumped as lp
from lumped import functionals as fun
from lumped.gradients import legs
from lumped.gradients.readings.product_curve import sample_steps, values_at
from lumped.gradients.steps import steps_of
from lumped.timeloop.plants.many_points import ManyPoints

POINT = np.array(list(VALUES.values()))
IN_TURN = ["explicit", "implicit", "explicit", "implicit"]


def used(run):
    return [used.method for used in run.statistics.methods]


@pytest.mark.parametrize("kept", [None, 40])
def test_gradients_are_those_of_the_closed_form(kept, monkeypatch):
    """Whether all states are kept, or most are made again."""
    if kept:
        monkeypatch.setattr(legs, "_KEPT_BYTES", 8 * 6 * kept)
    system = lp.assemble(InTurn())
    of = [fun.final("phi"), fun.final("w")]
    found = lp.gradient(system, of=of, by=list(VALUES), until=UNTIL, rtol=1e-9)
    assert used(found.run) == IN_TURN
    assert any(piece.ends is not None for piece in found.run.pieces) == bool(kept)
    shares = by_complex_step(end, POINT) * POINT
    error = np.abs(found.derivatives * POINT - shares).max(axis=1) / np.abs(shares).max(axis=1)
    assert error.max() < 1e-7


def test_sensitivities_are_those_of_the_closed_form():
    system = lp.assemble(InTurn())
    found = lp.sensitivity(system, of=["phi", "w"], by=list(VALUES), until=UNTIL, rtol=1e-8)
    assert used(found.run) == IN_TURN
    shares = by_complex_step(end, POINT) * POINT
    error = np.abs(found.derivatives[-1] * POINT - shares).max(axis=1) / np.abs(shares).max(axis=1)
    assert error.max() < 1e-6


def test_values_between_steps_of_both_methods():
    """At times in any order, and in all steps of the run."""
    system = lp.assemble(InTurn())
    run = lp.simulate(system, until=UNTIL, grid=None, rtol=1e-9, method="steps")
    assert used(run) == IN_TURN
    course = legs.SmoothParts(run, legs.legs_of(run), steps_of(run.system, ()), 1e-9)
    look = ManyPoints(ca.Function("look", system.inputs, [system.expressions(["phi"])]))

    def angle(t):
        phi, w = 0.1, 0.0
        for begin, stop in zip((0.0, *EDGES), (*EDGES, UNTIL), strict=True):
            if t > begin:
                damping = VALUES["free" if begin in (0.0, EDGES[1]) else "d"]
                rest = min(t, stop) - begin
                phi, w = moved(phi, w, rest, VALUES["J"], VALUES["c"], damping, VALUES["tau"])
        return np.real(phi)

    times = np.array([3.9, 0.3, 2.7, 1.4, 3.00001, 0.999, 2.0005, 1.00001])
    numbers = times.astype(int)
    found = values_at(course, look, numbers, times)[:, 0]
    assert found == pytest.approx([angle(t) for t in times], abs=1e-8)
    for samples in sample_steps(course, look):
        expected = np.vectorize(angle)(samples.t)
        assert np.abs(samples.values[:, :, 0] - expected).max() < 1e-8
