"""Where in a step a mode must change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np

from lumped.analysis.calls import Call, called
from lumped.analysis.dense import INSIDE, Method, doubtful, interpolated
from lumped.system import System

__all__ = ["Crossing", "Step", "first_crossing"]

_FINEST = 1e-3
"""Part of a step down to which a margin is searched for a dip below zero."""

_LOCATING = 40
"""Iterations in which a root inside a step is found to rounding."""


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


def first_crossing(system: System, method: Method, row: int, step: Step) -> Crossing | None:
    """The first instant in a step at which a margin is used up, if there is one."""
    probe = _function(system, method, "probe", step)
    span = _first_below(probe, step)
    if span is None:
        return None
    values = (*step[:2], step.dense.ravel(), *step[3:])
    suspects = np.flatnonzero(probe(span[1], 0.0, *values)[0][: _count(system)] < 0)
    locate = _function(system, method, "locate", step)
    roots = []
    for suspect in suspects.tolist():
        choice = np.zeros(_count(system))
        choice[suspect] = 1.0
        low = span[0] or _risen(system, method, step, suspect, span[1])
        roots.append(float(locate(low, span[1], choice, *values)[0][0]))
    fraction = min(roots)
    x = step.after
    if fraction < 1:
        x = interpolated(method, fraction, step.before, step.after, list(step.dense))
    time = step.t + fraction * step.h
    left, tolerance = called(system, "margins")(x, step.theta, time, step.settings)
    rows, first = system.switching.rows, system.switching.first_modes
    fired = [rows[i] for i, root in zip(suspects, roots, strict=True) if root == fraction]
    # what shares one reaction lets go together
    sharing = set(np.flatnonzero(step.settings[first + 3] > 0).tolist())
    for i in np.flatnonzero(left <= tolerance).tolist():
        kind, h = rows[i]
        together = kind in ("upper", "lower") and h in sharing
        if (together or i in suspects) and rows[i] not in fired:
            fired.append(rows[i])
    return Crossing(row, time, x, fired)


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
    probe: Call, step: Step, low: float = 0.0, width: float = 1.0
) -> tuple[float, float] | None:
    """Fractions of a step between which some margin first falls below zero."""
    values = (*step[:2], step.dense.ravel(), *step[3:])
    found, doubts = probe(low, width, *values)
    samples = found.reshape(len(INSIDE), -1)
    end = next((i for i in range(1, len(INSIDE)) if (samples[i] < 0).any()), None)
    if doubts.any() and width > _FINEST:
        for begin in (low, low + 0.5 * width):
            if end is not None and low + INSIDE[end - 1] * width <= begin:
                break
            inner = _first_below(probe, step, begin, 0.5 * width)
            if inner is not None:
                return inner
    if end is None:
        return None
    return low + INSIDE[end - 1] * width, low + INSIDE[end] * width


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
    return ca.Function(
        "probe", [low, part, *step], [ca.vertcat(*samples), doubtful(samples, slopes)]
    )


def _locator(system: System, method: Method, width: int) -> ca.Function:
    """Fraction at which one margin falls to zero, between two at which its sign differs.

    Illinois variant of the secant method (Dowell and Jarratt, BIT 11 (1971) 168).
    """
    step, inside = _inside(system, method, width)
    choice = ca.MX.sym("choice", _count(system))
    fraction, bracket = ca.MX.sym("fraction"), ca.MX.sym("bracket", 4)
    value = ca.dot(choice, system.margins(*inside(fraction, *step))[0])
    margin = ca.Function("margin", [fraction, choice, *step], [value])
    a, fa, b, fb = ca.vertsplit(bracket)
    secant = ca.if_else(fa == fb, b, (a * fb - b * fa) / (fb - fa))
    fc = margin(secant, choice, *step)
    crossed = fc * fb < 0
    improved = ca.vertcat(ca.if_else(crossed, b, a), ca.if_else(crossed, fb, 0.5 * fa), secant, fc)
    done = ca.logic_or(fb == 0, a == b)
    once = ca.Function("once", [bracket, choice, *step], [ca.if_else(done, bracket, improved)])
    low, high = ca.MX.sym("low"), ca.MX.sym("high")
    found = ca.vertcat(low, margin(low, choice, *step), high, margin(high, choice, *step))
    for _ in range(_LOCATING):
        found = once(found, choice, *step)
    # of the last bracket, the end at which the margin is used up
    root = ca.if_else(found[3] <= 0, found[2], found[0])
    return ca.Function("locate", [low, high, choice, *step], [root])
