"""Masses on arms in gravity and journals under load, against closed forms and energy integrals."""

import numpy as np
import pytest
from rows import in_a_row
from scipy.special import ellipk

import lumped as lp
from lumped.components import (
    Inertia,
    JournalFriction,
    Speed,
    SwingingMass,
)
from lumped.ops import where

G = 9.80665


def test_a_pendulum_swings_with_its_closed_period():
    # hanging at -90 deg; the period of a mathematical pendulum is 4 sqrt(R/g) K(sin^2(amplitude/2))
    R, amplitude = 0.7, 1.9
    period = 4 * np.sqrt(R / G) * ellipk(np.sin(amplitude / 2) ** 2)
    begin = amplitude - np.pi / 2
    model = in_a_row(bob=SwingingMass(m=3.0, R=R), hub=Inertia(J=1e-12))
    run = lp.simulate(
        lp.assemble(model), until=5 * period, rtol=1e-11, grid=10, start={"bob.phi": begin}
    )
    assert run["bob.phi"][::2] == pytest.approx(begin, abs=1e-6)
    assert run["bob.phi"][1::2] == pytest.approx(-np.pi - begin, abs=1e-6)


@pytest.mark.parametrize(("m", "R", "J", "phi0"), [(4.0, 0.6, 0.5, 0.0), (2.5, -1.1, 0.0, 0.7)])
def test_it_takes_inertia_times_acceleration_and_its_weight_times_the_lever(m, R, J, phi0):
    # phi = 0.3 + 0.5 t + t^2: a = 2
    model = in_a_row(
        turn=Speed(w=0.5 + 2.0 * lp.time), body=SwingingMass(m=m, R=R, J=J, phi0=phi0, g=9.81)
    )
    system = lp.assemble(model, keep=["body.phi"])
    run = lp.simulate(system, until=3.0, rtol=1e-11, grid=50, start={"body.phi": 0.3})
    phi = 0.3 + 0.5 * run.t + run.t**2
    expected = (J + m * R**2) * 2.0 + m * 9.81 * R * np.cos(phi + phi0)
    assert -run["turn.flange.tau"] == pytest.approx(expected, rel=1e-9)


# -- journals ----------------------------------------------------------------------------------

MU, D = 0.2, 0.3


def test_a_journal_fades_with_its_load():
    # the load is doubled at 1 s
    J, w, load = 4.0, 20.0, 100.0
    grip = MU * load * D / 2
    model = in_a_row(
        body=Inertia(J=J, w=w),
        journal=JournalFriction(mu=MU, d=D, f_n=where(lp.time >= 1.0, 2 * load, load)),
    )
    run = lp.simulate(lp.assemble(model), until=20.0, rtol=1e-10, grid=40)
    rest = 1.0 + (w - grip / J) * J / (2 * grip)
    expected = np.where(run.t < 1, w - grip / J * run.t, 2 * grip / J * np.maximum(rest - run.t, 0))
    assert run["body.w"] == pytest.approx(expected, abs=1e-9)
    (stop,) = (event for event in run.events if event.after == "stuck")
    assert stop.time == pytest.approx(rest, rel=1e-10)
    assert (run["body.w"][run.t > rest] == 0).all()


def test_without_load_a_journal_is_free():
    model = in_a_row(body=Inertia(J=1.0, w=3.0), journal=JournalFriction(mu=MU, d=D, f_n=0.0))
    run = lp.simulate(lp.assemble(model), until=5.0)
    assert (run["body.w"] == 3.0).all()
