"""Equivalent loads, mean speeds and load spectra against integrals by hand."""

import numpy as np
import pytest
import scipy

import lumped as lp
from lumped.components import Damper, Fixed, Inertia, Speed, Torque
from lumped.errors import OptionError
from lumped.life import LoadSpectrum, equivalent_load, load_spectrum, mean_speed

P = 10 / 3
OF = ("body.flange_a.tau", "body.w")


def rig(torque, speed):
    """A shaft whose torque and speed over time are given."""
    return lp.assemble(
        lp.compose(
            pull=Torque(tau=torque),
            body=Inertia(J=1e-9),
            turn=Speed(w=speed),
            connections=lambda m: [*lp.chain(m.pull, m.body, m.turn)],
        ),
        keep=["pull.tau"],
    )


@pytest.fixture(scope="module")
def run():
    # torque 100 + 20 t and speed 10 + t from 0 to 4 s
    return lp.simulate(rig(100 + 20 * lp.time, 10 + lp.time), until=4.0, grid=400, rtol=1e-10)


def integrate(f):
    return scipy.integrate.quad(f, 0, 4, epsabs=0, epsrel=1e-12)[0]


class TestRun:
    @pytest.mark.parametrize("exponent", [3.0, P, 6.61])
    def test_equivalent_load_is_the_mean_over_revolutions(self, run, exponent):
        turned = integrate(lambda t: 10 + t)
        done = integrate(lambda t: (100 + 20 * t) ** exponent * (10 + t))
        received = run.value(equivalent_load(OF, exponent=exponent))
        assert received == pytest.approx((done / turned) ** (1 / exponent), rel=1e-8)

    def test_a_part_of_a_run(self, run):
        turned = scipy.integrate.quad(lambda t: 10 + t, 1, 2)[0]
        done = scipy.integrate.quad(lambda t: (100 + 20 * t) ** 3 * (10 + t), 1, 2)[0]
        received = run.value(equivalent_load(OF, exponent=3.0, between=(1.0, 2.0)))
        assert received == pytest.approx((done / turned) ** (1 / 3), rel=1e-8)
        assert run.value(mean_speed(OF[1], between=(1.0, 2.0))) == pytest.approx(11.5, rel=1e-8)

    def test_signs_do_not_matter(self):
        found = lp.simulate(rig(-100 - 20 * lp.time, -10 - lp.time), until=4.0, rtol=1e-10)
        done = integrate(lambda t: (100 + 20 * t) ** P * (10 + t))
        assert found.value(equivalent_load(OF)) == pytest.approx((done / 48) ** 0.3, rel=1e-8)
        assert found.value(mean_speed(OF[1])) == pytest.approx(12.0, rel=1e-8)

    def test_names_and_expressions_are_the_same(self, run):
        model = lp.compose(pull=Torque(tau=100.0), body=Inertia(J=2.0))
        named = equivalent_load(OF)
        told = equivalent_load((model.body.flange_a.tau, model.body.w))
        assert run.value(told) == run.value(named)
        assert str(told) == str(named) == "equivalent_load(body.flange_a.tau, body.w)"
        assert run.value(equivalent_load((2 * model.body.flange_a.tau, OF[1]))) == pytest.approx(
            2 * run.value(named), rel=1e-12
        )

    def test_it_has_the_unit_of_the_load(self, run):
        assert equivalent_load(OF).unit(run.system) == "N.m"
        assert mean_speed(OF[1]).unit(run.system) == "rad/s"

    def test_its_derivative_is_that_of_the_closed_form(self):
        """Torque k w while the body runs down: w = 50 exp(-k t / J)."""
        model = lp.compose(
            body=Inertia(J=2.0, w=50.0),
            drag=Damper(d=0.5),
            wall=Fixed(),
            connections=lambda m: [*lp.chain(m.body, m.drag, m.wall)],
        )
        wanted = equivalent_load(("drag.tau", "body.w"), exponent=3.0)
        system = lp.assemble(model)
        found = lp.gradient(system, of=[wanted], by=["drag.d"], until=3.0, rtol=1e-10)

        def load(k):
            """Both integrals are those of powers of an exponential."""
            c = k / 2
            done = (50 * k) ** 3 * 50 * (1 - np.exp(-12 * c)) / (4 * c)
            return (done / (50 * (1 - np.exp(-3 * c)) / c)) ** (1 / 3)

        assert found.values[0] == pytest.approx(load(0.5), rel=1e-8)
        slope = (load(0.5 + 1e-4) - load(0.5 - 1e-4)) / 2e-4
        assert found.derivatives[0, 0] == pytest.approx(slope, rel=1e-6)
        over = [0.3, 0.5, 0.8]
        many = lp.ensemble(system, over={"drag.d": over}, until=3.0, of=[wanted], rtol=1e-10)
        assert many.values[:, 0] == pytest.approx([load(k) for k in over], rel=1e-8)


