import casadi as ca
import numpy as np
import pytest

from lumped.code.operations import operations_of
from lumped.code.step_functions import tabulate_steps
from lumped.language.expression import time
from lumped.language.lowering import lower
from lumped.ops import interpolate, periodic_spline
from lumped.timeloop.plants.many_points import ManyPoints

RANDOM = np.random.default_rng(7)
PLACES = np.sort(RANDOM.uniform(-1.0, 9.0, 40))


def tables(kind, x, p):
    """Tables of two numbers, one in the other, and derivatives."""
    values = RANDOM.normal(size=40)

    def of(place):
        if kind == "periodic":
            found = interpolate(time, PLACES, values, period=12.0)
        elif kind == "spline":
            found = periodic_spline(time, PLACES, [*values[:-1], values[0]])
        else:
            found = interpolate(time, PLACES, values)
        return lower(found, lambda _: place, time=place)

    first, second = of(x[0] * p), of(x[1])
    both = first / (1 + x[1] ** 2) + of(first + second) ** 2
    return ca.vertcat(both, second, ca.gradient(both, x), of(x[0]) * of(x[0]))


@pytest.mark.parametrize("kind", ["lines", "periodic", "spline"])
def test_tables_looked_up_have_the_bits_of_their_comparisons(kind):
    x, p, t, m = ca.SX.sym("x", 2), ca.SX.sym("p"), ca.SX.sym("t"), ca.SX.sym("m", 1)
    function = ca.Function("f", [x, p, t, m], [ca.cse(tables(kind, x, p) * m)])
    parts = tabulate_steps(operations_of(function), 1)
    assert parts is not None
    assert len(parts.rest.table) < 0.4 * len(operations_of(function).table)
    points = np.column_stack([RANDOM.uniform(-30, 30, 500), RANDOM.uniform(-30, 30, 500)])
    points[:40] = PLACES[:, None]  # where one piece ends
    points[40:80, 1] = np.nextafter(PLACES, -np.inf)
    points[80], points[81] = (np.nan, 1.0), (1.0, np.inf)
    found = ManyPoints(function)(points, np.ones(1), np.zeros(500), np.full((500, 1), 2.0))
    for point, row in zip(points, found, strict=True):
        wanted = np.array(function(point, 1.0, 0.0, 2.0)).ravel()
        np.testing.assert_array_equal(row, wanted)


def test_few_comparisons_are_left_as_they_are():
    x, none = ca.SX.sym("x"), ca.SX.sym("none", 0)
    function = ca.Function("f", [x, none, ca.SX.sym("t"), none], [ca.if_else(x >= 1, x, 2)])
    assert tabulate_steps(operations_of(function), 0) is None
