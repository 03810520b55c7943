"""Derivatives of a run by parameters and start values, exact across events."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from lumped.analysis.forward import Forward
from lumped.analysis.result import Trajectory
from lumped.analysis.simulate import simulate
from lumped.analysis.start import start_slopes
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
    return _Varied(system, tuple(of), tuple(to), start or {}, rtol).go(
        simulate(system, until=until, parameters=parameters, start=start, grid=grid, rtol=rtol)
    )


class _Varied:
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
        self.given = start
        self.places, self.varied = self._sources(start)
        # each column is scaled by the size of what it is differentiated by
        defaults = system._flat.parameters.defaults
        self.scale = np.array([abs(defaults[i]) if i >= 0 else 1.0 for i in self.places])
        self.scale[self.scale == 0] = 1.0
        self.seed = np.zeros((len(defaults), self.k))
        for column, place in enumerate(self.places):
            if place >= 0:
                self.seed[place, column] = self.scale[column]

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

    def go(self, run: Trajectory) -> Sensitivity:
        """Follow the derivatives along the pieces of a run."""
        forward = Forward(self.system, self.seed, self.rtol)
        courses, instants = forward.courses(run, self._start(run))
        values = forward.along(run, courses, self.of) / self.scale
        at = tuple((t, t_p / self.scale) for t, t_p in instants)
        return Sensitivity(run, self.of, self.to, values, at)
