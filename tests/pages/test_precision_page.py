"""What docs/analyses/precision.md shows is true."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import lumped as lp
from lumped.models.reversing_mill.scenes import SKIDS

PAGE = (Path(__file__).parents[2] / "docs" / "analyses" / "precision.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)

G = 9.80665
J = np.array([3.01, 2.45, 0.1601, 0.1601, 5.46]) * G  # motor, gearbox, rolls, rolls, lower motor
C = np.array([2.62e4, 0.918e4, 0.918e4]) * G
TWIST = np.array([[-1.0, 1, 0, 0, 0], [0, -1, 1, 0, 0], [0, 0, 0, 1, -1]])
SLIP = np.array([[0.0, 0, 1, -1, 0]])
LOAD = -365 * G * np.array([0.0, 0, 1, 1, 0])


def torques(t):
    """Shaft torques by the exponential of twists, speeds and 1; positive while motors drive."""
    a = np.zeros((9, 9))
    a[:3, 3:8] = TWIST
    a[3:8, :3] = -(TWIST.T * C) / J[:, None]
    a[3:8, 3:8] = -150 * G * (SLIP.T @ SLIP) / J[:, None]
    a[3:8, 8] = LOAD / J
    step, z, rows = expm(a * (t[1] - t[0])), np.eye(9)[8], []
    for _ in t:
        rows.append(z[:3] * C)
        z = step @ z
    return np.array(rows)


def test_the_page_runs_and_its_errors_are_the_true_ones(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for block in BLOCKS:
        exec(compile(block, "precision.md", "exec"), names)
    assert (tmp_path / "precision.png").stat().st_size > 5_000
    found, t = names["found"], np.linspace(0, 0.5, 998)
    expected = np.abs(torques(t))
    checked = 0
    for row in found.rows:
        if row.rtol not in (1e-5, 1e-8):
            continue
        run = lp.simulate(names["system"], until=0.5, grid=t, rtol=row.rtol, method=row.method)
        received = np.abs(run.table(names["SHAFTS"]))
        true = (
            np.abs(received - expected).max(axis=0) / np.ptp(run.table(names["SHAFTS"]), 0)
        ).max()
        print(row.method, row.rtol, row.error, true)
        if row.method in ("exact", "auto"):
            assert true < 1e-11
            assert row.error <= found.reference_error
        else:
            assert row.error == pytest.approx(true, rel=0.01)
        checked += 1
    assert checked == 8
    at = {(r.method, r.rtol): r for r in found.rows}
    for row in found.rows:
        if row.method == "explicit":
            assert row.error < 10 * row.rtol  # between steps too, as the page says
    # stability holds its steps
    assert at["explicit", 1e-7].steps < 1.3 * at["explicit", 1e-3].steps
    good = [row for row in found.rows if row.error <= 1e-6]
    assert found.fastest(1e-6) == min(good, key=lambda row: row.seconds)
    certificate = names["run"].certificate
    skids = [e.time for e in names["run"].events if e.component == "gap" and e.after]
    assert skids == pytest.approx(SKIDS, abs=1e-5)
    assert 0 < certificate.states.window < 1e-4
    assert 1e-9 < certificate["upper.spindle.tau"].relative < 1e-4
    assert not certificate.states.missed
