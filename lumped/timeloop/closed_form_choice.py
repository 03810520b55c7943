"""Whether the closed form of a linear drive costs less than steps: from counts, never from time."""

from __future__ import annotations

import itertools
import math

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once
from lumped.timeloop.instants import Instants, instants
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.run_in_closed_form import has_linear_form, linear_form
from lumped.timeloop.run_options import RunPlan

_MOST_STATES = 200
"""States up to which eigenvalues and eigenvectors cost less than the steps of a short run."""
_MOST_INSTANTS = 300
"""Instants of functions of time up to which parts in closed form cost less than steps."""
_LONGEST = 6.4
"""Explicit step times the highest frequency at the limit of stability."""
_FINEST = 1.1
"""Steps for each radian of the highest frequency while it lasts, at a tolerance of 1e-6."""
_ORDER, _STEP_ORDER = 9, 8
"""Roots with which steps grow with the tolerance, and as vibrations decay."""
_RESTART = 10
"""Steps to find the step size after a jump."""


def closed_form_pays(point: OperatingPoint, plan: RunPlan, points: int) -> bool:
    """Whether the closed form holds (see `closed_form_holds`) and costs less than explicit steps.

    Parameters
    ----------
    points : int
        Number of output times.
    """
    if not _may_be_short(point.system):
        return False
    span, parts = plan.until - point.time, len(_find_instants(point, plan.until).modes)
    highest, decay = _pace(point.system)(point.theta, point.time, point.settings)[0].tolist()
    steps = parts * _count_steps(highest, decay, span / parts, plan.rtol)
    # operations are counted in nanoseconds of a usual machine
    n = len(point.x)
    by_steps = steps * (150 + 42 * n) + points * (10 + 5 * n)
    in_closed_form = 1.1e5 + 900 * n**2 + 3.5e4 * parts + points * 45 * n
    return not by_steps < in_closed_form and closed_form_holds(point, plan.until, plan.rtol)


def closed_form_holds(point: OperatingPoint, until: float, rtol: float) -> bool:
    """Whether there is a closed form, with few states and rounding below the tolerance."""
    system, theta = point.system, point.theta
    if not _may_be_short(system):
        return False
    form, found = linear_form(system), _find_instants(point, until)
    if len(found.times) > _MOST_INSTANTS:
        return False
    modes = np.zeros(system.structure.mode_count)
    for (begin, end), now in zip(itertools.pairwise(found.edges), found.modes, strict=True):
        modes[found.places] = now
        entries, _ = form.at(theta, begin, modes)
        if not np.isfinite(entries).all() or form.solve(entries).rounding(end - begin) > rtol:
            return False
    return True


@made_once
def _may_be_short(system: System) -> bool:
    """Whether there is a closed form, with few states."""
    return 0 < len(system.state_names) <= _MOST_STATES and has_linear_form(system)


def _find_instants(point: OperatingPoint, until: float) -> Instants:
    return instants(point.system, point.theta, point.time, until)


def _count_steps(highest: float, decay: float, length: float, rtol: float) -> float:
    """Explicit steps through a part of a run.

    They follow the highest frequency while it decays, until stability limits them.
    """
    finest: float = _FINEST * (1e-6 / rtol) ** (1 / _ORDER)
    longest = 1 / _LONGEST
    if not decay > 0:
        return _RESTART + highest * length * finest
    growth = decay / _STEP_ORDER
    follows: float = min(length, math.log(finest / longest) / growth)
    followed = finest * -math.expm1(-growth * follows) / growth
    return _RESTART + highest * (followed + longest * (length - follows))


@made_once
def _pace(system: System) -> ArrayFunction:
    """(p, t, m) -> highest frequency and its decay, 1/s, about.

    The sizes of the entries of a matrix lead a vector towards the mode of the highest frequency;
    the states that move most in it tell its decay.
    """
    x, theta, t, settings = system.inputs
    slopes = system.jacobian(ca.SX.zeros(x.numel()), theta, t, settings)[0]
    size, damping = ca.fabs(slopes), ca.fmax(-ca.diag(slopes), 0)
    mode = ca.mtimes(size, ca.mtimes(size, ca.SX.ones(x.numel())))
    twice = ca.mtimes(size, ca.mtimes(size, mode))
    highest = ca.sqrt(ca.mmax(twice / ca.fmax(mode, 1e-300)))
    decay = 0.5 * ca.dot(mode**2, damping) / ca.fmax(ca.sumsqr(mode), 1e-300)
    return ArrayFunction(ca.Function("pace", [theta, t, settings], [ca.vertcat(highest, decay)]))
