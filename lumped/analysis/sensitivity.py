"""Derivatives of a run by parameters and start values, exact across events."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lumped.analysis.forward import Forward
from lumped.analysis.ranking import ranked
from lumped.analysis.result import Trajectory
from lumped.analysis.simulate import simulate
from lumped.analysis.varied import slopes_at_zero, sources, varied_values
from lumped.errors import OptionError
from lumped.system import Changes, Name, System
from lumped.table import number, table
from lumped.units import in_seconds

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Sensitivity", "Varied", "sensitivity"]


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
    shared : tuple of float
        Instants at which statically indeterminate constraints let go, s. Derivatives hold the
        shares of what each carries fixed there, and are not exact if these depend on what varies.
    evaluations : int
        Evaluations of the right-hand side with its derivatives, after the run.
    rtol : float
        Tolerance under which run and derivatives were integrated.
    """

    run: Trajectory
    of: tuple[str, ...]
    to: tuple[str, ...]
    values: np.ndarray
    instants: tuple[tuple[float, np.ndarray], ...]
    shared: tuple[float, ...]
    evaluations: int
    rtol: float

    def __getitem__(self, pair: tuple[Name, Name]) -> np.ndarray:
        of, to = (self.run.system.key(name) for name in pair)
        found: np.ndarray = self.values[:, self.of.index(of), self.to.index(to)]
        return found

    def ranked(self, of: Name, at: float | None = None) -> list[tuple[str, float]]:
        """Names and relative sensitivities ``p/y dy/dp`` of a quantity, the largest first.

        Parameters
        ----------
        of : name
            The quantity.
        at : float, optional
            Instant, s; the output time next to it is taken. Default is the end.

        Raises
        ------
        OptionError
            If the quantity is zero there, to which nothing is relative.
        """
        name = self.run.system.key(of)
        k = len(self.run.t) - 1 if at is None else int(np.abs(self.run.t - at).argmin())
        value = float(self.run[name][k])
        slopes = self.values[k, self.of.index(name)]
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = slopes * varied_values(self.run, self.to) / value
        return ranked(f"{name} at t = {self.run.t[k]:g} s", value, self.to, relative)

    def plot(self, of: Name | None = None, at: float | None = None) -> Figure:
        """Tornado of what matters most to a quantity (see `lumped.plot.tornado`)."""
        from lumped.plot import tornado

        name = self.of[0] if of is None else self.run.system.key(of)
        time = self.run.t[-1] if at is None else at
        title = f"{self.run.system.name}: {name} at t = {time:g} s"
        return tornado(self.ranked(name, at), title, name)

    def __repr__(self) -> str:
        s, rows = self.run.statistics, []
        for i, name in enumerate(self.of[:12]):
            last = float(self.run[name][-1])
            text = "zero: nothing is relative to it"
            if last:
                text = "; ".join(f"{n} {v:+.4f}" for n, v in self.ranked(name)[:4] if v)
            largest = np.abs(self.values[:, i]).max(initial=0.0)
            rows.append((name, number(last, 9), number(float(largest)), text))
        head = (
            f"{self.run.system.name}: derivatives of {len(self.of)} quantities by {len(self.to)} "
            f"parameters and start values over {self.run.t[-1]:g} s; run of {s.steps} steps "
            f"({s.method}), {s.evaluations} evaluations, derivatives {self.evaluations} more, "
            f"rtol {self.rtol:.0e}, {len(self.instants)} instants of change crossed"
        )
        if self.shared:
            head += "\nshares of indeterminate constraints held fixed where they let go, t = "
            head += ", ".join(f"{t:.6g} s" for t in self.shared[:6])
        columns = ("quantity", "at the end", "largest derivative", "relative at the end")
        return f"{head}\n" + table(columns, rows)


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
    until = in_seconds(until, "until")
    if not (grid is None or isinstance(grid, int)):
        raise OptionError(
            f"sensitivity: grid = {grid!r}: a number of intervals is needed, or None for the steps "
            "of the solver."
        )
    return Varied(system, tuple(of), tuple(to), start or {}, rtol).go(
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


class Varied:
    """Derivatives of runs that differ in their parameters only; arguments as for `sensitivity`."""

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
        self.places, self.varied = sources(system, self.to, start)
        # each column is scaled by the size of what it is differentiated by
        defaults = system._flat.parameters.defaults
        self.scale = np.array([abs(defaults[i]) if i >= 0 else 1.0 for i in self.places])
        self.scale[self.scale == 0] = 1.0
        self.seed = np.zeros((len(defaults), self.k))
        for column, place in enumerate(self.places):
            if place >= 0:
                self.seed[place, column] = self.scale[column]
        self.forward = Forward(system, self.seed, rtol)

    def go(self, run: Trajectory) -> Sensitivity:
        """Follow the derivatives along the pieces of a run."""
        before = self.forward.evaluations
        begin = slopes_at_zero(run, self.given, self.seed, self.varied)
        courses, instants = self.forward.courses(run, begin)
        values = self.forward.along(run, courses, self.of) / self.scale
        at = tuple((i.t, i.slopes / self.scale) for i in instants)
        shared = tuple(i.t for i in instants if i.shared)
        cost = self.forward.evaluations - before
        return Sensitivity(run, self.of, self.to, values, at, shared, cost, self.rtol)
