"""Points inside the steps of a finished run at which a quantity may be highest, or turns."""

from __future__ import annotations

from typing import Literal, NamedTuple

import casadi as ca
import numpy as np

from lumped.code.operations import Operations, operations_of
from lumped.functionals.damage_law import DamageLaw
from lumped.gradients.spans import Span
from lumped.gradients.steps import Steps
from lumped.kernel.watch import Watch
from lumped.support.made_once import made_once
from lumped.timeloop.cycle_count import count_record
from lumped.timeloop.plants.many_points import CountedFunction
from lumped.timeloop.plants.parts import make_enclosed
from lumped.timeloop.step_bounds import heights, kinks

Signs = tuple[Literal[-1, 0, 1], ...]
"""Of each extreme: 1 for the greatest value, -1 for the least, 0 for the largest size."""

_ROOM = 256
"""Points for which there is room at first."""


class _Functions(NamedTuple):
    """What kernels need to enclose a quantity, by the fields of a watch."""

    operations: dict[str, Operations]
    counted: dict[str, CountedFunction]


@made_once
def _functions(steps: Steps, factors: tuple[str, ...], signs: Signs) -> _Functions:
    """A quantity as extremes with these signs, or as a load without any."""
    system = steps.system
    quantity = system.product(factors)
    repeated = [quantity] * max(len(signs), 1)
    whole = ca.Function("quantities", system.inputs, [ca.densify(ca.vertcat(*repeated))])
    found = {"extreme" if signs else "load": operations_of(whole)}
    if signs:
        found["height"] = heights(system, repeated, signs, steps.states + steps.integrals)
    kinked = kinks(system, [quantity])
    if kinked is not None:
        found["kink"] = operations_of(kinked)
    return _Functions(found, {field: CountedFunction(own) for field, own in found.items()})


def _watch(steps: Steps, functions: _Functions, signs: Signs) -> Watch:
    operations = functions.operations
    counts = dict.fromkeys(("integrands", "points", "finals", "event_points", "wanted_events"), 0)
    counts |= {"extremes": len(signs), "loads": int(not signs)}
    counts["kinks"] = operations["kink"].results if "kink" in operations else 0
    watch = Watch({**counts, "states": steps.states + steps.integrals})
    for field, count in counts.items():
        setattr(watch, field, count)
    watch.begin[:], watch.end[:], watch.sign[:] = -np.inf, np.inf, signs
    watch.enclosed_extremes = make_enclosed(operations.get("extreme"))
    watch.enclosed_loads = make_enclosed(operations.get("load"))
    watch.count = count_record([DamageLaw()] * counts["loads"], 0)
    return watch


def highest_points(
    steps: Steps,
    span: Span,
    factors: tuple[str, ...],
    sign: Literal[-1, 0, 1],
    best: float,
    slack: float,
) -> tuple[np.ndarray, float]:
    """Where a quantity is highest in parts of steps, up to a slack, shape (k, 3); what it reaches.

    Each row has the number of the step, the part of it, and the value there. A part that is highest
    at its end gives this end. That it reaches `best` is known.
    """
    functions = _functions(steps, factors, (sign,))
    watch = _watch(steps, functions, (sign,))
    watch.lists, watch.best[0], watch.slack = _ROOM, best - slack, slack
    rows = steps.list_points(span, watch, functions.counted, 1.0)
    return rows, float(np.maximum(best, watch.best[0] + slack))


def turning_points_in(
    steps: Steps, span: Span, factors: tuple[str, ...], least: float
) -> np.ndarray:
    """Where a quantity turns, or has a kink, inside steps, as `highest_points`.

    Turning points may be missed beside which it swings by less than a tenth of `least`.
    """
    functions = _functions(steps, factors, ())
    watch = _watch(steps, functions, ())
    watch.lists, watch.load_size[0] = _ROOM, 1.0
    return steps.list_points(span, watch, functions.counted, least)


def range_of(
    steps: Steps, span: Span, factors: tuple[str, ...], known: tuple[float, float]
) -> tuple[float, float]:
    """Least and greatest value of a quantity in steps, no narrower than a known range."""
    functions = _functions(steps, factors, (-1, 1))
    watch = _watch(steps, functions, (-1, 1))
    watch.best[:] = -known[0], known[1]
    steps.list_points(span, watch, functions.counted, 1.0)
    return -float(watch.best[0]), float(watch.best[1])
