"""Loads over the stroke of a crank, and a motor with the torque of an inverter."""

import numpy as np
import pytest
from rows import in_a_row
from scipy.special import beta

import lumped as lp
from lumped.components import Fixed, InverterInductionMotor, Speed, StrokeLoad, translation


class TestStrokeLoad:
    def test_work_of_both_ways_is_that_of_the_beta_function(self):
        p, q, forth, back = 1.3, 0.66, 50.0, 20.0

        class Metered(lp.Component):
            load: StrokeLoad = StrokeLoad(forward=forth, backward=back, s_0=-1, s_1=1, p=p, q=q)
            move: translation.Position = translation.Position(s=-lp.ops.cos(lp.time))
            work: lp.Var = lp.var("1", "work", state="prefer")

            def connections(self):
                yield lp.connect(self.load.flange, self.move.flange)

            def equations(self):
                yield lp.der(self.work) == self.load.loss()

        run = lp.simulate(
            lp.assemble(Metered()), until=2 * np.pi, grid=[np.pi, 2 * np.pi], rtol=1e-9
        )
        top = p / (p + q)
        stroke = 2 * beta(p + 1, q + 1) / (top**p * (1 - top) ** q)
        assert abs(run["work"][0] / (forth * stroke) - 1) < 1e-5
        assert abs(run["work"][1] / ((forth + back) * stroke) - 1) < 1e-5

    def test_force_is_greatest_at_its_place_and_none_beyond_the_ends(self):
        load = StrokeLoad(forward=50.0, backward=20.0, s_0=-1, s_1=3, p=1.0, q=3.0)
        model = in_a_row(load=load, move=translation.Position(s=lp.time - 2.0))
        run = lp.simulate(lp.assemble(model), until=6.0, grid=[0.5, 1.0, 2.0, 3.0, 5.0, 5.5])
        expected = [0, 0, -50, -50 * 2 * (2 / 3) ** 3, 0, 0]  # g = 4 z (4 (1 - z) / 3)^3
        assert np.abs(run["load.f"] - expected).max() < 1e-12


MOTOR = {"J": 2.0, "tau_k": 130.0, "d_k": 5.0, "T": 0.02}


class TestInverterInductionMotor:
    @pytest.mark.parametrize(("slip", "share"), [(5.0, 1.0), (-5.0, -1.0), (10.0, 0.8), (0.0, 0.0)])
    def test_torque_comes_with_its_lag_to_the_curve(self, slip, share):
        model = in_a_row(
            motor=InverterInductionMotor(w_s=100.0, **MOTOR), turn=Speed(w=100.0 - slip)
        )
        run = lp.simulate(lp.assemble(model), until=0.1, rtol=1e-10)
        expected = share * 130.0 * (1 - np.exp(-run.t / 0.02))
        assert np.abs(run["motor.tau"] - expected).max() < 1e-7

    def test_stalled_rotor_feels_the_far_end_of_the_curve(self):
        model = in_a_row(motor=InverterInductionMotor(w_s=100.0, **MOTOR), wall=Fixed())
        point = lp.equilibrium(lp.assemble(model))
        assert abs(point["motor.tau"] / (130.0 * 2 * 20 / (1 + 20**2)) - 1) < 1e-9

    def test_free_rotor_comes_to_the_speed_of_the_field(self):
        model = lp.compose(motor=InverterInductionMotor(w_s=-40.0, **MOTOR))
        run = lp.simulate(lp.assemble(model), until=10.0)
        assert abs(run["motor.w"][-1] + 40.0) < 1e-4
