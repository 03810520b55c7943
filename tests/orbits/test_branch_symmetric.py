"""Branches of symmetric Duffing oscillators, against shooting of their own."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import lumped as lp
from lumped.ops import sin


class Duffing(lp.Component):
    """``x'' + d x' + x + x^3 = F sin(om t)``."""

    F: lp.Param = lp.param("N.m", "amplitude", 0.1)
    om: lp.Param = lp.param("rad/s", "frequency", 1.0)
    d: lp.Param = lp.param("1/s", "damping", 0.2)
    x: lp.Var = lp.var("rad", "angle")
    w: lp.Var = lp.var("rad/s", "its rate")

    def equations(self):
        yield lp.der(self.x) == self.w
        force = self.F * sin(self.om * lp.time)
        yield lp.der(self.w) == force - self.d * self.w - self.x - self.x**3


@pytest.fixture(scope="module")
def oscillator():
    return lp.assemble(Duffing())


def follow(oscillator, d, om, high, step):
    given = {"d": d, "om": om, "F": 0.1}
    orbit = lp.periodic(oscillator, period=2 * np.pi / om, parameters=given)
    return lp.orbits.branch(orbit, along={"F": (0.1, high)}, step=step)


def shoot(begin, F, d, om, halves=2):
    """States that repeat after half a period with the other sign (1) or a period (2)."""
    T, y = np.pi * halves / om, np.array(begin, dtype=float)
    sign = 1.0 if halves == 2 else -1.0

    def rates(t, z):
        A = np.array([[0, 1], [-1 - 3 * z[0] ** 2, -d]])
        force = F * np.sin(om * t) - d * z[1] - z[0] - z[0] ** 3
        return np.concatenate([[z[1], force], (A @ z[2:6].reshape(2, 2)).ravel(), [z[0]]])

    for _ in range(30):
        start = np.concatenate([y, [1, 0, 0, 1, 0]])
        end = solve_ivp(rates, (0, T), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        missed, M = sign * end[:2] - y, sign * end[2:6].reshape(2, 2)
        if np.abs(missed).max() < 1e-10:
            return y, M, end[6] / T
        y = y - np.linalg.solve(M - np.eye(2), missed)
    raise AssertionError("own shooting does not converge")


CASES = [(0.2, 1.0, 24.0), (0.3, 0.8, 27.0), (0.1, 0.8, 12.0), (0.1, 1.0, 24.0)]


@pytest.mark.parametrize("step", [0.05, 0.01])
@pytest.mark.parametrize(("d", "om", "high"), CASES)
def test_a_symmetric_branch_is_kept_and_tells_each_change_of_stability(
    oscillator, d, om, high, step
):
    """Where symmetry breaks, the map over half a period has the multiplier -1 (det(M + 1) = 0)."""
    found = follow(oscillator, d, om, high, step * 40 / high)
    assert found.ends[1] == "the greatest value that was asked for is reached"
    named = {point.number for point in found.points}
    for i in np.flatnonzero(np.diff(found.stable)):
        assert named & {i, i + 1}
    points = found.named("branch point")
    assert len({round(point.value, 3) for point in points}) == len(points) >= 2
    for point in points:
        begin = [found.runs[point.number].x[0, i] for i in (0, 1)]

        def test(F, begin=begin):
            # a disturbance without the symmetry changes its sign in half a period
            return np.linalg.det(shoot(begin, F, d, om, 1)[1] + np.eye(2))

        own = brentq(test, 0.998 * point.value, 1.002 * point.value, rtol=1e-10)
        assert point.value == pytest.approx(own, abs=2e-5)
    for i in range(0, len(found.values), 15):
        run = found.runs[i]
        _, half, _ = shoot(run.x[0], found.values[i], d, om, 1)
        sizes = np.abs(np.linalg.eigvals(half @ half))
        assert found.largest[i] == pytest.approx(sizes.max(), rel=1e-5)


@pytest.mark.parametrize("number", [0, 1])
def test_a_switch_leaves_for_the_branch_without_symmetry(oscillator, number):
    """It is a closed loop between both points, on which the mean angle is not zero."""
    main = follow(oscillator, 0.2, 1.0, 12.0, 0.1)
    low, high = (point.value for point in main.named("branch point"))
    other = main.switch(main.named("branch point")[number])
    assert other.ends == ("the branch is closed",) * 2
    assert [other.values.min(), other.values.max()] == pytest.approx([low, high], abs=1e-4)
    for orbit in other.at(5.0):
        _, M, mean = shoot(orbit.run.x[0], 5.0, 0.2, 1.0)
        assert orbit.mean("x") == pytest.approx(mean, abs=1e-8)
        assert abs(mean) == pytest.approx(0.18382, abs=5e-6)
        assert orbit.largest == pytest.approx(np.abs(np.linalg.eigvals(M)).max(), abs=1e-7)
    assert len(other.at(5.0)) == 2
