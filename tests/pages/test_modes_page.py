"""What docs/analyses/modes.md shows is true."""

import re
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import eig

PAGE = (Path(__file__).parents[2] / "docs" / "analyses" / "modes.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)

G = 9.80665
J = np.array([3.01, 2.45, 0.1601, 0.1601, 5.46]) * G  # motor, gearbox, rolls, rolls, lower motor
C = np.diag([2.62e4, 0.918e4, 0.918e4]) * G
TWIST = np.array([[1.0, -1, 0, 0, 0], [0, 1, -1, 0, 0], [0, 0, 0, 1, -1]])
SLIP = np.array([[0.0, 0, 1, -1, 0]])


def eigenvalues(creep):
    K, D = TWIST.T @ C @ TWIST, creep / 2 * SLIP.T @ SLIP
    zero, one = np.zeros((5, 5)), np.eye(5)
    return eig(np.block([[zero, one], [-K, -D]]), np.block([[one, zero], [zero, np.diag(J)]]))[0]


def test_the_page_runs_and_agrees_with_matrices_written_here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for block in BLOCKS:
        exec(compile(block, "modes.md", "exec"), names)
    for picture in ("shapes.png", "modes.png"):
        assert (tmp_path / picture).stat().st_size > 5_000
    found = eigenvalues(300 * G)
    found = np.sort(np.abs(found[found.imag > 1.0]))
    assert names["modes"].hertz == pytest.approx(found / (2 * np.pi), rel=1e-9)
    total = names["energies"].damping.sum(axis=1)
    assert total == pytest.approx(names["modes"].damping, rel=1e-9)
    locus = names["locus"]
    errors = []
    for value, row in zip(locus.values[::20], locus.eigenvalues[::20], strict=True):
        expected = eigenvalues(value)
        errors += [np.abs(expected - root).min() / 250 for root in row]
    print("largest error of a root:", max(errors))
    assert max(errors) < 1e-8
    w, slope = names["w"], names["slope"]
    numbers = {"spindle.c": C[1, 1], "motor.J": J[0], "gearbox.J": J[1], "rolls.J": J[2]}
    for formula, expected in (
        (w, np.sqrt(C[1, 1] * (1 / J[4] + 1 / J[2]))),
        (slope, np.sqrt((1 / J[4] + 1 / J[2]) / C[1, 1]) / 2),
    ):
        symbols = ca.symvar(formula)
        at = [numbers[s.name()] for s in symbols]
        assert float(ca.Function("f", symbols, [formula])(*at)) == pytest.approx(expected)
