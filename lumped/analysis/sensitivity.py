"""Derivatives of a run by parameters and start values, exact across events."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import cast

import casadi as ca
import numpy as np

from lumped.analysis.advance import nominals
from lumped.analysis.dense import Method
from lumped.analysis.result import Piece, Trajectory
from lumped.analysis.saltation import Saltation
from lumped.analysis.simulate import simulate
from lumped.analysis.start import start_slopes
from lumped.analysis.stepper import ACCEPTED, GIVEN_UP, Stepper, first_step
from lumped.errors import OptionError, SolverError
from lumped.system import Changes, Name, System

__all__ = ["Sensitivity", "sensitivity"]


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Derivatives over the times of a run; ``found["b.w", "shaft.c"]`` gives one of them.

    Attributes
    ----------
    run : Trajectory
        The run itself.
    of, to : tuple of str
        What is differentiated, and by what.
    values : ndarray, shape (len(run.t), len(of), len(to))
        The derivatives.
    instants : tuple of (float, ndarray)
        Each instant at which the run stopped, s, and its derivatives, shape (len(to),).
    """

    run: Trajectory
    of: tuple[str, ...]
    to: tuple[str, ...]
    values: np.ndarray
    instants: tuple[tuple[float, np.ndarray], ...]

    def __getitem__(self, pair: tuple[Name, Name]) -> np.ndarray:
        of, to = (self.run.system.key(name) for name in pair)
        found: np.ndarray = self.values[:, self.of.index(of), self.to.index(to)]
        return found


def sensitivity(
    system: System,
    *,
    of: Iterable[Name],
    to: Iterable[Name],
    until: float,
    parameters: Changes | None = None,
    start: Changes | None = None,
    grid: int | None = 500,
    rtol: float = 1e-6,
) -> Sensitivity:
    """Derivatives of quantities by parameters and start values along a run.

    The forward sensitivity equations ``der(S) == f_x S + f_p`` are integrated beside the states,
    under the same error control. Where the run stops at an instant ``t(p)``, ``S`` jumps by
    ``g_x S + g_p + (g_x f_before + g_t - f_after) t_p`` less ``S`` (the saltation matrix; Leine and
    Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7), with ``g``
    the change of the states there, if a `when` makes one.

    Parameters
    ----------
    system : System
        From `assemble`.
    of : iterable of names
        Quantities.
    to : iterable of names
        Parameters, given start values (of instances, or in `start`), and states, which stand for
        their start values.
    until, parameters, start, grid, rtol
        As for `simulate`; `grid` is a number of intervals, or None. Derivatives are given at the
        times of the run.

    Returns
    -------
    Sensitivity

    Raises
    ------
    OptionError
        If `of` or `to` is empty, a name in `to` is nothing that can be varied, or `grid` is no
        number.
    SolverError
        If different events coincide, a border is touched without being crossed, several changes
        follow each other at one instant, or states change places: where the run has no derivative,
        or none that is followed.
    """
    if not (grid is None or isinstance(grid, int)):
        raise OptionError(
            f"sensitivity: grid = {grid!r}: a number of intervals is needed, or None for the steps "
            "of the solver."
        )
    return _Forward(system, tuple(of), tuple(to), start or {}, rtol).go(
        simulate(
            system,
            until=until,
            parameters=parameters,
            start=start,
            grid=grid,
            rtol=rtol,
            method="steps",
        )
    )


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


