"""What docs/analyses/ensemble.md shows is true."""

import numpy as np
import pytest

import lumped as lp
from lumped.models.reversing_mill.stand import RATED, SHAFTS

NAME = "analyses/ensemble"


def test_the_page_runs_and_its_runs_are_those_of_simulate(names):
    found, system = names["found"], names["system"]
    print(f"{names['seconds']:.2f} s for {len(found)} runs")
    errors = []
    for i in range(0, len(found), 2500):
        run = lp.simulate(
            system,
            until=0.4,
            start=dict.fromkeys(SHAFTS, RATED),
            parameters=dict(zip(found.names, found.points[i].tolist(), strict=True)),
            rtol=1e-9,
            grid=4000,
        )
        skids = [e.time for e in run.events if e.component == "gap" and e.after == "forward"]
        assert found["skids"][i] == len(skids)
        assert found["first skid"][i] == pytest.approx(skids[0], rel=1e-6)
        errors.append(found["peak"][i] / np.abs(run["upper.spindle.tau"]).max() - 1)
    assert np.abs(errors).max() < 2e-5
