"""Adaptive steps as CasADi functions: many per call, no Python in between."""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.numerics.inside_step import INSIDE, Method, below, doubtful, interpolated
from lumped.numerics.one_step import (
    combined,
    explicit_dense,
    explicit_step,
    implicit_dense,
    implicit_step,
)
from lumped.timeloop.calls import Call, called, expanded

__all__ = [
    "ACCEPTED",
    "CLOSED",
    "CROSSED",
    "GIVEN_UP",
    "HEAD",
    "IDLE",
    "REJECTED",
    "STIFF_AFTER",
    "Stepper",
    "first_step",
]

ACCEPTED, REJECTED, IDLE = 1, 0, -1
GIVEN_UP, CROSSED = 1, 2

HEAD = 6
"""Entries of `head` before the implicit quantities."""

CLOSED = 1e-9
"""Largest last step of Newton's method, relative; the error is then its square."""

_FEW = 8
"""Attempts in a short chunk."""

STIFF_AFTER = 15
"""Steps at the stability limit after which a problem counts as stiff (Hairer's DOP853)."""


@dataclass(frozen=True)
class Stepper:
    """A method made for one system.

    Attributes
    ----------
    few, many : Call
        (head, x, f, p, m, end, rtol, atol) -> (head, x, f, log, xs, dense): a chunk of attempts,
        a short one for what follows a change of modes, as all is idle after the next. `head` is
        (t, h, just rejected, stiff count, calm count, stopped, implicit quantities), where stopped
        is GIVEN_UP or CROSSED.
        Columns of `log` are (t before, t after, outcome) for each attempt, with the outcome
        ACCEPTED, REJECTED or IDLE (the end was reached before); `xs` is the state after it, with
        the implicit quantities, `dense` its interpolation coefficients (empty without dense
        output).
    evaluations : int
        Evaluations of the right-hand side per attempt.
    """

    few: Call
    many: Call
    evaluations: int
    method: Method
    dense: bool

    @classmethod
    def build(cls, system: System, method: Method, dense: bool) -> Stepper:
        """Make the function for a system."""
        attempt, evaluations = (_explicit if method == "explicit" else _implicit)(system, dense)
        n = len(system.states)
        if method == "explicit":
            attempt = expanded(attempt, system)
        width = attempt.size1_out(5) * attempt.size2_out(5) + 2 * n + 12
        chunk = int(np.clip(1_000_000 // width, 8, 32 if system.switching else 256))
        many = Call(_chained(attempt, chunk))
        few = Call(_chained(attempt, _FEW)) if system.switching else many
        return cls(few, many, evaluations, method, dense)

    def interpolate(
        self, theta: np.ndarray, before: np.ndarray, after: np.ndarray, dense: np.ndarray
    ) -> np.ndarray:
        """States inside steps.

        Parameters
        ----------
        theta : ndarray, shape (k,)
            Fraction of the step.
        before, after : ndarray, shape (k, n)
            States at the ends of the step.
        dense : ndarray, shape (k, c, n)
            Interpolation coefficients.
        """
        columns = [dense[:, i] for i in range(dense.shape[1])]
        inside: np.ndarray = interpolated(self.method, theta[:, None], before, after, columns)
        return inside


def first_step(
    system: System,
    theta: np.ndarray,
    span: tuple[float, float],
    x: np.ndarray,
    rates: np.ndarray,
    settings: np.ndarray,
    scale: np.ndarray,
) -> float:
    """Step to begin with (Hairer, Norsett, Wanner, vol. I, II.4).

    Parameters
    ----------
    span : tuple of float
        Begin and end of the segment, s.
    x, rates : ndarray, shape (n,)
        States and their derivatives at the begin.
    settings : ndarray
        Modes and implicit quantities.
    scale : ndarray, shape (n,)
        Error that is tolerated in each state.
    """
    begin, end = span
    d0, d1 = _rms(x / scale), _rms(rates / scale)
    h0 = 1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1
    h0 = min(h0, end - begin)
    (later,) = called(system, "rhs")(x + h0 * rates, theta, begin + h0, settings)
    steepest = max(d1, _rms((later - rates) / scale) / h0)
    h1 = max(1e-6, h0 * 1e-3) if steepest <= 1e-15 else (0.01 / steepest) ** (1 / 8)
    first = min(100 * h0, h1, end - begin)
    return first if np.isfinite(first) and first > 0 else 1e-6 * (end - begin)


def _rms(values: np.ndarray) -> float:
    with np.errstate(over="ignore", invalid="ignore"):
        return math.sqrt(float(values @ values) / len(values))


def _chained(attempt: ca.Function, count: int) -> ca.Function:
    """Several attempts, until the end or something that stops them."""
    step = ca.Function.if_else("step", attempt, _skip(attempt))
    args = [ca.MX.sym(f"a{i}", attempt.sparsity_in(i)) for i in range(attempt.n_in())]
    head, x, f, *rest = args
    logs, xs, denses = [], [], []
    for _ in range(count):
        busy = ca.logic_and(head[0] < rest[2], head[5] == 0)
        head, x, f, log, row, interpolation = step(busy, head, x, f, *rest)
        logs.append(log)
        xs.append(row)
        denses.append(interpolation)
    results = [head, x, f, ca.horzcat(*logs), ca.horzcat(*xs), ca.horzcat(*denses)]
    return ca.Function("chunk", args, results)


def _skip(attempt: ca.Function) -> ca.Function:
    """What a step does when the end is reached: nothing."""
    args = [ca.MX.sym(f"a{i}", attempt.sparsity_in(i)) for i in range(attempt.n_in())]
    log = ca.vertcat(args[0][0], args[0][0], IDLE)
    return ca.Function(
        "skip",
        args,
        [
            *args[:3],
            log,
            ca.vertcat(args[1], args[0][HEAD:]),
            ca.MX.zeros(*attempt.size_out(5)),
        ],
    )


class _Frame:
    """What all methods share: symbols, error norm, step-size control."""

    def __init__(self, system: System) -> None:
        n, np_ = len(system.states), system._inputs[1].numel()
        implicit = system.closure.size1_out(0)
        nm = system._inputs[3].numel() - implicit
        self.head = ca.MX.sym("head", HEAD + implicit)
        self.x, self.f = ca.MX.sym("x", n), ca.MX.sym("f", n)
        self.p, self.m = ca.MX.sym("p", np_), ca.MX.sym("m", nm)
        self.settings = ca.vertcat(self.m, self.head[HEAD:])
        self.closure = system.closure if implicit else None
        watched = bool(system.switching) and bool(system.margins.size1_out(0))
        self.margins = system.margins if watched else None
        self.margin_rates = system.margin_rates if watched else None
        self.end, self.rtol = ca.MX.sym("end"), ca.MX.sym("rtol")
        self.atol = ca.MX.sym("atol", n)
        self.t = self.head[0]
        self.h = ca.fmin(self.head[1], self.end - self.t)
        self.n = n
        self.rhs = system.rhs
        self.args = [self.head, self.x, self.f, self.p, self.m, self.end, self.rtol, self.atol]

    def rate(self, x: ca.MX, t: ca.MX) -> ca.MX:
        return self.rhs(x, self.p, t, self.settings)

    def scale(self, x: ca.MX) -> ca.MX:
        return self.atol + self.rtol * ca.fmax(ca.fabs(self.x), ca.fabs(x))

    def finish(
        self,
        name: Method,
        new: ca.MX,
        f_new: ca.MX,
        error: ca.MX,
        power: float,
        limit: ca.MX | None,
        dense: ca.MX,
    ) -> ca.Function:
        """Accept or reject the step and choose the next."""
        last = self.h >= self.end - self.t
        t_new = ca.if_else(last, self.end, self.t + self.h)
        guesses = self.head[HEAD:]
        if self.closure is not None:
            found, correction = self.closure(new, self.p, t_new, self.settings)
            open_loop = ca.norm_inf(correction / (1 + ca.fabs(found))) > CLOSED
            error = ca.if_else(open_loop, 100, error)
            guesses = ca.if_else(error <= 1, found, guesses)
        stop = ca.MX(0)
        if self.margins is not None and self.margin_rates is not None:
            settings = ca.vertcat(self.m, guesses)
            columns = ca.horzsplit(dense)
            samples = []
            for part in INSIDE:
                x = interpolated(name, part, self.x, new, columns) if 0 < part < 1 else new
                t = self.t + part * (t_new - self.t)
                margins, tolerances = self.margins(x if part else self.x, self.p, t, settings)
                samples.append(margins + tolerances)
            ends = ((self.x, self.t), (new, t_new))
            slopes = [(t_new - self.t) * self.margin_rates(x, self.p, t, settings) for x, t in ends]
            suspected = ca.logic_or(below(samples), doubtful(samples, slopes))
            stop = CROSSED * (ca.mmax(suspected) > 0)
        finite = ca.logic_and(ca.norm_inf(new) < 1e300, ca.norm_inf(f_new) < 1e300)
        accept = ca.logic_and(error <= 1, finite)
        growth = 0.9 * ca.fmax(error, 1e-12) ** -power
        growth = ca.fmin(ca.fmax(growth, 0.2), ca.if_else(self.head[2], 1.0, 8.0))
        growth = ca.if_else(accept, growth, ca.fmin(growth, 0.9))
        h_new = self.h * growth
        tiny = h_new < 1e-14 * ca.fmax(ca.fabs(self.t), 1e-6)
        given_up = ca.logic_and(ca.logic_not(accept), tiny)
        stiff, calm = self.head[3], self.head[4]
        if limit is not None:
            at_limit = limit > 6.1
            calm = ca.if_else(accept, ca.if_else(at_limit, 0, calm + 1), calm)
            stiff = ca.if_else(accept, ca.if_else(at_limit, stiff + 1, stiff), stiff)
            stiff = ca.if_else(calm >= 6, 0, stiff)
        t_out = ca.if_else(accept, t_new, self.t)
        stop = ca.if_else(accept, stop, GIVEN_UP * given_up)
        flags = (ca.logic_not(accept), stiff, calm, stop)
        head = ca.vertcat(t_out, h_new, *flags, guesses)
        x_out = ca.if_else(accept, new, self.x)
        f_out = ca.if_else(accept, f_new, self.f)
        log = ca.vertcat(self.t, t_out, accept)
        row = ca.vertcat(x_out, guesses)
        return ca.Function(name, self.args, [head, x_out, f_out, log, row, dense])


def _explicit(system: System, dense: bool) -> tuple[ca.Function, int]:
    """One attempt of DOP853."""
    s = _Frame(system)
    stages, argument, new = explicit_step(s.rate, s.x, s.f, s.t, s.h)
    f_new = s.rate(new, s.t + s.h)
    scale = s.scale(new)
    limit = s.h * ca.norm_2((f_new - stages[-1]) / scale)
    limit = limit / ca.fmax(ca.norm_2((new - argument) / scale), 1e-300)
    stages.append(f_new)
    e5 = ca.sumsqr(combined(stages, scipy.integrate.DOP853.E5) / scale)
    e3 = ca.sumsqr(combined(stages, scipy.integrate.DOP853.E3) / scale)
    # the ratio is 0/0 only where both estimates vanish
    error = s.h * e5 / ca.sqrt(ca.fmax((e5 + 0.01 * e3) * s.n, 1e-300))
    interpolation = ca.MX(s.n, 0)
    if dense:
        interpolation = explicit_dense(s.rate, s.x, new, stages, s.t, s.h)
    evaluations = 12 + 3 * dense
    return s.finish("explicit", new, f_new, error, 1 / 8, limit, interpolation), evaluations


def _implicit(system: System, dense: bool) -> tuple[ca.Function, int]:
    """One attempt of Rodas5P."""
    s = _Frame(system)
    jacobian, drift = system.jacobian(s.x, s.p, s.t, s.settings)
    increments, new = implicit_step(s.rate, (jacobian, drift), s.x, s.f, s.t, s.h)
    f_new = s.rate(new, s.t + s.h)
    error = ca.norm_2(increments[-1] / s.scale(new)) / np.sqrt(s.n)
    interpolation = implicit_dense(increments) if dense else ca.MX(s.n, 0)
    return s.finish("implicit", new, f_new, error, 1 / 5, None, interpolation), 8
