"""Where in a step a mode must change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np
import numpy.typing as npt

from lumped.compiler.system import System
from lumped.numerics.inside_step import INSIDE, Method, doubtful, interpolated
from lumped.timeloop.calls import Call, called, expanded

__all__ = ["CROWDED", "Crossing", "Step", "first_crossing"]

CROWDED = 1e-14
"""Relative distance of instants that differ by rounding."""

_FINEST = 1e-3
"""Part of a step down to which a margin is searched for a dip below zero."""

_LOCATING = 40
"""Most iterations in which a root inside a step is found to rounding."""

_ROUNDING = 2.0**-53
"""Of fractions of a step."""


class Step(NamedTuple):
    """A step and what it was made with.

    Attributes
    ----------
    before, after : ndarray, shape (n,)
        States at its ends.
    dense : ndarray, shape (c, n)
        Interpolation coefficients.
    t, h : float
        Begin and length, s.
    theta, settings : ndarray
        Parameters; modes and implicit quantities.
    """

    before: np.ndarray
    after: np.ndarray
    dense: np.ndarray
    t: float
    h: float
    theta: np.ndarray
    settings: np.ndarray


@dataclass(frozen=True)
class Crossing:
    """Where margins are used up.

    Attributes
    ----------
    row : int
        Attempt in the chunk of steps.
    time : float
        Instant, s.
    x : ndarray, shape (n,)
        State there.
    fired : list of (str, int)
        Margins that are used up (see `Switching.rows`).
    """

    row: int
    time: float
    x: np.ndarray
    fired: list[tuple[str, int]]


def first_crossing(
    system: System, method: Method, row: int, step: Step, crowded: bool
) -> Crossing | None:
    """The first instant in a step at which a margin is used up, if there is one.

    If modes changed twice where the step begins (`crowded`, to `CROWDED` of the time), a margin
    that is below zero there within its tolerance waits until it leaves that, as rounding alone
    would change modes again. Speeds and gaps wait for half of it: where they stop they may stay.
    """
    values = (*step[:2], step.dense.ravel(), *step[3:])
    probe, margins = _function(system, method, "probe", step), called(system, "margins")
    span = _first_below(probe, values)
    if span is None:
        return None
    low, high, suspects = span
    used_up = suspects
    locate = _function(system, method, "locate", step)
    choice = np.zeros(_count(system))
    fired = set()
    while len(used_up):  # not after `high` any more
        margin = int(used_up[0])
        choice[margin] = 1.0
        fired = {margin}
        begin = low or _risen(system, method, step, margin, high)
        extra = crowded * (0.5 if system.switching.rows[margin][0] == "slide" else 1.0)
        found = float(locate(begin, high, extra, choice, *values)[0][0])
        if not begin - _FINEST <= found <= high:
            # zero within its tolerance all the time before, as where rounding alone moves a rest
            found = float(locate(begin, high, 1.0, choice, *values)[0][0])
        high = max(found, 0.0)
        choice[margin] = 0.0
        x = step.after
        if high < 1:
            x = interpolated(method, high, step.before, step.after, list(step.dense))
        time = step.t + high * step.h
        left, tolerance = margins(x, step.theta, time, step.settings)
        earlier = used_up[left[used_up] < -tolerance[used_up]]
        used_up = earlier[earlier != margin]
    rows, first = system.switching.rows, system.switching.first_modes
    near = left <= tolerance
    fired.update(suspects[near[suspects]].tolist())
    # what shares one reaction lets go together
    sharing = step.settings[first + 3] > 0
    if sharing.any():
        for i in np.flatnonzero(near).tolist():
            kind, h = rows[i]
            if kind in ("upper", "lower") and sharing[h]:
                fired.add(i)
    return Crossing(row, time, x, [rows[i] for i in sorted(fired)])


def _risen(system: System, method: Method, step: Step, margin: int, end: float) -> float:
    """Where a margin that is zero when the step begins is positive before it falls again."""
    margins, states = called(system, "margins"), (step.before, step.after, list(step.dense))
    for power in range(1, 30):
        fraction = end * 0.5**power
        x = interpolated(method, fraction, *states)
        left, _ = margins(x, step.theta, step.t + fraction * step.h, step.settings)
        if left[margin] > 0:
            return fraction
    return 0.0


def _count(system: System) -> int:
    return int(system.margins.size1_out(0))


def _first_below(
    probe: Call, values: tuple[npt.ArrayLike, ...], low: float = 0.0, width: float = 1.0
) -> tuple[float, float, np.ndarray] | None:
    """Fractions of a step between which a margin first falls below zero, and all that do there."""
    found, doubts = probe(low, width, *values)
    samples = found.reshape(len(INSIDE), -1)
    lowest = samples.min(axis=1).tolist()
    end = next((i for i in range(1, len(INSIDE)) if lowest[i] < 0), None)
    if doubts.any() and width > _FINEST:
        for begin in (low, low + 0.5 * width):
            if end is not None and low + INSIDE[end - 1] * width <= begin:
                break
            inner = _first_below(probe, values, begin, 0.5 * width)
            if inner is not None:
                return inner
    if end is None:
        return None
    fallen = np.flatnonzero(samples[end] < 0)
    return low + INSIDE[end - 1] * width, low + INSIDE[end] * width, fallen


def _function(system: System, method: Method, what: Literal["probe", "locate"], step: Step) -> Call:
    key = (what, method)
    if key not in system.made:
        make = _prober if what == "probe" else _locator
        system.made[key] = Call(make(system, method, len(step.dense)))
    made: Call = system.made[key]
    return made


def _inside(system: System, method: Method, width: int) -> tuple[list[ca.MX], ca.Function]:
    """Symbols of a `Step`, and arguments of functions of the system at a fraction of it."""
    n = len(system.states)
    step = [ca.MX.sym("before", n), ca.MX.sym("after", n), ca.MX.sym("dense", n, width)]
    step += [ca.MX.sym("t"), ca.MX.sym("h")]
    step += [ca.MX.sym("p", system._inputs[1].numel()), ca.MX.sym("m", system._inputs[3].numel())]
    before, after, dense, t, h, p, m = step
    fraction = ca.MX.sym("fraction")
    x = interpolated(method, fraction, before, after, ca.horzsplit(dense))
    return step, ca.Function("inside", [fraction, *step], [x, p, t + fraction * h, m])


def _prober(system: System, method: Method, width: int) -> ca.Function:
    """Margins and tolerances in a part of a step at `INSIDE`, and which may dip between."""
    step, inside = _inside(system, method, width)
    low, part = ca.MX.sym("low"), ca.MX.sym("part")
    points: list[Any] = [inside(low + share * part, *step) for share in INSIDE]
    samples = []
    for point in points:
        margins, tolerances = system.margins(*point)
        samples.append(margins + tolerances)
    slopes = [part * step[4] * system.margin_rates(*points[i]) for i in (0, -1)]
    results = [ca.vertcat(*samples), doubtful(samples, slopes)]
    return expanded(ca.Function("probe", [low, part, *step], results), system)


def _locator(system: System, method: Method, width: int) -> ca.Function:
    """Fraction at which one margin, or it and `extra` tolerances, falls to zero.

    Between two fractions at which its sign differs; or a little before the first, if it is negative
    there already, within the tolerance.

    Illinois variant of the secant method (Dowell and Jarratt, BIT 11 (1971) 168).
    """
    step, inside = _inside(system, method, width)
    choice = ca.MX.sym("choice", _count(system))
    fraction, bracket = ca.MX.sym("fraction"), ca.MX.sym("bracket", 4)
    left, tolerance = (ca.dot(choice, v) for v in system.margins(*inside(fraction, *step)))
    extra = ca.MX.sym("extra")
    given = [extra, choice, *step]
    margin = ca.Function("margin", [fraction, *given], [left + extra * tolerance])
    a, fa, b, fb = ca.vertsplit(bracket)
    secant = ca.if_else(fa == fb, b, (a * fb - b * fa) / (fb - fa))
    fc = margin(secant, *given)
    crossed = fc * fb < 0
    improved = ca.vertcat(ca.if_else(crossed, b, a), ca.if_else(crossed, fb, 0.5 * fa), secant, fc)
    once = expanded(ca.Function("once", [bracket, *given], [improved]), system)
    search = ca.Function.if_else("search", once, ca.Function("found", [bracket, *given], [bracket]))
    low, high = ca.MX.sym("low"), ca.MX.sym("high")
    found = ca.vertcat(low, margin(low, *given), high, margin(high, *given))
    for _ in range(_LOCATING):
        apart = ca.fabs(found[0] - found[2]) > _ROUNDING
        found = search(ca.logic_and(found[3] != 0, apart), found, *given)
    # of the last bracket, the end at which the margin is used up
    root = ca.if_else(found[3] <= 0, found[2], found[0])
    return ca.Function("locate", [low, high, *given], [root])
