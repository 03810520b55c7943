"""Tangents along a run, and the derivative of the sweep back along them."""

from __future__ import annotations

import itertools
from typing import Any

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.gradients.adjoint import Leg, Steps
from lumped.gradients.backward_steps import CHUNKS
from lumped.gradients.functional_terms import SmoothParts
from lumped.gradients.jumps import Crossing
from lumped.numerics.inside_step import Method
from lumped.simulation.functional_kinds import At, Final, Integral, product
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import Shared, made_once

__all__ = ["Second"]

_Span = tuple[Method, int, int]
"""Steps of one method: the first, and that after the last."""


class Second(Shared):
    """Second derivatives of one functional of a run.

    Parameters
    ----------
    course : SmoothParts
        The run, every instant that counts an end of a step; rates do not jump in it.
    seed, S : ndarray, shapes (p, k) and (n, k)
        Derivatives of the parameters and of the states at the start by what is varied.
    of : functional
        What is differentiated (the integral, if it is one).
    """

    def __init__(
        self, course: SmoothParts, seed: np.ndarray, S: np.ndarray, of: Final | At | Integral
    ) -> None:
        super().__init__(course.run.system.building)
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

    def go(self) -> tuple[float, np.ndarray, np.ndarray]:
        """Value, and first and second derivatives."""
        n, p = self.n, len(self.run.theta)
        tangents = self._tangents()
        value, first, second = 0.0, np.zeros(n + p), np.zeros((n + p, self.k))
        for number in reversed(range(len(self.course.legs))):
            leg, S = self.course.legs[number], tangents[number]
            value += self._look(number, len(leg.t) - 1, S[-1], first, second)
            for span in reversed(self._spans(leg)):
                value += self._back(leg, span, S, first, second)
                value += self._look(number, span[1], S[span[1]], first, second)
            if number:
                crossing = self.course.crossings[number - 1]
                second += self._across(crossing, S[0], first[:n])
        by_both = np.vstack([self.S, self.seed])
        return value, by_both.T @ first, by_both.T @ second

    def _tangents(self) -> list[list[np.ndarray]]:
        """Derivatives of the states at the ends of all steps, leg by leg."""
        found, last = [], self.S
        for leg in self.course.legs:
            own = [last]
            for method, begin, end in self._spans(leg):
                inputs = (own[-1].ravel(order="F"), *self._points(leg, begin, end))
                (many,) = self._call("forward", method, end - begin)(*inputs)
                own += list(many.reshape(end - begin, self.k, self.n).transpose(0, 2, 1))
            last = own[-1]
            found.append(own)
        return found

    def _look(
        self, number: int, place: int, S: np.ndarray, first: np.ndarray, second: np.ndarray
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
                second += found[2].sparse() @ np.vstack([S, self.seed])
        return total

    def _back(
        self,
        leg: Leg,
        span: _Span,
        tangents: list[np.ndarray],
        first: np.ndarray,
        second: np.ndarray,
    ) -> float:
        """Back over some steps; gives their part of the integral."""
        method, begin, end = span
        n, k = self.n, self.k
        inside = self.window[0] < 0.5 * (leg.t[begin] + leg.t[end]) < self.window[1]
        S = np.concatenate([tangents[i].ravel(order="F") for i in range(begin, end)])
        weights = np.full(self.steps.integrands.numel(), float(inside))
        inputs = (first[:n], second[:n].ravel(order="F"), S, weights)
        results = self._call("back", method, end - begin)(*inputs, *self._points(leg, begin, end))
        first[:n], second[:n] = results[0], results[1].reshape(k, n).T
        first[n:] += results[2]
        second[n:] += results[3].reshape(k, -1).T
        total = float(results[4].sum())
        return total if inside else 0.0

    def _across(self, crossing: Crossing, S: np.ndarray, adjoint: np.ndarray) -> np.ndarray:
        """What second derivatives gain where the derivatives of the rates jump, (n + p, k).

        The instant moves by ``t_p``, and on one side of it the adjoint follows other rates: the
        gain is the transposed jump of their derivatives times the adjoint times ``t_p``.
        """
        total = np.zeros((self.n + len(self.run.theta), self.k))
        turned = _turned(self.steps)
        inside = float(self.window[0] < crossing.t < self.window[1])
        weights = np.append(adjoint, np.full(self.steps.integrands.numel(), inside))
        for jump in (j for order in crossing.orders[:1] for j in order):
            moved = jump.instant @ np.vstack([S, self.seed])
            before, after = (
                np.asarray(turned(x, self.run.theta, crossing.t, m, weights)).ravel()
                for x, m in (jump.before, jump.after)
            )
            total += np.outer(before - after, moved)
        return total

    def _spans(self, leg: Leg) -> list[_Span]:
        """Steps in chunks that end where something is looked at."""
        end, change = len(leg.t) - 1, self.run.statistics.implicit_from
        first = int(np.searchsorted(leg.t[:-1], change))
        soon = 1e-10 * self.course.until
        near = [np.abs(leg.t - t) <= soon for t in (*self.times, *self.window)]
        borders = np.flatnonzero(np.any(near, axis=0)).tolist() if near else []
        stops = sorted({0, first, end, *borders})
        spans: list[_Span] = []
        for begin, stop in itertools.pairwise(stops):
            method: Method = "explicit" if begin < first else "implicit"
            while begin < stop:
                count = next(c for c in CHUNKS if c <= stop - begin)
                spans.append((method, begin, begin + count))
                begin += count
        return spans

    def _points(self, leg: Leg, begin: int, end: int) -> tuple[np.ndarray, ...]:
        t, x, m = (v[begin:end] for v in (leg.t, leg.x, leg.settings))
        lengths = np.diff(leg.t[begin : end + 1])
        return x.ravel(), self.run.theta, self.seed.ravel(order="F"), t, lengths, m.ravel()

    @made_once
    def _call(self, what: str, method: Method, count: int) -> ArrayFunction:
        """Several steps: tangents after each, or back."""
        make = self._forward if what == "forward" else self._backward
        return ArrayFunction(make(method, count))

    def _symbols(self, count: int) -> list[ca.MX]:
        p, k = self.seed.shape
        m = self.course.legs[0].settings.shape[1]
        sizes = ((self.n, count), (p, 1), (p, k), (1, count), (1, count), (m, count))
        return [ca.MX.sym(f"a{i}", *size) for i, size in enumerate(sizes)]

    def _forward(self, method: Method, count: int) -> ca.Function:
        """(S, x, p, seed, t, h, m) -> S after each step."""
        step, n, k = self.steps.step(method), self.n, self.k
        kind: Any = ca.SX if step.is_a("SXFunction") else ca.MX
        p, m = len(self.seed), step.size1_in(4)
        both, along = kind.sym("both", n + p), kind.sym("along", n + p, k)
        t, h, modes = kind.sym("t"), kind.sym("h"), kind.sym("m", m)
        new = step(both[:n], both[n:], t, h, modes)[0]
        found = ca.densify(ca.jtimes(new, both, along))
        once = ca.Function("forward", [both, along, t, h, modes], [found])
        S = ca.MX.sym("S", n, k)
        xs, theta, seed, *rest = symbols = self._symbols(count)
        columns = [ca.horzsplit(v) for v in (xs, *rest)]
        found_all, last = [], S
        for x, *others in zip(*columns, strict=True):
            last = once(ca.vertcat(x, theta), ca.vertcat(last, seed), *others)
            found_all.append(last)
        return ca.Function("tangents", [S, *symbols], [ca.horzcat(*found_all)])

    def _backward(self, method: Method, count: int) -> ca.Function:
        """(adjoint, its tangents, S, weights, x, p, seed, t, h, m) -> these before, sums by p.

        And the integrals over the steps.
        """
        n, k, p = self.n, self.k, len(self.seed)
        back = self.steps.single(method, 1)
        kind: Any = ca.SX if back.is_a("SXFunction") else ca.MX
        all_, along = kind.sym("all", 2 * n + p), kind.sym("along", 2 * n + p, k)
        t, h, modes = kind.sym("t"), kind.sym("h"), kind.sym("m", back.size1_in(4))
        chosen = kind.sym("chosen", back.size1_in(5), 1)
        before, by_p, part = back(all_[:n], all_[n:], t, h, modes, chosen)
        turned = ca.densify(ca.jtimes(ca.vertcat(before, by_p), all_, along))
        results = [before, by_p, turned[:n, :], turned[n:, :], part]
        once = ca.Function("second", [all_, along, t, h, modes, chosen], results)
        adjoint, turn = ca.MX.sym("adjoint", n), ca.MX.sym("turn", n, k)
        S, weights = ca.MX.sym("S", n, k * count), ca.MX.sym("weights", back.size1_in(5))
        xs, theta, seed, *rest = symbols = self._symbols(count)
        columns = [ca.horzsplit(v) for v in (xs, *rest)] + [ca.horzsplit(S, k)]
        a, b = adjoint, turn
        sums = [ca.MX.zeros(p), ca.MX.zeros(p, k), ca.MX.zeros(*back.size_out(2))]
        for x, time, length, setting, s in reversed(list(zip(*columns, strict=True))):
            both = ca.vertcat(a, x, theta)
            tangents = ca.vertcat(b, s, seed)
            a, more, b, turned_p, q = once(both, tangents, time, length, setting, weights)
            sums = [u + v for u, v in zip(sums, (more, turned_p, q), strict=True)]
        return ca.Function("second", [adjoint, turn, S, weights, *symbols], [a, b, *sums])


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
