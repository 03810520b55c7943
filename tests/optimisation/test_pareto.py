"""Designs between two aims against closed forms."""

import numpy as np
import pytest
from optimised_drives import BEST, TAU, A, D, W, pushed, shaken, two_bodies

import lumped as lp
from lumped import functionals as fun
from lumped.errors import OptimisationError, OptionError
from lumped.optimisation.design_problem import DesignProblem


class TestPareto:
    def test_front_is_the_closed_form_and_falls(self):
        """Torque against stiffness: ``rms = A/sqrt(2) sqrt((c - J w^2)^2 + (d w)^2)``."""
        front = lp.optimisation.pareto(
            shaken(30.0),
            vary={"spring.c": (20, 1000)},
            minimise=(fun.rms(TAU), fun.peak("spring.tau")),
            count=7,
        )
        rms, torque = front.values.T
        assert np.all(np.diff(rms) > 0)
        assert np.all(np.diff(torque) < 0)
        c = np.array([design.parameters["spring.c"] for design in front.designs])
        expected = A / np.sqrt(2) * np.hypot(c - BEST, D * W)
        assert np.abs(rms / expected - 1).max() < 1e-6
        assert c[0] == pytest.approx(BEST, rel=1e-3)
        assert c[-1] == pytest.approx(20, rel=1e-6)
        assert np.abs(np.diff(torque, 2)).max() < 1e-6 * torque[0]

    def test_it_needs_two(self):
        with pytest.raises(OptionError, match="two different functionals"):
            lp.optimisation.pareto(
                shaken(), vary={"spring.c": (1, 99)}, minimise=(fun.rms(TAU), fun.rms(TAU))
            )
        with pytest.raises(OptionError, match="at least two designs"):
            lp.optimisation.pareto(
                shaken(),
                vary={"spring.c": (1, 99)},
                minimise=(fun.rms(TAU), fun.peak(TAU)),
                count=1,
            )

    def test_aims_that_agree_have_one_design(self, capfd):
        """Both least at the largest inertia: ``w(T) = tau / d (1 - exp(-d T / J))``."""
        T = 0.7
        run = lp.simulate(pushed(1.0), until=T)
        front = lp.optimisation.pareto(
            run,
            vary={"body.J": (0.5, 5.0)},
            minimise=(fun.final("body.w"), fun.mean("body.w")),
            intervals=20,
        )
        (design,) = front.designs
        assert design.parameters["body.J"] == pytest.approx(5.0, rel=1e-6)
        decay = 1 - np.exp(-D * T / 5.0)
        expected = [decay / D, (T - 5.0 / D * decay) / D / T]
        assert front.values[0] == pytest.approx(expected, rel=1e-6)
        assert "both are least in one design" in repr(front)
        # nothing of the libraries below, as of a matrix that is singular
        assert capfd.readouterr().err == ""

    def test_a_search_that_fails_from_the_design_before_begins_at_the_other_end(self, monkeypatch):
        """Two masses of which the first shall be slow, though the second is pulled by it."""
        solve, failed = DesignProblem.solve, []

        def watch(problem, *weights, **options):
            try:
                return solve(problem, *weights, **options)
            except OptimisationError:
                failed.append(options["limits"])
                raise

        monkeypatch.setattr(DesignProblem, "solve", watch)
        run = lp.simulate(two_bodies(), until=1.0)
        front = lp.optimisation.pareto(
            run,
            vary={"s.d": (0.0, 20.0), "a.J": (0.1, 3.0)},
            minimise=(fun.final("b.w"), fun.final("a.w")),
            intervals=10,
            count=4,
        )
        assert len(failed) == 1
        assert len(front.designs) == 4
        first, second = front.values.T
        assert (np.diff(first) > 0).all()
        assert (np.diff(second) < 0).all()
