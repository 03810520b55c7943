"""What docs/exchange.md shows is true."""

import re

import numpy as np
import pytest
from page_code import read_page, run_blocks

import lumped as lp

NAME = "exchange"


def test_the_page_runs_and_agrees_with_momentum_and_with_the_model_itself(tmp_path):
    pytest.importorskip("fmpy")
    names, _ = run_blocks(NAME, tmp_path)
    counts = re.search(r"\d+ parameters, .* operations", read_page(NAME))[0]
    assert counts in repr(names["unit"])
    system, rated, changed = names["system"], names["RATED"], names["changed"]
    values = system.parameters
    torque = lp.ops.where(lp.time >= 0.15, 0.0, 1.0)
    given = {"upper.drive.tau": rated * torque, "lower.drive.tau": 0.4 * rated * torque}
    own = lp.assemble(names["stand"].with_(given), keep=["gap.tau"])
    run = lp.simulate(own, until=0.2, grid=200, rtol=1e-11, parameters=changed)
    changes = np.unique([event.time for event in run.events])
    assert any(event.after == "forward" for event in run.events)
    for kind, found in names["runs"].items():
        smooth = np.abs(found["time"][:, None] - changes).min(axis=1) > 1e-6
        for name in ("upper.rolls.w", "upper.motor.w", "gap.tau"):
            expected = run[name][np.searchsorted(run.t, found["time"] - 1e-9)]
            error = np.abs(found[name] - expected)[smooth].max() / np.abs(expected).max()
            print(f"{kind} {name}: {error:.1e}")
            assert error < 1e-6
    # momentum of both branches: driven for 150 ms, loaded for 100 ms
    bodies = [n.removesuffix(".J") for n in values if n.endswith(".J")]
    momentum = sum(values[f"{body}.J"] * run[f"{body}.w"][-1] for body in bodies)
    impulse = 1.4 * rated * 0.15 - 2 * rated * 0.1
    assert momentum == pytest.approx(impulse, rel=1e-6)
    found = np.linalg.eigvals(names["closed"])
    found = found[np.abs(found) > 1e-6]
    poles = names["poles"][np.abs(names["poles"]) > 1e-6]
    assert len(found) == len(poles)
    assert max(np.abs(found - pole).min() / abs(pole) for pole in poles) < 1e-9
    assert names["compared"].frac == pytest.approx(1.0, abs=1e-12)
