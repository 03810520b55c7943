"""Critical speeds that follow the mean torque, kept away from the speeds of operation."""

import numpy as np
import pytest
from progressive_drive import CUBIC, Progressive, critical, cubic_stiffness, drive, hertz, respond

import lumped as lp
from lumped import functionals as fun
from lumped.errors import OptimisationError, OptionError

BETWEEN = (95.0, 110.0)
ORDER = 1.5
APART = fun.separation([ORDER], between=BETWEEN)


@pytest.fixture(scope="module")
def response():
    return respond(drive(Progressive()), [60.0, 150.0])


def critical_of(soft, cubic, begin=40.0, end=200.0):
    (speed,) = critical(ORDER, lambda torque: cubic_stiffness(torque, soft, cubic), begin, end)
    return speed


def test_a_critical_speed_leaves_the_range_of_operation(response):
    begin = critical_of(2e4, CUBIC)
    assert BETWEEN[0] < begin < BETWEEN[1]
    found = lp.optimise(
        response,
        vary={"coupling.soft": (5e3, 1e5)},
        minimise={"coupling.soft": -1.0},
        subject_to=APART >= 0.1,
    )
    (soft,) = found.parameters.values()
    speed = critical_of(soft, CUBIC)
    # a softer beginning of the characteristic has the steeper slope at the mean torque
    assert speed == pytest.approx(1.1 * BETWEEN[1], rel=1e-8)
    assert found.values[APART] == pytest.approx(0.1, rel=1e-7)
    assert str(APART) in found.active[0]
    assert soft < 2e4
    # at the frequency of one state, that of the first speed, it would stay elsewhere
    fixed = 2 * np.pi * hertz(60.0, lambda t: cubic_stiffness(t, soft, CUBIC)) / ORDER
    assert abs(fixed / speed - 1) > 0.05


def test_the_separation_is_made_large_by_both_stiffnesses(response):
    """Against the best of a grid of both."""
    vary = {"coupling.soft": (1.2e4, 1e5), "coupling.cubic": (1e6, 1e7)}
    found = lp.optimise(
        response,
        vary=vary,
        minimise={APART: -1.0, "coupling.soft": -1e-9, "coupling.cubic": -1e-11},
    )
    best = max(
        1 - critical_of(soft, cubic) / BETWEEN[0]
        for soft in np.linspace(1.2e4, 2e4, 9)
        for cubic in np.linspace(1e6, 5e6, 9)
    )
    print(found.values[APART], best)
    assert found.values[APART] == pytest.approx(best, abs=1e-3)
    own = 1 - critical_of(*found.parameters.values()) / BETWEEN[0]
    assert found.values[APART] == pytest.approx(own, rel=1e-7)


def test_limits_of_vibration_and_separation_hold_together(response):
    peak = fun.order_peak("coupling.tau", measure=1.0)
    limit = 0.9 * float(response.magnitude("coupling.tau", 1.0).max())
    found = lp.optimise(
        response,
        vary={"coupling.soft": (5e3, 1e5), "b.J": (2.0, 20.0)},
        minimise={"b.J": 1.0},
        subject_to=[peak <= limit, APART >= 0.05],
    )
    soft, j_b = found.parameters.values()
    (speed,) = critical(
        ORDER, lambda torque: cubic_stiffness(torque, soft, CUBIC), 40.0, 250.0, j_b=j_b
    )
    low, high = BETWEEN
    assert not low * 0.95 * (1 + 1e-8) < speed < high * 1.05 * (1 - 1e-8)
    assert found.run.magnitude("coupling.tau", 1.0).max() <= limit * (1 + 1e-8)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"minimise": {APART: 1.0}}, "can be made large"),
        ({"subject_to": APART <= 0.5}, "can be made large"),
        ({"subject_to": APART >= 1.0}, "a share under"),
    ],
)
def test_slips_are_named(response, options, text):
    given = {"vary": {"coupling.soft": (5e3, 1e5)}, "minimise": {"coupling.soft": 1.0}, **options}
    with pytest.raises(OptionError, match=text):
        lp.optimise(response, **given)


@pytest.mark.parametrize(
    ("orders", "between", "text"),
    [([], (1.0, 2.0), "positive"), ([0.0], (1.0, 2.0), "positive"), ([1], (2.0, 1.0), "first")],
)
def test_what_makes_no_separation_is_named(orders, between, text):
    with pytest.raises(OptionError, match=text):
        fun.separation(orders, between=between)


def test_a_separation_out_of_reach_is_told_with_its_speed(response):
    with pytest.raises(OptimisationError, match=r"separation\(orders 1.5.* mode 0 at .* 1/min"):
        lp.optimise(
            response,
            vary={"coupling.soft": (1.9e4, 2.1e4)},
            minimise={"coupling.soft": 1.0},
            subject_to=APART >= 0.3,
        )
