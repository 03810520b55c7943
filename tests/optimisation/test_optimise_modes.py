"""Design optimisation of frequencies and damping against closed forms."""

import numpy as np
import pytest
from rows import assemble_row

import lumped as lp
from lumped import functionals as fun
from lumped.components import Inertia, Spring, SpringDamper
from lumped.errors import OptimisationError, OptionError


class TestModes:
    @staticmethod
    def drive(c_1=4000.0, c_2=9000.0, d=1.0):
        return assemble_row(
            a=Inertia(J=1.0),
            one=SpringDamper(c=c_1, d=d),
            b=Inertia(J=0.5),
            two=SpringDamper(c=c_2, d=d),
            c=Inertia(J=2.0),
        )

    @staticmethod
    def hertz(J, c):
        """Frequencies of the free chain of three from its characteristic polynomial."""
        J_a, J_b, J_c = J
        c_1, c_2 = c
        p = c_1 * (1 / J_a + 1 / J_b) + c_2 * (1 / J_b + 1 / J_c)
        q = c_1 * c_2 * (J_a + J_b + J_c) / (J_a * J_b * J_c)
        root = np.sqrt(p**2 / 4 - q)
        return np.sqrt(np.array([p / 2 - root, p / 2 + root])) / (2 * np.pi)

    def test_two_frequencies_are_put_where_they_are_wanted(self):
        wanted = (11.0, 30.0)
        found = lp.optimise(
            lp.modes(self.drive(d=0.0)),
            vary={"one.c": (1e3, 1e5), "two.c": (1e3, 1e5)},
            minimise={"one.c": 1.0},
            subject_to=[
                each
                for i, f in enumerate(wanted)
                for each in (fun.frequency(i) <= f, fun.frequency(i) >= f)
            ],
        )
        received = self.hertz((1.0, 0.5, 2.0), found.parameters.values())
        assert np.abs(received / wanted - 1).max() < 1e-8

    def test_lightest_flywheels_for_a_lowest_frequency(self):
        names = ("a.J", "b.J", "c.J")
        found = lp.optimise(
            lp.modes(self.drive(d=0.0)),
            vary=dict.fromkeys(names, (0.1, 5.0)),
            minimise=dict.fromkeys(names, 1.0),
            subject_to=fun.frequency(0) <= 10.0,
        )
        J = np.array([found.parameters[name] for name in names])
        assert self.hertz(J, (4000, 9000))[0] == pytest.approx(10, rel=1e-9)
        # no lighter design nearby, along the curve of equal frequency
        rng = np.random.default_rng(2)
        for _ in range(200):
            other = np.clip(J * (1 + 0.02 * rng.standard_normal(3)), 0.1, 5)
            if self.hertz(other, (4000, 9000))[0] <= 10:
                assert other.sum() > J.sum() - 1e-9
        assert found.solution.residual < 1e-6

    def test_clearance_is_the_same_on_both_sides(self):
        """One free parameter between two excitations: equal relative distance from both."""
        pair = assemble_row(a=Inertia(J=1.0), shaft=Spring(c=4000.0), b=Inertia(J=0.5))
        low, high = 15.0, 25.0
        found = lp.optimise(
            lp.modes(pair),
            vary={"shaft.c": (3000, 6000)},
            minimise={fun.clearance((low, high)): -1.0},
        )
        f = 2 * low * high / (low + high)  # f / low - 1 == 1 - f / high
        assert found.run.hertz[0] == pytest.approx(f, rel=1e-8)
        assert found.parameters["shaft.c"] == pytest.approx((2 * np.pi * f) ** 2 / 3, rel=1e-8)
        assert found.values[fun.clearance((low, high))] == pytest.approx(f / low - 1, rel=1e-8)

    def test_damping_ratio(self):
        """Two bodies: ``zeta = d (1/J_a + 1/J_b) / (2 w)``."""
        pair = assemble_row(a=Inertia(J=1.0), shaft=SpringDamper(c=4000.0, d=0.1), b=Inertia(J=0.5))
        found = lp.optimise(
            lp.modes(pair),
            vary={"shaft.d": (0, 100)},
            minimise={"shaft.d": 1.0},
            subject_to=fun.damping(0) >= 0.05,
        )
        assert found.parameters["shaft.d"] == pytest.approx(0.1 * np.sqrt(12e3) / 3, rel=1e-7)

    def test_what_cannot_be(self):
        modes = lp.modes(self.drive())
        with pytest.raises(OptimisationError, match=r"Worst violated: frequency\(0\)"):
            lp.optimise(
                modes,
                vary={"a.J": (0.5, 2)},
                minimise={"a.J": 1},
                subject_to=fun.frequency(0) >= 100,
            )
        with pytest.raises(OptionError, match="0 to 1"):
            lp.optimise(modes, vary={"a.J": (0.5, 2)}, minimise=fun.frequency(5))
        with pytest.raises(OptionError, match="no functional of modes"):
            lp.optimise(modes, vary={"a.J": (0.5, 2)}, minimise=fun.rms("a.w"))
        with pytest.raises(OptionError, match="negative weight"):
            lp.optimise(modes, vary={"a.J": (0.5, 2)}, minimise=fun.clearance((10.0,)))
