"""Operations of CasADi, by name: what code, bounds and enclosures are tried on."""

import casadi as ca
import numpy as np

from lumped.kernel import engine
from lumped.kernel.plant import Function, Plant
from lumped.kernel.run import Run

ONE = {
    name: getattr(ca, name)
    for name in (
        *("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh"),
        *("asinh", "acosh", "atanh", "exp", "expm1", "log", "log1p", "sqrt", "erf"),
        *("floor", "ceil", "fabs", "sign"),
    )
}
ONE |= {
    "negative": lambda a: -a,
    "square": lambda a: a * a,
    "twice": lambda a: 2 * a,
    "inverse": lambda a: 1 / a,
    "cube": lambda a: a**3,
    "not": ca.logic_not,
}
"""Of one number."""

TWO = {
    name: getattr(ca, name)
    for name in ("atan2", "hypot", "fmin", "fmax", "fmod", "remainder", "copysign")
}
TWO |= {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b,
    "power": lambda a, b: a**b,
    "less": lambda a, b: a < b,
    "at most": lambda a, b: a <= b,
    "if else": lambda a, b: ca.if_else(a > b, a, 3 * b),
}
"""Of two."""


def interpret(operations, x, p, t, m):
    """Results of a function by the interpreter of the present engine."""
    code = Function(
        count=len(operations.table),
        operations=operations.table.ravel(),
        constants=operations.constants,
    )
    sizes = dict.fromkeys(Run.lengths(), 0) | {"work": operations.work}
    sizes |= {"states": len(x), "parameters": len(p), "settings": len(m)}
    run, found = Run(sizes, plant=Plant(), t=float(t)), np.zeros(max(operations.results, 1))
    run.x[:], run.p[:], run.m[:] = x, p, m
    engine.call("value", run, code, found)
    return found
