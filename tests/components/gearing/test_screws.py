"""Screws and worms against Shigley's example, angles of friction and motions by hand."""

import numpy as np
import pytest
from rows import assemble_row

import lumped as lp
from lumped.components import (
    BallScrew,
    Inertia,
    LeadScrew,
    Speed,
    Torque,
    WormGear,
    translation,
)
from lumped.errors import ParameterError
from lumped.ops import where

SHIGLEY = LeadScrew(lead=0.008, d=0.030, mu=0.08)
"""Example 8-1: square thread of 32 mm, two starts of 4 mm, mean diameter 30 mm."""


def angles(lead, d, mu, alpha=0.0):
    """Of the lead and of friction."""
    return np.arctan(lead / np.pi / d), np.arctan(mu / np.cos(alpha))


def jack(screw, drive, f, m=100.0, J=0.01, **start):
    """A load on the nut, as a force and a mass; a torque on the screw."""
    return assemble_row(
        drive=Torque(tau=drive),
        rotor=Inertia(J=J, **start),
        screw=screw,
        load=translation.Mass(m=m),
        weight=translation.Force(f=f),
        keep=["load.s", "rotor.phi", "rotor.w"],
    )


def torque(screw, w, f):
    """On the screw that is turned at a speed against a force on its load."""
    system = assemble_row(turn=Speed(w=w), screw=screw, weight=translation.Force(f=f))
    return lp.start_point(system)["screw.flange_a.tau"]


class TestTorque:
    @pytest.mark.parametrize(("w", "printed", "digits"), [(1, 15.94, 5e-3), (-1, 0.466, 5e-4)])
    def test_of_shigleys_example_to_raise_and_to_hold_back(self, w, printed, digits):
        """Without the collar; the load of 6.4 kN lowers itself against 0.466 N.m."""
        assert abs(torque(SHIGLEY, w, -6400.0) - printed) < digits

    @pytest.mark.parametrize("alpha", [0.0, np.radians(15)])
    def test_is_that_of_the_inclined_plane(self, alpha):
        lead, d, mu, f = 0.005, 0.02, 0.12, 800.0
        screw = LeadScrew(lead=lead, d=d, mu=mu, alpha=alpha)
        g, r = angles(lead, d, mu, alpha)
        assert np.isclose(torque(screw, 1, -f), f * d / 2 * np.tan(g + r), rtol=1e-12)
        assert np.isclose(torque(screw, -1, -f), f * d / 2 * np.tan(g - r), rtol=1e-12)
        left = screw.with_({"lead": -lead})
        assert np.isclose(torque(left, -1, -f), -f * d / 2 * np.tan(g + r), rtol=1e-12)

    def test_of_a_worm_is_that_of_the_forces_on_its_flank(self):
        """A normal force with friction along the helix, taken along both pitch circles."""
        gamma, alpha, mu, ratio = 0.3, np.radians(20), 0.06, 15.0
        gear = WormGear(ratio=ratio, gamma=gamma, alpha=alpha, mu=mu)
        for w, tau, rub in ((1, -50.0, mu), (-1, -50.0, -mu)):
            system = assemble_row(turn=Speed(w=w), gear=gear, load=Torque(tau=tau))
            on_worm = np.cos(alpha) * np.sin(gamma) + rub * np.cos(gamma)
            on_wheel = np.cos(alpha) * np.cos(gamma) - rub * np.sin(gamma)
            # the pitch radius of the wheel is ratio tan(gamma) times that of the worm
            expected = -tau * on_worm / (on_wheel * ratio * np.tan(gamma))
            point = lp.start_point(system)
            assert np.isclose(point["gear.flange_a.tau"], expected, rtol=1e-12)
            assert point["gear.support_a.tau"] == -point["gear.flange_a.tau"]
            assert point["gear.support_b.tau"] == -point["gear.flange_b.tau"]


