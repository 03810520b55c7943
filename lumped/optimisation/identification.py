"""Parameters that fit measured curves, and how well these tell them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np

from lumped.plots.draw import Canvas, draw
from lumped.plots.picture import Axis, Curve, Level, Panel, Picture, label_axis
from lumped.plots.style import ZERO, look
from lumped.simulation.simulate import places_of
from lumped.support.arguments import checked
from lumped.support.display_units import Units, choose_units, display, time_unit
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, table
from lumped.timeloop.results.trajectory import Trajectory

_POINTS = {"dash": "", "mark": "circle", "size": 2.5}


@dataclass(frozen=True, eq=False)
class Identification(RichHtml):
    """Parameters that fit measured curves best.

    Attributes
    ----------
    run : Trajectory
        The run with these parameters.
    parameters, start : dict of str to float
        Values found, and those at which the search began.
    covariance : ndarray, shape (p, p)
        Of the parameters in this order; infinite on the diagonal for those of `unknown`.
    level : float
        Probability of `intervals`.
    intervals : dict of str to (float, float)
        Confidence intervals of single parameters, from the linearised model.
    correlation : ndarray, shape (p, p)
        Correlation coefficients; nan where not identified.
    singular_values : ndarray, shape (p,)
        Of the weighted derivatives by relative changes, the largest first.
    unknown : tuple of str
        Parameters that the curves do not tell: changed together in some ratio they have no effect.
    t : ndarray, shape (n,)
        Instants of the measurement, s.
    residuals : dict of str to ndarray
        Measured less computed at these instants.
    deviation : float
        Root of the weighted sum of squares over the degrees of freedom: 1 if model, `sigma` and
        noise agree; without `sigma` the relative noise.
    bounded : tuple of str
        Parameters at a bound, for which the interval does not hold.
    doubts : tuple of str
        Why no interval may hold: residuals far above `sigma`, or residuals that are no noise, as in
        a local minimum or where the model cannot follow the curves.
    others : tuple of (float, dict of str to float)
        Other minima that searches found: the deviation and the values of each, the best first.
    status : str
        Why the search ended.
    iterations, evaluations : int
        Jacobians and runs.
    residual : float
        Greatest slope of the sum of squares that is left, relative to that at the start.
    seconds : float
        Wall time.
    """

    run: Trajectory
    parameters: dict[str, float]
    start: dict[str, float]
    covariance: np.ndarray
    level: float
    intervals: dict[str, tuple[float, float]]
    correlation: np.ndarray
    singular_values: np.ndarray
    unknown: tuple[str, ...]
    t: np.ndarray
    residuals: dict[str, np.ndarray]
    deviation: float
    bounded: tuple[str, ...]
    doubts: tuple[str, ...]
    others: tuple[tuple[float, dict[str, float]], ...]
    status: str
    iterations: int
    evaluations: int
    residual: float
    seconds: float

    @property
    def condition(self) -> float:
        """Largest over smallest singular value."""
        s = self.singular_values
        return float(s[0] / s[-1]) if s[-1] > 0 else float("inf")

    @checked
    def plot(self, *, units: Units = None, **canvas: Unpack[Canvas]) -> Any:
        """Measured points, the fitted curve and the residuals, two panels for each channel.

        Parameters
        ----------
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend : {"matplotlib", "plotly"}
            What draws; plotly makes an interactive figure.
        ax : matplotlib Axes, or an array of as many as there are panels, optional
            Where matplotlib draws; default is a new figure, which needs no display.

        Returns
        -------
        matplotlib.figure.Figure or plotly.graph_objects.Figure

        Raises
        ------
        OptionError
            If plotly is not installed, or `ax` does not fit.
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        choice = choose_units(units, ("time", *self.residuals))
        return draw(self._picture(choice), **canvas)

    def _picture(self, choice: Units) -> Picture:
        """Measured points and the fitted curve, and below them what is left, for each channel."""
        run, time, panels = self.run, time_unit(choice), []
        x, places = Axis(label_axis("time", time.unit)), places_of(run, self.t)
        t = time.value(self.t)
        for name, rest in self.residuals.items():
            fitted, shown = run[name], display(name, run.system.quantity(name).unit, choice)
            measured = Curve(t, shown.value(fitted[places] + rest), "measured", look(1, **_POINTS))
            curves = measured, Curve(time.value(run.t), shown.value(fitted), "fitted", look(0))
            left = Level(0.0, look=ZERO), Curve(t, rest * shown.factor, "", look(1, **_POINTS))
            panels.append(Panel(curves, x, Axis(label_axis(name, shown.unit)), height=2.2))
            panels.append(Panel(left, x, Axis(label_axis("residual", shown.unit)), height=1.3))
        return Picture(run.system.name, tuple(panels), shared=True)

    def __repr__(self) -> str:
        system, rows = self.run.system, []
        for name, value in self.parameters.items():
            unit = (
                system.parameter_unit(name)
                if name in system.parameters
                else system.quantity(name).unit
            )
            begin, low, high, to_show = amounts(name, unit, self.start[name], *self.intervals[name])
            note = "not identified" if name in self.unknown else f"{low} .. {high}"
            if name in self.bounded:
                note += " (at its bound)"
            found, _ = amounts(name, unit, value, digits=8)
            rows.append((name, begin, found, note, to_show))
        lines = [
            f"{system.name}: {self.status}; {self.iterations} iterations, {self.evaluations} runs, "
            f"{self.seconds:.2g} s",
            f"slope left {self.residual:.1e}, condition {self.condition:.1e}, deviation "
            f"{self.deviation:.4g}",
            table(("parameter", "start", "found", f"{100 * self.level:g} %", "unit"), rows),
        ]
        if self.doubts:
            lines.append(
                f"doubtful: {'; '.join(self.doubts)}. The intervals do not hold where this is a "
                "local minimum or the model cannot follow the curves: begin elsewhere, and look at "
                "the residuals."
            )
        if self.unknown:
            lines.append(
                f"not told by these curves: {', '.join(self.unknown)}. Hold one of them, or "
                "measure more."
            )
        pairs = [
            (abs(self.correlation[i, j]), a, b, self.correlation[i, j])
            for i, a in enumerate(self.parameters)
            for j, b in enumerate(self.parameters)
            if i < j and abs(self.correlation[i, j]) > 0.9
        ]
        for _, a, b, value in sorted(pairs, reverse=True)[:6]:
            lines.append(f"correlated: {a} and {b}, {value:+.4f}")
        return "\n".join(lines)
