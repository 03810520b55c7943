"""What docs/analyses/modes.md shows is true."""

import casadi as ca
import numpy as np
import pytest
from mill_matrices import C, G, J, eigenvalues, oscillating

NAME = "analyses/modes"


def test_the_page_runs_and_agrees_with_matrices_written_here(names):
    assert names["modes"].hertz == pytest.approx(oscillating(300 * G) / (2 * np.pi), rel=1e-9)
    total = names["energies"].damping.sum(axis=1)
    assert total == pytest.approx(names["modes"].damping, rel=1e-9)
    locus = names["locus"]
    errors = []
    for value, row in zip(locus.values[::20], locus.eigenvalues[::20], strict=True):
        expected = eigenvalues(value)
        errors += [np.abs(expected - root).min() / 250 for root in row]
    assert max(errors) < 1e-8
    w, slope = names["graph"], names["slope"]
    numbers = {"spindle.c": C[1], "motor.J": J[0], "gearbox.J": J[1], "rolls.J": J[2]}
    for formula, expected in (
        (w, np.sqrt(C[1] * (1 / J[4] + 1 / J[2]))),
        (slope, np.sqrt((1 / J[4] + 1 / J[2]) / C[1]) / 2),
    ):
        symbols = ca.symvar(formula)
        at = [numbers[s.name()] for s in symbols]
        assert float(ca.Function("f", symbols, [formula])(*at)) == pytest.approx(expected)
