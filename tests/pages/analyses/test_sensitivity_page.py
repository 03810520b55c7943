"""What docs/analyses/sensitivity.md shows is true."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

import lumped as lp

NAME = "analyses/sensitivity"


def test_the_page_runs_and_agrees_with_matrices_written_here(names):
    found, system, rated = names["found"], names["system"], names["RATED"]
    values = system.parameters
    to = ["M_s", "upper.spindle.c", "upper.motor.J", "upper.shaft.c"]

    def slip(t, M_s, c_spindle, J_motor, c_shaft):
        """Torque between the rolls less what they hold, while both turn as one body."""
        J = [J_motor, values["upper.gearbox.J"]]
        lower = values["lower.motor.J"] + values["lower.gearbox.J"]
        rolls = values["upper.rolls.J"] + values["lower.rolls.J"]
        # speeds of upper motor, upper gearbox, rolls, lower motor; torques of the shafts
        joints = ((0, 1, c_shaft), (1, 2, c_spindle), (3, 2, values["lower.spindle.c"]))
        inertia = [*J, rolls, lower]
        A = np.zeros((8, 8), dtype=complex)
        for k, (i, j, c) in enumerate(joints):
            A[4 + k, i], A[4 + k, j] = c, -c
            A[i, 4 + k], A[j, 4 + k] = -1 / inertia[i], 1 / inertia[j]
        A[0, 7], A[3, 7] = 1.6 * rated / inertia[0], 0.4 * rated / lower
        A[2, 7] = -2 * rated / rolls
        x = expm(A * t) @ np.array([0, 0, 0, 0, rated, rated, rated, 1.0])
        return x[5] - rated - values["upper.rolls.J"] * (A @ x)[2] - M_s

    point = [values[name] for name in to]
    instant = "instant(gap, forward, 0)"
    t = brentq(lambda t: slip(t, *point).real, 0.02, 0.04, xtol=1e-15)
    assert found.values[found.of.index(instant)] == pytest.approx(t, rel=1e-7)
    rate = slip(t + 1e-30j, *point).imag / 1e-30
    for i, name in enumerate(to):
        moved = [value + 1e-30j * (i == k) for k, value in enumerate(point)]
        expected = -slip(t, *moved).imag / 1e-30 / rate
        assert found[instant, name] == pytest.approx(expected, rel=1e-6)
    fine = lp.simulate(system, **names["scene"], grid=20_000, rtol=1e-9)
    top = np.abs(fine["upper.spindle.tau"]).max()
    assert found.values[0] == pytest.approx(top, rel=1e-6)
    work = np.trapezoid(fine["gap.tau"] * fine["gap.w_rel"], fine.t)
    assert found.values[2] == pytest.approx(work, rel=1e-5)
    at = int(np.abs(names["curves"].run.t - 0.1).argmin())
    run = names["curves"].run
    ranked = dict(names["curves"].ranked("upper.spindle.tau", at=0.1))
    direct = names["curves"]["upper.spindle.tau", "M_s"][at] * values["M_s"]
    assert ranked["M_s"] == pytest.approx(direct / run["upper.spindle.tau"][at])
    # a mixed derivative is the same in either order
    J = values["upper.motor.J"]
    after, before = (
        lp.gradient(
            system,
            of=names["of"],
            by=["M_pr"],
            parameters={"upper.motor.J": changed},
            **names["scene"],
        ).derivatives[0, 0]
        for changed in (1.01 * J, 0.99 * J)
    )
    assert names["second"][0, 0] == pytest.approx((after - before) / (0.02 * J), rel=1e-3)
