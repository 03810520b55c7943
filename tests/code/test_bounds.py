"""Bounds of functions over intervals against their values inside, and against closed forms."""

import casadi as ca
import casadi_operations
import numpy as np
import pytest

from lumped.code.bounds import bounds_of
from lumped.code.operations import operations_of

X, P, T, M = ca.SX.sym("x", 2), ca.SX.sym("p"), ca.SX.sym("t"), ca.SX.sym("m")
GIVEN = 1.3, -0.7
ONE = casadi_operations.ONE | {
    "fourth power": lambda a: a**4,
    "inverse of a cube": lambda a: a**-3,
    "power that is set": lambda a: ca.fabs(a) ** M,
}
TWO = casadi_operations.TWO | {
    "equal": lambda a, b: ca.floor(a) == ca.floor(b),
    "not equal": lambda a, b: ca.floor(a) != ca.floor(b),
    "and": lambda a, b: ca.logic_and(a > 0, b > 0),
    "or": lambda a, b: ca.logic_or(a > 0, b > 0),
    "if": lambda a, b: ca.if_else(a > 0, b, 0),
}
ALL = {name: f(X[0] + P * T) for name, f in ONE.items()}
ALL |= {name: f(X[0] - M, X[1] * P + T) for name, f in TWO.items()}
ALL |= {f"{name}, times a constant": -2 * f for name, f in ALL.items()}


def evaluated(made, low, high):
    x = [*low[:2], *high[:2], low[2], high[2]]
    return casadi_operations.interpret(made, x, [GIVEN[0]], 0.0, [GIVEN[1]])


def bounds(expressions, low, high):
    """Lower bounds, and upper ones, of expressions of states and time between two points."""
    function = ca.Function("f", [X, P, T, M], [ca.densify(ca.vertcat(*expressions))])
    operations = operations_of(function)
    found = evaluated(bounds_of(operations, 2), low, high).reshape(2, -1)
    alone = evaluated(bounds_of(operations, 2, upper=False), low, high)
    np.testing.assert_array_equal(alone, found[0])
    return found


@pytest.mark.parametrize("name", ALL)
def test_values_inside_lie_between_bounds(name):
    rng = np.random.default_rng(len(name))
    function = ca.Function("f", [X, P, T, M], [ALL[name]])
    for _ in range(40):
        low = rng.uniform(-3, 3, 3)
        high = low + 10 ** rng.uniform(-3, 0.8, 3)
        (least,), (most,) = bounds([ALL[name]], low, high)
        shares = np.hstack([rng.uniform(size=(3, 60)), [[0, 1, 0, 1]] * 3])
        x = low[:, None] + shares * (high - low)[:, None]
        values = np.asarray(function(x[:2], GIVEN[0], x[2:], GIVEN[1])).ravel()
        values = values[np.isfinite(values)]
        slack = 1e-12 * (1 + np.abs(values))
        assert (values >= least - slack).all()
        assert (values <= most + slack).all()


def test_bounds_of_what_moves_once_are_its_range():
    low, high = np.array([-0.5, 1.0, 2.0]), np.array([2.0, 1.5, 2.5])
    x, y, p, m = X[0], X[1], *GIVEN
    expected = {
        x * x: (0.0, 4.0),
        y**2.5: (1.0, 1.5**2.5),
        ca.cos(x): (np.cos(2.0), 1.0),
        ca.sin(x): (np.sin(-0.5), 1.0),
        ca.sin(4 * y): (-1.0, np.sin(6.0)),
        1 / y: (1 / 1.5, 1.0),
        M * x: (2 * m, -0.5 * m),
        P * T - y: (2 * p - 1.5, 2.5 * p - 1.0),
        ca.fabs(x): (0.0, 2.0),
        x * y: (-0.75, 3.0),
        ca.tan(y / 1.5): (np.tan(1 / 1.5), np.tan(1.0)),
        ca.if_else(y < 1.6, x, 100.0): (-0.5, 2.0),
        ca.if_else(y < 1.2, x, 100.0): (-0.5, 102.0),
        ca.if_else(M < 0, x, 100.0): (-0.5, 2.0),
    }
    received = bounds(expected, low, high).T
    np.testing.assert_allclose(received, list(expected.values()), rtol=1e-13, atol=1e-13)


def test_what_may_be_anything_has_no_bounds():
    low, high = np.array([-0.5, -1.0, 0.0]), np.array([2.0, 1.5, 2.5])
    received = bounds([1 / X[0], X[1] ** -2, ca.tan(X[0])], low, high)
    assert (received[0] < -1e290).all()
    assert (received[1] > 1e290).all()
