"""A genset that misfires: the largest coupling and the thinnest shaft that keep limits."""

import numpy as np
import pytest

import lumped as lp
from lumped import functionals as fun
from lumped.vibration import mean_campbell, order_response
from tests.drawing.genset import RPM, genset

STRESS, SIZE, DIAMETER = "shaft.sections[0].stress", "coupling.size", "shaft.sections[0].d"
LIMIT = 12e6
OPERATION = (1400 * RPM, 1600 * RPM)
WEIGHTS = {DIAMETER: 1.0, SIZE: -0.08}


def response_of(system, design, low=1400, high=1600, count=5):
    return order_response(
        system,
        speeds=np.linspace(low, high, count) * RPM,
        of=[STRESS],
        shaft="flywheel.phi",
        turns=2,
        free="load.tau",
        parameters=design,
    )


def test_shaft_and_coupling_keep_stress_and_separation_at_once():
    system = genset({1: "compression"})
    found = lp.optimise(
        response_of(system, {SIZE: 0.7, DIAMETER: 0.075}),
        vary={SIZE: (0.3, 4.0), DIAMETER: (0.03, 0.12)},
        minimise=WEIGHTS,
        subject_to=[
            fun.order_peak(STRESS) <= LIMIT,
            fun.separation((0.5, 1.0, 1.5), between=OPERATION) >= 0.1,
        ],
    )
    assert len(found.active) == 2

    def stress_of(design):
        """Largest vibration over its limit."""
        return response_of(system, design).synthesis(STRESS).half_range.max() / LIMIT

    def criticals_of(design):
        """Critical speeds, 1/min."""
        wide = mean_campbell(response_of(system, design, 1100, 1800, 9), orders=(0.5, 1.0, 1.5))
        return [critical.speed / RPM for critical in wide.critical]

    stress, criticals = stress_of(found.parameters), criticals_of(found.parameters)
    assert stress == pytest.approx(1, abs=1e-8)
    assert criticals == [pytest.approx(0.9 * 1400, abs=1e-5)]
    rng, better = np.random.default_rng(2), 0
    for _ in range(6):
        design = {k: v * (1 + 0.01 * rng.standard_normal()) for k, v in found.parameters.items()}
        if sum(w * design[k] for k, w in WEIGHTS.items()) <= found.objective:
            better += 1
            broken = stress_of(design) > 1
            assert broken or any(0.9 * 1400 < n < 1.1 * 1600 for n in criticals_of(design))
    assert better