class TestSteps:
    def test_a_textbook_duty_cycle_of_two_steps(self):
        """(3.45), (3.46) by hand: 20 kN at 100 for 0.3 and 10 kN at 200 for 0.7 of the time."""
        found = LoadSpectrum.of_steps([20e3, 10e3], speeds=[100, 200], times=[0.3, 0.7])
        assert found.mean_speed == pytest.approx(170.0)
        expected = ((20e3**P * 30 + 10e3**P * 140) / 170) ** 0.3
        assert found.equivalent() == pytest.approx(expected, rel=1e-12)

    def test_one_step_is_its_own_equivalent(self):
        found = LoadSpectrum.of_steps([5e3], speeds=[7.0], times=[2.0])
        assert (found.equivalent(), found.mean_speed) == pytest.approx((5e3, 7.0), rel=1e-14)

    @pytest.mark.parametrize(
        ("loads", "speeds", "times", "text"),
        [
            ([1.0, 2.0], [1.0], [1.0, 1.0], "as many"),
            ([1.0], [1.0], [-1.0], "not be negative"),
            ([1.0], [1.0], [0.0], "all zero"),
        ],
    )
    def test_steps_that_make_no_sense_are_refused(self, loads, speeds, times, text):
        with pytest.raises(OptionError, match=text):
            LoadSpectrum.of_steps(loads, speeds=speeds, times=times)

    def test_what_never_turns_has_no_mean(self):
        with pytest.raises(OptionError, match="nothing turns"):
            LoadSpectrum.of_steps([1.0], speeds=[0.0], times=[1.0]).equivalent()


class TestSpectrum:
    def test_a_load_that_rises_evenly_stays_as_long_in_each_class(self, run):
        found = load_spectrum(run, OF, classes=4)
        assert found.times == pytest.approx([1.0] * 4, abs=1e-9)
        assert found.loads == pytest.approx([110, 130, 150, 170], rel=1e-9)
        assert found.speeds == pytest.approx([10.5, 11.5, 12.5, 13.5], rel=1e-9)
        assert found.unit == "N.m"

    def test_a_sine_lasts_as_long_as_its_inverse_says(self):
        system = rig(200 + 100 * lp.ops.sin(np.pi * lp.time), 5.0 + 0 * lp.time)
        run = lp.simulate(system, until=2.0, grid=20_000, rtol=1e-10)
        found = load_spectrum(run, OF, classes=4)
        shares = np.diff(np.arcsin([-1, -0.5, 0, 0.5, 1])) / np.pi
        assert found.shares == pytest.approx(shares, abs=1e-5)
        assert found.duration == pytest.approx(2.0, rel=1e-12)

    def test_a_constant_load_has_one_class(self):
        run = lp.simulate(rig(70.0 + 0 * lp.time, 3.0 + 0 * lp.time), until=2.0, grid=10)
        found = load_spectrum(run, OF)
        assert found.times == pytest.approx([2.0])
        assert found.loads == pytest.approx([70.0], rel=1e-6)

    def test_its_equivalent_tends_to_that_of_the_run(self, run):
        exact = run.value(equivalent_load(OF))
        off = [abs(load_spectrum(run, OF, classes=n).equivalent() - exact) for n in (5, 50)]
        assert off[1] < 0.02 * off[0]
        assert off[1] < 1e-4 * exact

    def test_it_prints_its_levels_and_draws_them(self, run):
        found = load_spectrum(run, OF, classes=4)
        assert "25.0%" in repr(found)
        panel = found.plot().axes[0]
        assert [bar.get_width() for bar in panel.patches] == pytest.approx([25.0] * 4, abs=1e-6)

    def test_no_class_is_refused(self, run):
        with pytest.raises(OptionError, match="classes = 0"):
            load_spectrum(run, OF, classes=0)
