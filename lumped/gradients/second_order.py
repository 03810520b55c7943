"""Tangents along a run, and the derivative of the sweep back along them.

A run and its derivative along one direction are a run of twice as many states. The derivatives of
that derivative are one row of the Hessian, by the sweep back that gives gradients.
"""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.gradients.functional_terms import SmoothParts
from lumped.gradients.jumps import EventDerivatives
from lumped.gradients.legs import Leg
from lumped.gradients.second_jumps import SecondJumps
from lumped.gradients.step_code import Span, StepCode
from lumped.gradients.steps import Steps
from lumped.simulation.functional_kinds import At, Final, Integral, product
from lumped.support.made_once import made_once
from lumped.timeloop.run import nominals

__all__ = ["Found", "Second"]

_Tangent = tuple[list[tuple[int, int, np.ndarray]], np.ndarray]
"""Parts of a leg, from step to step, with what they begin with; what the leg ends with."""


class Found(NamedTuple):
    """Value of a functional, and its derivatives by states at the start, then parameters.

    Attributes
    ----------
    value : float
        What it is.
    first, second : ndarray, shapes (n + p,) and (n + p, k)
        First derivatives; those of the derivatives along each direction.
    each : list of ndarray, shape (steps, k)
        Errors of these by each step, leg by leg, relative to what they owe to the states by then.
    errors : ndarray, shape (k,)
        Their errors by all steps.
    """

    value: float
    first: np.ndarray
    second: np.ndarray
    each: list[np.ndarray]
    errors: np.ndarray


