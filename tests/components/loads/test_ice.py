"""Ice on a propeller: half sines over the angle, and what a shaft answers."""

from itertools import pairwise

import numpy as np
import pytest
from rows import assemble_row, assemble_rows
from scipy.integrate import quad

import lumped as lp
from lumped.components import IceTorque, Inertia, Position, Speed, Spring
from lumped.errors import EquationError, ParameterError, SolverError

ONE = ((0.75, np.pi / 2, 0.0),)
TWO = ((0.5, np.pi / 4, 0.0), (0.5, np.pi / 4, 0.9))


def series(blocks, Z, angle):
    """Sum of half sines over the angle since the begin, each blade after the one before."""
    total = np.zeros_like(angle)
    for blade in range(Z):
        for factor, width, first in blocks:
            x = np.mod(angle - 2 * np.pi * blade / Z - first, 2 * np.pi)
            total += factor * np.where(x < width, np.sin(np.pi * x / width), 0.0)
    return total


@pytest.mark.parametrize("Z", [1, 3, 4])
@pytest.mark.parametrize("blocks", [ONE, ((1.0, 0.75 * np.pi, 0.3),), TWO])
def test_torques_of_the_blades_add_between_their_ramps(blocks, Z):
    turn = Position(phi=4.0 * lp.time)
    ice = IceTorque(blocks=blocks, Z=Z, Q_max=2e5, turns=4.0, begin=1.0)
    at = np.linspace(0.0, 7.0, 1401)
    run = lp.simulate(assemble_row(turn=turn, ice=ice, keep=["ice.tau"]), until=7.0, grid=at)
    angle = 4.0 * at - 1.0
    ramp = np.clip(np.minimum(angle, 8 * np.pi - angle) / (1.5 * np.pi), 0.0, 1.0)
    assert run["ice.tau"] == pytest.approx(2e5 * ramp * series(blocks, Z, angle), abs=1e-7)


def test_work_of_a_turn_is_that_of_its_half_sines():
    """Each half sine does ``C_q Q_max 2 alpha / pi``; with TWO and 4 blades 8 of them."""
    ice = IceTorque(blocks=TWO, Z=4, Q_max=1e5, turns=10.0)
    model = assemble_row(turn=Position(phi=lp.time), ice=ice, keep=["ice.tau"])
    points = np.linspace(10.0, 10.0 + 2 * np.pi, 8001)
    run = lp.simulate(model, until=17.0, grid=points)
    received = np.trapezoid(run["ice.tau"], points)
    assert received == pytest.approx(8 * 0.5 * 1e5 * 2 * (np.pi / 4) / np.pi, rel=1e-6)


@pytest.mark.parametrize("rate", [0.6, 2.3])
def test_two_masses_answer_one_half_sine_as_the_closed_form(rate):
    """Twist by ``q / (w^2 - W^2) (sin(W t) - W / w sin(w t))``, then free vibration.

    The hull turns instead of the propeller, so that the angle is the time's, and the ramp is over.
    """
    J_p, J_e, c, Q, alpha = 100.0, 300.0, 1e6, 1e-3, np.pi / 2
    w = np.sqrt(c * (1 / J_p + 1 / J_e))
    W = rate * w  # pi times the speed over alpha
    hull = W * alpha / np.pi
    lead = 4 * np.pi  # the ramp is over
    system = assemble_rows(
        *("engine shaft propeller ice.flange", "ice.support hull.flange"),
        engine=Inertia(J=J_e, w=0.0),
        shaft=Spring(c=c, phi_rel=0.0),
        propeller=Inertia(J=J_p),
        ice=IceTorque(blocks=((0.75, alpha, 0.0),), Z=1, Q_max=Q, turns=5.0, begin=-lead),
        hull=Position(phi=-hull * lp.time),
        keep=["shaft.phi_rel"],
    )
    pulse = np.pi / W
    run = lp.simulate(system, until=2.5 * pulse, rtol=1e-12, atol=1e-20)
    q = -0.75 * Q / J_p

    def twist(t):
        return q / (w**2 - W**2) * (np.sin(W * t) - W / w * np.sin(w * t))

    def rate_of(t):
        return q * W / (w**2 - W**2) * (np.cos(W * t) - np.cos(w * t))

    after = run.t - pulse
    free = twist(pulse) * np.cos(w * after) + rate_of(pulse) / w * np.sin(w * after)
    expected = np.where(run.t < pulse, twist(run.t), free)
    assert run["shaft.phi_rel"] == pytest.approx(expected, abs=2e-6 * np.abs(expected).max())


def test_a_free_propeller_is_slowed_by_the_work_of_the_ice():
    J, w_0 = 50.0, 12.0
    ice = IceTorque(blocks=ONE, Z=4, Q_max=100.0, turns=3.0)
    system = assemble_row(body=Inertia(J=J, w=w_0, phi=0.0), ice=ice, keep=["body.phi"])
    run = lp.simulate(system, until=2.0, rtol=1e-11)
    angle = run["body.phi"][-1]
    assert angle > 6 * np.pi

    def torque(a):
        ramp = np.clip(min(a, 6 * np.pi - a) / (1.5 * np.pi), 0.0, 1.0)
        return 100.0 * ramp * series(ONE, 4, np.array(a))

    edges = np.arange(13) * np.pi / 2
    work = sum(quad(torque, a, b, epsabs=1e-12)[0] for a, b in pairwise(edges))
    assert J * (w_0**2 - run["body.w"][-1] ** 2) / 2 == pytest.approx(work, rel=1e-9)


def test_a_propeller_turns_back_outside_of_the_sequence_only():
    """At 5 rad/s for 3 s and back, the ice of two turns from 0 on is met twice."""
    ice = IceTorque(blocks=ONE, Q_max=1e3, turns=2.0)
    turned = lp.ops.table([0.0, 3.0, 6.0], [0.0, 15.0, 0.0])
    run = lp.simulate(assemble_row(turn=Position(phi=turned), ice=ice), until=3.4)
    assert run["ice.w"][-1] == pytest.approx(-5.0, rel=1e-9)
    with pytest.raises(SolverError, match=r"speed in the ice = -.* forward motion"):
        lp.simulate(assemble_row(turn=Position(phi=turned), ice=ice), until=4.0)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"blocks": ()}, "rows of factor, width"),
        ({"blocks": ((0.75, 90.0, 0.0),)}, "width 90 rad"),
        ({"blocks": ((-0.75, 1.0, 0.0),)}, "factor -0.75"),
        ({"Z": 0}, "Z = 0"),
    ],
)
def test_blocks_that_make_no_sense_are_refused(given, words):
    with pytest.raises(EquationError, match=words):
        assemble_row(
            turn=Speed(w=1.0), ice=IceTorque(**{"blocks": ONE, "Q_max": 1.0} | given, turns=2.0)
        )


def test_a_negative_torque_of_ice_is_refused():
    with pytest.raises(ParameterError, match=r"ice.Q_max = -5 N.m"):
        assemble_row(turn=Speed(w=1.0), ice=IceTorque(blocks=ONE, Q_max=-5.0, turns=2.0))
