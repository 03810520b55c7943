"""Geneva wheel against the geometry of its pin, closed forms, energy and an integration."""

import numpy as np
import pytest
import scipy
from rows import assemble_row

import lumped as lp
from lumped.components import Geneva, Inertia, Position, Torque
from lumped.errors import EquationError

W = 3.0


def turned(n, turns=4.0, w=W, **options):
    """The driver turned from opposite of the wheel, with a torque on the wheel."""
    system = assemble_row(
        turn=Position(phi=w * lp.time),
        geneva=Geneva(slots=n, phase=-np.pi),
        table=Inertia(J=2.0),
        load=Torque(tau=-5.0),
        keep=["table.phi", "turn.phi"],
    )
    return lp.simulate(system, until=2 * np.pi * turns / abs(w), **options)


@pytest.mark.parametrize("n", [3, 4, 6, 12])
class TestMotion:
    def test_a_slot_points_at_the_pin_while_it_turns(self, n):
        """Directions as complex numbers; the wheel's axis is at the distance 1 of the driver's."""
        run = turned(n, grid=720)
        x = run["turn.phi"] - np.pi
        engaged = np.cos(x) > np.sin(np.pi / n)
        to_pin = np.sin(np.pi / n) * np.exp(1j * x[engaged]) - 1
        slot = -np.exp(1j * run["table.phi"][engaged])
        assert np.abs((to_pin / np.abs(to_pin) / slot) ** n - 1).max() < 1e-12
        assert np.count_nonzero(engaged) > 100

    def test_it_stands_in_between_and_one_slot_further_after_each_turn(self, n):
        run = turned(n, grid=720)
        x = run["turn.phi"] - np.pi
        locked = np.cos(x) < np.sin(np.pi / n)
        passed = np.round((x[locked] + np.pi) / (2 * np.pi))
        expected = (1 - 2 * passed) * np.pi / n
        assert np.abs(run["table.phi"][locked] - expected).max() < 1e-13
        assert np.abs(run["table.w"][locked]).max() < 1e-12
        assert np.abs(run["turn.flange.tau"][locked]).max() < 1e-12

    def test_the_pin_enters_and_leaves_at_a_right_angle_to_the_line_of_the_axes(self, n):
        run = turned(n)
        half = np.pi / 2 - np.pi / n
        centres = np.pi + 2 * np.pi * np.arange(4)
        expected = np.sort([*(centres - half), *(centres + half)]) / W
        assert np.allclose([event.time for event in run.events], expected, rtol=1e-12)
        assert [event.after for event in run.events] == ["pin in a slot", "wheel locked"] * 4

    def test_greatest_speed_and_jump_of_acceleration_are_those_of_the_books(self, n):
        entry = (np.pi / 2 + np.pi / n) / W
        run = turned(n, turns=0.5, grid=[0.0, entry * (1 - 1e-9), entry * (1 + 1e-9), np.pi / W])
        e = np.sin(np.pi / n)
        assert np.isclose(run["table.w"][-1], -W * e / (1 - e), rtol=1e-12)
        before, after = np.searchsorted(run.t, entry * (1 + 1e-9 * np.array([-1, 1])) - 1e-12)
        assert abs(run["table.a"][before]) < 1e-12
        assert np.isclose(-run["table.a"][after], np.tan(np.pi / n) * W**2, rtol=1e-7)


def test_backwards_it_goes_the_same_way():
    there, back = turned(5, grid=200), turned(5, w=-W, grid=200)
    assert np.isclose(back["table.phi"][-1] - back["table.phi"][0], 4 * 2 * np.pi / 5, rtol=1e-12)
    assert [event.after for event in back.events] == [event.after for event in there.events]


def test_two_flywheels_keep_their_energy_over_ten_slots():
    system = assemble_row(
        wheel=Inertia(J=0.5, w=8.0, phi=-2.0), geneva=Geneva(slots=6), table=Inertia(J=2.0)
    )
    run = lp.simulate(system, until=10.0, rtol=1e-10)
    energy = 0.25 * run["wheel.w"] ** 2 + run["table.w"] ** 2
    assert len(run.events) > 20
    assert run["wheel.w"].min() < 5
    assert np.abs(energy / energy[0] - 1).max() < 1e-8


def test_driven_by_a_torque_against_an_independent_integration():
    J, load, n = (0.5, 2.0), 3.0, 4
    system = assemble_row(
        drive=Torque(tau=2.0),
        wheel=Inertia(J=J[0], w=4.0, phi=-1.5),
        geneva=Geneva(slots=n),
        table=Inertia(J=J[1]),
        brake=Torque(tau=load),
        keep=["wheel.phi"],
    )
    run = lp.simulate(system, until=3.0, grid=50, rtol=1e-10)
    e = np.sin(np.pi / n)

    def ratio(x):
        return e * (np.cos(x) - e) / (1 - 2 * e * np.cos(x) + e * e)

    def slope(x):
        return e * np.sin(x) * (e * e - 1) / (1 - 2 * e * np.cos(x) + e * e) ** 2

    def rates(t, y):
        x, w = y
        k, s = (ratio(x), slope(x)) if np.cos(x) > e else (0.0, 0.0)
        return w, (2.0 - k * load - J[1] * k * s * w * w) / (J[0] + J[1] * k * k)

    times, index = np.unique(run.t, return_inverse=True)
    found = scipy.integrate.solve_ivp(
        rates, (0, 3.0), (-1.5, 4.0), "DOP853", times, rtol=1e-12, atol=1e-12, max_step=1e-3
    )
    assert len(run.events) > 1
    assert np.abs(run["wheel.w"] - found.y[1][index]).max() < 1e-6


@pytest.mark.parametrize("slots", [2, 4.5, -4])
def test_too_few_slots_are_refused(slots):
    with pytest.raises(EquationError, match=rf"geneva .*slots = {slots}: .* at least 3"):
        turned(slots)
