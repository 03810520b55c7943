"""What docs/analyses/branches.md shows is true."""

import numpy as np
import pytest
from page_code import read_page

import lumped as lp

NAME = "analyses/branches"


def test_the_folds_that_the_page_tells_are_those_found(names):
    folds = sorted(point.value * 30 / np.pi for point in names["jump"].named("fold"))
    for fold in folds:
        assert f"{fold:.3f}" in read_page(NAME)
    assert len(names["jump"].at(29.0)) == 3


def test_teeth_part_where_the_page_says_and_a_sweep_jumps_between_the_same_steps(names):
    rattle, system = names["rattle"], names["gears"]
    parting = [point.value for point in rattle.points if "x > 1" in point.words]
    folds = sorted(point.value for point in rattle.named("fold"))
    assert len(parting) == 2
    assert len(folds) == 2

    def swept(speeds, x):
        """Peak-to-peak values, each after 150 periods from where the last ended."""
        found = []
        for W in speeds:
            end = 300 * np.pi / W
            run = lp.simulate(
                system,
                until=end,
                start=dict(zip(("x", "v"), x, strict=True)),
                parameters={"W": W},
                grid=np.linspace(0.99 * end, end, 400),
                rtol=1e-7,
            )
            x = run.x[-1]
            found.append(np.ptp(run["x"]))
        return np.array(found), x

    for k, way in ((0, -1), (1, 1)):
        speeds = folds[k] + way * np.array([-0.004, 0.004])
        stable_ones = [o for o in rattle.at(speeds[0]) if o.stable]
        begin = min(stable_ones, key=lambda o: way * np.ptp(o["x"]))
        values, _ = swept(speeds, begin.run.x[0])
        stable = [[np.ptp(o["x"]) for o in rattle.at(W) if o.stable] for W in speeds]
        print(values, stable)
        assert len(stable[0]) == 2
        assert len(stable[1]) == 1
        assert values[1] == pytest.approx(stable[1][0], rel=0.02)
        assert abs(values[0] / stable[1][0] - 1) > 0.2