class _Forward:
    def __init__(
        self,
        system: System,
        of: tuple[Name, ...],
        to: tuple[Name, ...],
        start: Changes,
        rtol: float,
    ) -> None:
        if not of or not to:
            raise OptionError("sensitivity: name at least one quantity in `of` and one in `to`.")
        self.system, self.rtol = system, rtol
        self.of = tuple(system.key(name) for name in of)
        self.to = tuple(system.key(name) for name in to)
        self.n, self.k = len(system.states), len(to)
        x, p, t, m = system._inputs
        self.given = start
        self.places, self.varied = self._sources(start)
        # each column is scaled by the size of what it is differentiated by
        defaults = system._flat.parameters.defaults
        self.scale = np.array([abs(defaults[i]) if i >= 0 else 1.0 for i in self.places])
        self.scale[self.scale == 0] = 1.0
        self.seed = np.zeros((p.numel(), self.k))
        for column, place in enumerate(self.places):
            if place >= 0:
                self.seed[place, column] = self.scale[column]
        self.S = ca.SX.sym("S", self.n, self.k)
        y = system.expressions(self.of)
        self.output = ca.Function("output", [x, self.S, p, t, m], [ca.vec(self._along(y))])
        self.augmented = self._augment()

    def _sources(self, start: Changes) -> tuple[list[int], dict[int, np.ndarray]]:
        """Places of parameters in `to` (-1: a start value); unit vectors of start values."""
        system, tree = self.system, self.system._tree
        given = [*system._flat.given, *(tree.unknown(name) for name in start)]
        nodes = {system._reduced.node(unknown): unknown for unknown in given}
        places: list[int] = []
        varied: dict[int, np.ndarray] = {}
        for column, name in enumerate(self.to):
            if name in system.parameters:
                places.append(system.places([name])[0])
                continue
            unknown = tree.unknown(name)
            node = system._reduced.node(unknown)
            if node is None or (node not in nodes and node not in system.states):
                raise OptionError(
                    f"sensitivity: {name} is no parameter that can be changed, no given start "
                    f"value and no state. States: {', '.join(system.state_names[:12])}."
                )
            signs, held = system._reduced.aliases.signs, nodes.get(node, unknown)
            places.append(-1)
            unit = np.eye(self.k)[column] * float(signs[unknown] * signs[held])
            varied[held] = varied.get(held, 0.0) + unit
        return places, varied

    def _start(self, run: Trajectory) -> np.ndarray:
        """Derivatives of the states at the time zero, scaled."""
        x, S = start_slopes(self.system, run.theta, self.given, self.seed, self.varied)
        if np.abs(x - run.pieces[0].x[0]).max(initial=0.0) > 0:
            raise SolverError(
                f"{self.system.name}: bodies collide at the time zero; derivatives are not "
                "followed across that. Give start values after the impact.",
                run,
            )
        return S

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

    def go(self, run: Trajectory) -> Sensitivity:
        """Follow the derivatives along the pieces of a run."""
        method: Method = "implicit" if "implicit" in run.statistics.method else "explicit"
        stepper = Stepper.build(self.augmented, method, True) if self.n else None
        saltation = Saltation(self.system, self.S, self.seed)
        S = self._start(run)
        pieces = [piece for piece in run.pieces if len(piece.t)]
        values: list[np.ndarray] = []
        instants: list[tuple[float, np.ndarray]] = []
        for number, piece in enumerate(pieces):
            if piece.system is not self.system:
                raise SolverError(
                    f"{self.system.name}: at t = {piece.t[0]:.9g} s states change places (see "
                    "run.events); derivatives are not followed across that.",
                    run,
                )
            t = float(piece.t[0])
            if number:
                last = pieces[number - 1]
                sides = (last.x[-1], last.settings[-1]), (piece.x[0], piece.settings[0])
                S, t_p = saltation.across(run, t, *sides, S)
                instants.append((t, t_p / self.scale))
            courses = [S] * len(piece.t)
            if stepper is not None and piece.t[-1] > t:
                courses = self._through(stepper, run, piece, S)
            S = courses[-1]
            found = self.output.map(len(piece.t))(
                piece.x.T,
                np.hstack(courses),
                np.repeat(run.theta[:, None], len(piece.t), axis=1),
                piece.t[None, :],
                piece.settings.T,
            )
            rows = np.asarray(found).T.reshape(len(piece.t), self.k, len(self.of))
            values.append(rows.transpose(0, 2, 1) / self.scale)
        return Sensitivity(run, self.of, self.to, np.concatenate(values), tuple(instants))

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
