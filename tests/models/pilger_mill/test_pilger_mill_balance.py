"""Cold pilger mill LG90: its balance as an optimum."""

import numpy as np
import pytest
from checks import apart
from pilger_by_hand import ByHand, golden

import lumped as lp
from lumped.models.pilger_mill import stand
from lumped.models.pilger_mill.balance import Balance, balance
from lumped.models.pilger_mill.stand import DESIGNS, SETS, SPEED, Mill

PUBLISHED = np.array(list(DESIGNS["after"].values()))


@pytest.fixture(scope="module", params=["F", "P"])
def found(request):
    return request.param, balance(request.param)


class TestBalance:
    def test_best_sectors_for_the_published_counterweight(self, found):
        name, of = found
        received = of.best_sectors(7228.0)
        assert abs(received - {"F": 3137.40, "P": 3157.93}[name]) < 0.0051
        assert abs(received - ByHand(name).best_sectors(7228.0)) < 1e-4

    def test_optimum_is_that_of_nested_searches_by_hand(self, found):
        """The digits of the reference end at 0.1 kg; here all formulas are written anew."""
        name, of = found
        hand = ByHand(name)
        lightest = golden(lambda m2: hand.force(m2, hand.best_sectors(m2)), 6000.0, 8000.0)
        calmest = golden(hand.fluctuation, 6000.0, 8000.0)
        goals = hand.force(lightest, hand.best_sectors(lightest)), hand.fluctuation(calmest)
        assert np.abs(np.divide(of.goals(), goals) - 1).max() < 1e-6

        def objective(m2):
            return (
                hand.force(m2, hand.best_sectors(m2)) / goals[0] + hand.fluctuation(m2) / goals[1]
            )

        m2 = golden(objective, 6000.0, 8000.0)
        expected = m2, hand.best_sectors(m2)
        assert np.abs(np.divide(of.optimum(), expected) - 1).max() < 1e-6
        assert abs(of.objective(of.optimum()) / objective(m2) - 1) < 1e-6

    def test_printed_sign_of_the_rotating_masses_has_another_best(self, found):
        """(21, 22) add what has to be taken away: the sectors would add to the stand's force."""
        name, of = found
        angle, p, w = np.radians(np.arange(1440) / 4)[:, None], SETS[name], SPEED[name]
        out = w**2 * np.hstack([np.cos(angle), np.sin(angle)])
        rest = (p["m_pin"] + 2 * 0.55 * (p["m_rod"] + p["m_rod_1"])) * 0.59
        force = of.force + np.array([2 * rest * out, 0 * out, -8 * out])
        wrong = Balance(force, of.torque)
        expected, sectors = {"P": (537e3, 348), "F": (2804e3, 23)}[name]
        assert abs(wrong.forces(PUBLISHED).max() / expected - 1) < 1e-3
        assert abs(wrong.best_sectors(7228.0) - sectors) < 0.51

    def test_front_falls_and_is_convex(self, found):
        _, of = found
        front = of.front(20)
        force, torque = front[:, 2], front[:, 3]
        assert (np.diff(force) > 0).all()
        assert (np.diff(torque) < 0).all()
        assert (np.diff(np.diff(force)) > -1e-6 * force[0]).all()
        for w in (0.2, 0.5, 0.8):  # no weighted optimum lies below the front
            u = of.best((1 - w) / force[0], w / torque[-1])
            F1, F2 = of.forces(u).max(), of.fluctuation(u)
            on_front = np.interp(F2, torque[::-1], force[::-1])
            assert F1 - on_front > -2e-4 * force[0]

    def test_torque_without_gravity_does_not_know_the_sectors(self, found):
        _, of = found
        assert np.abs(of.torque[2]).max() < 1e-9
        heavy = balance("P", kind=Mill, g=9.80665).torque[2]
        assert abs(np.ptp(heavy) - 2 * 4 * 9.80665 / 0.96) < 1e-4

    def test_curves_of_a_design_are_those_of_its_own_run(self, found):
        name, of = found
        w, degrees = SPEED[name], np.arange(1441) / 4
        own = stand.revolution(stand.turn_mill(stand.mill(name), w * lp.time), w, degrees)
        force = np.hypot(*stand.shaking_force(own).T)[:-1]
        assert apart(of.forces(PUBLISHED), force) < 1e-11

    def test_ideal_cranks_have_the_optimum_of_the_closed_form(self):
        """Without slope of the rods the force is zero at My = Mx, S = (Mx + mq) R."""
        angle, Mx, My0, mq, r = np.radians(np.arange(1440) / 4), 9.4e3, 1.6e3, 11e3, 0.59
        cosine, sine, none = np.cos(angle), np.sin(angle), np.zeros(1440)
        force = [
            np.column_stack([-(Mx + mq) * r * cosine, -(My0 + mq) * r * sine]),
            np.column_stack([none, -r * sine]),
            np.column_stack([4 * cosine, 4 * sine]),
        ]
        both = r**2 * np.sin(2 * angle) / 2
        torque = np.array([(My0 - Mx) * both, both, none])
        ideal = Balance(np.array(force) * 45 + 1e-3, torque * 45)
        received = ideal.best(1e-5, 1e-5)
        assert np.abs(received / [Mx - My0, (Mx + mq) * r / 4] - 1).max() < 1e-6
