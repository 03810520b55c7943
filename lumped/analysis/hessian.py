"""Second derivatives of numbers that sum up a run without events."""

from __future__ import annotations

import time as clock
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import casadi as ca
import numpy as np

from lumped.analysis.adjoint import Leg, Steps, legs_of
from lumped.analysis.calls import Call
from lumped.analysis.dense import Method
from lumped.analysis.functionals import Final, Functional, Integral
from lumped.analysis.gradient import check, integrated
from lumped.analysis.result import Trajectory
from lumped.analysis.reverse import CHUNKS
from lumped.analysis.simulate import simulate
from lumped.analysis.varied import slopes_at_zero, sources, varied_values
from lumped.errors import OptionError, SolverError
from lumped.system import Changes, Name, System
from lumped.table import number, table
from lumped.units import in_seconds

__all__ = ["Hessian", "hessian"]


@dataclass(frozen=True, eq=False)
class Hessian:
    """A functional of a run with its first and second derivatives.

    Attributes
    ----------
    run : Trajectory
        The run, at the steps of the solver.
    of : str
        The functional, as printed.
    to : tuple of str
        Parameters and start values.
    value : float
        What the functional is.
    gradient : ndarray, shape (k,)
        First derivatives.
    matrix : ndarray, shape (k, k)
        Second derivatives.
    seconds : float
        Wall time of everything after the run.
    rtol : float
        Tolerance of the run. Derivatives are exact for its steps.
    asymmetry : float
        Largest difference of mixed derivatives taken in either order, each for relative changes,
        over the largest of all: rounding. The matrix is their mean.
    """

    run: Trajectory
    of: str
    to: tuple[str, ...]
    value: float
    gradient: np.ndarray
    matrix: np.ndarray
    seconds: float
    rtol: float
    asymmetry: float

    def __repr__(self) -> str:
        rows = [
            (name, number(float(slope), 6), *(number(float(v), 6) for v in row[:8]))
            for name, slope, row in zip(self.to[:8], self.gradient, self.matrix, strict=False)
        ]
        head = (
            f"{self.run.system.name}: {self.of} = {number(self.value, 9)}; run of "
            f"{self.run.steps} steps, rtol {self.rtol:.0e}, in {self.run.statistics.seconds:.3g} "
            f"s, derivatives in {self.seconds:.3g} s more; asymmetry {self.asymmetry:.1e}"
        )
        return f"{head}\n" + table(("by", "first", *self.to[:8]), rows)


