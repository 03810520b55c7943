"""Integrals over a run, as exact as its tolerance asks: steps are halved where they need it."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.errors import SolverError
from lumped.gradients.adjoint import Leg, Steps
from lumped.numerics.inside_step import Method
from lumped.support.made_once import made_once
from lumped.timeloop.result import Trajectory

__all__ = ["resolve", "totals"]

_HALVINGS = 40
_MOST = 1_000_000
"""Steps of a run at most."""


def resolve(run: Trajectory, legs: list[Leg], steps: Steps, rtol: float) -> None:
    """Halve steps until each integral over every step is that over its halves.

    The error of all steps together stays below `rtol` of the integral of the size.
    """
    if not steps.integrands.numel():
        return
    span = legs[-1].t[-1] - legs[0].t[0]
    parts = [_Leg(run, leg, steps) for leg in legs]
    for _ in range(_HALVINGS):
        size = np.sum([part.size for part in parts], axis=0)
        again = False
        for part in parts:
            again |= part.halve(rtol * size / span, 1e-15 * size)
        if not again:
            return
        if sum(len(leg.t) for leg in legs) > _MOST:
            raise SolverError(
                f"{run.system.name}: an integral needs more than {_MOST} steps at "
                f"rtol = {rtol:g}. Loosen rtol, or end the run earlier.",
                run,
            )


def totals(
    run: Trajectory, legs: list[Leg], steps: Steps, spans: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Each integral over its span, and of its size; spans end where steps do."""
    found, sizes = np.zeros(len(spans)), np.zeros(len(spans))
    for leg in legs:
        _, halves, _ = _looked(run, leg, steps, np.arange(len(leg.t) - 1))
        middle = 0.5 * (leg.t[1:] + leg.t[:-1])
        inside = (spans[:, :1] < middle) & (middle < spans[:, 1:])
        found += (halves * inside).sum(axis=1)
        sizes += np.abs(halves * inside).sum(axis=1)
    return found, sizes


class _Leg:
    """One leg and what its steps are worth."""

    def __init__(self, run: Trajectory, leg: Leg, steps: Steps) -> None:
        self.run, self.leg, self.steps = run, leg, steps
        self.found = _looked(run, leg, steps, np.arange(len(leg.t) - 1))

    @property
    def size(self) -> np.ndarray:
        """Integrals of the sizes, shape (integrals,)."""
        total: np.ndarray = np.abs(self.found[1]).sum(axis=1)
        return total

    def halve(self, tolerated: np.ndarray, least: np.ndarray) -> bool:
        """Halve the steps whose errors are greater than tolerated per second."""
        whole, halves, middle = self.found
        h = np.diff(self.leg.t)
        error = np.abs(whole - halves)
        wrong = (error > np.maximum(tolerated[:, None] * h, least[:, None])).any(axis=0)
        wrong &= h > 1e-12 * (1.0 + np.abs(self.leg.t[1:]))
        rows = np.flatnonzero(wrong)
        if not len(rows):
            return False
        leg = self.leg
        t = leg.t[rows] + 0.5 * h[rows]
        leg.t = np.insert(leg.t, rows + 1, t)
        leg.x = np.insert(leg.x, rows + 1, middle[:, rows].T, axis=0)
        leg.settings = np.insert(leg.settings, rows + 1, leg.settings[rows], axis=0)
        left = rows + np.arange(len(rows))
        fresh = np.sort(np.concatenate([left, left + 1]))
        new = _looked(self.run, leg, self.steps, fresh)
        found = []
        for old, own in zip(self.found, new, strict=True):
            kept = np.zeros((len(old), len(leg.t) - 1))
            kept[:, np.setdiff1d(np.arange(len(leg.t) - 1), fresh)] = np.delete(old, rows, axis=1)
            kept[:, fresh] = own
            found.append(kept)
        self.found = tuple(found)
        return True


def _looked(run: Trajectory, leg: Leg, steps: Steps, rows: np.ndarray) -> tuple[np.ndarray, ...]:
    """Integrals over some steps, those over both halves, states between; columns are steps."""
    system, q = run.system, steps.integrands.numel()
    found = [np.zeros((size, len(rows))) for size in (q, q, len(system.state_names))]
    implicit = leg.t[rows] >= run.statistics.implicit_from
    methods: tuple[tuple[Method, np.ndarray], ...] = (
        ("explicit", np.flatnonzero(~implicit)),
        ("implicit", np.flatnonzero(implicit)),
    )
    for method, places in methods:
        own = rows[places]
        if not len(own):
            continue
        h = np.diff(leg.t)[own]
        results = _halved(steps, method).map(len(own))(
            leg.x[own].T, run.theta, leg.t[None, own], h[None], leg.settings[own].T
        )
        for kept, values in zip(found, results, strict=True):
            kept[:, places] = np.asarray(values).reshape(len(kept), len(own))
    return tuple(found)


@made_once
def _halved(steps: Steps, method: Method) -> ca.Function:
    """(x, p, t, h, m) -> integrals over a step, over its halves, states between these."""
    step = steps.step(method)
    x, p, t, h, m = (ca.MX.sym(f"a{i}", step.size1_in(i)) for i in range(5))
    whole = step(x, p, t, h, m)[1]
    middle, first = step(x, p, t, h / 2, m)
    second = step(middle, p, t + h / 2, h / 2, m)[1]
    outputs = [ca.densify(v) for v in (whole, first + second, middle)]
    return ca.Function("halved", [x, p, t, h, m], outputs)