class TestHolding:
    def test_a_load_stays_exactly_and_is_moved_beyond_friction(self):
        lead, d, mu, f = 0.004, 0.03, 0.15, 6400.0
        screw = LeadScrew(lead=lead, d=d, mu=mu)
        push = where(lp.time < 1, 0.0, 40 * (lp.time - 1))
        run = lp.simulate(jack(screw, push, -f), until=1.8, grid=90)
        at_rest = run.t <= 1
        assert (run["rotor.phi"][at_rest] == 0).all()
        assert (run["load.s"][at_rest] == 0).all()
        g, r = angles(lead, d, mu)
        up = [event for event in run.events if event.after == "forward"]
        assert np.isclose(up[0].time, 1 + f * d / 2 * np.tan(g + r) / 40, rtol=1e-9)

    def test_a_load_that_holds_itself_is_driven_down(self):
        lead, d, mu, f = 0.004, 0.03, 0.15, 6400.0
        screw = LeadScrew(lead=lead, d=d, mu=mu)
        run = lp.simulate(jack(screw, -40 * lp.time, -f), until=0.6)
        g, r = angles(lead, d, mu)
        down = [event for event in run.events if event.after == "backward"]
        assert np.isclose(down[0].time, f * d / 2 * np.tan(r - g) / 40, rtol=1e-9)

    def test_a_load_runs_down_a_steep_screw_evenly_faster(self):
        lead, f, m, J, eta = 0.02, 500.0, 30.0, 0.002, 0.85
        screw = BallScrew(lead=lead, eta_a=0.9, eta_b=eta)
        run = lp.simulate(jack(screw, 0.0, -f, m=m, J=J), until=1.0, grid=20)
        i = lead / 2 / np.pi
        expected = -eta * i * f / (J + eta * m * i**2) * run.t
        assert np.abs(run["rotor.w"] - expected).max() < 1e-9 * np.abs(expected).max()

    def test_a_wheel_cannot_turn_its_worm(self):
        gear = WormGear(ratio=40.0, gamma=0.05, alpha=0.35, mu=0.08)
        run = lp.simulate(
            assemble_row(
                rotor=Inertia(J=0.01),
                gear=gear,
                wheel=Inertia(J=1.0),
                pull=Torque(tau=100 * lp.ops.sin(9 * lp.time)),
                keep=["rotor.phi"],
            ),
            until=1.0,
        )
        assert np.abs(run["rotor.phi"]).max() < 1e-18
        assert np.abs(run["rotor.w"]).max() < 1e-12


def test_power_that_is_lost_is_what_does_not_leave():
    screw = LeadScrew(lead=0.01, d=0.02, mu=0.1, alpha=0.2)
    run = lp.simulate(
        jack(screw, 3 * lp.ops.sin(7 * lp.time), -200.0, m=20.0),
        until=3.0,
        rtol=1e-10,
    )
    v = run["screw.w"] * 0.01 / (2 * np.pi)
    left = run["screw.flange_a.tau"] * run["screw.w"] + run["screw.flange_b.f"] * v
    lost = run["screw.tau_loss"] * run["screw.w"]
    assert np.abs(left - lost).max() < 1e-10 * lost.max()
    assert lost.min() > -1e-12
    assert {"forward", "backward"} <= {event.after for event in run.events}


def test_without_friction_it_is_the_ideal_screw():
    run = lp.simulate(jack(LeadScrew(lead=0.01, d=0.02, mu=0.0), 0.0, -200.0), until=0.5)
    i = 0.01 / (2 * np.pi)
    assert np.isclose(run["rotor.w"][-1], -200 * i / (0.01 + 100 * i**2) * 0.5, rtol=1e-9)


@pytest.mark.parametrize(
    ("screw", "message"),
    [
        (LeadScrew(lead=0.0, d=0.02, mu=0.1), r"screw\.lead = 0 m .way in one turn.* zero"),
        (BallScrew(lead=0.01, eta_a=1.1, eta_b=0.8), r"screw\.eta_a = 1\.1 .* at most 1"),
        (BallScrew(lead=0.01, eta_a=0.0, eta_b=0.8), r"screw\.eta_a = 0 .* greater than 0"),
        (BallScrew(lead=0.01, eta_a=0.9, eta_b=1.01), r"screw\.eta_b = 1\.01 .* at most 1"),
        (LeadScrew(lead=0.1, d=0.02, mu=0.9), r"screw\.eta_a = -.* greater than 0"),
    ],
)
def test_what_makes_no_sense_is_refused(screw, message):
    with pytest.raises(ParameterError, match=message):
        torque(screw, 1, -1.0)
