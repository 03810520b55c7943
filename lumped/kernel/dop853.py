"""One attempt of DOP853 (Hairer, Norsett, Wanner), with the coefficients that SciPy publishes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import DOP853

from lumped.kernel.layout import (
    ARGUMENT,
    ATOL,
    DENSE,
    E5,
    EVALUATIONS,
    LIMIT,
    NEW,
    RHS,
    RTOL,
    STAGES,
    M,
    N,
    P,
    T,
    X,
)
from lumped.kernel.words import Integers, Kernel, Numbers, at, evaluate, kernel

__all__ = ["dense_explicit", "explicit"]


def _sum(weights: np.ndarray) -> str:
    """A sum of stages, written out."""
    terms = [f"{float(w)!r} * k[{j} * n + i]" for j, w in enumerate(weights) if w]
    return " + ".join(terms)


def _loop(name: str, head: str, before: str, lines: list[str], after: str = "") -> Kernel:
    """A function that goes through all states once."""
    body = "\n".join(f"        {line}" for line in lines)
    source = f"def {name}({head}, k: Numbers, n: int, h: float) -> None:\n    {before}\n"
    source += f"    for i in range(n):\n{body}\n    {after}\n"
    return Kernel(f"{__name__}.{name}", source, globals())


def _stage(number: int, weights: np.ndarray) -> Any:
    line = f"out[i] = x[i] + h * ({_sum(weights)})"
    return _loop(f"stage_{number}", "x: Numbers, out: Numbers", "pass", [line])


(_1, _2, _3, _4, _5, _6, _7, _8, _9, _10, _11) = (
    _stage(1 + i, row) for i, row in enumerate(DOP853.A[1:])
)
_NEW = _stage(12, DOP853.B)
_13, _14, _15 = (_stage(13 + i, row) for i, row in enumerate(DOP853.A_EXTRA))
_C = tuple(float(c) for c in DOP853.C)
_C_EXTRA = tuple(float(c) for c in DOP853.C_EXTRA)
_COLUMNS: Any = _loop(
    "columns",
    "x: Numbers, new: Numbers, out: Numbers",
    "pass",
    [
        "delta = new[i] - x[i]",
        "out[i] = delta",
        "out[n + i] = h * k[i] - delta",
        "out[2 * n + i] = 2 * delta - h * (k[12 * n + i] + k[i])",
        *(f"out[{3 + j} * n + i] = h * ({_sum(row)})" for j, row in enumerate(DOP853.D)),
    ],
)
_ERRORS: Any = _loop(
    "errors",
    "x: Numbers, new: Numbers, last: Numbers, rtol: float, atol: Numbers, sums: Numbers",
    "e5 = e3 = steep = moved = 0.0",
    [
        "scale = atol[i] + rtol * max(abs(x[i]), abs(new[i]))",
        f"a = ({_sum(DOP853.E5)}) / scale",
        f"b = ({_sum(DOP853.E3)}) / scale",
        "c = (k[12 * n + i] - k[11 * n + i]) / scale",
        "d = (new[i] - last[i]) / scale",
        "e5 += a * a",
        "e3 += b * b",
        "steep += c * c",
        "moved += d * d",
    ],
    "sums[0], sums[1], sums[2], sums[3] = e5, e3, steep, moved",
)


@kernel
def explicit(Z: Integers, R: Numbers, h: float) -> float:
    """New states, their derivatives, and the error relative to what is tolerated."""
    n, t = Z[N], R[T]
    x, k, a, new = at(R, Z[X]), at(R, Z[STAGES]), at(R, Z[ARGUMENT]), at(R, Z[NEW])
    p, m, f = at(R, Z[P]), at(R, Z[M]), Z[RHS]
    _1(x, a, k, n, h)
    evaluate(f, a, p, t + _C[1] * h, m, at(k, n))
    _2(x, a, k, n, h)
    evaluate(f, a, p, t + _C[2] * h, m, at(k, 2 * n))
    _3(x, a, k, n, h)
    evaluate(f, a, p, t + _C[3] * h, m, at(k, 3 * n))
    _4(x, a, k, n, h)
    evaluate(f, a, p, t + _C[4] * h, m, at(k, 4 * n))
    _5(x, a, k, n, h)
    evaluate(f, a, p, t + _C[5] * h, m, at(k, 5 * n))
    _6(x, a, k, n, h)
    evaluate(f, a, p, t + _C[6] * h, m, at(k, 6 * n))
    _7(x, a, k, n, h)
    evaluate(f, a, p, t + _C[7] * h, m, at(k, 7 * n))
    _8(x, a, k, n, h)
    evaluate(f, a, p, t + _C[8] * h, m, at(k, 8 * n))
    _9(x, a, k, n, h)
    evaluate(f, a, p, t + _C[9] * h, m, at(k, 9 * n))
    _10(x, a, k, n, h)
    evaluate(f, a, p, t + _C[10] * h, m, at(k, 10 * n))
    _11(x, a, k, n, h)
    evaluate(f, a, p, t + _C[11] * h, m, at(k, 11 * n))
    _NEW(x, new, k, n, h)
    evaluate(f, new, p, t + h, m, at(k, 12 * n))
    sums = at(R, E5)
    _ERRORS(x, new, a, R[RTOL], at(R, Z[ATOL]), sums, k, n, h)
    # the ratio is 0/0 only where both estimates vanish
    size = (sums[0] + 0.01 * sums[1]) * n
    size = 1e-300 if size < 1e-300 else size
    R[LIMIT] = h * math.sqrt(sums[2]) / max(math.sqrt(sums[3]), 1e-300)
    Z[EVALUATIONS] += 12
    return h * sums[0] / math.sqrt(size)


@kernel
def dense_explicit(Z: Integers, R: Numbers, h: float) -> None:
    """Interpolation coefficients of a step that was accepted."""
    n, t = Z[N], R[T]
    x, k, a, new = at(R, Z[X]), at(R, Z[STAGES]), at(R, Z[ARGUMENT]), at(R, Z[NEW])
    p, m, f = at(R, Z[P]), at(R, Z[M]), Z[RHS]
    _13(x, a, k, n, h)
    evaluate(f, a, p, t + _C_EXTRA[0] * h, m, at(k, 13 * n))
    _14(x, a, k, n, h)
    evaluate(f, a, p, t + _C_EXTRA[1] * h, m, at(k, 14 * n))
    _15(x, a, k, n, h)
    evaluate(f, a, p, t + _C_EXTRA[2] * h, m, at(k, 15 * n))
    _COLUMNS(x, new, at(R, Z[DENSE]), k, n, h)
    Z[EVALUATIONS] += 3
