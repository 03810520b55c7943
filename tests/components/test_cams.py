"""Switches and loads by the angle of a shaft."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import CamSwitch, Inertia, PulseTorque, Speed
from lumped.errors import EquationError


def turned(part: lp.Component, w: float = 1.0, **options: object) -> lp.Trajectory:
    model = lp.compose(
        drive=Speed(w=w), part=part, connections=lambda m: lp.chain(m.drive.flange, m.part.flange)
    )
    system = lp.assemble(model, keep=["drive.flange.phi"])
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
    @pytest.mark.parametrize(("shape", "mean"), [("half-sine", 2 / np.pi), ("rectangle", 1.0)])
    def test_work_of_a_turn_is_that_of_the_pulse(self, shape, mean):
        pulse = PulseTorque(shape=shape, tau_max=-3.0, centre=0.1, width=1.2)
        run = turned(pulse, w=2.0, grid=20_000)
        received = np.trapezoid(run["part.tau"] * 2.0, run.t) / 4
        expected = -3.0 * 1.2 * mean
        assert abs(received / expected - 1) < 2e-6  # of the trapezoids

    def test_half_sine_is_greatest_in_the_middle(self):
        at = 2.0 + np.array([-0.6, -0.3, 0.0, 0.3, 0.59999])
        run = turned(PulseTorque(tau_max=5.0, centre=2.0 - 2 * np.pi, width=1.2), grid=at)
        received = run["part.tau"][np.isin(run.t, at)]
        expected = 5.0 * np.cos(np.pi * (at - 2.0) / 1.2)
        assert np.abs(received[:5][1:] - expected[1:]).max() < 1e-9

    def test_free_flywheel_gets_the_work_of_each_pulse(self):
        model = lp.compose(
            wheel=Inertia(J=2.0, w=1.0),
            pulse=PulseTorque(tau_max=3.0, centre=1.0, width=0.5),
            connections=lambda m: lp.chain(m.wheel, m.pulse.flange),
        )
        system = lp.assemble(model, keep=["wheel.phi"])
        run = lp.simulate(system, until=5.0, rtol=1e-10)
        turns = 1 + np.floor((run["wheel.phi"][-1] - 1.25) / (2 * np.pi))
        expected = 1.0 + turns * 3.0 * 0.5 * 2 / np.pi
        assert turns >= 1
        assert abs(run["wheel.w"][-1] ** 2 / expected - 1) < 1e-9

    def test_unknown_shape_is_refused(self):
        with pytest.raises(EquationError, match="'half-sine' or 'rectangle'"):
            turned(PulseTorque(shape="triangle", tau_max=1.0, centre=0.0, width=1.0))
