"""Load of a rolling pass against the balance of the strip, coasting and energy."""

import numpy as np
import pytest
from rows import in_a_row
from scipy.integrate import quad

import lumped as lp
from lumped.components import Inertia, RollingTorque, Speed, Torque

J, F, A, R = 50.0, 2e6, 0.012, 0.4
FORMING = 2 * F * A


def rolls(until, w=0.0, tau=0.0, grid=400, **given):
    """Rolls with their drive; what is given goes to the pass."""
    values = {"F": F, "a": A, "R": R, "T_back": 0.0, "T_front": 0.0} | given
    model = in_a_row(drive=Torque(tau=tau), body=Inertia(J=J, w=w), gap=RollingTorque(**values))
    system = lp.assemble(model, keep=["body.phi"])
    return lp.simulate(system, until=until, rtol=1e-10, grid=grid)


@pytest.mark.parametrize(("T_back", "T_front"), [(0.0, 0.0), (3e5, 0.0), (1e5, 4e5)])
def test_the_torque_is_that_of_the_shear_that_balances_the_strip(T_back, T_front):
    """Shear of the roll on the strip, integrated over the arc of contact."""
    bite, b, top = 0.08, 1.2, 9e8  # rad, m, Pa; the pressure falls to both ends

    def pressure(x):
        return top * x * (bite - x) / bite**2

    # per roll; angles small: force b R int p dx, its lever arm from the line of the axes
    force = b * R * quad(pressure, 0, bite)[0]
    arm = b * R**2 * quad(lambda x: pressure(x) * x, 0, bite)[0] / force
    # pressure pushes the strip back, shear forward: 2 shear - 2 int p x = T_back - T_front
    back = b * R * quad(lambda x: pressure(x) * x, 0, bite)[0]
    shear = back + (T_back - T_front) / 2
    model = in_a_row(
        turn=Speed(w=1.0), gap=RollingTorque(F=force, a=arm, R=R, T_back=T_back, T_front=T_front)
    )
    received = lp.start_point(lp.assemble(model))["gap.tau"]
    assert received == pytest.approx(2 * R * shear, rel=1e-9)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_rolls_that_coast_stop_in_the_strip_and_stay(side):
    T_back, T_front = (1e5, 4e4) if side > 0 else (4e4, 1e5)
    run = rolls(2.0, w=8.0 * side, T_back=T_back, T_front=T_front)
    rate = (FORMING + 6e4 * R) / J
    stop = 8.0 / rate
    expected = side * np.where(run.t < stop, 8.0 - rate * run.t, 0.0)
    assert run["body.w"] == pytest.approx(expected, abs=1e-8)
    assert run["gap.position"][-1] == 0
    # at rest the strip holds the tensions
    assert run["gap.tau"][-1] == pytest.approx(0.0, abs=1e-6)
    assert run["gap.tau_f"][-1] == pytest.approx(-side * 6e4 * R, rel=1e-9)


@pytest.mark.parametrize("share", [0.999, 1.001])
def test_front_tension_pulls_resting_rolls_along_only_beyond_the_torque_of_forming(share):
    run = rolls(1.0, T_front=share * FORMING / R)
    expected = max(share - 1, 0.0) * FORMING / J
    assert run["body.w"][-1] == pytest.approx(expected, abs=1e-9)


def test_open_rolls_run_freely():
    run = rolls(1.0, w=3.0, F=0.0)
    assert run["body.w"] == pytest.approx(3.0, rel=1e-12)
    assert run["gap.position"][-1] == 2
