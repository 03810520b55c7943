"""Initial states: start values and initial equations hold, declared defaults fill the rest."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from lumped.analysis.calls import Call
from lumped.analysis.changeover import Change, Settler
from lumped.analysis.machine import begun
from lumped.analysis.result import OperatingPoint
from lumped.analysis.settings import modes_at, settings_at
from lumped.analysis.targets import Targets
from lumped.arguments import checked
from lumped.errors import SolverError, StartError
from lumped.quantity import beyond
from lumped.system import Changes, Name, System
from lumped.units import plain

__all__ = ["StartForm", "start_form", "start_point", "start_slopes"]


@checked
def start_point(
    system: System,
    parameters: Changes | None = None,
    start: Changes | None = None,
    free: Iterable[Name] = (),
) -> OperatingPoint:
    """States at the time zero.

    Start values given to instances (``Inertia(J=1, w=100)``), those in `start`, and the
    ``initial_equations`` of components hold exactly. States that they do not determine take their
    declared defaults; where a given quantity is not itself a state, the least wanted states follow
    from it. For a quantity that a closed linkage determines, the start value is where the search
    begins, and so chooses the assembly. Where bodies collide at once, the start values are those
    before the impact, and the states those after it.

    Newton's method starts from the defaults. If it fails, the wanted values are approached step by
    step from those that the quantities have there.

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
        If start values and initial equations contradict each other, do not determine a free
        parameter, or put bodies inside each other.
    OptionError
        If `start` is no mapping.
    """
    theta = system.theta(parameters)
    begin = _Start(system, theta, start or {}, system.places(free))
    x, settings = begin.solve()[system._in_use], begin.settings
    collisions: tuple[Change, ...] = ()
    if system.switching:
        found = begun(system, begin.theta, x, settings)
        if found is not None:
            return OperatingPoint(system, 0.0, found[0], begin.theta, found[1])
        count = len(settings) - len(system._values.implicit)
        settler = Settler(system, begin.theta, 1.0)
        try:
            x, modes, collisions = settler.begin(0.0, x, settings[:count], settings[count:])
        except SolverError as error:
            raise StartError(str(error)) from None
        settings = np.concatenate([modes, settings[count:]])
    return OperatingPoint(system, 0.0, x, begin.theta, settings, collisions)


def start_slopes(
    system: System,
    theta: np.ndarray,
    start: Changes,
    seed: np.ndarray,
    varied: Mapping[int, np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """States at the time zero, before any impact there, and their derivatives.

    Parameters
    ----------
    seed : ndarray, shape (parameters, k)
        Derivatives of the parameters.
    varied : mapping of int to ndarray, shape (k,)
        Derivatives of start values of unknowns; each is given or a state.

    Returns
    -------
    ndarray, shapes (n,) and (n, k)
    """
    begin = _Start(system, theta, start, [])
    x = begin.solve()
    return x[system._in_use], begin.slopes(x, seed, varied)[system._in_use]


@dataclass(frozen=True, eq=False)
class StartForm:
    """States at the time zero as expressions of the parameters, before any impact there.

    Attributes
    ----------
    states : SX, shape (all states, 1)
        Those that are given or take their defaults; numbers for those that must be searched for.
    miss : SX
        What must vanish: targets less what is wanted, relative to that if it is above one;
        expressions of all states, parameters, time and settings.
    rows, columns : list of int
        Targets and states of a regular system of as many equations as states.
    guesses : ndarray
        Where the search for implicit quantities begins.
    """

    states: ca.SX
    miss: ca.SX
    rows: list[int]
    columns: list[int]
    guesses: np.ndarray


def start_form(system: System, start: Changes) -> StartForm:
    """How the states at the time zero follow from the parameters; some start values are set."""
    begin = _Start(system, system.theta(None), start, [])
    x, flat, reduced = begin.solve(), system._flat, begin.reduced

    def signed(unknown: int) -> ca.SX:
        given = begin.given if unknown in begin.changed else {**flat.starts, **flat.given}
        return float(reduced.aliases.signs[unknown]) * ca.SX(given[unknown])

    states = ca.SX.zeros(len(x))
    for unknown in (*flat.starts, *(u for u, _ in begin.fixed.values())):
        node = reduced.node(unknown)
        if node in begin.position:
            states[begin.position[node]] = signed(unknown)
    guesses = begin.settings[len(begin.settings) - len(begin.guesses) :]
    if begin.search is None:
        return StartForm(states, ca.SX(0, 1), [], [], guesses)
    rows, columns = begin.search.regular(x)
    states[columns] = ca.DM(x[columns])
    wanted = ca.SX.zeros(begin.search.value.numel())
    for i, (unknown, _) in enumerate(begin.targets.values()):
        wanted[i] = signed(unknown)
    miss = (begin.search.value - wanted) / ca.fmax(1, ca.fabs(wanted))
    return StartForm(states, miss, rows, columns, guesses)


class _Start:
    def __init__(self, system: System, theta: np.ndarray, start: Changes, free: list[int]) -> None:
        self.system, self.theta, self.free = system, theta, free
        self.reduced = system._reduced
        self.position = {n: i for i, n in enumerate(self.reduced.states)}
        given, self.starts = self._evaluated()
        for name, value in start.items():
            unknown = system._tree.unknown(name)
            unit = system._tree.quantity(unknown).unit
            given[unknown] = plain(value, unit, f"{system.key(name)} =", StartError)
        self.given, self.changed = given, {system._tree.unknown(name) for name in start}
        for unknown, number in given.items():
            why = beyond(number)
            if why is not None:
                raise StartError(f"{self._text(unknown)}: a start value {why}.")
        self.guesses = self._first_guesses()
        self.settings = np.concatenate([modes_at(system, theta, 1e-300), self.guesses])
        self.x = np.zeros(len(self.reduced.states))
        for unknown, value in self.starts.items():
            node = self.reduced.node(unknown)
            if node in self.position:
                self.x[self.position[node]] = self._signed(unknown, value)

    def _evaluated(self) -> tuple[dict[int, float], dict[int, float]]:
        """Start values given to instances, and those of declarations."""
        flat, made = self.system._flat, self.system.made
        if "starts" not in made:
            both = ca.vertcat(ca.SX(0, 1), *flat.given.values(), *flat.starts.values())
            inputs = [flat.parameters.theta]
            made["starts"] = Call(ca.Function("starts", inputs, [ca.densify(both)]))
        numbers = made["starts"](self.theta)[0].tolist()
        count = len(flat.given)
        return (
            dict(zip(flat.given, numbers[:count], strict=True)),
            dict(zip(flat.starts, numbers[count:], strict=True)),
        )

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
        self.fixed, self.targets = fixed, targets
        self.search: Targets | None = None
        for node, (_, value) in fixed.items():
            self.x[self.position[node]] = value
        if targets or self.free or self.system._flat.initial:
            held = {self.position[n]: u for n, (u, _) in fixed.items()}
            self.search = Targets(
                self.system, targets, held, self.free, self.settings, self.guesses, self._text
            )
            self.x, self.theta = self.search.meet(self.x, self.theta)
            if self.free:
                self.system.check_parameters(self.theta)
        if len(self.guesses):
            x = self.x[self.system._in_use]
            self.settings = settings_at(self.system, x, self.theta, 1e-300, self.guesses)
        return self.x

    def slopes(
        self, x: np.ndarray, seed: np.ndarray, varied: Mapping[int, np.ndarray]
    ) -> np.ndarray:
        """Derivatives of the states found (see `start_slopes`)."""
        flat, signs = self.system._flat, self.reduced.aliases.signs
        values, p = {**flat.starts, **flat.given}, flat.parameters.theta
        made = self.system.made
        if "start slopes" not in made:
            column = ca.vertcat(ca.SX(0, 1), *values.values())
            made["start slopes"] = ca.Function("slopes", [p], [ca.jacobian(column, p)])
        found = made["start slopes"](self.theta).sparse() @ seed
        none = np.zeros(seed.shape[1])
        rows = {**dict(zip(values, found, strict=True)), **dict.fromkeys(self.changed, none)}
        rows.update(varied)
        S = np.zeros((len(x), seed.shape[1]))
        for unknown in (*flat.starts, *varied):
            node = self.reduced.node(unknown)
            if node in self.position:
                S[self.position[node]] = signs[unknown] * rows[unknown]
        for node, (unknown, _) in self.fixed.items():
            S[self.position[node]] = signs[unknown] * rows[unknown]
        if self.search is None:
            return S
        wanted = [signs[unknown] * rows[unknown] for unknown, _ in self.targets.values()]
        return self.search.slopes(x, S, seed, np.array(wanted).reshape(-1, seed.shape[1]))

    def _first_guesses(self) -> np.ndarray:
        """Where the search for implicit quantities begins: start values given or declared."""
        implicit = {node: i for i, node in enumerate(self.system._values.implicit)}
        guesses = np.zeros(len(implicit))
        for values in (self.starts, self.given) if implicit else ():
            for unknown, value in values.items():
                node = self.reduced.node(unknown)
                if node in implicit:
                    guesses[implicit[node]] = self._signed(unknown, value)
        return guesses

    def _text(self, unknown: int) -> str:
        tree = self.system._tree
        unit = tree.quantity(unknown).unit
        return f"{tree.unknown_name(unknown)} = {self.given[unknown]:g} {unit}"
