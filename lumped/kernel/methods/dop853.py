"""One attempt of DOP853 (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.5).

The stages are the derivatives of the states: at the begin, at the eleven inner nodes, at the end,
and at three nodes that dense output needs.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from lumped.code.trigonometry import FARTHEST
from lumped.code.words import Numbers, any_lane, fmax, kernel, make_kernel, sqrt
from lumped.kernel.interpret import evaluate
from lumped.kernel.methods.rates import end_step, find_rates
from lumped.kernel.run import ANGLE, END, ERROR, LENGTH, STIFFNESS, TOLERANCE, Run
from lumped.numerics import dop853 as tableau


def _sum(weights: Iterable[float]) -> str:
    """A sum of stages, written out."""
    terms = [f"{float(w)!r} * k[{j} * n + i]" for j, w in enumerate(weights) if w]
    return " + ".join(terms)


def _loop(name: str, head: str, before: str, lines: list[str], after: str = "pass") -> Any:
    """A function that goes through all states once."""
    body = "\n".join(f"        {line}" for line in lines)
    source = f"def {name}({head}, k: Numbers, n: int, h: float) -> None:\n    {before}\n"
    source += f"    for i in range(n):\n{body}\n    {after}\n"
    return make_kernel(name, source, globals())


def _write_states(number: int, line: str) -> Any:
    return _loop(f"stage_{number}", "x: Numbers, out: Numbers", "pass", [f"out[i] = {line}"])


def _stage(number: int, weights: Iterable[float]) -> Any:
    """States at a stage; the newest rate comes in last, so that nothing else waits for it."""
    *older, newest = np.trim_zeros(np.array(weights), "b").tolist()
    before = f"x[i] + h * ({_sum(older)})" if any(older) else "x[i]"
    return _write_states(number, f"{before} + h * {newest!r} * k[{len(older)} * n + i]")


STAGES = tuple(_stage(1 + i, row) for i, row in enumerate(tableau.A[1:]))
"""States at which the rates of the second to the twelfth stage are taken."""
(_1, _2, _3, _4, _5, _6, _7, _8, _9, _10, _11) = STAGES
_NEW = _write_states(12, f"x[i] + h * ({_sum(tableau.B)})")
_13, _14, _15 = (_stage(13 + i, row) for i, row in enumerate(tableau.A_EXTRA))
_C = tuple(float(c) for c in tableau.C)
_AT_07 = (0.7, 0.21, 0.147, 0.0441, 0.03087, 0.009261, 0.0064827)
_SLOPE_07 = (1.0, -0.4, -0.07, -0.168, -0.0735, -0.05292, -0.027783)
"""The interpolation and its slope at 0.7 of the step, by its coefficients."""
NODES = (0.25, 0.6)
"""Two of the inner nodes, at which series look at the rates, too."""
_DOUBT = 2.0
"""Weight of the linear estimate of the error."""
_C_EXTRA = tuple(float(c) for c in tableau.C_EXTRA)
_columns = _loop(
    "columns",
    "x: Numbers, new: Numbers, out: Numbers",
    "pass",
    [
        "delta = new[i] - x[i]",
        "out[i] = delta",
        "out[n + i] = h * k[i] - delta",
        "out[2 * n + i] = 2 * delta - h * (k[12 * n + i] + k[i])",
        *(f"out[{3 + j} * n + i] = h * ({_sum(row)})" for j, row in enumerate(tableau.D)),
    ],
)
_weigh = _loop(
    "weigh",
    "x: Numbers, new: Numbers, last: Numbers, atol: Numbers, rtol: float, out: Numbers",
    "pass",
    [
        "weight = 1.0 / (atol[i] + rtol * fmax(abs(x[i]), abs(new[i])))",
        f"out[i] = ({_sum(tableau.E6)}) * weight",
        f"out[n + i] = ({_sum(tableau.E5)}) * weight",
        f"out[2 * n + i] = ({_sum(tableau.E3)}) * weight",
        "out[3 * n + i] = (k[12 * n + i] - k[11 * n + i]) * weight",
        "out[4 * n + i] = (new[i] - last[i]) * weight",
    ],
)
"""Errors of the states, relative to the tolerance, and by how much rates and states differ from
the last stage to the end. Apart from their squares, these are found side by side."""


@kernel
def _add_squares(n: int, given: Numbers) -> float:
    found = 0.0
    for i in range(n):
        found += given[i] * given[i]
    return found


def _bernstein() -> list[str]:
    """Coefficients of the interpolation in the Bernstein basis, column after column."""
    held, lines = ["k[6 * n + i]"], []
    for g in range(7):
        next_ = f"k[{5 - g} * n + i]" if g < 6 else "x[i]"
        lines.append(f"c = {next_}")
        shares = [(j / (g + 1), (g + 1 - j) / (g + 1)) for j in range(g + 2)]
        if g % 2 == 0:  # times the part of the step
            new = ["c", *(f"{shares[j][0]!r} * {held[j - 1]} + c" for j in range(1, g + 2))]
        else:  # times the rest of it
            new = [*(f"{shares[j][1]!r} * {held[j]} + c" for j in range(g + 1)), "c"]
        lines += [f"b{g}_{j} = {text}" for j, text in enumerate(new)]
        held = [f"b{g}_{j}" for j in range(g + 2)]
    least = most = held[0]
    for name in held[1:]:
        least, most = f"min({least}, {name})", f"max({most}, {name})"
    return [*lines, f"out[i] = {least}", f"out[n + i] = {most}"]


def _rough() -> list[str]:
    """Ranges between lines with the least and greatest slopes through both ends."""
    least = most = "k[i]"
    for j in range(5, 13):
        least, most = f"min({least}, k[{j} * n + i])", f"max({most}, k[{j} * n + i])"
    return [
        f"least, most = {least}, {most}",
        f"room = {_ROOM} * (most - least)",
        "least, most = least - room, most + room",
        "way, both = new[i] - x[i], most - least",
        "up = most * (way - h * least) / both if least < 0.0 and most > 0.0 else 0.0",
        "down = least * (h * most - way) / both if least < 0.0 and most > 0.0 else 0.0",
        "out[i] = min(min(x[i], new[i]), x[i] + down)",
        "out[n + i] = max(max(x[i], new[i]), x[i] + up)",
    ]


_ROOM = 0.25
"""Part of the span of the rates at the stages by which rates between them may lie beyond it."""
set_rough_ranges = _loop(
    "set_rough_ranges", "x: Numbers, new: Numbers, out: Numbers", "pass", _rough()
)
"""Ranges of the states before the interpolation is known, from the rates at the accurate stages."""

set_ranges = _loop("set_ranges", "x: Numbers, out: Numbers", "pass", _bernstein())
"""Least and greatest of these coefficients for each state, from columns of the interpolation."""


LOOKED = (0, 5, 6, 7, 8, 9, 10, 11)
"""Stages that have a weight in the step or in its error."""


def _over_looks(weights: Iterable[float]) -> str:
    """A sum over these stages, written out."""
    whole = list(weights)
    return " + ".join(f"{float(whole[j])!r} * v[{r} * n + i]" for r, j in enumerate(LOOKED))


integrals_by_stages = make_kernel(
    "integrals_by_stages",
    f"""def integrals_by_stages(run: Run, h: float) -> float:
    watch, worst = run.watch, 0.0
    n, v = watch.integrands, run.at_stages
    for i in range(n):
        watch.parts[i] = h * ({_over_looks(tableau.B)})
        a, b = {_over_looks(tableau.E5)}, {_over_looks(tableau.E3)}
        c = {_over_looks(tableau.E6)}
        size = abs(v[i])
        for r in range(1, {len(LOOKED)}):
            size = max(size, abs(v[r * n + i]))
        error = max(a * a / sqrt(max(a * a + 0.01 * b * b, 1e-300)), _DOUBT * abs(c))
        size = max(h * size, abs(watch.sums[i]))
        worst = max(worst, h * error / max(run.rtol * size, 1e-300))
    return worst
