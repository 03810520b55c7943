"""Initial states: given start values hold exactly, declared defaults fill the rest."""

from __future__ import annotations

import warnings
from collections.abc import Iterable

import casadi as ca
import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import MatrixRankWarning, spsolve

from lumped.analysis.result import OperatingPoint
from lumped.analysis.changeover import Settler
from lumped.errors import SolverError, StartError
from lumped.select import RANK, select_dependent
from lumped.system import Changes, Name, System
from lumped.template import CONSTANT

__all__ = ["closed_with", "given_states", "modes_at", "settings_at", "start_point"]

_TOLERANCE = 1e-9
_MOST_CLOSING = 20
_RADII = (0.0, *(r for r in (0.1, 0.3, 1.0, 3.0) for _ in range(5)))
"""Distances from the given guesses at which the search for a linkage's position begins."""


def modes_at(system: System, theta: np.ndarray, time: float) -> np.ndarray:
    """Modes of all conditions at a time that is not itself an instant of change."""
    function, directions = system._flat.thresholds
    if not len(directions):
        return np.zeros(0)
    instants = np.asarray(function(theta)).ravel()
    return (directions * (time - instants) >= 0).astype(float)


def start_point(
    system: System,
    parameters: Changes | None = None,
    start: Changes | None = None,
    free: Iterable[Name] = (),
) -> OperatingPoint:
    """States at the time zero.

    Start values given to instances (``Inertia(J=1, w=100)``) and those in `start` hold exactly.
    States that they do not determine take their declared defaults; where a given quantity is not
    itself a state, the least wanted states follow from it. For a quantity that a closed linkage
    determines, the start value is where the search begins, and so chooses the assembly.

    Parameters
    ----------
    system : System
        From `assemble`.
    parameters, start : mapping of name to float, optional
        Parameters to change, start values to set.
    free : iterable of names
        Parameters that the start values determine, for example the rest length of a spring that
        holds a body at a given place with a given acceleration.

    Raises
    ------
    StartError
        If given values contradict each other, or do not determine a free parameter.
    """
    theta = system.theta(parameters)
    solver = _Start(system, theta, start or {}, system.places(free))
    x, settings = solver.solve()[system._in_use], solver.settings
    if system.switching:
        count = len(settings) - len(system._values.implicit)
        settler = Settler(system, solver.theta, 1.0)
        try:
            x, modes = settler.begin(1e-300, x, settings[:count], settings[count:])
        except SolverError as error:
            raise StartError(str(error)) from None
        settings = np.concatenate([modes, settings[count:]])
    return OperatingPoint(system, 0.0, x, solver.theta, settings)


def settings_at(
    system: System, x: np.ndarray, theta: np.ndarray, time: float, guesses: np.ndarray
) -> np.ndarray:
    """Modes at a time, and implicit quantities there, found from guesses.

    Raises
    ------
    StartError
        If a closed linkage cannot be closed from these guesses.
    """
    return closed_with(system, x, theta, time, modes_at(system, theta, time), guesses)


def closed_with(
    system: System,
    x: np.ndarray,
    theta: np.ndarray,
    time: float,
    modes: np.ndarray,
    guesses: np.ndarray,
) -> np.ndarray:
    """The same for given modes."""
    if not len(guesses):
        return modes
    rng = np.random.default_rng(3)
    for radius in _RADII:
        begin = guesses + radius * rng.uniform(-1, 1, len(guesses))
        found = _closed(system, (x, theta, time), modes, begin)
        if found is not None:
            return np.concatenate([modes, found])
    names = ", ".join(system._node_name(n) for n in system._values.implicit[:6])
    raise StartError(
        f"{system.name}: no values of {names} meet their equations at t = {round(time, 12):g} s, "
        "so a linkage cannot be closed. Check its lengths, and give start values near the "
        "position that is meant."
    )


def _closed(
    system: System,
    point: tuple[np.ndarray, np.ndarray, float],
    modes: np.ndarray,
    guesses: np.ndarray,
) -> np.ndarray | None:
    """Implicit quantities by Newton's method, or None if it does not converge."""
    for _ in range(_MOST_CLOSING):
        found, step = system.closure(*point, np.concatenate([modes, guesses]))
        guesses, last = np.asarray(found).ravel(), np.asarray(step).ravel()
        if not np.isfinite(guesses).all():
            return None
        if np.abs(last).max() <= 1e-12 * (1 + np.abs(guesses).max()):
            return guesses
    return None


