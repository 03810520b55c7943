"""Derivatives of a run over its time, as a result."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple, Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.functionals import Functional
from lumped.gradients.varied import describe_shared, read_varied_values, resolve_name
from lumped.plots.draw import Canvas, draw
from lumped.plots.numbers import tornado
from lumped.support.arguments import checked
from lumped.support.by_name import find_place
from lumped.support.display_units import display
from lumped.support.ranking import list_largest, rank_by_size
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.timeloop.results.trajectory import Trajectory


class MovedInstant(NamedTuple):
    """An instant at which the run stopped.

    Attributes
    ----------
    time : float
        When, s.
    slopes : ndarray, shape (len(by),)
        Its derivatives; for parameters that grow, where those for shrinking ones differ.
    components : tuple of str
        What changes.
    left : ndarray or None, shape (len(by),)
        Derivatives for parameters that shrink, where these differ.
    """

    time: float
    slopes: np.ndarray
    components: tuple[str, ...]
    left: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Sensitivity(RichHtml):
    """Derivatives over the times of a run; ``found["b.w", "shaft.c"]`` gives one of them.

    Attributes
    ----------
    run : Trajectory
        The run itself.
    of, to : tuple of str
        What is differentiated, and by what.
    derivatives : ndarray, shape (len(run.t), len(of), len(by))
        The derivatives.
    instants : tuple of MovedInstant
        Each instant at which the run stopped, its derivatives, and the components that change.
    shared : tuple of float
        Instants at which statically indeterminate constraints let go, s. Derivatives hold the
        shares of what each carries fixed there, and are not exact if these depend on what varies.
    evaluations : int
        Evaluations of the right-hand side with its derivatives, after the run.
    rtol : float
        Accuracy asked for.
    functionals : tuple of str
        Functionals, as printed.
    values : ndarray, shape (len(functionals),)
        What they are.
    slopes : ndarray, shape (len(functionals), len(by))
        Their derivatives.
    units : tuple of str
        Units of the functionals.
    """

    run: Trajectory
    of: tuple[str, ...]
    by: tuple[str, ...]
    derivatives: np.ndarray
    instants: tuple[MovedInstant, ...]
    shared: tuple[float, ...]
    evaluations: int
    rtol: float
    functionals: tuple[str, ...] = ()
    values: np.ndarray = field(default_factory=lambda: np.zeros(0))
    slopes: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    units: tuple[str, ...] = ()

    @checked
    def __getitem__(self, pair: tuple[Name | Functional, Name]) -> np.ndarray | float:
        by, functional = resolve_name(self.run.system, pair[1]), str(pair[0])
        if functional in self.functionals and by in self.by:
            row = self.functionals.index(functional)
            return float(self.slopes[row, self.by.index(by)])
        of = self.run.system.key(pair[0])  # type: ignore[arg-type]
        places = [self._place(key, known) for key, known in ((of, self.of), (by, self.by))]
        return self.derivatives[:, places[0], places[1]]

    def _place(self, key: str, known: tuple[str, ...]) -> int:
        return find_place(key, known, "is not in this sensitivity")

    @checked
    def ranked(self, of: Name, *, at: float | None = None) -> list[tuple[str, float]]:
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
            If the quantity is zero there, to which nothing is relative, or the instant is not
            within the run.
        UnknownNameError
            If the quantity was not differentiated.
        """
        name, t = self.run.system.key(of), self.run.t
        place = self._place(name, self.of)
        if at is not None:
            self.run.check_instant(at)
        k = len(t) - 1 if at is None else int(np.abs(t - at).argmin())
        value = float(self.run[name][k])
        changes = self.derivatives[k, place] * read_varied_values(self.run, self.by)
        return rank_by_size(f"{name} at t = {self.run.t[k]:g} s", value, self.by, changes)

    @checked
    def plot(
        self,
        of: Name | None = None,
        *,
        at: float | None = None,
        **canvas: Unpack[Canvas],
    ) -> Any:
        """Tornado of what matters most to a quantity.

        Parameters
        ----------
        of : name, optional
            The quantity; default is the first.
        at : float, optional
            Instant, s; default is the end.
        backend, ax
            As in `lumped.Trajectory.plot`.
        """
        name = self.of[0] if of is None else self.run.system.key(of)
        time = self.run.t[-1] if at is None else at
        title = f"{self.run.system.name}: {name} at t = {time:g} s"
        return draw(tornado(self.ranked(name, at=at), title, name), **canvas)

    def __repr__(self) -> str:
        s, rows = self.run.statistics, []
        for i, name in enumerate(self.of[:12]):
            last = float(self.run[name][-1])
            text = "zero: nothing is relative to it"
            if last:
                text = list_largest((n, v) for n, v in self.ranked(name) if v)
            to_show = display(name, self.run.system.quantity(name).unit)
            largest = to_show.factor * float(np.abs(self.derivatives[:, i]).max(initial=0.0))
            cells = number(to_show.value(last), 9), to_show.unit, number(largest), text
            rows.append((name, *cells))
        head = (
            f"{self.run.system.name}: derivatives of {len(self.of)} quantities by {len(self.by)} "
            f"parameters and start values over {self.run.t[-1]:g} s; run of {s.steps} steps "
            f"({s.method}), {s.evaluations} evaluations, derivatives {self.evaluations} more, "
            f"rtol {self.rtol:.0e}, {len(self.instants)} instants of change crossed"
        )
        head += describe_shared(self.shared)
        columns = ("quantity", "at the end", "unit", "largest derivative", "relative at the end")
        text = f"{head}\n" + (table(columns, rows) if rows else "")
        if self.functionals:
            sums = []
            for label, unit, value, slopes in zip(
                self.functionals, self.units, self.values, self.slopes, strict=True
            ):
                to_show = display(label, unit)
                shares = (number(to_show.factor * float(v)) for v in slopes[:6])
                total = number(to_show.value(float(value)), 9)
                sums.append((label, total, to_show.unit, *shares))
            text += "\n" * bool(rows) + table(("functional", "value", "unit", *self.by[:6]), sums)
        return text