class Second:
    """Second derivatives of one functional of a run.

    Parameters
    ----------
    course : SmoothParts
        The run, every instant that counts an end of a step.
    seed, S : ndarray, shapes (p, k) and (n, k)
        The directions: derivatives of the parameters and of the states at the start.
    of : functional
        What is differentiated (the integral, if it is one).
    """

    def __init__(
        self, course: SmoothParts, seed: np.ndarray, S: np.ndarray, of: Final | At | Integral
    ) -> None:
        self.course, self.seed, self.S = course, seed, S
        self.run, self.steps = course.run, course.steps
        self.n, self.k = S.shape
        self.jumps = SecondJumps(self.run, self.steps)
        self.names: tuple[str, ...] = ()
        self.times: tuple[float, ...] = ()
        self.window = (0.0, 0.0)
        if isinstance(of, Integral):
            self.window = of.between or (0.0, course.until)
        elif isinstance(of, At):
            self.names, self.times = of.names, of.times
        else:
            self.names, self.times = (of.name,), (course.until,)

    def go(self) -> Found:
        """Value, and first and second derivatives."""
        own = [self._along(k) for k in range(self.k)]
        second = np.column_stack([found.second for found in own])
        each = [np.hstack(columns) for columns in zip(*(f.each for f in own), strict=True)]
        errors = np.concatenate([f.errors for f in own])
        return Found(own[0].value, own[0].first, second, each, errors)

    def _along(self, k: int) -> Found:
        """Value, first derivatives, and those of the derivative along one direction."""
        n, p, seed = self.n, len(self.run.theta), self.seed[:, k]
        tangents = self._tangents(k)
        twice = _twice(self.steps)
        value, first, second = 0.0, np.zeros(n + p), np.zeros(n + p)
        largest = lost = np.zeros((2 * (n + self.steps.integrals), 1))
        each = [np.zeros((len(leg.t) - 1, 1)) for leg in self.course.legs]
        for number in reversed(range(len(tangents))):
            parts, last = tangents[number]
            leg, sums = self.course.legs[number], np.zeros(len(each[number]))
            value += self._look(number, len(leg.t) - 1, last[n:], seed, first, second)
            for begin, end, z in reversed(parts):
                middle = 0.5 * (leg.t[begin] + leg.t[end])
                inside = float(self.window[0] < middle < self.window[1])
                weights = np.repeat([0.0, inside], self.steps.integrals)
                adjoint = np.concatenate([second[:n], first[:n], weights])[:, None]
                by_parameters = np.concatenate([second[n:], first[n:]])[:, None]
                span = self._span(leg, begin, end, z, seed)
                back = twice.back(span, adjoint, by_parameters, largest, lost)
                second[:n], first[:n] = back.adjoint[:n, 0], back.adjoint[n : 2 * n, 0]
                second[n:], first[n:] = np.split(back.by_parameters[:, 0], 2)
                largest, lost = back.largest, back.lost
                each[number][begin:end] = back.errors
                sums[begin:end] = inside * back.parts[:, : self.steps.integrals].sum(axis=1)
                value += self._look(number, begin, z[n:], seed, first, second)
            value += float(sums.sum())
            if number:
                S = tangents[number - 1][1][n:]
                second, first = self._back(number - 1, S, seed, second, first)
        return Found(value, first, second, each, twice.relative(largest, lost))

    def _tangents(self, k: int) -> list[_Tangent]:
        """States and, behind these, their derivatives along a direction, leg by leg."""
        found, S = list[_Tangent](), self.S[:, k]
        for number, leg in enumerate(self.course.legs):
            if number:
                for jump in self._jumps(number - 1):
                    S = jump.forward(S[:, None], self.seed[:, [k]])[0].ravel()
            z, parts = np.concatenate([leg.side(0)[0], S]), []
            for stop, following in itertools.pairwise(self._stops(leg)):
                for begin, end in leg.chunks(stop, following):
                    parts.append((begin, end, z))
                    z = self._span(leg, begin, end, z, self.seed[:, k]).x[-1].copy()
            found.append((parts, z))
            S = z[self.n :]
        return found

    def _jumps(self, number: int) -> tuple[EventDerivatives, ...]:
        """What happens at a crossing, in one order: others are the same (see `SecondJumps`)."""
        orders = self.course.crossings[number].orders
        return orders[0] if orders else ()

    def _back(
        self, number: int, S: np.ndarray, seed: np.ndarray, second: np.ndarray, first: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Second and first derivatives before a crossing, S being the tangent there."""
        crossing, tangents = self.course.crossings[number], [S]
        for jump in self._jumps(number):
            tangents.append(jump.forward(tangents[-1][:, None], seed[:, None])[0].ravel())
        inside = float(self.window[0] < crossing.t < self.window[1])
        for jump, before in reversed(list(zip(self._jumps(number), tangents, strict=False))):
            second, first = self.jumps.back(crossing, jump, before, seed, second, first, inside)
        return second, first

    def _span(self, leg: Leg, begin: int, end: int, z: np.ndarray, seed: np.ndarray) -> Span:
        """Some steps with the derivatives of the states behind these, from those at the begin."""
        x = np.zeros((end - begin + 1, 2 * self.n))
        x[0] = z
        theta, m = np.concatenate([self.run.theta, seed]), leg.settings(begin, end)
        t = leg.t[begin : end + 1]
        span = Span(theta, t, x, m, self.run.statistics.is_implicit(t[:-1]))
        is_given = np.arange(len(x)) == 0
        return replace(span, x=_twice(self.steps).replayed(span, is_given))

    def _look(
        self,
        number: int,
        place: int,
        S: np.ndarray,
        seed: np.ndarray,
        first: np.ndarray,
        second: np.ndarray,
    ) -> float:
        """Value at an instant that counts; adds its derivatives."""
        leg, t, total = self.course.legs[number], float(self.course.legs[number].t[place]), 0.0
        if number and not place:
            return total  # the leg before ends there, and states do not jump
        for time in self.times:
            if abs(time - t) <= 1e-10 * self.course.until:
                bent = _bent(self.run.system, self.names)
                x, m = leg.side(place)
                found = bent(x, self.run.theta, t, m)
                total += float(found[0])
                first += np.asarray(found[1]).ravel()
                second += found[2].sparse() @ np.concatenate([S, seed])
        return total

    def _stops(self, leg: Leg) -> list[int]:
        """Ends of steps where something is looked at, and of the leg."""
        soon = 1e-10 * self.course.until
        near = [np.abs(leg.t - t) <= soon for t in (*self.times, *self.window)]
        borders = np.flatnonzero(np.any(near, axis=0)).tolist() if near else []
        return sorted({0, len(leg.t) - 1, *borders})


@made_once
def _twice(steps: Steps) -> StepCode:
    """The steps together with their derivatives along one direction.

    States, then their derivatives; parameters, then the direction; integrals, then their
    derivatives.
    """
    system = steps.system
    x, p, t, m = system.inputs
    s, along = ca.SX.sym("s", x.numel()), ca.SX.sym("along", p.numel())
    direction = ca.vertcat(s, along)

    def both(expression: ca.SX) -> ca.SX:
        change = ca.jtimes(expression, ca.vertcat(x, p), direction)
        return ca.vertcat(expression, ca.densify(change))

    inputs = [ca.vertcat(x, s), ca.vertcat(p, along), t, m]
    rates, integrands = both(system.rates), both(ca.densify(steps.integrands))
    nominal = np.tile(nominals(system), 2)
    return StepCode(system.name, inputs, rates, integrands, nominal)


@made_once
def _bent(system: System, names: tuple[str, ...]) -> ca.Function:
    """A product, its derivatives by states and parameters, and their second ones: (x, p, t, m)."""
    x, p, _, _ = system.inputs
    y = product(system, names)
    bend, slope = ca.hessian(y, ca.vertcat(x, p))
    return ca.Function("bent", system.inputs, [y, ca.densify(slope), bend])