def given_states(system: System, start: Changes | None) -> np.ndarray:
    """Which states in use have a start value that was given, not only declared."""
    unknowns = [*system._flat.given, *(system._tree.unknown(name) for name in start or {})]
    nodes = {system._reduced.node(u) for u in unknowns}
    return np.array([node in nodes for node in system.states], dtype=bool)


class _Start:
    def __init__(self, system: System, theta: np.ndarray, start: Changes, free: list[int]) -> None:
        self.system, self.theta, self.free = system, theta, free
        self.reduced = system._reduced
        self.position = {n: i for i, n in enumerate(self.reduced.states)}
        flat = system._flat
        given = self._evaluated(flat.given)
        for name, value in start.items():
            unknown = system._tree.unknown(name)
            try:
                given[unknown] = float(value)
            except (TypeError, ValueError):
                unit = system._tree.quantity(unknown).unit
                raise StartError(
                    f"{system.key(name)} = {value!r}: a number in {unit} is needed."
                ) from None
        self.given = given
        for unknown, number in given.items():
            if not np.isfinite(number):
                raise StartError(f"{self._text(unknown)}: a start value must be a finite number.")
        self.guesses = self._first_guesses()
        self.settings = np.concatenate([modes_at(system, theta, 1e-300), self.guesses])
        self.x = np.zeros(len(self.reduced.states))
        for unknown, value in self._evaluated(flat.starts).items():
            node = self.reduced.node(unknown)
            if node in self.position:
                self.x[self.position[node]] = self._signed(unknown, value)

    def _evaluated(self, values: dict[int, ca.SX]) -> dict[int, float]:
        if not values:
            return {}
        theta = self.system._flat.parameters.theta
        function = ca.Function("starts", [theta], [ca.vertcat(*values.values())])
        found = np.asarray(function(self.theta)).ravel()
        return dict(zip(values, found.tolist(), strict=True))

    def _signed(self, unknown: int, value: float) -> float:
        return value * float(self.reduced.aliases.signs[unknown])

    def solve(self) -> np.ndarray:
        fixed: dict[int, tuple[int, float]] = {}
        targets: dict[int, tuple[int, float]] = {}
        for unknown, raw in self.given.items():
            node, value = self.reduced.node(unknown), self._signed(unknown, raw)
            if node is None:
                if raw != 0.0:
                    raise StartError(
                        f"{self._text(unknown)} cannot hold: this quantity is always zero here. "
                        "Remove the start value."
                    )
                continue
            if node in self.system._values.implicit:
                continue
            store = fixed if node in self.position else targets
            if node in store and not np.isclose(store[node][1], value, rtol=1e-12, atol=0):
                raise StartError(
                    f"Start values contradict each other: {self._text(store[node][0])} and "
                    f"{self._text(unknown)}, but both are the same motion. Give only one of them."
                )
            store[node] = (unknown, value)
        for node, (_, value) in fixed.items():
            self.x[self.position[node]] = value
        if targets or self.free:
            self._meet(targets, {self.position[n]: u for n, (u, _) in fixed.items()})
            self.system.check_parameters(self.theta)
        if len(self.guesses):
            x = self.x[self.system._in_use]
            self.settings = settings_at(self.system, x, self.theta, 1e-300, self.guesses)
        return self.x

    def _first_guesses(self) -> np.ndarray:
        """Where the search for implicit quantities begins: start values given or declared."""
        implicit = {node: i for i, node in enumerate(self.system._values.implicit)}
        guesses = np.zeros(len(implicit))
        for values in (self._evaluated(self.system._flat.starts), self.given):
            for unknown, value in values.items():
                node = self.reduced.node(unknown)
                if node in implicit:
                    guesses[implicit[node]] = self._signed(unknown, value)
        return guesses

    def _meet(self, targets: dict[int, tuple[int, float]], fixed: dict[int, int]) -> None:
        """Newton iteration on the free states and parameters to meet the targets."""
        values, count = self.system._values, len(self.x)
        expression, theta = values.of(targets), self.system._inputs[1]
        unknowns = ca.vertcat(values.states, theta[self.free] if self.free else ca.SX(0, 1))
        function = ca.Function(
            "targets",
            [values.states, *self.system._inputs[1:]],
            [expression, ca.jacobian(expression, unknowns)],
        )
        wanted = np.array([v for _, v in targets.values()])
        scale = np.maximum(1.0, np.abs(wanted))
        columns: list[int] = []
        for iteration in range(50):
            if len(self.guesses):
                x = self.x[self.system._in_use]
                self.settings = settings_at(self.system, x, self.theta, 1e-300, self.guesses)
            value, jacobian = function(self.x, self.theta, 0.0, self.settings)
            miss = np.asarray(value).ravel() - wanted
            matrix = csc_array(jacobian.sparse())
            bad = ~(np.abs(miss) <= _TOLERANCE * scale)
            if iteration == 0 and self._leave_stationary(matrix, np.flatnonzero(bad), fixed):
                continue
            if not columns:
                columns, rows = self._free_columns(matrix, fixed)
            if not bad[rows].any():
                break
            if not np.isfinite(miss).all():
                break
            square = csc_array(matrix[rows][:, columns])
            step = np.zeros(count + len(self.free))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", MatrixRankWarning)
                step[columns] = np.atleast_1d(spsolve(square, miss[rows]))
            if not np.isfinite(step).all():
                break
            self.x -= step[:count]
            self.theta[self.free] -= step[count:]
        if bad.any():
            self._refuse(targets, miss, matrix, bad, rows, fixed)

    def _leave_stationary(
        self, matrix: csc_array, missed: np.ndarray, fixed: dict[int, int]
    ) -> bool:
        """Move free states off a point where a target does not react to them (a dead centre)."""
        entries = matrix.tocoo()
        free = ~np.isin(entries.col, list(fixed))
        moved = False
        for row in missed:
            own = free & (entries.row == row)
            states = entries.col[own & (entries.col < len(self.x))]
            if own.any() and not entries.data[own].any() and len(states):
                self.x[states] += 0.1
                moved = True
        return moved

    def _free_columns(
        self, matrix: csc_array, fixed: dict[int, int]
    ) -> tuple[list[int], np.ndarray]:
        coo = matrix.tocoo()
        rows: list[dict[int, tuple[float, int]]] = [{} for _ in range(matrix.shape[0])]
        for i, j, v in zip(coo.row.tolist(), coo.col.tolist(), coo.data.tolist(), strict=True):
            if j not in fixed and v:
                rows[i][j] = (v, CONSTANT)
        rank = np.array([self._rank(n) for n in self.reduced.states] + [-1] * len(self.free))
        chosen = select_dependent(rows, rank, np.arange(len(rank)))
        usable = np.setdiff1d(np.arange(matrix.shape[0]), chosen.unused)
        parameters = self.system._flat.parameters
        for k, place in enumerate(self.free):
            if len(self.x) + k not in chosen.dependent:
                name = parameters.names[parameters.free[place]]
                raise StartError(
                    f"The free parameter {name} is not determined by the start values. Give one "
                    "more start value that depends on it, for example an acceleration."
                )
        return chosen.dependent, usable

    def _rank(self, node: int) -> int:
        unknown = self.system._members.get(node)
        return RANK["avoid" if unknown is None else self.system._tree.quantity(unknown).wish]

    def _text(self, unknown: int) -> str:
        tree = self.system._tree
        unit = tree.quantity(unknown).unit
        return f"{tree.unknown_name(unknown)} = {self.given[unknown]:g} {unit}"

    def _refuse(
        self,
        targets: dict[int, tuple[int, float]],
        miss: np.ndarray,
        matrix: csc_array,
        bad: np.ndarray,
        searched: np.ndarray,
        fixed: dict[int, int],
    ) -> None:
        row = int(np.flatnonzero(bad)[0])
        unknown = list(targets.values())[row][0]
        if row in searched:
            raise StartError(
                f"No start state was found near the defaults with {self._text(unknown)}. Give "
                "start values of the angles or positions near the ones that are meant."
            )
        touching = matrix[[row]].tocoo()
        if not touching.nnz:
            value = self._signed(unknown, miss[row]) + self.given[unknown]
            raise StartError(
                f"{self._text(unknown)} cannot hold: supports, sources or loads of the model make "
                f"it {value:.6g} at the start. Remove the start value, or change them."
            )
        involved = [fixed[j] for j in touching.col.tolist() if j in fixed]
        involved += [u for u, _ in targets.values() if u != unknown]
        names = ", ".join(self._text(u) for u in involved[:6])
        raise StartError(
            f"Start values contradict each other: {self._text(unknown)} cannot hold together with "
            f"{names or 'the rest of the model'}. Give fewer start values, or make them fit."
        )
