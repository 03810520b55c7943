"""Critical speeds where the stiffness follows the mean torque, and this the speed."""

import numpy as np
import pytest
from differences import slope
from progressive_drive import (
    CUBIC,
    J_B,
    SOFT,
    Progressive,
    critical,
    cubic_stiffness,
    drive,
    hertz,
    respond,
)

import lumped as lp
from lumped.components import ElasticCoupling
from lumped.errors import OptionError
from lumped.vibration.speeds.mean_campbell import speeds_that_show
from lumped.vibration.speeds.mean_spectrum import MeanSpectrum
from tests.vibration.ordered.test_order_means import OPTIONS, ship

SPEEDS = np.linspace(30.0, 220.0, 7)
ORDERS = (1.3, 1.5, 2.0)


@pytest.fixture(scope="module")
def response():
    return respond(drive(Progressive()), SPEEDS)


def test_critical_speeds_of_a_progressive_coupling_are_fixed_points(response):
    found = lp.vibration.mean_campbell(response, orders=ORDERS)
    expected = {order: critical(order, cubic_stiffness, 30.0, 220.0) for order in ORDERS}
    assert [len(speeds) for speeds in expected.values()] == [1, 1, 1]
    error = max(abs(c.speed / expected[c.order][0] - 1) for c in found.critical)
    assert len(found.critical) == 3
    assert error < 1e-9
    # those of the state at the first speed are far away
    first = 2 * np.pi * hertz(30.0, cubic_stiffness) / 1.3
    assert abs(first / expected[1.3][0] - 1) > 0.1
    rows = [hertz(speed, cubic_stiffness) for speed in found.speeds]
    assert found.hertz[:, 0] == pytest.approx(rows, rel=1e-9)


def test_an_order_that_meets_a_mode_three_times_has_three_critical_speeds():
    """The stiffness of a catalogue, linear between its rows, over the torque of the propeller."""
    rows = ((0, 1.5e4), (500, 1.8e4), (2000, 1.2e5), (6000, 1.3e5))
    coupling = ElasticCoupling(stiffness=rows, psi=0.0, w_loss=100.0)
    response = respond(drive(coupling), [40.0, 230.0])

    def stiffness(torque):
        return np.interp(torque, *np.transpose(rows))

    found = lp.vibration.mean_campbell(response, orders=[1.9])
    expected = critical(1.9, stiffness, 40.0, 230.0)
    assert len(expected) == 3
    assert [c.speed for c in found.critical] == pytest.approx(expected, rel=1e-9)


def test_a_narrow_pair_of_intersections_is_seen():
    """A parabola that dips below the ray of order 1 by so little that no node shows it."""
    depth, middle = 1e-4, 83.21

    def rows(speeds):
        return ((speeds + (speeds - middle) ** 2 / 100 - depth) / (2 * np.pi))[:, None]

    speeds = speeds_that_show(rows, 20.0, 200.0, [1.0])
    signs = np.sign(2 * np.pi * rows(speeds)[:, 0] - speeds)
    assert (signs[1:] != signs[:-1]).sum() == 2
    assert len(speeds) < 40


def test_derivatives_of_a_critical_speed_equal_differences_of_independent_ones(response):
    found = lp.vibration.mean_campbell(response, orders=[1.5])
    slopes = lp.vibration.critical_sensitivity(response, found.critical[0])
    near = (0.9 * found.critical[0].speed, 1.1 * found.critical[0].speed)

    def speed(**more):
        stiffness = {key: more.pop(key) for key in ("soft", "cubic") if key in more}
        return critical(1.5, lambda torque: cubic_stiffness(torque, **stiffness), *near, **more)[0]

    varied = {
        "coupling.soft": ("soft", SOFT, 1),
        "coupling.cubic": ("cubic", CUBIC, 1),
        "b.J": ("j_b", J_B, 1),
        "water.tau_nominal": ("rated", 900.0, -1),
    }
    for name, (option, size, sign) in varied.items():
        wanted = sign * slope(lambda x, option=option: speed(**{option: x}), size, 1e-3 * size, 4)
        assert slopes[name] == pytest.approx(wanted, rel=1e-7), name
    # a stiffness that grows with the speed makes them larger than at a constant state
    assert slopes["coupling.cubic"] > 0
    assert "critical speed of mode 1, order 1.5" in repr(slopes)
    assert "motor.tau" not in slopes.by


def test_slips_are_named(response):
    (found,) = lp.vibration.mean_campbell(response, orders=[1.5]).critical
    other = lp.vibration.CriticalSpeed(50.0, 1.5, 0, 12.0)
    with pytest.raises(OptionError, match="no critical speed of mode 1"):
        lp.vibration.critical_sensitivity(response, other)
    with pytest.raises(OptionError, match="free and follows"):
        lp.vibration.critical_sensitivity(response, found, by=["motor.tau"])
    with pytest.raises(OptionError, match="two ascending speeds"):
        lp.vibration.mean_campbell(response, between=(50.0, 40.0))
    with pytest.raises(OptionError, match="positive"):
        lp.vibration.mean_campbell(response, orders=[-1.0])
    system = response.system
    given = lp.vibration.order_response(
        system,
        speeds=[50.0, 60.0],
        of=["coupling.tau"],
        excitations={"motor.tau": {1: 1.0}},
        at=lambda w: lp.start_point(system, start={"a.w": w, "coupling.phi_rel": 1e-3}),
    )
    with pytest.raises(OptionError, match="given at each speed"):
        lp.vibration.critical_sensitivity(given, found)


@pytest.mark.parametrize("free", [None, "gas.mean"])
def test_derivatives_by_the_speed_equal_differences(free):
    """A crank drive with a progressive coupling, whose mean state follows the speed."""
    found = lp.vibration.order_response(ship(), free=free, parameters={"water.d": 20.0}, **OPTIONS)

    def spectrum(speed):
        return MeanSpectrum(found.small, found.turning(np.array([speed])), found.orders)

    received = spectrum(90.0).hertz_by_speed(0)
    wanted = slope(lambda speed: spectrum(speed).hertz[0], 90.0, 0.09, 4)
    assert received == pytest.approx(wanted, rel=1e-7, abs=1e-10)
    assert (abs(received) > 1e-10) == (free is not None)
