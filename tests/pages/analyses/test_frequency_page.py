"""What docs/analyses/frequency.md shows is true."""

import numpy as np
import pytest
from mill_matrices import SLIP, TWIST, C, G, J, K, oscillating

NAME = "analyses/frequency"


def test_the_page_runs_and_agrees_with_matrices_written_here(names):
    turning = oscillating(300 * G)
    assert names["modes"].hertz == pytest.approx(turning / (2 * np.pi), rel=1e-9)
    response = names["response"]
    s = 2j * np.pi * response.hertz
    load = np.array([0.0, 0, 1, 0, 0])
    for k in (10, 200, 700):
        matrix = s[k] ** 2 * np.diag(J) + s[k] * 150 * G * SLIP.T @ SLIP + K
        angles = np.linalg.solve(matrix, load)
        # a spring torque is positive when the motor side leads
        torque = C[1] * (TWIST @ angles)[1]
        received = response["upper.spindle.tau", "upper_load.tau"][k]
        assert received == pytest.approx(torque, rel=1e-9)
    speeds = [c.speed for c in names["lp"].vibration.critical_speeds(names["modes"], [2])]
    assert speeds == pytest.approx(turning / 2, rel=1e-9)
    for critical in names["diagram"].critical:
        met = oscillating(2942.0 / (1 + 0.01 * critical.speed))[critical.mode]
        assert critical.order * critical.speed == pytest.approx(met, rel=1e-9)
    k = np.arange(1, 6)
    expected = np.sqrt(2e4 / 0.3) * np.sin(k * np.pi / 4000) / np.pi
    assert names["lowest"].hertz == pytest.approx(expected, rel=1e-11)