def hessian(
    system: System,
    *,
    of: Functional,
    to: Iterable[Name],
    until: float,
    parameters: Changes | None = None,
    start: Changes | None = None,
    rtol: float = 1e-8,
    method: Literal["auto", "explicit", "implicit"] = "auto",
) -> Hessian:
    """Simulate, and differentiate a functional of the run twice by a few parameters.

    Forward over adjoint: the sweep of `gradient`, differentiated along each parameter. The cost
    grows with the number of parameters. Only for runs without events, and for final values and
    integrals (means, root mean squares): at events states jump by derivatives whose own are not
    formed, and peaks move.

    Parameters
    ----------
    system : System
        From `assemble`.
    of : functional
        From `lumped.functionals`: final, integral, mean or rms.
    to : iterable of names
        Parameters, and start values that are states.
    until, parameters, start, rtol, method
        As for `simulate`.

    Raises
    ------
    OptionError
        If the functional is of another kind, there is nothing to vary, or start states depend on
        a parameter that varies.
    SolverError
        If something happens in the run.
    """
    until = in_seconds(until, "until")
    names = [system.key(name) for name in to]
    check(system, [of], names)
    label = str(of)
    if not isinstance(of, Final | Integral):
        raise OptionError(
            f"hessian: {label} has no second derivatives here; take final, integral, mean or rms."
        )
    if not system.states:
        raise OptionError(f"{system.name}: a run without states has no steps to differentiate.")
    places, varied = sources(system, names, start or {})
    run = simulate(
        system,
        until=until,
        parameters=parameters,
        start=start,
        grid=None,
        rtol=rtol,
        method=method,
    )
    begin = clock.perf_counter()
    legs = legs_of(run)
    if len(legs) > 1:
        raise SolverError(
            f"{system.name}: the run stops at t = {legs[1].t[0]:.9g} s (see run.events); second "
            "derivatives are only formed for runs without events. End the run before, or take "
            "differences of lumped.gradient.",
            run,
        )
    seed = np.zeros((len(run.theta), len(names)))
    for column, place in enumerate(places):
        if place >= 0:
            seed[place, column] = 1.0
    S = slopes_at_zero(run, start or {}, seed, varied)
    _check_start(system, names, places, S)
    steps, _ = integrated(system, [of])
    total, first, second = _Second(run, legs[0], steps, seed, S).go(of)
    value = total
    if isinstance(of, Integral):
        value, slope, curvature = of.outcome(total, until)
        second = slope * second + curvature * np.outer(first, first)
        first = slope * first
    sizes = np.abs(varied_values(run, names))
    sizes[sizes == 0] = 1.0
    relative = second * np.outer(sizes, sizes)
    asymmetry = np.abs(relative - relative.T).max() / (np.abs(relative).max() or 1.0)
    second = 0.5 * (second + second.T)
    seconds = clock.perf_counter() - begin
    return Hessian(run, label, tuple(names), value, first, second, seconds, rtol, float(asymmetry))


def _check_start(system: System, names: list[str], places: list[int], S: np.ndarray) -> None:
    """Refuse start states that are not linear in what varies."""
    for name, place, column in zip(names, places, S.T, strict=True):
        plain = np.count_nonzero(column) == 1 and np.abs(column).max() == 1.0
        if not (plain if place < 0 else not column.any()):
            raise OptionError(
                f"{system.name}: states at the start depend on {name} through equations, whose "
                "second derivatives are not formed. Give start values of the states themselves: "
                f"{', '.join(system.state_names[:12])}."
            )