""",
    globals(),
)
"""Integrals over a step from values at its stages; gives the error of the worst of them, relative
to the tolerance of what has come together so far, as for a state."""


integral_error = make_kernel(
    "integral_error",
    f"""def integral_error(k: Numbers, n: int, i: int, h: float) -> float:
    a, b, c = {_sum(tableau.E5)}, {_sum(tableau.E3)}, {_sum(tableau.E6)}
    return max(h * a * a / sqrt(max(a * a + 0.01 * b * b, 1e-300)), _DOUBT * abs(h * c))
""",
    globals(),
)
"""Error of an integral over a step that was made as one more state."""


@kernel
def _look(run: Run, x: Numbers, t: float, row: int) -> None:
    """Values at a stage of what is integrated."""
    if run.watches:
        watch = run.watch
        if watch.integrands > 0:
            evaluate(watch.integrand, run, x, t, run.m, run.at_stages[row * watch.integrands :])


@kernel
def _find_rates(run: Run, stage: int, h: float) -> None:
    """Rates at a stage, and what is integrated if that has a weight."""
    t = run.t + _C[stage] * h
    find_rates(run, run.argument, t, run.stages[stage * run.plant.states :])
    if stage >= 5:
        _look(run, run.argument, t, stage - 4)


@kernel
def stages(run: Run, h: float) -> None:
    """Compute new states and their derivatives."""
    n, x, k, a, new = run.plant.states, run.x, run.stages, run.argument, run.new
    _look(run, x, run.t, 0)
    _1(x, a, k, n, h)
    _find_rates(run, 1, h)
    _2(x, a, k, n, h)
    _find_rates(run, 2, h)
    _3(x, a, k, n, h)
    _find_rates(run, 3, h)
    _4(x, a, k, n, h)
    _find_rates(run, 4, h)
    _5(x, a, k, n, h)
    _find_rates(run, 5, h)
    _6(x, a, k, n, h)
    _find_rates(run, 6, h)
    _7(x, a, k, n, h)
    _find_rates(run, 7, h)
    _8(x, a, k, n, h)
    _find_rates(run, 8, h)
    _9(x, a, k, n, h)
    _find_rates(run, 9, h)
    _10(x, a, k, n, h)
    _find_rates(run, 10, h)
    _11(x, a, k, n, h)
    _find_rates(run, 11, h)
    _NEW(x, new, k, n, h)
    end_step(run)
    run.evaluations += 12


@kernel
def attempt(run: Run, h: float) -> None:
    """Compute new states, their derivatives, the error relative to the tolerance, and stiffness."""
    n, found, parts = run.plant.states, run.attempt, run.dense
    stages(run, h)
    _weigh(run.x, run.new, run.argument, run.atol, run.rtol, parts, run.stages, n, h)
    e6, e5 = _add_squares(n, parts), _add_squares(n, parts[n:])
    e3, steepness = _add_squares(n, parts[2 * n :]), _add_squares(n, parts[3 * n :])
    # the ratio is 0/0 only where both estimates vanish
    size = fmax((e5 + 0.01 * e3) * n, 1e-300)
    found[ERROR] = fmax(h * e5 / sqrt(size), _DOUBT * h * sqrt(e6 / n))
    found[STIFFNESS] = h * sqrt(steepness) / fmax(sqrt(_add_squares(n, parts[4 * n :])), 1e-300)


@kernel
def step(run: Run, h: float) -> float:
    """Compute new states and their derivatives; gives the error relative to the tolerance.

    The attempt of a small system is written out, unless angles are too far for its sines.
    """
    found = run.attempt
    found[ANGLE] = math.inf
    if run.is_written and run.written.address != 0 and not run.shares:
        found[LENGTH], found[END], found[TOLERANCE] = h, run.t_new, run.rtol
        evaluate(run.written, run, run.x, run.t, run.m, run.stages)
        run.evaluations += 12
    if any_lane(not found[ANGLE] <= FARTHEST):
        attempt(run, h)
    run.stiffness = found[STIFFNESS]
    return found[ERROR]


@kernel
def dense_output(run: Run, h: float) -> None:
    """Coefficients of the interpolation in a step that was accepted."""
    n, t = run.plant.states, run.t
    x, k, a, new = run.x, run.stages, run.argument, run.new
    _13(x, a, k, n, h)
    find_rates(run, a, t + _C_EXTRA[0] * h, k[13 * n :])
    _14(x, a, k, n, h)
    find_rates(run, a, t + _C_EXTRA[1] * h, k[14 * n :])
    _15(x, a, k, n, h)
    find_rates(run, a, t + _C_EXTRA[2] * h, k[15 * n :])
    run.evaluations += 3
    _columns(x, new, run.dense, k, n, h)


@kernel
def dense_error(run: Run, h: float) -> float:
    """Error of the interpolation, relative to the tolerance, by its defect at one point.

    The interpolation meets the equations at 0, 0.1, 0.2, 7/9 and 1. Its defect at 0.7 is 8 to 12
    times its largest error; an error of three times the tolerance is allowed.
    """
    n, x, c, u = run.plant.states, run.x, run.dense, run.argument
    f = run.stages[13 * n :]
    for i in range(n):
        u[i] = x[i]
        for j in range(7):
            u[i] += _AT_07[j] * c[j * n + i]
    find_rates(run, u, run.t + 0.7 * h, f)
    run.evaluations += 1
    total = 0.0
    for i in range(n):
        slope = 0.0
        for j in range(7):
            slope += _SLOPE_07[j] * c[j * n + i]
        scale = run.atol[i] + run.rtol * max(abs(x[i]), abs(run.new[i]))
        part = (slope - h * f[i]) / scale
        total += part * part
    return sqrt(total / n) / 27.0


@kernel
def interpolate(run: Run, part: float, out: Numbers) -> None:
    """States at a part of the step."""
    n, x, c = run.plant.states, run.x, run.dense
    rest = 1.0 - part
    for i in range(n):
        y = c[6 * n + i] * part
        y = (y + c[5 * n + i]) * rest
        y = (y + c[4 * n + i]) * part
        y = (y + c[3 * n + i]) * rest
        y = (y + c[2 * n + i]) * part
        y = (y + c[n + i]) * rest
        y = (y + c[i]) * part
        out[i] = x[i] + y


@kernel
def polynomial(run: Run, i: int) -> int:
    """Coefficients of a state by powers of the part of the step; gives the degree."""
    n, q, c = run.plant.states, run.powers, run.dense
    q[0] = c[6 * n + i]
    for g in range(7):
        # times the part, or the rest of it; then the next column
        if g % 2 == 0:
            for j in range(g + 1, 0, -1):
                q[j] = q[j - 1]
            q[0] = 0.0
        else:
            q[g + 1] = -q[g]
            for j in range(g, 0, -1):
                q[j] -= q[j - 1]
        q[0] += c[(5 - g) * n + i] if g < 6 else run.x[i]
    return 7
