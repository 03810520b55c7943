"""How second derivatives pass an instant at which rates or states jump.

States and their derivatives along one direction are a system of twice as many states. It jumps at
the same instant as the first, by a change that is known in closed form: the states by their own
change, the derivatives by the saltation matrix. So the jump of second derivatives is the transposed
saltation matrix of that system (Leine and Nijmeijer, Dynamics and Bifurcations of Non-Smooth
Mechanical Systems, 2004, ch. 7, for both).
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.errors import SolverError
from lumped.gradients.instant_values import looks_of
from lumped.gradients.jumps import Crossing, EventDerivatives
from lumped.gradients.saltation import saltation_of
from lumped.gradients.state_changes import Change
from lumped.gradients.steps import Steps
from lumped.support.made_once import made_once
from lumped.timeloop.result import Trajectory

__all__ = ["SecondJumps", "is_smooth"]

_SAME = 1e-6
"""Relative difference below which two rows of derivatives of an instant are the same."""

_Cause = tuple[str, int]
"""What decides when it happens: a margin or a clock, with its number; or that it does not move."""


class SecondJumps:
    """Jumps of the second derivatives along one run.

    Parameters
    ----------
    run : Trajectory
        The run.
    steps : Steps
        How it was made, with what is integrated.
    """

    def __init__(self, run: Trajectory, steps: Steps) -> None:
        self.run, self.steps = run, steps

    def check(self, crossing: Crossing) -> None:
        """Refuse an instant that second derivatives do not pass.

        Raises
        ------
        SolverError
            If different changes coincide, bounces come to an end, or redundant constraints let go.
        """
        jumps = crossing.orders[0] if crossing.orders else ()
        if len(jumps) > 1 and not all(is_smooth(self.run, self.steps, crossing, j) for j in jumps):
            self._refuse(crossing, "different changes coincide")
        if any(jump.settles for jump in jumps):
            self._refuse(crossing, "ever smaller bounces come to an end")
        if any(jump.shared for jump in jumps):
            self._refuse(crossing, "statically indeterminate constraints let go")
        for jump in jumps:
            self._cause(crossing, jump)

    def _refuse(self, crossing: Crossing, why: str) -> None:
        raise SolverError(
            f"{self.run.system.name}: at t = {crossing.t:.9g} s {why} "
            f"({', '.join(crossing.names)}); second derivatives are not followed across that. "
            "Change a parameter a little, end the run before, or take differences of "
            "lumped.gradient.",
            self.run,
        )

    def _cause(self, crossing: Crossing, jump: EventDerivatives) -> _Cause:
        """What moves the instant as a jump says."""
        if not jump.instant.any():
            return "fixed", 0
        x, m = jump.before
        looks = looks_of(self.run.system)
        values = looks.at(x, self.run.theta, crossing.t, m)
        for i in jump.used:
            if _same(-looks.margin_slopes(values, i) / values.margin_rates[i], jump.instant):
                return "margin", i
        for k, fast in enumerate(values.fast.tolist()):
            if fast and _same(-looks.clock_slopes(values, k) / fast, jump.instant):
                return "clock", k
        self._refuse(crossing, "it is not one margin that decides when something changes")
        raise AssertionError

    def back(
        self,
        crossing: Crossing,
        jump: EventDerivatives,
        S: np.ndarray,
        along: np.ndarray,
        second: np.ndarray,
        first: np.ndarray,
        weight: float,
    ) -> tuple[np.ndarray, np.ndarray]:
        """The derivatives of a derivative, and the first ones, before a jump from those after it.

        Parameters
        ----------
        S, along : ndarray, shapes (n,) and (p,)
            Derivatives of the states before it, and of the parameters, along a direction.
        second, first : ndarray, shape (n + p,)
            By states and parameters.
        weight : float
            What the result owes to integrals over this instant.
        """
        n, (x, m) = len(S), jump.before
        change = saltation_of(self.run.system).changes.states(*jump.act, jump.after[1])
        function = _made(self.steps, self._cause(crossing, jump), change)
        point = x, S, self.run.theta, along, crossing.t, m, jump.after[1]
        found = function(*point, second[:n], first[:n], np.full(self.steps.integrals, weight))
        slopes, late = np.asarray(found[0]).ravel(), float(found[1])
        by_x, by_S, by_p, by_along = np.split(slopes, np.cumsum([n, n, len(along)]))
        before = np.concatenate([by_x, second[n:] + by_p]) + late * jump.instant
        return before, np.concatenate([by_S, first[n:] + by_along])


def is_smooth(run: Trajectory, steps: Steps, crossing: Crossing, jump: EventDerivatives) -> bool:
    """Whether neither states nor rates nor integrands jump, only their derivatives."""
    n = len(jump.drift)
    off = np.abs(jump.states.toarray() - np.eye(n)).max(initial=0.0)
    off = max(off, np.abs(jump.parameters.toarray()).max(initial=0.0))
    for function in (run.system.rhs, steps.integrated):
        before, after = (
            np.asarray(function(x, run.theta, crossing.t, m)).ravel()
            for x, m in (jump.before, jump.after)
        )
        size = 1.0 + np.abs(before).max(initial=0.0)
        off = max(off, np.abs(before - after).max(initial=0.0) / size)
    return bool(off <= 1e-9)


def _same(one: np.ndarray, other: np.ndarray) -> bool:
    return bool(np.abs(one - other).max() <= _SAME * np.abs(other).max())


@made_once
def _made(steps: Steps, cause: _Cause, change: Change) -> ca.Function:
    """Derivatives of what is owed, by all before the jump, and by its instant.

    Of (x, S, p, along, t, settings before, settings after, second, first, weights of integrals).
    """
    system = steps.system
    x, p, t, m = system.inputs
    m_after = ca.SX.sym("m_after", m.numel())
    S, along = ca.SX.sym("S", x.numel()), ca.SX.sym("along", p.numel())
    second, first = ca.SX.sym("second", x.numel()), ca.SX.sym("first", x.numel())
    weights = ca.SX.sym("weights", steps.integrals)
    both, direction = ca.vertcat(x, p), ca.vertcat(S, along)

    q = ca.densify(steps.integrands)
    parts = [system.rates, q]
    parts += [ca.densify(ca.jtimes(part, both, direction)) for part in parts]
    flow = ca.Function("flow", [x, S, p, along, t, m], parts)
    f, q, f_along, q_along = flow(x, S, p, along, t, m)

    moved = _moved(steps, cause, direction)
    x_new = change.found
    after = system.rhs(x_new, p, t, m_after)
    drift = ca.jtimes(x_new, ca.vertcat(x, t), ca.vertcat(f, 1)) - after
    S_new = ca.densify(ca.jtimes(x_new, both, direction) + drift * moved)
    f_new, q_new, f_new_along, q_new_along = flow(x_new, S_new, p, along, t, m_after)

    owed = ca.dot(second, x_new) + ca.dot(first, S_new) + ca.dot(weights, q - q_new) * moved
    late = ca.jtimes(owed, ca.vertcat(x, S, t), ca.vertcat(f, f_along, 1))
    late -= ca.dot(second, f_new) + ca.dot(first, f_new_along)
    late += ca.dot(weights, q_along - q_new_along)
    slopes = ca.densify(ca.gradient(owed, ca.vertcat(x, S, p, along)))
    inputs = [x, S, p, along, t, m, m_after, second, first, weights]
    return ca.Function("jump", inputs, [slopes, late])


def _moved(steps: Steps, cause: _Cause, direction: ca.SX) -> ca.SX:
    """Derivative of the instant along a direction."""
    system, (kind, number) = steps.system, cause
    x, p, t, _ = system.inputs
    if kind == "fixed":
        return ca.SX(0)
    if kind == "clock":
        what = looks_of(system).clocks[number].condition.argument
    else:
        what = system.structure.in_states(system.switching.margins[0])[number]
    rate = ca.jtimes(what, ca.vertcat(x, t), ca.vertcat(system.rates, 1))
    return -ca.jtimes(what, ca.vertcat(x, p), direction) / rate
