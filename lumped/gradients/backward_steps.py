"""Steps of a run as functions, alone and backwards: many per call, no Python in between."""

from __future__ import annotations

from typing import Any

import casadi as ca

from lumped.compiler.system import System
from lumped.numerics.inside_step import Method, interpolated
from lumped.numerics.one_step import explicit_dense, explicit_step, implicit_dense, implicit_step
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once

__all__ = ["CHUNKS", "FRACTIONS", "backwards", "chained", "looked", "step_function"]

_EXPAND_BELOW = 200
"""States up to which what is called often is expanded to scalar operations."""

CHUNKS = (64, 8, 1)
"""Steps in one call, largest first."""

FRACTIONS = tuple(i / 8 for i in range(1, 9))
"""Of each step, at which it is looked for extremes."""


def step_function(system: System, method: Method, integrands: ca.SX) -> ca.Function:
    """One step: (x, p, t, h, m) -> new x, integrals over the step."""
    n, q = len(system.state_names), integrands.numel()
    x, p, t, h, m = _symbols(system)
    rates = ca.densify(ca.cse(ca.vertcat(system.rates, integrands)))
    rhs = ca.Function("rates", system.inputs, [rates])

    def rate(z: ca.MX, t: ca.MX) -> ca.MX:
        return rhs(ca.vertsplit(z, [0, n, n + q])[0], p, t, m)

    z = ca.vertcat(x, ca.MX.zeros(q))
    if method == "explicit":
        new = explicit_step(rate, z, rate(z, t), t, h)[-1]
    else:
        by_x = ca.horzcat(ca.jacobian(rates, system.inputs[0]), ca.SX(n + q, q))
        by_t = ca.densify(ca.jacobian(rates, system.inputs[2]))
        jacobian, drift = ca.Function("slopes", system.inputs, [by_x, by_t])(x, p, t, m)
        new = implicit_step(rate, (jacobian, drift), z, rate(z, t), t, h)[-1]
    results = ca.vertsplit(new, [0, n, n + q])
    function = ca.Function("step", [x, p, t, h, m], results)
    return _expanded(function, system) if method == "explicit" else function


def backwards(step: ca.Function, results: int) -> ca.Function:
    """Adjoints before a step from those after it.

    (adjoint, states and parameters, t, h, m, chosen) -> adjoint, derivatives by parameters,
    integrals; `chosen` holds the derivatives of the results by the integrals.

    Parameters
    ----------
    step : Function
        From `step_function`.
    results : int
        Their number.
    """
    n, p, m = (step.size1_in(i) for i in (0, 1, 4))
    kind: Any = ca.SX if step.is_a("SXFunction") else ca.MX
    after, both = kind.sym("after", n, results), kind.sym("both", n + p)
    t, h, modes = kind.sym("t"), kind.sym("h"), kind.sym("m", m)
    chosen = kind.sym("chosen", step.size1_out(1), results)
    x, theta = ca.vertsplit(both, [0, n, n + p])
    new, integrals = step(x, theta, t, h, modes)
    seeds = ca.vertcat(after, chosen)
    found = ca.densify(ca.jtimes(ca.vertcat(new, integrals), both, seeds, True))
    outputs = [*ca.vertsplit(found, [0, n, n + p]), ca.densify(integrals)]
    return ca.Function("back", [after, both, t, h, modes, chosen], outputs)


def chained(back: ca.Function, parameters: int, count: int) -> ArrayFunction:
    """Several steps backwards.

    (adjoint, x, p, t, h, m, chosen) -> adjoint, derivatives by p, integrals; columns of x, t, h
    and m are the steps, the first one first; results are sums over the steps, but for the adjoint.
    """
    n, k = back.size_in(0)
    m = back.size1_in(4)
    adjoint, theta = ca.MX.sym("adjoint", n, k), ca.MX.sym("p", parameters)
    xs, ts, hs = ca.MX.sym("x", n, count), ca.MX.sym("t", 1, count), ca.MX.sym("h", 1, count)
    ms, chosen = ca.MX.sym("m", m, count), ca.MX.sym("chosen", *back.size_in(5))
    columns = [ca.horzsplit(v) for v in (xs, ts, hs, ms)]
    by_p, total = (ca.MX.zeros(*back.size_out(i)) for i in (1, 2))
    before = adjoint
    for x, time, length, setting in reversed(list(zip(*columns, strict=True))):
        both = ca.vertcat(x, theta)
        before, more, part = back(before, both, time, length, setting, chosen)
        by_p, total = by_p + more, total + part
    inputs = [adjoint, xs, theta, ts, hs, ms, chosen]
    return ArrayFunction(ca.Function("sweep", inputs, [before, by_p, total]))


@made_once
def looked(system: System, method: Method, quantities: ca.Function) -> ca.Function:
    """Quantities inside a step: (x, p, t, h, m) -> shape (quantities, FRACTIONS)."""
    x, p, t, h, m = _symbols(system)

    def rate(x: ca.MX, t: ca.MX) -> ca.MX:
        return system.rhs(x, p, t, m)

    if method == "explicit":
        stages, _, new = explicit_step(rate, x, rate(x, t), t, h)
        dense = explicit_dense(rate, x, new, [*stages, rate(new, t + h)], t, h)
    else:
        jacobian, drift = system.jacobian(x, p, t, m)
        increments, new = implicit_step(rate, (jacobian, drift), x, rate(x, t), t, h)
        dense = implicit_dense(increments)
    columns = ca.horzsplit(dense)
    found = []
    for part in FRACTIONS:
        inside = interpolated(method, part, x, new, columns) if part < 1 else new
        found.append(quantities(inside, p, t + part * h, m))
    function = ca.Function("looked", [x, p, t, h, m], [ca.densify(ca.horzcat(*found))])
    return _expanded(function, system) if method == "explicit" else function


def _symbols(system: System) -> list[ca.MX]:
    """States, parameters, time, length of a step, settings."""
    x, p, _, m = system.inputs
    sizes = {"x": x.numel(), "p": p.numel(), "t": 1, "h": 1, "m": m.numel()}
    return [ca.MX.sym(name, size) for name, size in sizes.items()]


def _expanded(function: ca.Function, system: System) -> ca.Function:
    """The function as scalar operations, unless the system is so large that they are too many."""
    return function.expand() if len(system.state_names) <= _EXPAND_BELOW else function
