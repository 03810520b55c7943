"""What docs/analyses/frequency.md shows is true."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eig

PAGE = (Path(__file__).parents[2] / "docs" / "analyses" / "frequency.md").read_text()
G = 9.80665
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


def test_the_page_runs_and_agrees_with_matrices_written_here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for block in BLOCKS:
        exec(compile(block, "frequency.md", "exec"), names)
    for picture in ("tornado.png", "frequency.png", "campbell.png"):
        assert (tmp_path / picture).stat().st_size > 5_000
    # upper motor, gearbox, rolls; lower rolls, motor with gearbox
    M = np.diag([3.01, 2.45, 0.1601, 0.1601, 5.46]) * G
    twist = np.array([[1.0, -1, 0, 0, 0], [0, 1, -1, 0, 0], [0, 0, 0, 1, -1]])
    slip = np.array([[0.0, 0, 1, -1, 0]])
    K = twist.T @ np.diag([2.62e4, 0.918e4, 0.918e4]) @ twist * G

    def eigenvalues(creep):
        D, zero, one = creep / 2 * slip.T @ slip, np.zeros((5, 5)), np.eye(5)
        found = eig(np.block([[zero, one], [-K, -D]]), np.block([[one, zero], [zero, M]]))[0]
        return np.sort(np.abs(found[found.imag > 1.0]))

    oscillating = eigenvalues(300 * G)
    assert names["modes"].hertz == pytest.approx(oscillating / (2 * np.pi), rel=1e-9)
    response = names["response"]
    s = 2j * np.pi * response.hertz
    load = np.array([0.0, 0, 1, 0, 0])
    for k in (10, 200, 700):
        matrix = s[k] ** 2 * M + s[k] * 150 * G * slip.T @ slip + K
        angles = np.linalg.solve(matrix, load)
        # a spring torque is positive when the motor side leads
        torque = 0.918e4 * G * (twist @ angles)[1]
        received = response["upper.spindle.tau", "upper_load.tau"][k]
        assert received == pytest.approx(torque, rel=1e-9)
    speeds = [c.speed for c in names["lp"].vibration.critical_speeds(names["modes"], [2])]
    assert speeds == pytest.approx(oscillating / 2, rel=1e-9)
    for critical in names["diagram"].critical:
        met = eigenvalues(2942.0 / (1 + 0.01 * critical.speed))[critical.mode]
        assert critical.order * critical.speed == pytest.approx(met, rel=1e-9)
    k = np.arange(1, 6)
    expected = np.sqrt(2e4 / 0.3) * np.sin(k * np.pi / 4000) / np.pi
    assert names["lowest"].hertz == pytest.approx(expected, rel=1e-11)
