"""Scatter of order responses, against the closed form of one inertia on a shaft."""

import itertools

import numpy as np
import pytest
from checks import worst
from rows import in_a_row
from scipy.optimize import minimize_scalar

import lumped as lp
from lumped import functionals as fun
from lumped.components import Damper, Fixed, Inertia, SpringDamper, Torque
from lumped.tolerances import scene_of

SPEEDS = np.linspace(40.0, 80.0, 21)
J, BIG, C, D, A, ORDER = 0.5, 50.0, 2.0e4, 6.0, 100.0, 3.0
OVER = {n: lp.normal(v, 0.02 * v) for n, v in (("shaft.c", C), ("shaft.d", D), ("small.J", J))}


@pytest.fixture(scope="module")
def response():
    """A small inertia, excited three times a turn, on a shaft to a large one."""
    model = in_a_row(
        torque=Torque(tau=0.0),
        small=Inertia(J=J),
        shaft=SpringDamper(c=C, d=D),
        big=Inertia(J=BIG),
        water=Damper(d=1.0),
        ground=Fixed(),
    )
    return lp.vibration.order_response(
        lp.assemble(model), speeds=SPEEDS, of=["shaft.tau"], excitations={"torque.tau": {ORDER: A}}
    )


def torque(speed, c, d, small):
    """Torque of the shaft: m x'' + b x' + k x = f of two bodies."""
    w = ORDER * speed
    k, b = np.array([[c, -c], [-c, c]]), np.array([[d, -d], [-d, d + 1.0]])
    x = np.linalg.solve(k + 1j * w * b - w**2 * np.diag([small, BIG]), [A, 0.0])
    return abs((c + 1j * w * d) * (x[1] - x[0]))


def peak(c, d, small):
    """The largest torque between the first and the last speed."""
    middle = np.sqrt(c * (1 / small + 1 / BIG)) / ORDER
    assert 1.2 * SPEEDS[0] < middle < SPEEDS[-1] / 1.1
    found = minimize_scalar(
        lambda speed: -torque(speed, c, d, small),
        bounds=(0.9 * middle, 1.1 * middle),
        options={"xatol": 1e-9},
    )
    return -found.fun


def test_values_and_slopes_are_those_of_dense_solutions(response):
    scene = scene_of(
        response, over=OVER, of=[fun.order_peak("shaft.tau", measure=ORDER), fun.frequency(0)]
    )
    points = scene.draw(4, 2)
    values, slopes = scene.slopes(points)
    assert not scene.failures
    assert np.array_equal(scene.values(points), values)
    for point, value, slope in zip(points, values, slopes, strict=True):
        assert value[0] == pytest.approx(peak(*point), rel=1e-10)
        for j in range(3):
            step = np.zeros(3)
            step[j] = 1e-5 * point[j]
            by = (peak(*(point + step)) - peak(*(point - step))) / (2 * step[j])
            assert slope[0, j] == pytest.approx(by, rel=1e-6)
        # the water hardly matters to the frequency of the small inertia on the shaft
        assert value[1] == pytest.approx(
            np.sqrt(point[0] * (1 / point[2] + 1 / BIG)) / (2 * np.pi), rel=1e-4
        )
    found = lp.scatter(response, over=OVER, of=fun.order_peak("shaft.tau", measure=ORDER), runs=20)
    peaks = [peak(*point) for point in found.points]
    assert found["order_peak(shaft.tau, order 3)"].mean == pytest.approx(np.mean(peaks), rel=1e-10)


def test_second_derivatives_are_those_of_dense_solutions(response):
    """By central differences of fourth order, all for one standard deviation."""
    middle = np.array([C, D, J])
    of = fun.order_peak("shaft.tau", measure=ORDER)
    weights = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))
    h, unit, expected = 0.02, np.eye(3), np.zeros((3, 3))
    for i, k in np.ndindex(3, 3):
        for (a, first), (b, second) in itertools.product(weights, weights):
            point = middle * (1 + 0.02 * h * (a * unit[i] + b * unit[k]))
            expected[i, k] += first * second / h**2 * peak(*point)
    wide = 0.02 * middle
    received = scene_of(response, over=OVER, of=[of]).curvatures(middle)[0] * np.outer(wide, wide)
    assert worst(received, expected) < 1e-5
    found = lp.scatter(response, over=OVER, of=of, search="derivatives")[str(of)]
    assert found.order == 2
