"""Order responses against periodic motions, both against closed forms and independent turns."""

import numpy as np
import pytest
from periodic_motions import ROTOR, start_and_torque, turn

import lumped as lp
from lumped.errors import OptionError
from tests.vibration.ordered.test_order_means import OPTIONS, ship

SPEEDS = np.array([5.0, 8.0, 16.0])


@pytest.fixture(scope="module")
def rotor():
    return lp.vibration.order_response(
        ROTOR, speeds=SPEEDS, of=["w"], shaft="phi", free="tau", orders=[1]
    )


def first_order(speed):
    """Amplitude of the rotor's speed over its mean angle, by a turn over the angle."""
    begin, tau = start_and_torque(2 * np.pi / speed)
    phi = np.linspace(0, 2 * np.pi, 20_001)
    w, t = turn(begin, tau=tau, t_eval=phi).y
    offset = np.trapezoid(phi - speed * t, t) / t[-1]
    return np.trapezoid(w * np.exp(-1j * (speed * t + offset)), t) * 2 / t[-1]


def test_differences_are_those_of_turns_over_the_angle(rotor):
    check = lp.orbits.check_orders(rotor, speeds=SPEEDS, tolerance=1e-3)
    linear = 2j / (0.5 + 1j * SPEEDS)  # J der(w) + d w == -G sin(phi), sin = Re(-j e^(j phi))
    exact = np.array([first_order(w) for w in SPEEDS])
    wanted = np.abs(linear - exact) / np.abs(exact)
    assert rotor["w"][:, 0] == pytest.approx(linear, rel=1e-9)
    assert check.values[:, 0, 0] == pytest.approx(exact, rel=1e-7)
    assert check.differences[:, 0, 0] == pytest.approx(wanted, abs=1e-7)
    assert [row[0] for row in check.exceeding] == SPEEDS[wanted > 1e-3].tolist()
    assert 0 < len(check.exceeding) < len(SPEEDS)
    assert not check.holds
    assert "NO" in repr(check)
    assert lp.orbits.check_orders(rotor, speeds=SPEEDS[2:], tolerance=1e-3).holds


def test_what_the_response_expects_to_leave_out_is_what_motions_have():
    """One more step of the perturbation against the motions, where it is not small."""
    orders = np.array([0.5, *range(1, 9)])
    for cubic in (0.0, 1e5):
        response = lp.vibration.order_response(
            ship(cubic),
            free="load.tau",
            parameters={"drive.m": 0.002},
            **{**OPTIONS, "orders": orders, "speeds": [20.0, 98.0, 150.0]},
        )
        told = response.linearity
        check = lp.orbits.check_orders(response, speeds=[told.speed])
        o = int(np.flatnonzero(orders == told.order)[0])
        assert check.differences[0, o, 0] == pytest.approx(told.share, rel=0.1)
        assert told.share > 0.1
        assert check.exceeding[0][2] == told.order


def test_a_motion_that_is_not_found_is_told():
    response = lp.vibration.order_response(
        ship(), free="load.tau", **{**OPTIONS, "speeds": [72.0, 150.0]}
    )
    check = lp.orbits.check_orders(response, speeds=response.speeds, iterations=4)
    assert list(check.faults) == [72.0]
    assert "at 687.549 1/min: Model: no load.tau" in repr(check)
    assert np.isnan(check.values[0]).all()
    assert not check.holds


def test_slips_of_a_check_are_named(rotor):
    for options, text in (
        ({"tolerance": 0.0}, "tolerance = 0 must be positive"),
        ({"speeds": []}, "at least one speed"),
        ({"speeds": [7.0]}, "7 rad/s is none of the speeds"),
    ):
        with pytest.raises(OptionError, match=text):
            lp.orbits.check_orders(rotor, **options)
