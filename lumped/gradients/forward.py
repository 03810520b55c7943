"""Derivatives of states along a given run, exact across its events."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import casadi as ca
import numpy as np

from lumped.errors import SolverError
from lumped.gradients.jumps import Crossing
from lumped.gradients.legs import SmoothParts, legs_of, pieces_of
from lumped.gradients.saltation import crossings_of
from lumped.gradients.steps import Steps
from lumped.kernel import engine
from lumped.kernel.run import DONE, FULL, RESTART
from lumped.support.made_once import Shared, made_once
from lumped.timeloop.nominal_sizes import nominals
from lumped.timeloop.plants.executable import Executable, smooth_executable, span
from lumped.timeloop.plants.kept_run import KeptRun
from lumped.timeloop.results.trajectory import Piece, Trajectory

AGREE = 1e-6
"""Relative difference up to which derivatives to both sides are the same."""
_LEAST_ROWS = 64
"""Room for so many times at least, so that the next piece can have it."""
Method = Literal["explicit", "implicit"]


class StopInstant(NamedTuple):
    """An instant at which a run stopped.

    Attributes
    ----------
    t : float
        When, s.
    slopes : ndarray, shape (k,)
        Its derivatives.
    components : tuple of str
        What changes there.
    shared : bool
        Statically indeterminate constraints let go; their shares are held fixed.
    number : int
        Of the smooth part that begins there.
    """

    t: float
    slopes: np.ndarray
    components: tuple[str, ...]
    shared: bool
    number: int


class Followed(NamedTuple):
    """Derivatives along a run.

    Attributes
    ----------
    states : list of ndarray, shape (len(t), n, k)
        Derivatives of the states, for each smooth part.
    integrals : list of ndarray, shape (len(t), q, k)
        Derivatives of the integrals since its begin.
    jumps : list of ndarray, shape (q, k)
        What integrals gain where each part but the first begins, as the instant moves.
    instants : list of StopInstant
        At which the run stopped.
    """

    states: list[np.ndarray]
    integrals: list[np.ndarray]
    jumps: list[np.ndarray]
    instants: list[StopInstant]


def coincide(run: Trajectory, crossings: Sequence[Crossing]) -> SolverError:
    """What is raised where derivatives depend on which of several changes comes first."""
    texts = [f"t = {c.t:.9g} s ({', '.join(c.names)})" for c in crossings if len(c.orders) > 1]
    return SolverError(
        f"{run.system.name}: different changes coincide at {'; '.join(texts)}; which comes first "
        "depends on the parameters, so the run has no derivative there.",
        run,
    )


class _Tangents(Shared):
    """States of a system with their derivatives along some directions.

    Parameters
    ----------
    steps : Steps
        Of the system, with what is integrated.
    seed : ndarray, shape (parameters, k)
        Derivatives of the parameters along the directions.
    """

    def __init__(self, steps: Steps, seed: np.ndarray) -> None:
        super().__init__()
        self.steps, self.system, self.seed = steps, steps.system, seed
        self.S = ca.SX.sym("S", steps.states, seed.shape[1])

    @property
    @made_once
    def augmented(self) -> Executable:
        """States, their derivatives, integrals and those of these, ready to be run."""
        x, p, t, m = self.system.inputs
        integrands = self.steps.integrands
        Q = ca.SX.sym("Q", self.steps.integrals, 1 + self.seed.shape[1])
        both = ca.vertcat(x, ca.vec(self.S), ca.vec(Q))
        slopes = ca.vec(self._along(self.system.rates)), ca.vec(self._along(integrands))
        rates = ca.cse(ca.vertcat(self.system.rates, slopes[0], integrands, slopes[1]))
        inputs = [both, p, t, m]
        functions = {"rates": ca.Function("rates", inputs, [rates])}
        implicit = len(self.system.structure.implicit)
        if implicit:
            closed = self.system.closure(x, p, t, m)
            functions["closure"] = ca.Function("closure", inputs, list(closed))

        def jacobian() -> ca.Function:
            results = [ca.jacobian(rates, both), ca.densify(ca.jacobian(rates, t))]
            return ca.Function("jacobian", inputs, results)

        return smooth_executable(inputs, functions, jacobian, implicit)

    @made_once
    def output(self, names: tuple[str, ...]) -> ca.Function:
        """Derivatives of quantities, one direction after the other: (x, S, p, t, m)."""
        inputs = [self.system.inputs[0], self.S, *self.system.inputs[1:]]
        along = self._along(self.system.expressions(names))
        return ca.Function("output", inputs, [ca.vec(along)])

    def _along(self, expression: ca.SX) -> ca.SX:
        """Derivatives of an expression along the columns of S and the parameters."""
        x, p, _, _ = self.system.inputs
        seed = ca.vertcat(self.S, ca.SX(ca.DM(self.seed)))
        return ca.densify(ca.jtimes(expression, ca.vertcat(x, p), seed))


@made_once
def _tangents(steps: Steps, k: int, seed: bytes) -> _Tangents:
    return _Tangents(steps, np.frombuffer(seed).reshape(-1, k))


class Forward:
    """Sensitivity equations of one system, ``der(S) == f_x S + f_p``, for any of its runs.

    Parameters
    ----------
    steps : Steps
        Of the system, with what is integrated and differentiated too.
    seed : ndarray, shape (parameters, k)
        Derivatives of the parameters by what is varied.
    rtol : float
        Relative tolerance.
    sizes : ndarray, shape (q,), optional
        Sizes of the integrals.

    Attributes
    ----------
    evaluations : int
        Evaluations of the right-hand side with its derivatives, in all runs so far.
    """

    def __init__(
        self, steps: Steps, seed: np.ndarray, rtol: float, sizes: np.ndarray | None = None
    ) -> None:
        self.steps, self.system, self.seed, self.rtol = steps, steps.system, seed, rtol
        self.n, self.k = steps.states, seed.shape[1]
        self.q = steps.integrals
        self.sizes = np.ones(self.q) if sizes is None else sizes
        self.tangents = _tangents(steps, self.k, seed.tobytes())
        self.evaluations = 0

    def sensitivities(
        self, run: Trajectory, S: np.ndarray
    ) -> tuple[list[np.ndarray], list[StopInstant]]:
        """Follow the derivatives along the pieces of a run.

        Parameters
        ----------
        S : ndarray, shape (n, k)
            Derivatives of the states at its start.

        Returns
        -------
        list of ndarray, shape (len(piece.t), n, k)
            For each piece that holds points.
        list of StopInstant
            At which the run stopped.

        Raises
        ------
        SolverError
            Where the run has no derivative, or none that is followed.
        """
        found = self._of_all_orders(run, pieces_of(run), S)
        return found.states, found.instants

    def at_end(self, run: Trajectory, S: np.ndarray) -> np.ndarray:
        """As `sensitivities`, but only those at the end of the run, shape (n, k)."""
        ends = [
            Piece(p.system, p.t[[0, -1]], p.x[[0, -1]], p.settings[[0, -1]]) for p in pieces_of(run)
        ]
        found: np.ndarray = self._of_all_orders(run, ends, S).states[-1][-1]
        return found

    def _of_all_orders(self, run: Trajectory, wanted: list[Piece], S: np.ndarray) -> Followed:
        """Derivatives at wanted points of the pieces, which must agree in all orders of changes."""
        crossings = self.crossings(run)
        found = self.follow(run, wanted, crossings, S, 1)
        if any(len(crossing.orders) > 1 for crossing in crossings):
            other = self.follow(run, wanted, crossings, S, -1)
            for right, left in zip(found.states, other.states, strict=True):
                if np.abs(right - left).max(initial=0.0) > AGREE * np.abs(right).max(initial=0.0):
                    raise coincide(run, crossings)
        return found

    def crossings(self, run: Trajectory) -> list[Crossing]:
        """How derivatives jump between the pieces."""
        return crossings_of(SmoothParts(run, legs_of(run), self.steps, self.rtol))

    def follow(
        self,
        run: Trajectory,
        pieces: list[Piece],
        crossings: Sequence[Crossing],
        S: np.ndarray,
        side: int,
    ) -> Followed:
        """Follow the derivatives to one side: what is varied grows (1) or shrinks (-1)."""
        method: Method = "implicit" if "implicit" in run.statistics.method else "explicit"
        found = Followed([], [], [], [])
        for number, piece in enumerate(pieces):
            if number:
                S = self._across(run, crossings[number - 1], number, S, side, found)
            if (self.n or self.q) and piece.t[-1] > piece.t[0]:
                states, integrals = self._through(method, run, piece, S)
            else:
                count = len(piece.t)
                states = S[None].repeat(count, axis=0)
                integrals = np.zeros((count, self.q, self.k))
            S = states[-1]
            found.states.append(states)
            found.integrals.append(integrals)
        return found

    def _across(
        self,
        run: Trajectory,
        crossing: Crossing,
        number: int,
        S: np.ndarray,
        side: int,
        found: Followed,
    ) -> np.ndarray:
        """Sensitivities after a crossing; notes its instants and what integrals gain."""
        gains = np.zeros((self.q, self.k))
        if not crossing.orders:
            found.jumps.append(gains)
            return S
        passed = crossing.forward(S, self.seed, side)
        for jump, slopes, _ in passed.parts:
            found.instants.append(StopInstant(crossing.t, slopes, jump.names, jump.shared, number))
        for jump, _, slopes in passed.gains if self.q else ():
            rates = [
                np.asarray(self.steps.integrated(x, run.theta, crossing.t, m)).ravel()
                for x, m in (jump.before, jump.after)
            ]
            gains += np.outer(rates[0] - rates[1], slopes)
        found.jumps.append(gains)
        return passed.S

    def along(
        self, run: Trajectory, courses: list[np.ndarray], names: tuple[str, ...]
    ) -> np.ndarray:
        """Derivatives of quantities, shape (len(run.t), len(names), k)."""
        output, values = self.tangents.output(names), []
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

    def _through(
        self, method: Method, run: Trajectory, piece: Piece, S: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """S and derivatives of integrals at all times of a piece, from S at the first."""
        n, k, q = self.n, self.k, self.q
        x = np.concatenate([piece.x[0], S.ravel(order="F"), np.zeros(q * (1 + k))])
        sizes = np.tile(nominals(self.system), 1 + k), np.tile(self.sizes, 1 + k)
        atol = max(self.rtol * 1e-3, 1e-12) * np.concatenate(sizes)
        found = self._solve(method, run, piece, x, atol)
        S, Q = found[:, n : n + n * k], found[:, n + n * k + q :]
        count = len(found)
        return S.reshape(count, k, n).transpose(0, 2, 1), Q.reshape(count, k, q).transpose(0, 2, 1)

    def _solve(
        self, method: Method, run: Trajectory, piece: Piece, x: np.ndarray, atol: np.ndarray
    ) -> np.ndarray:
        """States and derivatives at all times of a piece, from those at the first."""
        code, t = self.tangents.augmented, piece.t
        grid = np.ascontiguousarray(t[1:], dtype=float)
        kept = self._records(method, len(grid))
        loop, room = kept.run, kept.room
        span(loop, max(abs(float(t[0])), abs(float(t[-1]))))
        loop.atol[:] = atol
        loop.t, loop.end = float(t[0]), float(t[-1])
        loop.edges = np.array([t[0], t[-1]], dtype=float)
        room.begin(grid, 0, on_grid=True, both_sides=False)
        code.place(loop, run.theta, x, piece.settings[0])
        why = FULL
        while why == FULL:
            loop.pause = loop.steps + loop.rejected + code.attempts
            why = engine.call("loop", loop)
            code.account(loop)
        count = room.output.rows
        at_end = loop.x[None, :].repeat(len(grid) - count, axis=0)
        found = np.concatenate([x[None, :], room.x[:count], at_end])
        self.evaluations += loop.evaluations
        code.take_back(kept)
        if why != DONE:
            raise SolverError(
                f"{self.system.name}: the derivatives grow without bound or are not finite "
                f"near t = {loop.t:.9g} s.",
                run,
            )
        return found

    def _records(self, method: Method, count: int) -> KeptRun:
        """Records of a run with so many output times, at no point yet."""
        code = self.tangents.augmented
        rows = max(_LEAST_ROWS, 1 << (count + 8).bit_length())
        options = self.rtol, method, rows
        kept = code.reuse_run(options)
        if kept is not None:
            return kept
        run, plant = code.blank_run(), code.plant
        run.rtol, run.max_steps = self.rtol, 1 << 60
        run.phase, run.segments = RESTART, 1
        if method == "implicit":
            code.add_matrix(run)
            run.is_implicit = 1
        modes = plant.settings - plant.implicit
        room = code.room((rows, 1, 1, plant.states, plant.implicit, modes))
        run.output = room.output
        return KeptRun(options, run, room)
