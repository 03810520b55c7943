"""Periodic motions in which constraints stay closed, against the rigid system by hand."""

import numpy as np
import pytest
from scipy.linalg import expm

import lumped as lp
from lumped.components import (
    Clutch,
    Coupling,
    Damper,
    Fixed,
    Inertia,
    OneWayClutch,
    SlipCoupling,
    SpringDamper,
    Stop,
    Synchroniser,
    Torque,
)


@pytest.mark.parametrize(
    "closed",
    [
        Clutch(f_max=1e3, u=1.0),
        SlipCoupling(static=1e3, kinetic=900.0, u=1.0),
        Coupling(u=1.0),
        OneWayClutch(u=0.0),
        Synchroniser(f_max=1.0, mu=0.1, R=0.1, alpha=0.1, u=1.0, locked=1.0),
    ],
    ids=lambda part: type(part).__name__,
)
def test_a_drive_with_a_closed_clutch_turns_as_one_inertia(closed):
    """3 kg.m2 on 1 N.m.s; a slip fades within an instant, so that its multiplier is zero."""
    w = 10.0
    system = lp.assemble(
        lp.compose(
            pull=Torque(tau=20 + 10 * lp.ops.sin(w * lp.time)),
            a=Inertia(J=1.0),
            closed=closed,
            b=Inertia(J=2.0),
            d=Damper(d=1.0),
            g=Fixed(),
            connections=lambda m: lp.chain(m.pull, m.a, m.closed, m.b, m.d, m.g),
        )
    )
    orbit = lp.periodic(system, period=2 * np.pi / w, start={"a.w": 20.0, "b.w": 20.0})
    assert orbit.greatest("b.w").value == pytest.approx(20 + 10 / np.hypot(1, 3 * w), rel=1e-9)
    assert orbit.multipliers[0] == pytest.approx(np.exp(-2 * np.pi / w / 3), abs=1e-8)
    assert orbit.multipliers[1:] == pytest.approx(0, abs=1e-8)
    by = orbit.sensitivity(of=["b.w"], by=["a.J", "d.d"])
    assert by.mean[0] == pytest.approx([0, -20], abs=1e-6)
    greatest = [-10 * 3 * w**2, -10] / np.hypot(1, 3 * w) ** 3 - [0, 20]
    assert by.greatest[0] == pytest.approx(greatest, abs=1e-5)


def test_bodies_that_lie_on_each_other_vibrate_as_one():
    """3 kg.m2 on a damped spring; what lies on a stop moves with the stop if that is moved."""
    w = 2.0
    system = lp.assemble(
        lp.compose(
            push=Torque(tau=-50.0),
            a=Inertia(J=1.0),
            stop=Stop(),
            b=Inertia(J=2.0),
            k=SpringDamper(c=30.0, d=1.0),
            g=Fixed(),
            shake=Torque(tau=10 * lp.ops.sin(w * lp.time)),
            connections=lambda m: [
                *lp.chain(m.g, m.k, m.b, m.stop, m.a, m.push),
                *lp.chain(m.shake, m.b),
            ],
        )
    )
    orbit = lp.periodic(system, period=2 * np.pi / w, warm_up=60)
    amplitude = 10 / np.hypot(30 - 3 * w**2, w)
    assert abs(orbit.harmonics("b.phi", 1)[1]) == pytest.approx(amplitude, rel=1e-8)
    own = np.linalg.eigvals(expm(2 * np.pi / w * np.array([[0, 1], [-10, -1 / 3]])))
    assert np.sort(orbit.multipliers) == pytest.approx(np.sort([*own, 0, 0]), abs=1e-8)
    by = orbit.sensitivity(of=["a.phi", "b.phi"], by=["stop.phi_min"])
    assert by.mean[:, 0] == pytest.approx([1, 0], abs=1e-8)
