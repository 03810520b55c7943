"""Switches and loads by the angle of a shaft."""

import numpy as np
import pytest
from rows import assemble_row, in_a_row
from scipy.interpolate import CubicSpline

import lumped as lp
from lumped.components import CamSwitch, HarmonicTorque, Inertia, PeriodicTorque, PulseTorque, Speed


def turned(part: lp.Component, w: float = 1.0, **options: object) -> lp.Trajectory:
    system = assemble_row(drive=Speed(w=w), part=part, keep=["drive.flange.phi"])
    return lp.simulate(system, until=4 * np.pi, rtol=1e-10, **options)


def changes(run: lp.Trajectory, component: str) -> np.ndarray:
    return np.array([event.time for event in run.events if event.component == component])


class TestCamSwitch:
    @pytest.mark.parametrize("w", [1.0, -1.0])
    def test_switches_at_the_ends_of_its_range_in_every_turn(self, w):
        run = turned(CamSwitch(centre=1.0, width=0.6), w)
        first = np.array([0.7, 1.3]) if w > 0 else 2 * np.pi - np.array([1.3, 0.7])
        expected = np.concatenate([first, first + 2 * np.pi])
        assert np.abs(changes(run, "part") - expected).max() < 1e-9

    def test_is_on_within_its_range_and_rests_elsewhere(self):
        run = turned(CamSwitch(centre=0.0, width=2.0), grid=[0.5, 1.5, 3.0, 5.0, 6.0, 7.0, 8.0])
        at = np.isin(run.t, [0.5, 1.5, 3.0, 5.0, 6.0, 7.0, 8.0])
        assert np.array_equal(run["part.y"][at], [1, 0, 0, 0, 1, 1, 0])
        assert np.array_equal(run["part.rest"], 1 - run["part.y"])


class TestPulseTorque:
    def test_half_sine_is_greatest_in_the_middle(self):
        at = 2.0 + np.array([-0.6, -0.3, 0.0, 0.3, 0.59999])
        run = turned(PulseTorque(tau_max=5.0, centre=2.0 - 2 * np.pi, width=1.2), grid=at)
        received = run["part.tau"][np.isin(run.t, at)]
        expected = 5.0 * np.cos(np.pi * (at - 2.0) / 1.2)
        assert np.abs(received[:5][1:] - expected[1:]).max() < 1e-9

    def test_free_flywheel_gets_the_work_of_each_pulse(self):
        model = in_a_row(
            wheel=Inertia(J=2.0, w=1.0), pulse=PulseTorque(tau_max=3.0, centre=1.0, width=0.5)
        )
        system = lp.assemble(model, keep=["wheel.phi"])
        run = lp.simulate(system, until=5.0, rtol=1e-10)
        turns = 1 + np.floor((run["wheel.phi"][-1] - 1.25) / (2 * np.pi))
        expected = 1.0 + turns * 3.0 * 0.5 * 2 / np.pi
        assert turns >= 1
        assert abs(run["wheel.w"][-1] ** 2 / expected - 1) < 1e-9


def torques(part: lp.Component, angles: np.ndarray) -> np.ndarray:
    """Torque of a load at given angles."""
    system = assemble_row(turn=Speed(w=1.0), part=part, keep=["turn.flange.phi"])
    name = system.state_names[0]
    return np.array([lp.start_point(system, start={name: a})["part.tau"] for a in angles])


def flywheel(part: lp.Component, until: float, w: float = 30.0) -> lp.Trajectory:
    """A flywheel of 2 kg.m2 under a load."""
    system = assemble_row(wheel=Inertia(J=2.0, w=w), part=part, keep=["wheel.phi"])
    return lp.simulate(system, until=until, rtol=1e-10, grid=400)


class TestHarmonicTorque:
    ROWS = ((0.5, 3.0, 0.4), (1.0, -2.0, 0.0), (2.5, 1.5, -1.1), (12.0, 0.2, 2.0))

    def test_its_spectrum_over_two_turns_is_that_of_the_rows(self):
        angles = 4 * np.pi * np.arange(64) / 64
        received = torques(HarmonicTorque(harmonics=self.ROWS, mean=-0.7), angles)
        # A sin(k phi + p) = Im A exp(j p) exp(j k phi): the line of order k is A exp(j p) / (2 j)
        expected = np.zeros(33, complex)
        expected[0] = -0.7
        for order, amplitude, phase in self.ROWS:
            expected[round(2 * order)] = amplitude * np.exp(1j * phase) / 2j
        assert np.abs(np.fft.rfft(received) / 64 - expected).max() < 1e-14


class TestPeriodicTorque:
    POINTS = ((-0.5, 3.0), (0.4, -1.0), (1.0, 2.0), (1.3, 2.5), (2.9, -4.0))
    PERIOD = 4.0

    @pytest.mark.parametrize("shape", ["smooth", "lines"])
    @pytest.mark.parametrize("turn", [0, 1, 250, -3])
    def test_every_period_is_the_curve_through_the_points(self, shape, turn):
        angles, values = np.array([*self.POINTS, (3.5, 3.0)]).T
        x = np.linspace(-0.5, 3.4999, 60)
        part = PeriodicTorque(points=self.POINTS, shape=shape, period=self.PERIOD)
        received = torques(part, x + turn * self.PERIOD)
        law = CubicSpline(angles, values, bc_type="periodic")
        assert received == pytest.approx(
            law(x) if shape == "smooth" else np.interp(x, angles, values), abs=1e-11
        )

    def test_one_point_is_a_constant(self):
        for shape in ("smooth", "lines"):
            received = torques(
                PeriodicTorque(points=((1.0, 5.0),), shape=shape), np.array([0.0, 9.0])
            )
            assert received == pytest.approx([5.0, 5.0])


@pytest.mark.parametrize("w", [40.0, -40.0])
def test_a_cut_falls_on_every_turn_in_both_directions(w):
    """A rectangular cut takes the same work from a flywheel in each turn."""
    cut = PulseTorque(shape="rectangle", tau_max=-3.0 * np.sign(w), centre=1.0, width=0.5)
    run = flywheel(cut, 1.3, w)
    begins = 0.75 if w > 0 else 2 * np.pi - 1.25
    cuts = np.floor((np.abs(run["wheel.phi"]) - begins) / (2 * np.pi)) + 1
    within = np.abs(run["wheel.phi"]) - begins - 2 * np.pi * (cuts - 1)
    expected = 40.0**2 - 3.0 * (0.5 * (cuts - 1) + np.clip(within, 0, 0.5)) * (cuts > 0)
    assert run["wheel.w"] ** 2 == pytest.approx(expected, rel=1e-9)
    assert cuts[-1] == (9 if w > 0 else 8)
