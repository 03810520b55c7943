"""A nonlinear programme with scaled unknowns and named constraints, solved by IPOPT."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt
import scipy

from lumped.errors import OptimisationError
from lumped.numerics.singular_factors import factors_of

_GOOD = ("Solve_Succeeded", "Solved_To_Acceptable_Level")
_ACTIVE = 1e-6


@dataclass(frozen=True, eq=False)
class Rows:
    """Constraints of one name.

    Attributes
    ----------
    label, unit : str
        Name and unit of the bounded quantity.
    first, count : int
        First row, number of rows.
    scale : float
        Size of the bounded quantity.
    times : ndarray or None
        Instants of the rows, s.
    given : bool
        The user gave the bounds.
    """

    label: str
    unit: str
    first: int
    count: int
    scale: float
    times: np.ndarray | None
    given: bool


@dataclass(frozen=True, eq=False)
class Solution:
    """Result of IPOPT.

    Attributes
    ----------
    w, g : ndarray
        Scaled unknowns and constraints.
    multipliers, bounds : ndarray
        Multipliers of the constraints and of the bounds of the unknowns, scaled.
    objective : float
        Least value.
    status : str
        Of IPOPT.
    iterations, evaluations : int
        Steps of the method, and evaluations of objective, constraints and their derivatives.
    residual, violation : float
        Greatest violation of the conditions of optimality and of the constraints, scaled.
    condition : float
        Condition number (1-norm, estimated) of the equations of optimality with the active
        constraints; infinite if the optimum is not unique or these depend on each other.
    seconds : float
        Wall time.
    """

    w: np.ndarray
    g: np.ndarray
    multipliers: np.ndarray
    bounds: np.ndarray
    objective: float
    status: str
    iterations: int
    evaluations: int
    residual: float
    violation: float
    condition: float
    seconds: float


class Programme:
    """Collects unknowns and constraints, then solves as often as wanted.

    Parameters
    ----------
    name : str
        Of the model, for errors.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.unknowns: list[ca.SX] = [ca.SX(0, 1)]
        self._box: list[np.ndarray] = [np.zeros((0, 3))]
        self.constraints: list[ca.SX] = [ca.SX(0, 1)]
        self._limits: list[np.ndarray] = [np.zeros((0, 2))]
        self.rows: list[Rows] = []
        self._solver: ca.Function | None = None

    def unknown(
        self,
        start: npt.ArrayLike,
        scale: float = 1.0,
        low: npt.ArrayLike = -np.inf,
        high: npt.ArrayLike = np.inf,
    ) -> ca.SX:
        """New unknowns as a column, in their own units."""
        begin = np.atleast_1d(np.asarray(start, dtype=float)).ravel()
        box = np.column_stack([begin, *(np.broadcast_to(b, begin.shape) for b in (low, high))])
        symbol = ca.SX.sym("w", len(begin))
        self.unknowns.append(symbol)
        self._box.append(box / scale)
        return symbol * scale

    def constrain(
        self,
        label: str,
        expression: ca.SX,
        low: npt.ArrayLike,
        high: npt.ArrayLike,
        *,
        scale: float = 1.0,
        unit: str = "1",
        times: np.ndarray | None = None,
        given: bool = False,
    ) -> Rows:
        """Bound an expression (a column)."""
        count = expression.numel()
        first = sum(part.numel() for part in self.constraints)
        self.constraints.append(ca.vec(ca.densify(expression)) / scale)
        limits = np.column_stack([np.broadcast_to(b, (count,)) for b in (low, high)]) / scale
        self._limits.append(limits)
        self.rows.append(Rows(label, unit, first, count, scale, times, given))
        return self.rows[-1]

    def ready(self, objective: ca.SX, weights: ca.SX) -> None:
        """Fix the objective, an expression of the unknowns and of weights that `solve` takes."""
        self.w, g = ca.vertcat(*self.unknowns), ca.vertcat(*self.constraints)
        self.box, self.limits = np.concatenate(self._box), np.concatenate(self._limits)
        self.functions = ca.Function("nlp", [self.w, weights], [objective, g])
        options: Any = {
            "print_time": False,
            "error_on_fail": False,
            "ipopt.print_level": 0,
            "ipopt.sb": "yes",
            "ipopt.tol": 1e-9,
            "ipopt.max_iter": 500,
            "ipopt.bound_relax_factor": 0.0,
            "ipopt.nlp_scaling_method": "none",
            "ipopt.mu_strategy": "adaptive",
            "ipopt.honor_original_bounds": "yes",
        }
        problem: Any = {"x": self.w, "p": weights, "f": objective, "g": g}
        self._solver = ca.nlpsol("ipopt", "ipopt", problem, options)

    def solve(
        self,
        weights: Sequence[float],
        *,
        begin: np.ndarray | None = None,
        limits: np.ndarray | None = None,
    ) -> Solution:
        """Solve from `begin` (scaled unknowns; default are the start values).

        Raises
        ------
        OptimisationError
            If IPOPT does not find an optimum, with the constraint that is violated most.
        """
        solver = self._solver
        assert solver is not None
        tic = clock.perf_counter()
        limits = self.limits if limits is None else limits
        found = solver(
            x0=self.box[:, 0] if begin is None else begin,
            p=ca.DM(list(weights)),
            lbx=self.box[:, 1],
            ubx=self.box[:, 2],
            lbg=limits[:, 0],
            ubg=limits[:, 1],
        )
        seconds, stats = clock.perf_counter() - tic, solver.stats()
        w, g, lam_g, lam_x = (
            np.asarray(found[key]).ravel() for key in ("x", "g", "lam_g", "lam_x")
        )
        beyond = _beyond(g, limits)
        status = stats["return_status"]
        if status not in _GOOD:
            raise OptimisationError(
                f"{self.name}: no optimum found ({status} after {stats['iter_count']} iterations). "
                f"{self._worst(beyond, g, limits)}",
                status,
            )
        course = stats["iterations"]
        return Solution(
            w,
            g,
            lam_g,
            lam_x,
            float(found["f"]),
            status,
            int(stats["iter_count"]),
            sum(int(v) for k, v in stats.items() if k.startswith("n_call_nlp_")),
            float(course["inf_du"][-1]),
            float(beyond.max(initial=0.0)),
            self._condition(w, g, lam_g, lam_x, weights, limits),
            seconds,
        )

    def list_active(self, solution: Solution) -> tuple[str, ...]:
        """Names of the user's constraints that are active."""
        pressing = np.abs(solution.multipliers) > 1e-6
        found = [
            row.label
            for row in self.rows
            if row.given and pressing[row.first : row.first + row.count].any()
        ]
        return tuple(dict.fromkeys(found))

    def _worst(self, beyond: np.ndarray, g: np.ndarray, limits: np.ndarray) -> str:
        """Text about the constraint that is violated most."""
        if not np.isfinite(g).all():
            i = int(np.flatnonzero(~np.isfinite(g))[0])
        elif not beyond.max(initial=0.0) > 1e-6:
            return "All constraints are met; narrow the bounds, or begin elsewhere."
        else:
            i = int(beyond.argmax())
        row = next(r for r in self.rows if r.first <= i < r.first + r.count)
        at = "" if row.times is None else f" at t = {row.times[i - row.first]:.6g} s"
        low, high = limits[i] * row.scale
        most, least = f"at most {high:.6g}", f"at least {low:.6g}"
        which = most if low == -np.inf else least if high == np.inf else f"{least} and {most}"
        wanted = f"{low:.6g}" if low == high else which
        return (
            f"Worst violated: {row.label} = {g[i] * row.scale:.6g} {row.unit}{at}, which must be "
            f"{wanted}. The constraints may exclude each other: widen some of them."
        )

    def _condition(
        self,
        w: np.ndarray,
        g: np.ndarray,
        lam_g: np.ndarray,
        lam_x: np.ndarray,
        weights: Sequence[float],
        limits: np.ndarray,
    ) -> float:
        """Condition of the KKT matrix with the unknowns and constraints that are active."""
        assert self._solver is not None
        hessian = self._solver.get_function("nlp_hess_l")(w, ca.DM(list(weights)), 1.0, lam_g)
        upper = scipy.sparse.csc_array(hessian.sparse())
        slopes = scipy.sparse.csr_array(
            self._solver.get_function("nlp_jac_g")(w, ca.DM(list(weights)))[1].sparse()
        )
        inside = np.minimum(w - self.box[:, 1], self.box[:, 2] - w) > _ACTIVE
        free = np.flatnonzero(inside | (np.abs(lam_x) < 1e-8))
        near = np.minimum(g - limits[:, 0], limits[:, 1] - g) <= _ACTIVE
        pressing = (np.abs(lam_g) > 1e-8) | (limits[:, 0] == limits[:, 1])
        active = np.flatnonzero(near & pressing)
        H = scipy.sparse.csr_array(upper + upper.T - scipy.sparse.diags_array(upper.diagonal()))[
            free
        ][:, free]
        A = slopes[active][:, free]
        matrix: Any = (
            scipy.sparse.csc_array(scipy.sparse.block_array([[H, A.T], [A, None]]))
            if len(active)
            else scipy.sparse.csc_array(H)
        )
        if not matrix.shape[0]:
            return 1.0
        factors = factors_of(matrix)
        if factors is None:
            return float("inf")
        inverse = scipy.sparse.linalg.LinearOperator(
            matrix.shape, factors.solve, rmatvec=lambda b: factors.solve(b, trans="T")
        )
        return float(
            scipy.sparse.linalg.onenormest(matrix) * scipy.sparse.linalg.onenormest(inverse)
        )


def _beyond(g: np.ndarray, limits: np.ndarray) -> np.ndarray:
    found: np.ndarray = np.maximum(np.maximum(limits[:, 0] - g, g - limits[:, 1]), 0.0)
    return found
