"""Result of a reliability analysis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, Unpack

import numpy as np
import scipy

from lumped.errors import OptionError, UnknownNameError, nearest
from lumped.plots.draw import Canvas, draw
from lumped.plots.numbers import exceedance, importance_factors
from lumped.plots.picture import label_axis
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.display_units import Units, choose_units, display
from lumped.support.ranking import rank
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.tolerances.failure.form import DesignPoint
from lumped.tolerances.failure.samples import Level, Sampled
from lumped.tolerances.failure.sorm import Curved

Kind = Literal["mean", "deviation", "value"]
"""What of a parameter changes."""

_PLANE = 1e-9
"""Curvature that is rounding."""
_METHODS = {
    "form": "first order (FORM)",
    "sorm": "second order (SORM)",
    "importance": "samples around the design points",
    "subset": "subset simulation",
}


class Influence(NamedTuple):
    """How beta changes with a mean, a standard deviation or the value of a parameter.

    Attributes
    ----------
    name : str
        The parameter.
    of : {"mean", "deviation", "value"}
        What changes: its mean, with which the whole distribution is shifted; its standard
        deviation, with which the distribution is stretched about its mean; or the value of a
        parameter that does not scatter.
    size : float
        Standard deviation of the parameter, or size of its value, in SI units.
    beta : float
        Derivative of beta of the nearest design point.
    probability : float
        Derivative of the probability, to first order.
    """

    name: str
    of: Kind
    size: float
    beta: float
    probability: float


@dataclass(frozen=True, eq=False)
class Reliability(RichHtml):
    """How likely a limit is passed, and by which combination of parameters most likely.

    Attributes
    ----------
    system : str
        Name of the system.
    event : str
        What happens, in words.
    label, unit : str
        The functional, and its unit.
    bound : float
        The limit.
    method : str
        How the probability was found.
    names, units : tuple of str
        Parameters that scatter, d of them, and their SI units.
    means, deviations : ndarray, shape (d,)
        Of their distributions.
    sampled : Sampled
        The probability, and what is known of its error.
    points : tuple of DesignPoint
        Design points, the nearest to the median first; none with subset simulation.
    importance : ndarray, shape (d,)
        Share of each parameter at the nearest design point, negative where a smaller value leads to
        the limit; sizes add up to 1.
    influences : tuple of Influence
        Derivatives at the design points.
    second_order : tuple of Curved
        The limit at each design point to second order, if that was asked for.
    evaluations, gradients : int
        Runs or analyses, and those of them with derivatives.
    """

    system: str
    event: str
    label: str
    unit: str
    bound: float
    method: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    means: Real
    deviations: Real
    sampled: Sampled
    points: tuple[DesignPoint, ...]
    importance: Real
    influences: tuple[Influence, ...]
    second_order: tuple[Curved, ...]
    evaluations: int
    gradients: int

    @property
    def probability(self) -> float:
        """That the limit is passed."""
        return self.sampled.probability

    @property
    def interval(self) -> tuple[float, float] | None:
        """Of 95 % of the probability; None where nothing was sampled."""
        return self.sampled.interval

    @property
    def beta(self) -> float:
        """Reliability index that belongs to the probability; of a plane limit the distance."""
        return float(-scipy.special.ndtri(self.probability))

    @property
    def notes(self) -> tuple[str, ...]:
        """What speaks against the result."""
        return self.sampled.notes

    @property
    def levels(self) -> tuple[Level, ...]:
        """Those of subset simulation."""
        return self.sampled.levels

    @property
    def design_point(self) -> dict[str, float]:
        """The most likely combination of parameters at the limit, in SI units.

        Raises
        ------
        OptionError
            If there is none, with subset simulation or at a kink.
        """
        return dict(zip(self.names, self._nearest().x.tolist(), strict=True))

    def influence(self, name: str, of: Kind = "mean") -> Influence:
        """Derivatives by one parameter.

        Parameters
        ----------
        name : str
            The parameter.
        of : {"mean", "deviation", "value"}
            See `Influence`; "value" for those in `by`.

        Raises
        ------
        OptionError
            If there is no design point.
        UnknownNameError
            If it is none of these.
        """
        self._nearest()
        known = {one.name: one for one in self.influences if one.of == of}
        if name not in known:
            raise UnknownNameError(
                f"reliability: there is no derivative by the {of} of '{name}'. "
                f"{nearest(name, known)}"
            )
        return known[name]

    def _nearest(self) -> DesignPoint:
        if not self.points:
            raise OptionError(
                f"reliability: {self.event}: there is no design point with search="
                f"'{self.method}'. {self.notes[0] if self.notes else ''} Take search='form'."
            )
        return self.points[0]

    @checked
    def plot(self, *, units: Units = None, **canvas: Unpack[Canvas]) -> Any:
        """Importance factors at the nearest design point, or the levels of subset simulation.

        Parameters
        ----------
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        OptionError
            If there is neither.
        UnitError
            If a unit does not fit.
        """
        head = f"{self.event}: probability {self.probability:.3g}"
        if self.levels:
            shown = display(self.label, self.unit, choose_units(units, [self.label]))
            rows = np.array([(shown.value(one.value), one.probability) for one in self.levels])
            what = label_axis(self.label, shown.unit)
            bound = shown.value(self.bound)
            return draw(exceedance(head, what, (rows[:, 0], rows[:, 1]), bound), **canvas)
        self._nearest()
        return draw(importance_factors(head, rank(self.names, self.importance)), **canvas)

    def __repr__(self) -> str:
        own = f"probability {number(self.probability, 4)}, beta = {number(self.beta, 4)}"
        lines = [
            f"{self.system}: {self.event}: {own}; {_METHODS[self.method]}",
            f"{self.evaluations} evaluations, {self.gradients} of them with derivatives",
        ]
        if self.sampled.interval is not None:
            low, high = (number(p, 3) for p in self.sampled.interval)
            lines.append(
                f"95 %: {low} to {high}, coefficient of variation {self.sampled.deviation:.2g}"
            )
        if self.sampled.failed:
            lines.append(
                f"{self.sampled.failed} evaluations failed, with a probability of "
                f"{self.sampled.unknown:.2g}; the upper end of the interval takes them as beyond "
                "the limit"
            )
        for one in self.second_order:
            bends = ", ".join(number(k if abs(k) > _PLANE else 0.0, 3) for k in one.curvatures)
            lines.append(
                f"Breitung {number(one.breitung, 4)}, Hohenbichler and Rackwitz "
                f"{number(one.hohenbichler, 4)}, Tvedt {number(one.tvedt, 4)}; curvatures {bends} "
                f"by {one.source}"
            )
        if len(self.points) > 1:
            far = ", ".join(number(point.beta, 4) for point in self.points)
            lines.append(f"{len(self.points)} design points, beta = {far}; below is the nearest")
        lines += self.notes
        return "\n".join([*lines, *self._tables()])

    def _tables(self) -> list[str]:
        found = []
        if self.points:
            head = (
                "parameter", "mean", "at the limit", "unit", "importance, %", "beta by mean",
                "by deviation",
            )  # fmt: skip
            found.append(table(head, [self._row(i) for i in range(len(self.names))]))
            found.append("derivatives of beta are for one standard deviation of the parameter")
        rows = [
            (one.name, *(number(0.01 * one.size * v + 0.0, 3) for v in (one.beta, one.probability)))
            for one in self.influences
            if one.of == "value"
        ]
        if rows:
            found.append(table(("1 % more of", "beta", "probability"), rows))
        if self.levels:
            columns = ("level", self.label, "unit", "probability", "moves accepted")
            found.append(table(columns, [self._level(i) for i in range(len(self.levels))]))
        return found

    def _row(self, i: int) -> tuple[str, ...]:
        name, unit = self.names[i], self.units[i]
        mean, there, shown = amounts(
            name, unit, float(self.means[i]), float(self.points[0].x[i]), digits=5
        )
        changes: Mapping[str, Influence] = {
            one.of: one for one in self.influences if one.name == name
        }
        by = [
            number(changes[of].beta * float(self.deviations[i]), 3) for of in ("mean", "deviation")
        ]
        return name, mean, there, shown, f"{100 * abs(self.importance[i]):.1f}", *by

    def _level(self, i: int) -> tuple[str, ...]:
        level = self.levels[i]
        value, unit = amounts(self.label, self.unit, level.value, digits=5)
        return str(i + 1), value, unit, number(level.probability, 3), f"{level.accepted:.0%}"
