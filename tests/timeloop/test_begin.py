"""Runs that begin at a time other than zero, and runs that go on."""

import numpy as np
import pytest
from linkages import double_rocker
from rows import assemble_row, in_a_row

import lumped as lp
from lumped.components import Brake, Inertia, SpringDamper, Torque
from lumped.errors import OptionError


def pushed(**body):
    """A body that a torque of 10 N.m pushes from 1 s on."""
    torque = lp.ops.where(lp.time >= 1.0, 10.0, 0.0)
    return assemble_row(push=Torque(tau=torque), body=Inertia(J=2.0, **body))


@pytest.mark.parametrize("begin", [-1.0, -0.5, 0.5, 3.0])
def test_a_run_begins_when_it_is_told_to(begin):
    system = pushed(w=1.0)
    for method in ("auto", "explicit"):
        run = lp.simulate(system, begin=begin, until=4.0, grid=4, method=method)
        assert [run.t[0], run.t[-1]] == [begin, 4.0]
        expected = 1.0 + 5.0 * np.maximum(0.0, run.t - max(1.0, begin))
        assert run["body.w"] == pytest.approx(expected, rel=1e-6)
        assert [event.time for event in run.events] == [1.0] * (begin < 1.0)
    assert lp.start_point(system, time=begin).time == begin


def test_a_step_at_the_begin_counts_from_there_on():
    system = pushed()
    run = lp.simulate(system, begin=1.0, until=2.0, grid=1)
    assert run["push.tau"] == pytest.approx([10.0, 10.0], abs=0)
    assert run["body.w"] == pytest.approx([0.0, 5.0], rel=1e-9)
    # what ends at the begin is over
    until = lp.ops.where(lp.time <= 1.0, 10.0, 0.0)
    model = in_a_row(push=Torque(tau=until), body=Inertia(J=1.0))
    assert lp.start_point(lp.assemble(model), time=1.0)["push.tau"] == 0.0


def braked():
    """Stick-slip: a torque that swings, and a brake that is pressed harder from 1.2 s on."""
    wave = lp.ops.sin(2 * lp.ops.pi * lp.time)
    return in_a_row(
        push=Torque(tau=8.0 * wave),
        body=Inertia(J=1.0),
        brake=Brake(f_max=6.0, u=lp.ops.where(lp.time >= 1.2, 1.0, 0.5)),
    )


def vibrating():
    """Two bodies on a shaft; a torque that comes at 1 s."""
    return in_a_row(
        push=Torque(tau=lp.ops.where(lp.time >= 1.0, 10.0, 0.0)),
        a=Inertia(J=1.0),
        shaft=SpringDamper(c=400.0, d=0.5),
        b=Inertia(J=2.0),
    )


@pytest.mark.parametrize(
    ("model", "name", "method"),
    [
        (braked(), "body.w", "explicit"),
        (vibrating(), "b.w", "exact"),
        (vibrating(), "b.w", "implicit"),
        (vibrating(), "b.w", "taylor"),
        (double_rocker(w=3.0), "crank.phi", "explicit"),
    ],
)
@pytest.mark.parametrize("middle", [0.1, 0.75, 1.1, 1.8])
def test_a_run_in_two_pieces_is_the_run_in_one(model, name, method, middle):
    system = lp.assemble(model)
    options = {"rtol": 1e-10, "method": method}
    late = [middle, 2.0, 3.0]
    whole = lp.simulate(system, until=3.0, grid=[0.0, *late], **options)
    first = lp.simulate(system, until=middle, grid=[middle], **options)
    second = lp.simulate(system, until=3.0, start=first.point(middle), grid=late, **options)
    error = np.abs(second[name] - whole[name][1:]).max()
    assert error < 1e-8 * max(1.0, np.abs(whole[name]).max())
    told = [
        (e.component, e.after) for run in (first, second) for e in run.events if e.kind != "states"
    ]
    assert told == [(e.component, e.after) for e in whole.events if e.kind != "states"]


def test_the_begin_is_a_finite_time_before_the_end():
    system = pushed()
    with pytest.raises(OptionError, match=r"until = 1\.0 s: .* after the begin, 2 s"):
        lp.simulate(system, begin=2.0, until=1.0)
    with pytest.raises(OptionError, match=r"begin = nan"):
        lp.simulate(system, begin=np.nan, until=1.0)
    with pytest.raises(OptionError, match=r"grid: .* leave 2 to 3 s"):
        lp.simulate(system, begin=2.0, until=3.0, grid=[0.0, 3.0])


def test_what_makes_no_run_refuses_a_point_by_name():
    system = pushed()
    point = lp.start_point(system, time=2.0)
    with pytest.raises(OptionError, match=r"start"):
        lp.equilibrium(system, start=point)


def test_a_certificate_and_a_comparison_of_methods_begin_there_too():
    system = pushed()
    run = lp.simulate(system, begin=0.5, until=2.0, certify=True)
    assert run.certificate.error < 1e-6
    assert run["body.w"][-1] == pytest.approx(5.0, rel=1e-9)
    point = lp.start_point(system, time=1.5)
    found = lp.simulation.work_precision(system, until=2.0, start=point, tolerances=[1e-6])
    assert all(row.error < 1e-6 for row in found.rows)
