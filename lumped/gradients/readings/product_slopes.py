"""Products of quantities and their derivatives along a run."""

from __future__ import annotations

import casadi as ca

from lumped.compiler.system import System
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once
from lumped.timeloop.plants.many_points import ManyPoints


@made_once
def differentiate_at_many(system: System, factors: tuple[str, ...]) -> ManyPoints:
    """A product, its derivative by time along the run, and those by states and parameters."""
    y, by_x, by_p, along = _slopes(system, factors)
    every = ca.densify(ca.vertcat(y, along, by_x.T, by_p.T))
    return ManyPoints(ca.Function("at_many", system.inputs, [every]))


@made_once
def differentiate_at_one(system: System, factors: tuple[str, ...]) -> ArrayFunction:
    """A product, its derivatives by states and parameters, by time along the run: (x, p, t, m)."""
    results = [ca.densify(each) for each in _slopes(system, factors)]
    return ArrayFunction(ca.Function("differentiated", system.inputs, results))


def _slopes(system: System, factors: tuple[str, ...]) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
    """A product of quantities, its derivatives by states, parameters, and time along the run."""
    x, p, t, _ = system.inputs
    y = system.product(factors)
    along = ca.jtimes(y, ca.vertcat(x, t), ca.vertcat(system.rates, 1))
    return y, ca.jacobian(y, x), ca.jacobian(y, p), along
