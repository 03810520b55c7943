"""Design optimisation of prescribed motion against closed forms, and what is refused."""

import numpy as np
import pytest
from optimised_drives import BEST, LEAST, TAU, A, D, W, shaken
from rows import in_a_row

import lumped as lp
from lumped import functionals as fun
from lumped.components import Damper, Fixed, IdealGear, Inertia, Speed, Torque
from lumped.errors import OptimisationError, OptionError, UnknownNameError


def best(minimise, **options):
    """The best spring of the shaken body."""
    given = {"vary": {"spring.c": (1, 1000)}} | options
    return lp.optimise(shaken(), minimise=minimise, **given)


class TestPrescribedMotion:
    @pytest.mark.parametrize(
        ("functional", "factor", "grid"),
        [(fun.rms, np.sqrt(0.5), 1e-7), (fun.peak, 1.0, 5e-5), (fun.swing, 2.0, 5e-5)],
    )
    def test_spring_cancels_the_inertia(self, functional, factor, grid):
        """A crest between two of the 400 instants is missed by ``(w dt)^2 / 8`` at most."""
        found = best(functional(TAU))
        # the design is where two such crests are equal: that error over the slope, d w / c
        assert found.parameters["spring.c"] == pytest.approx(BEST, rel=20 * grid)
        assert found.objective == pytest.approx(factor * LEAST, rel=grid)
        assert found.objective == found.values[functional(TAU)]
        # values are those at the instants; how far they are from those between is told
        true = factor * A * np.hypot(found.parameters["spring.c"] - BEST, D * W)
        assert found.error == pytest.approx(abs(found.objective / true - 1), rel=1e-2, abs=1e-9)
        assert found.solution.residual < 1e-7
        assert found.error < grid
        assert found.active == ()

    def test_weighted_sum_of_torque_and_stiffness(self):
        """``d/dc (rms + k c) == 0`` with rms = A/sqrt(2) sqrt((c - J w^2)^2 + (d w)^2)."""
        k = 0.1
        slope = k / (A / np.sqrt(2))
        expected = BEST - D * W * slope / np.sqrt(1 - slope**2)
        found = best({fun.rms(TAU): 1.0, "spring.c": k})
        assert found.parameters["spring.c"] == pytest.approx(expected, rel=1e-6)

    def test_bound_of_a_quantity_holds_at_all_instants(self):
        """The spring's torque has the amplitude ``c A``."""
        found = best(fun.rms(TAU), subject_to=fun.lowest("spring.tau") >= -8.0)
        assert found.parameters["spring.c"] == pytest.approx(8.0 / A, rel=1e-6)
        assert found.active == ("lowest(spring.tau)",)

    def test_bound_of_a_parameter_and_of_a_functional(self):
        low = best(fun.rms(TAU), vary={"spring.c": (1, 30)})
        assert low.parameters["spring.c"] == pytest.approx(30, rel=1e-8)
        assert low.active == ("spring.c at its upper bound",)
        bound = 1.5 * LEAST
        soft = best({"spring.c": 1.0}, subject_to=fun.peak(TAU) <= bound)
        expected = BEST - np.sqrt((bound / A) ** 2 - (D * W) ** 2)
        assert soft.parameters["spring.c"] == pytest.approx(expected, rel=1e-4)  # crests, see above
        assert soft.active == ("peak(drive.flange.tau)",)

    def test_all_torque_can_vanish(self):
        """The root mean square has a kink where it is zero."""
        found = best(fun.rms(TAU), vary={"spring.c": (1, 1000), "oil.d": (0, 10)})
        assert found.parameters["spring.c"] == pytest.approx(BEST, rel=1e-5)
        assert found.objective < 1e-5 * LEAST

    def test_inverse_dynamics(self):
        """Least mean square of ``J_a i^2 a + J_b a``'s motor torque over the ratio of a gear."""
        J_a, J_b = 0.02, 3.0
        rig = in_a_row(
            motor=Torque(tau=0), rotor=Inertia(J=J_a), gear=IdealGear(ratio=4), table=Inertia(J=J_b)
        )
        move = lp.profiles.polynomial5(distance=1.0, duration=0.5)
        run = lp.inverse(
            lp.assemble(rig),
            motion={"table.phi": lp.profiles.path(move)},
            drive="motor.tau",
            until=0.5,
        )
        found = lp.optimise(run, vary={"gear.ratio": (1, 100)}, minimise=fun.rms("motor.tau"))
        assert found.parameters["gear.ratio"] == pytest.approx(np.sqrt(J_b / J_a), rel=1e-6)


class TestBadInput:
    @pytest.mark.parametrize(
        ("vary", "options", "error", "text"),
        [
            ({}, {}, OptionError, "at least one parameter"),
            ({"spring.c": (9, 1)}, {}, OptionError, r"bounds of spring\.c = \(9, 1\)"),
            ({"spring.c": (1,)}, {}, OptionError, r"bounds of spring\.c"),
            ({"spring.c": (20, 99)}, {}, OptionError, r"spring\.c = 10 N\.m/rad, outside"),
            ({"spring.c": (-5, 99)}, {}, OptionError, r"spring\.c = -5 N\.m/rad"),
            ({"spring.k": (1, 9)}, {}, UnknownNameError, r"spring\.c"),
            (
                {"spring.c": (1, 99)},
                {"minimise": fun.rms("drive.tau")},
                UnknownNameError,
                "Nearest",
            ),
            ({"spring.c": (1, 99)}, {"minimise": {fun.rms(TAU): 0}}, OptionError, "nothing"),
            ({"spring.c": (1, 99)}, {"minimise": {fun.peak(TAU): -1}}, OptionError, "made small"),
            ({"spring.c": (1, 99)}, {"minimise": fun.lowest(TAU)}, OptionError, "made large"),
            (
                {"spring.c": (1, 99)},
                {"minimise": fun.frequency(0)},
                OptionError,
                "no functional of a run",
            ),
            (
                {"spring.c": (1, 99), "oil.d": (1, 9)},
                {"minimise": fun.rms("spring.tau")},
                OptionError,
                r"oil\.d has no effect on",
            ),
            (
                {"spring.c": (1, 99)},
                {"subject_to": fun.peak(TAU) <= 0.9 * LEAST},
                OptimisationError,
                r"Worst violated: peak\(drive\.flange\.tau\) = [\d.]+ N\.m, which must be at most",
            ),
            (
                {"spring.c": (1, 99)},
                {"subject_to": fun.lowest(TAU) >= "-1 N.m"},
                OptimisationError,
                r"Worst violated: lowest\(drive\.flange\.tau\) = .*must be at least -1",
            ),
        ],
    )
    def test_it_is_named(self, vary, options, error, text):
        with pytest.raises(error, match=text):
            best(**{"minimise": fun.rms(TAU), "vary": vary} | options)

    def test_parameter_that_moves_an_instant(self):
        class Stepped(lp.Component):
            when: lp.Param = lp.param("s", "begin", 0.5)
            turn: Speed = Speed(w=lp.ops.where(lp.time >= when, 2.0, 1.0))
            oil: Damper = Damper(d=D)
            ground: Fixed = Fixed()

            def connections(self):
                yield from lp.chain(self.turn, self.oil, self.ground)

        run = lp.simulate(lp.assemble(Stepped()), until=1.0)
        with pytest.raises(OptionError, match="when moves an instant"):
            lp.optimise(run, vary={"when": (0.1, 0.9)}, minimise=fun.rms("oil.tau"))
