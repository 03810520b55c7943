"""What docs/analyses/steady.md shows is true."""

import casadi as ca
import numpy as np
import pytest

import lumped as lp
from lumped.models.reversing_mill.scenes import KINETIC, RATED, SPEED, STATIC
from lumped.models.reversing_mill.stand import C_SHAFT, C_SPINDLE

NAME = "analyses/steady"
DROOP = 0.03


def shares(eps):
    """Torques of upper and lower spindle over the rated one, and the upper motor's speed.

    With slip t = (1 + s) - s tau for each motor; stuck, the lower rolls turn 1 + eps times as fast,
    and the torque between the rolls reaches them divided by 1 + eps.
    """
    # u: speed over SPEED; (tau_u - 1) + (1 + eps)(tau_l - 1) == 0 with tau = (1 + s - u) / s
    r, s = 1 + eps, DROOP
    u = ((1 + s) * (1 + r) - s * (1 + r)) / (1 + r**2)
    upper, lower = (1 + s - u) / s, (1 + s - r * u) / s
    if abs(upper - 1) > STATIC / RATED:
        upper = 1 + np.copysign(KINETIC / RATED, eps)
        lower = 1 - np.copysign(KINETIC / RATED, eps) / r
        u = 1 + s - s * upper
    return upper, lower, u


def test_motors_share_the_load_as_calculated_by_hand(names):
    skids = 0
    for eps, point in zip(names["differences"], names["points"], strict=True):
        upper, lower, u = shares(eps)
        skids += abs(point["gap.w_rel"]) > 0
        assert point["upper.spindle.tau"] / RATED == pytest.approx(upper, rel=1e-9)
        assert point["lower.spindle.tau"] / RATED == pytest.approx(lower, rel=1e-9)
        assert point["upper.motor.w"] / SPEED == pytest.approx(u, rel=1e-11)
        assert point["upper.shaft.phi_rel"] == pytest.approx(upper * RATED / C_SHAFT, rel=1e-9)
        assert point["upper.spindle.phi_rel"] == pytest.approx(upper * RATED / C_SPINDLE, rel=1e-9)
        assert point.search.residual < 1e-10
        assert point.search.growth == 0
    assert skids == 16


def test_its_derivatives_are_those_of_the_formula(names):
    eps = ca.SX.sym("eps")
    r, s = 1 + eps, DROOP
    upper = (1 + s - (1 + r) / (1 + r**2)) / s
    expected = float(ca.Function("slope", [eps], [ca.jacobian(upper, eps)])(0.01))
    found = names["found"]
    assert found["upper.spindle.tau", "eps"] / RATED == pytest.approx(expected, rel=1e-7)
    assert expected / 100 == pytest.approx(1 / 6, rel=1e-2)
    # loads of m times the rated torque: tau_u + r tau_l == m (1 + r), so u falls by
    # s (1 + r) / (1 + r^2) for each m, and the torque rises by that over s
    share = (1 + 1.01) / (1 + 1.01**2)
    assert found["upper.spindle.tau", "M_pr"] == pytest.approx(share, rel=1e-7)


def test_the_linearisation_gains_as_the_formula_says(names):
    line = names["line"]
    own = [i for i, name in enumerate(line.states) if name != "gap.w_rel"]
    A, B, C = line.A[np.ix_(own, own)], line.B[own], line.C[:, own]
    gain = (line.D - C @ np.linalg.solve(A, B)).item()
    assert gain == pytest.approx((1 + 1.01) / (1 + 1.01**2), rel=1e-9)


def test_the_static_response_is_that_slope_and_its_own_slope_is_that_of_the_formula(names):
    """The rolls stick, so that nothing drifts at 0 Hz."""
    response = lp.frequency_response(
        names["system"],
        inputs=["M_pr"],
        outputs=["upper.spindle.tau"],
        hertz=[0.0, 1.0],
        at=names["point"],
    )
    r = 1.01
    static = response["upper.spindle.tau", "M_pr"][0]
    assert static == pytest.approx((1 + r) / (1 + r**2), rel=1e-9)
    slope = lp.vibration.response_sensitivity(response, by=["eps"])[
        "upper.spindle.tau", "M_pr", "eps"
    ][0]
    expected = (1 + r**2 - 2 * r * (1 + r)) / (1 + r**2) ** 2
    assert slope == pytest.approx(expected, rel=1e-7)