class _Second:
    """Tangents along the run, and the derivative of the sweep back along them."""

    def __init__(
        self, run: Trajectory, leg: Leg, steps: Steps, seed: np.ndarray, S: np.ndarray
    ) -> None:
        self.run, self.leg, self.steps, self.seed, self.S = run, leg, steps, seed, S
        self.n, self.k = S.shape
        self._made: dict[tuple[str, Method, int], Call] = {}

    def go(self, of: Final | Integral) -> tuple[float, np.ndarray, np.ndarray]:
        """Value, and first and second derivatives of it (of the integral, if it is one)."""
        run, n, k = self.run, self.n, self.k
        value, first, second = 0.0, np.zeros(n + len(run.theta)), np.zeros((n + len(run.theta), k))
        spans = self._spans()
        tangents = [self.S]
        for method, begin, end in spans:
            inputs = (tangents[-1].ravel(order="F"), *self._points(begin, end))
            (found,) = self._call("forward", method, end - begin)(*inputs)
            tangents += list(found.reshape(end - begin, k, n).transpose(0, 2, 1))
        if isinstance(of, Final):
            value, first, second = self._last(of, tangents[-1])
        adjoint, turned = first[:n], second[:n]
        for method, begin, end in reversed(spans):
            S = np.concatenate([tangents[i].ravel(order="F") for i in range(begin, end)])
            inputs = (adjoint, turned.ravel(order="F"), S, *self._points(begin, end))
            results = self._call("back", method, end - begin)(*inputs)
            adjoint, turned = results[0], results[1].reshape(k, n).T
            first[n:] += results[2]
            second[n:] += results[3].reshape(k, -1).T
            value += float(results[4].sum())
        by_both = np.vstack([self.S, self.seed])
        first, second = np.append(adjoint, first[n:]), np.vstack([turned, second[n:]])
        return value, by_both.T @ first, by_both.T @ second

    def _spans(self) -> list[tuple[Method, int, int]]:
        """Steps in chunks."""
        end, change = len(self.leg.t) - 1, self.run.statistics.implicit_from
        first = int(np.searchsorted(self.leg.t[:-1], change))
        spans: list[tuple[Method, int, int]] = []
        parts: tuple[tuple[Method, int, int], ...] = (
            ("explicit", 0, first),
            ("implicit", first, end),
        )
        for method, begin, stop in parts:
            while begin < stop:
                count = next(c for c in CHUNKS if c <= stop - begin)
                spans.append((method, begin, begin + count))
                begin += count
        return spans

    def _points(self, begin: int, end: int) -> tuple[np.ndarray, ...]:
        leg = self.leg
        t, x, m = (v[begin:end] for v in (leg.t, leg.x, leg.settings))
        lengths = np.diff(leg.t[begin : end + 1])
        return x.ravel(), self.run.theta, self.seed.ravel(order="F"), t, lengths, m.ravel()

    def _last(self, of: Final, S: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """A final value, its derivatives by states and parameters, and these along the tangents."""
        system, leg = self.run.system, self.leg
        x, p, t, m = system._inputs
        second, first = ca.hessian(system.expressions([of.name]), ca.vertcat(x, p))
        results = [system.expressions([of.name]), ca.densify(first), second]
        function = ca.Function("last", [x, p, t, m], results)
        y, slope, curvature = function(leg.x[-1], self.run.theta, leg.t[-1], leg.settings[-1])
        along = curvature.sparse() @ np.vstack([S, self.seed])
        return float(y), np.asarray(slope).ravel(), along

    def _call(self, what: str, method: Method, count: int) -> Call:
        """Several steps: tangents after each, or back."""
        key = what, method, count
        if key not in self._made:
            make = self._forward if what == "forward" else self._backward
            self._made[key] = Call(make(method, count))
        return self._made[key]

    def _symbols(self, count: int) -> list[ca.MX]:
        p, k = self.seed.shape
        m = self.leg.settings.shape[1]
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
        """(adjoint, its tangents, S, x, p, seed, t, h, m) -> these before, sums by p, integrals."""
        n, k, p = self.n, self.k, len(self.seed)
        back = self.steps.single(method)
        kind: Any = ca.SX if back.is_a("SXFunction") else ca.MX
        all_, along = kind.sym("all", 2 * n + p), kind.sym("along", 2 * n + p, k)
        t, h, modes = kind.sym("t"), kind.sym("h"), kind.sym("m", back.size1_in(4))
        before, by_p, part = back(all_[:n], all_[n:], t, h, modes)
        turned = ca.densify(ca.jtimes(ca.vertcat(before, by_p), all_, along))
        results = [before, by_p, turned[:n, :], turned[n:, :], part]
        once = ca.Function("second", [all_, along, t, h, modes], results)
        adjoint, turn = ca.MX.sym("adjoint", n), ca.MX.sym("turn", n, k)
        S = ca.MX.sym("S", n, k * count)
        xs, theta, seed, *rest = symbols = self._symbols(count)
        columns = [ca.horzsplit(v) for v in (xs, *rest)] + [ca.horzsplit(S, k)]
        a, b = adjoint, turn
        sums = [ca.MX.zeros(p), ca.MX.zeros(p, k), ca.MX.zeros(*back.size_out(2))]
        for x, time, length, setting, s in reversed(list(zip(*columns, strict=True))):
            both = ca.vertcat(a, x, theta)
            a, more, b, turned_p, q = once(both, ca.vertcat(b, s, seed), time, length, setting)
            sums = [u + v for u, v in zip(sums, (more, turned_p, q), strict=True)]
        return ca.Function("second", [adjoint, turn, S, *symbols], [a, b, *sums])
