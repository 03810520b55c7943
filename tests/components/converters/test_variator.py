"""A variator's steady slip, efficiency and gross slip against closed forms."""

import numpy as np
import pytest
import scipy
from rows import assemble_row

import lumped as lp
from lumped.components import Inertia, Speed, Torque, Variator
from lumped.errors import EquationError, SolverError

TRACTION = ((0.0, 0.0), (0.02, 0.08), (1.0, 0.08))
R, F_N = 0.06, 6e3


def variator(**given):
    return Variator(
        **{"characteristic": TRACTION, "ratio": 1.5, "f_n": F_N, "R": R, "v_low": 0.01} | given
    )


def driven(load, until, w=200.0, **given):
    system = assemble_row(
        drive=Speed(w=w),
        belt=variator(**given),
        body=Inertia(J=0.4),
        load=Torque(tau=load),
    )
    return lp.simulate(system, until=until, rtol=1e-10, start={"body.w": w / 1.5})


@pytest.mark.parametrize("load", [-20.0, 20.0])
def test_steady_slip_and_efficiency_follow_from_the_load(load):
    run = driven(load, 3.0)
    r_b = 1.5 * 2 * R / 2.5
    slip = abs(load) / (r_b * F_N * 0.08 / 0.02)
    exact = 200.0 / 1.5 * ((1 - slip) if load < 0 else 1 / (1 - slip))
    assert run["body.w"][-1] == pytest.approx(exact, rel=1e-9)
    power = run["belt.flange_a.tau"][-1] * 200.0
    eta = -load * run["body.w"][-1] / power
    assert (eta if load < 0 else 1 / eta) == pytest.approx(1 - slip, rel=1e-9)
    assert run["belt.s"][-1] == pytest.approx(-np.sign(load) * slip, rel=1e-7)


def test_it_slips_grossly_above_the_greatest_traction():
    load, r_b = -60.0, 1.5 * 2 * R / 2.5
    assert abs(load) > r_b * F_N * 0.08
    run = driven(load, 0.3)
    late = run["belt.s"] > 0.02
    fall = (load + r_b * F_N * 0.08) / 0.4
    t, w = run.t[late], run["body.w"][late]
    assert w == pytest.approx(w[0] + fall * (t - t[0]), abs=1e-8)
    assert w[-1] < 0.95 * w[0]


def test_its_ratio_moves_during_a_run():
    run = driven(-20.0, 2.0, ratio=1.5 - 0.5 * lp.ops.sin(3 * lp.time))

    def rate(t, y):
        ratio = 1.5 - 0.5 * np.sin(3 * t)
        r_a, r_b = 2 * R / (1 + ratio), 2 * R * ratio / (1 + ratio)
        s = (r_a * 200.0 - r_b * y[0]) / max(r_a * 200.0, r_b * y[0])
        mu = np.interp(abs(s), *np.transpose(TRACTION)) * np.sign(s)
        return [(r_b * F_N * mu - 20.0) / 0.4]

    own = scipy.integrate.solve_ivp(
        rate, (0, 2), [200.0 / 1.5], rtol=1e-11, atol=1e-11, max_step=1e-2
    )
    assert run["body.w"][-1] == pytest.approx(own.y[0, -1], rel=1e-8)


def test_at_standstill_it_creeps_as_a_damper():
    run = driven(-20.0, 1.0, w=0.0)
    r_b = 1.5 * 2 * R / 2.5
    assert run["body.w"][-1] == pytest.approx(-20.0 * 0.01 / (r_b**2 * F_N * 4.0), rel=1e-8)


def test_a_ratio_out_of_range_stops_the_run():
    with pytest.raises(SolverError) as error:
        driven(-20.0, 1.0, ratio=1.5 + 2 * lp.time)
    for word in ("belt", "ratio", "2.5", "Command a ratio"):
        assert word in str(error.value)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"ratio": -1.0}, "ratio = -1"),
        ({"f_n": F_N * lp.ops.cos(20 * lp.time)}, "normal force = -"),
    ],
)
def test_a_contact_turned_inside_out_or_pulled_is_refused(given, words):
    with pytest.raises(SolverError, match=words):
        driven(-20.0, 1.0, **given)


def test_a_normal_force_may_come_down_to_zero():
    run = driven(0.0, 1.0, f_n=F_N * abs(lp.ops.cos(20 * lp.time)))
    assert run["body.w"][-1] == pytest.approx(200.0 / 1.5, rel=1e-9)


@pytest.mark.parametrize("ratios", [(0.0, 2.0), (2.0, 1.0), None, 2.0, (0.4, 1.0, 2.0), ("a", 2)])
def test_ratios_that_cannot_be_are_refused(ratios):
    with pytest.raises(EquationError) as error:
        driven(-20.0, 1.0, ratios=ratios)
    for word in ("belt (Variator)", "ratios", "above 0"):
        assert word in str(error.value)
