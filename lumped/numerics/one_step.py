"""One step of the methods, in symbols, without control of its size.

Explicit: DOP853 of Hairer, Norsett and Wanner (Solving Ordinary Differential Equations I, II.5),
with the coefficients that SciPy publishes. Implicit: Rodas5P of Steinebach (BIT Numerical
Mathematics 63 (2023) 27), a stiffly accurate L-stable Rosenbrock method, with the exact sparse
Jacobian. Both have dense output.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import casadi as ca
import numpy as np

from lumped.numerics import dop853, rodas5p

__all__ = ["combined", "explicit_dense", "explicit_step", "implicit_dense", "implicit_step"]

Rate = Callable[[ca.MX, ca.MX], ca.MX]
"""Derivatives of the states at states and a time."""


def explicit_step(
    rate: Rate, x: ca.MX, f: ca.MX, t: ca.MX, h: ca.MX
) -> tuple[list[ca.MX], ca.MX, ca.MX]:
    """Derivatives at the stages, states at the last of these, and new states."""
    stages, argument = [f], x
    for a, c in zip(dop853.A[1:], dop853.C[1:], strict=True):
        argument = x + h * combined(stages, a)
        stages.append(rate(argument, t + c * h))
    return stages, argument, x + h * combined(stages, dop853.B)


def explicit_dense(
    rate: Rate, x: ca.MX, new: ca.MX, stages: Sequence[ca.MX], t: ca.MX, h: ca.MX
) -> ca.MX:
    """Interpolation coefficients; the last of the stages is the derivative at the end."""
    stages, f, f_new = list(stages), stages[0], stages[-1]
    for a, c in zip(dop853.A_EXTRA, dop853.C_EXTRA, strict=True):
        stages.append(rate(x + h * combined(stages, a), t + c * h))
    delta = new - x
    columns = [delta, h * f - delta, 2 * delta - h * (f_new + f)]
    columns += [h * combined(stages, row) for row in dop853.D]
    return ca.horzcat(*columns)


def implicit_step(
    rate: Rate, slopes: tuple[ca.MX, ca.MX], x: ca.MX, f: ca.MX, t: ca.MX, h: ca.MX
) -> tuple[list[ca.MX], ca.MX]:
    """Increments and new states; `slopes` are derivatives of the rates by states and time."""
    jacobian, drift = slopes
    matrix = ca.MX.eye(x.numel()) - h * rodas5p.GAMMA * jacobian
    increments: list[ca.MX] = []
    new = x
    for i in range(8):
        if i < 6:
            new = x + combined(increments, np.array(rodas5p.A[i])) if i else x
        else:
            new = new + increments[-1]
        slope = f if i == 0 else rate(new, t + (rodas5p.NODES[i] if i < 5 else 1.0) * h)
        if i < 5:
            slope = slope + h * rodas5p.D[i] * drift
        if i:
            slope = slope + combined(increments, np.array(rodas5p.C[i])) / h
        increments.append(ca.solve(matrix, h * rodas5p.GAMMA * slope, "qr"))
    return increments, new + increments[-1]


def implicit_dense(increments: list[ca.MX]) -> ca.MX:
    """Interpolation coefficients."""
    return ca.horzcat(*(combined(increments, np.array(row)) for row in rodas5p.H))


def combined(stages: Sequence[ca.MX], weights: Iterable[float]) -> ca.MX:
    """Sum of the stages with their weights."""
    terms = [float(w) * k for k, w in zip(stages, weights, strict=False) if w]
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total
