"""What docs/analyses/precision.md shows is true."""

import numpy as np
import pytest
from mill_matrices import SLIP, TWIST, C, G, J
from scipy.linalg import expm

import lumped as lp
from lumped.models.reversing_mill.scenes import SKIDS

NAME = "analyses/precision"
LOAD = -365 * G * np.array([0.0, 0, 1, 1, 0])


def torques(t):
    """Shaft torques by the exponential of twists, speeds and 1; positive while motors drive."""
    a = np.zeros((9, 9))
    a[:3, 3:8] = -TWIST
    a[3:8, :3] = (TWIST.T * C) / J[:, None]
    a[3:8, 3:8] = -150 * G * (SLIP.T @ SLIP) / J[:, None]
    a[3:8, 8] = LOAD / J
    step, z, rows = expm(a * (t[1] - t[0])), np.eye(9)[8], []
    for _ in t:
        rows.append(z[:3] * C)
        z = step @ z
    return np.array(rows)


def test_the_page_runs_and_its_errors_are_the_true_ones(names):
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
        if run.statistics.method == "exact":
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
