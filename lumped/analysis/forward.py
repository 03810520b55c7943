"""Derivatives of states along a given run, exact across its events."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, cast

import casadi as ca
import numpy as np

from lumped.analysis.advance import nominals
from lumped.analysis.dense import Method
from lumped.analysis.result import Piece, Trajectory
from lumped.analysis.saltation import Saltation, coincide
from lumped.analysis.stepper import ACCEPTED, GIVEN_UP, IDLE, Stepper, first_step
from lumped.analysis.watch import exchange_fault
from lumped.errors import SolverError
from lumped.system import System

__all__ = ["Forward", "Instant"]


@dataclass(frozen=True, eq=False)
class _Augmented:
    """States and their sensitivities, as a stepper wants a system."""

    states: list[int]
    _inputs: list[ca.SX]
    rhs: ca.Function
    jacobian: ca.Function
    closure: ca.Function
    made: dict[object, object]
    switching: tuple[()] = ()


class Instant(NamedTuple):
    """An instant at which a run stopped.

    Attributes
    ----------
    t : float
        When, s.
    slopes : ndarray, shape (k,)
        Its derivatives.
    shared : bool
        Statically indeterminate constraints let go; their shares are held fixed.
    """

    t: float
    slopes: np.ndarray
    shared: bool


class Forward:
    """Sensitivity equations of one system, ``der(S) == f_x S + f_p``, for any of its runs.

    Parameters
    ----------
    system : System
        From `assemble`.
    seed : ndarray, shape (parameters, k)
        Derivatives of the parameters by what is varied.
    rtol : float
        Relative tolerance.

    Attributes
    ----------
    evaluations : int
        Evaluations of the right-hand side with its derivatives, in all runs so far.
    """

    def __init__(self, system: System, seed: np.ndarray, rtol: float) -> None:
        self.system, self.seed, self.rtol = system, seed, rtol
        self.n, self.k = len(system.states), seed.shape[1]
        self.S = ca.SX.sym("S", self.n, self.k)
        self.augmented = self._augment()
        self._steppers: dict[Method, Stepper] = {}
        self.evaluations = 0

    def courses(self, run: Trajectory, S: np.ndarray) -> tuple[list[np.ndarray], list[Instant]]:
        """Follow the derivatives along the pieces of a run.

        Parameters
        ----------
        S : ndarray, shape (n, k)
            Derivatives of the states at its start.

        Returns
        -------
        list of ndarray, shape (len(piece.t), n, k)
            For each piece that holds points.
        list of Instant
            At which the run stopped.

        Raises
        ------
        SolverError
            Where the run has no derivative, or none that is followed.
        """
        method: Method = "implicit" if "implicit" in run.statistics.method else "explicit"
        if self.n and method not in self._steppers:
            self._steppers[method] = Stepper.build(self.augmented, method, True)
        pieces = [piece for piece in run.pieces if len(piece.t)]
        found: list[np.ndarray] = []
        instants: list[Instant] = []
        for number, piece in enumerate(pieces):
            if piece.system is not self.system:
                raise SolverError(exchange_fault(run, float(piece.t[0])), run)
            t = float(piece.t[0])
            if number:
                last = pieces[number - 1]
                sides = (last.x[-1], last.settings[-1]), (piece.x[0], piece.settings[0])
                jump = Saltation.of(self.system).at(run, t, *sides)
                crossed = jump.forward(S, self.seed)
                if crossed is None:
                    raise coincide(run, t)
                S, t_p = crossed
                instants.append(Instant(t, t_p, jump.shared))
            course = [S] * len(piece.t)
            if self.n and piece.t[-1] > t:
                course = self._through(self._steppers[method], run, piece, S)
            S = course[-1]
            found.append(np.array(course))
        return found, instants

    def along(
        self, run: Trajectory, courses: list[np.ndarray], names: tuple[str, ...]
    ) -> np.ndarray:
        """Derivatives of quantities, shape (len(run.t), len(names), k)."""
        y = self.system.expressions(names)
        inputs = [self.system._inputs[0], self.S, *self.system._inputs[1:]]
        output = ca.Function("output", inputs, [ca.vec(self._along(y))])
        values = []
        pieces = [piece for piece in run.pieces if len(piece.t)]
        for piece, course in zip(pieces, courses, strict=True):
            count = len(piece.t)
            found = output.map(count)(
                piece.x.T,
                course.transpose(1, 0, 2).reshape(self.n, count * self.k),
                np.repeat(run.theta[:, None], count, axis=1),
                piece.t[None, :],
                piece.settings.T,
            )
            rows = np.asarray(found).T.reshape(count, self.k, len(names))
            values.append(rows.transpose(0, 2, 1))
        return np.concatenate(values)

    def _along(self, expression: ca.SX) -> ca.SX:
        """Derivatives of an expression along the columns of S and the parameters."""
        x, p, _, _ = self.system._inputs
        seed = ca.vertcat(self.S, ca.SX(ca.DM(self.seed)))
        return ca.densify(ca.jtimes(expression, ca.vertcat(x, p), seed))

    def _augment(self) -> System:
        x, p, t, m = self.system._inputs
        both = ca.vertcat(x, ca.vec(self.S))
        rates = ca.cse(ca.vertcat(self.system.rates, ca.vec(self._along(self.system.rates))))
        inputs = [both, p, t, m]
        closed = self.system.closure(x, p, t, m)
        found = _Augmented(
            list(range(both.numel())),
            inputs,
            ca.Function("rhs", inputs, [ca.densify(rates)]),
            ca.Function(
                "jacobian", inputs, [ca.jacobian(rates, both), ca.densify(ca.jacobian(rates, t))]
            ),
            ca.Function("closure", inputs, list(closed)),
            {},
        )
        return cast(System, found)

    def _through(
        self, stepper: Stepper, run: Trajectory, piece: Piece, S: np.ndarray
    ) -> list[np.ndarray]:
        """S at all times of a piece, from its value at the first."""
        count = self.system._flat.mode_count
        modes, guess = np.split(piece.settings[0], [count])
        t, end = float(piece.t[0]), float(piece.t[-1])
        x = np.concatenate([piece.x[0], S.ravel(order="F")])
        f = np.asarray(self.augmented.rhs(x, run.theta, t, piece.settings[0])).ravel()
        atol = max(self.rtol * 1e-3, 1e-12) * np.tile(nominals(self.system), 1 + self.k)
        scale = atol + self.rtol * np.abs(x)
        first = first_step(
            self.augmented, run.theta, (t, end), x, f, np.concatenate([modes, guess]), scale
        )
        head = np.concatenate([[t, first, 0, 0, 0, 0], guess])
        courses = [S]
        while head[0] < end:
            found = stepper.many(head, x, f, run.theta, modes, end, self.rtol, atol)
            log, xs = found[3].reshape(-1, 3).T, found[4].reshape(-1, len(x) + len(guess))
            accepted = np.flatnonzero(log[2] == ACCEPTED)
            self.evaluations += int((log[2] != IDLE).sum()) * stepper.evaluations
            if found[0][5] == GIVEN_UP or not len(accepted):
                raise SolverError(
                    f"{self.system.name}: the derivatives grow without bound or are not finite "
                    f"near t = {found[0][0]:.9g} s.",
                    run,
                )
            ends = log[1][accepted]
            wanted = piece.t[len(courses) : int(np.searchsorted(piece.t, ends[-1], "right"))]
            step = accepted[np.searchsorted(ends, wanted, "left")]
            before, after = np.vstack([x, xs[:-1, : len(x)]])[step], xs[step, : len(x)]
            dense = found[5].reshape(log.shape[1], -1, len(x))
            fraction = (wanted - log[0][step]) / (log[1][step] - log[0][step])
            inside = stepper.interpolate(fraction, before, after, dense[step])
            courses += [row[self.n :].reshape(self.n, self.k, order="F") for row in inside]
            head, x, f = found[:3]
        return courses
