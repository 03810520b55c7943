"""Tangents along a run, and the derivative of the sweep back along them.

A run and its derivative along one direction are a run of twice as many states. The derivatives of
that derivative are one row of the Hessian, by the sweep back that gives gradients.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.gradients.adjoint import Leg, Steps
from lumped.gradients.functional_terms import SmoothParts
from lumped.gradients.jumps import Crossing
from lumped.gradients.step_code import Span, StepCode
from lumped.simulation.functional_kinds import At, Final, Integral, product
from lumped.support.made_once import made_once
from lumped.timeloop.run import nominals

__all__ = ["Found", "Second"]


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
        The run, every instant that counts an end of a step; rates do not jump in it.
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
        spans = self._tangents(k)
        twice = _twice(self.steps)
        value, first, second = 0.0, np.zeros(n + p), np.zeros(n + p)
        largest = lost = np.zeros((2 * (n + self.steps.integrals), 1))
        each = [np.zeros((len(span.t) - 1, 1)) for span in spans]
        for number in reversed(range(len(spans))):
            span, leg = spans[number], self.course.legs[number]
            end = len(leg.t) - 1
            value += self._look(number, end, span.x[end, n:], seed, first, second)
            for begin in reversed(self._stops(leg)[:-1]):
                inside = float(self.window[0] < 0.5 * (leg.t[begin] + leg.t[end]) < self.window[1])
                weights = np.repeat([0.0, inside], self.steps.integrals)
                adjoint = np.concatenate([second[:n], first[:n], weights])[:, None]
                own = slice(begin, end + 1)
                part = replace(span, t=span.t[own], x=span.x[own], m=span.m[own])
                back = twice.back(part, adjoint, largest, lost)
                second[:n], first[:n] = back.adjoint[:n, 0], back.adjoint[n : 2 * n, 0]
                second[n:] += back.by_parameters[:p, 0]
                first[n:] += back.by_parameters[p:, 0]
                largest, lost = back.largest, back.lost
                each[number][begin:end] = back.errors
                value += inside * float(back.parts[:, : self.steps.integrals].sum())
                value += self._look(number, begin, span.x[begin, n:], seed, first, second)
                end = begin
            if number:
                crossing = self.course.crossings[number - 1]
                second += self._across(crossing, span.x[0, n:], seed, first[:n])
        return Found(value, first, second, each, twice.relative(largest, lost))

    def _tangents(self, k: int) -> list[Span]:
        """The legs, with the derivatives of the states along a direction behind these."""
        found, last = [], self.S[:, k]
        for leg in self.course.legs:
            theta = np.concatenate([self.run.theta, self.seed[:, k]])
            x = np.hstack([leg.x, np.zeros_like(leg.x)])
            x[0, self.n :] = last
            span = Span(theta, leg.t, x, leg.settings, self.run.statistics.implicit_from)
            if len(leg.t) > 1:
                is_given = np.arange(len(leg.t)) == 0
                span = replace(span, x=_twice(self.steps).replayed(span, is_given))
            last = span.x[-1, self.n :]
            found.append(span)
        return found

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
                found = bent(leg.x[place], self.run.theta, t, leg.settings[place])
                total += float(found[0])
                first += np.asarray(found[1]).ravel()
                second += found[2].sparse() @ np.concatenate([S, seed])
        return total

    def _across(
        self, crossing: Crossing, S: np.ndarray, seed: np.ndarray, adjoint: np.ndarray
    ) -> np.ndarray:
        """What second derivatives gain where the derivatives of the rates jump, (n + p,).

        The instant moves by ``t_p``, and on one side of it the adjoint follows other rates: the
        gain is the transposed jump of their derivatives times the adjoint times ``t_p``.
        """
        total = np.zeros(self.n + len(self.run.theta))
        turned = _turned(self.steps)
        inside = float(self.window[0] < crossing.t < self.window[1])
        weights = np.append(adjoint, np.full(self.steps.integrals, inside))
        for jump in (j for order in crossing.orders[:1] for j in order):
            moved = float(jump.instant @ np.concatenate([S, seed]))
            before, after = (
                np.asarray(turned(x, self.run.theta, crossing.t, m, weights)).ravel()
                for x, m in (jump.before, jump.after)
            )
            total += (before - after) * moved
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
    return StepCode(system.name, system.building, inputs, rates, integrands, nominal)


@made_once
def _bent(system: System, names: tuple[str, ...]) -> ca.Function:
    """A product, its derivatives by states and parameters, and their second ones: (x, p, t, m)."""
    x, p, _, _ = system.inputs
    y = product(system, names)
    bend, slope = ca.hessian(y, ca.vertcat(x, p))
    return ca.Function("bent", system.inputs, [y, ca.densify(slope), bend])


@made_once
def _turned(steps: Steps) -> ca.Function:
    """Derivatives of rates and integrands by states and parameters, times weights."""
    system, q = steps.system, steps.integrands
    x, p, t, m = system.inputs
    by = ca.SX.sym("by", x.numel() + q.numel())
    slopes = ca.jtimes(ca.vertcat(system.rates, q), ca.vertcat(x, p), by, True)
    return ca.Function("turned", [x, p, t, m, by], [ca.densify(slopes)])
