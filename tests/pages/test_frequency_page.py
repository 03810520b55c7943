"""What docs/analyses/frequency.md shows is true."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eig

PAGE = (Path(__file__).parents[2] / "docs" / "analyses" / "frequency.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


def test_the_page_runs_and_agrees_with_matrices_written_here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for block in BLOCKS:
        exec(compile(block, "frequency.md", "exec"), names)
    for picture in ("tornado.png", "response.png", "campbell.png"):
        assert (tmp_path / picture).stat().st_size > 5_000
    # motor, pinions, upper roll, lower roll
    M = np.diag([900.0, 600.0, 260.0, 250.0])
    twist = np.array([[-1.0, 2.0, 0.0, 0.0], [0.0, -1.0, 1.0, 0.0], [0.0, -1.0, 0.0, 1.0]])
    c, d = np.diag([4e7, 9e6, 8e6]), np.diag([2e4, 4e3, 4e3])
    D, K = twist.T @ d @ twist, twist.T @ c @ twist
    zero, one = np.zeros((4, 4)), np.eye(4)
    values = eig(np.block([[zero, one], [-K, -D]]), np.block([[one, zero], [zero, M]]))[0]
    oscillating = np.sort(np.abs(values[values.imag > 1.0]))
    assert names["modes"].hertz == pytest.approx(oscillating / (2 * np.pi), rel=1e-9)
    response = names["response"]
    s = 2j * np.pi * response.hertz
    load = np.array([0.0, 0.0, 1.0, 0.0])
    for k in (10, 200, 700):
        angles = np.linalg.solve(s[k] ** 2 * M + s[k] * D + K, load)
        torque = ((c + s[k] * d) @ twist @ angles)[1]
        received = response["upper_spindle.tau", "rolling.tau"][k]
        assert received == pytest.approx(torque, rel=1e-9)
    speeds = [c.speed for c in names["lp"].critical_speeds(names["modes"], [6])]
    assert speeds == pytest.approx(oscillating / 6, rel=1e-9)
    k = np.arange(1, 6)
    expected = np.sqrt(2e4 / 0.3) * np.sin(k * np.pi / 4000) / np.pi
    assert names["lowest"].hertz == pytest.approx(expected, rel=1e-11)
