"""How results scatter with tolerances."""

from __future__ import annotations

import time as clock
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Unpack

import numpy as np

from lumped.ensembles.outcome import list_reasons
from lumped.ensembles.variants import Over, Sampling
from lumped.errors import Interrupted, OptionError, SolverError, UnknownNameError, nearest
from lumped.plots.draw import Canvas, draw
from lumped.plots.numbers import spreads_picture
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.by_name import ByName
from lumped.support.display_units import Units, choose_units, display
from lumped.support.optional_packages import extra
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table
from lumped.timeloop.run_options import RunOptions
from lumped.tolerances.evaluated import Failures
from lumped.tolerances.expansions.by_derivatives import by_derivatives
from lumped.tolerances.expansions.chaos import by_chaos
from lumped.tolerances.intervals import Quantile
from lumped.tolerances.scene import Scattered, Scene, scene_of
from lumped.tolerances.spread import SampledSpread, Spread, Spreads

_RUNS = {"samples": 1000, "derivatives": 64, "chaos": 200}
_TOLD = (0.01, 0.5, 0.99)
_MOST = 5
"""Parameters that are told of each functional."""


@dataclass(frozen=True, eq=False)
class Scatter(ByName, RichHtml):
    """Distributions of functionals; ``found[label]`` is one of them (see `Spread`).

    Attributes
    ----------
    title : str
        Name of the system.
    method : str
        How they were found.
    names : tuple of str
        Parameters that scatter.
    spreads : dict of str to Spread
        How each functional scatters, by its label.
    points, values : ndarray, shapes (n, d) and (n, k)
        Parameters and functionals of the runs that were made, nan where one has no value: the
        sample, the check of derivatives, or what polynomials were fitted to.
    failures : dict of int to str
        Why functionals have no value, by the number of the run.
    notes : tuple of str
        What else must be known.
    seconds : float
        Wall time.
    """

    title: str
    method: str
    names: tuple[str, ...]
    spreads: dict[str, Spread]
    points: Real
    values: Real
    failures: Failures
    notes: tuple[str, ...]
    seconds: float

    @checked
    def __getitem__(self, label: str) -> Spread:
        if label not in self.spreads:
            raise UnknownNameError(f"'{label}' was not asked for. {nearest(label, self.spreads)}")
        return self.spreads[label]

    def _names(self) -> Sequence[str]:
        return tuple(self.spreads)

    @checked
    def plot(
        self,
        labels: Sequence[str] | None = None,
        *,
        units: Units = None,
        **canvas: Unpack[Canvas],
    ) -> Any:
        """Histograms with quantiles and their intervals, and shares of parameters in the variance.

        Parameters
        ----------
        labels : sequence of str, optional
            Of the functionals; default is all.
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        choice = choose_units(units, self.spreads)
        shown: dict[str, Any] = {}
        for label in self.spreads if labels is None else labels:
            own = self[label]
            to_show = display(label, own.unit, choice)
            quantiles = [
                (q, *(to_show.value(v) for v in found))
                for q in _TOLD
                if (found := _find_quantile(own, q)) is not None
            ]
            values = to_show.value(own.sample())
            shown[label] = to_show.unit, values, quantiles, own.ranking
        return draw(spreads_picture(self.title, shown), **canvas)

    def to_pandas(self, *, units: Units = None) -> Any:
        """A DataFrame with one row for each functional: moments, and quantiles with intervals.

        Parameters
        ----------
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.

        Raises
        ------
        OptionError
            If pandas is not installed.
        UnitError
            If a unit does not fit.
        """
        pandas = extra("pandas", "data", "to_pandas")
        choice, rows = choose_units(units, self.spreads), []
        for label, own in self.spreads.items():
            to_show = display(label, own.unit, choice)
            change = display(label, own.unit, choice, is_change=True)
            row: dict[str, Any] = {"mean": to_show.value(own.mean), "std": change.value(own.std)}
            row |= {"skewness": own.skewness, "unit": to_show.unit}
            for q in _TOLD:
                found = _find_quantile(own, q) or Quantile(np.nan, np.nan, np.nan)
                for what, value in zip(("", " low", " high"), found, strict=True):
                    row[f"{100 * q:g} %{what}"] = to_show.value(value)
            rows.append(row)
        return pandas.DataFrame(rows, index=pandas.Index(self.spreads, name="functional"))

    def __repr__(self) -> str:
        head = (
            f"{self.title}: scatter of {len(self.spreads)} functionals by {len(self.names)} "
            f"parameters, by {self.method}; {len(self.points)} runs, {len(self.failures)} without "
            f"a value; {self.seconds:.3g} s"
        )
        rows = []
        for label, own in self.spreads.items():
            mean, unit = amounts(label, own.unit, own.mean, digits=5)
            std, _ = amounts(label, own.unit, own.std, digits=4, is_change=True)
            cells = [_format_quantile(label, own.unit, _find_quantile(own, q)) for q in _TOLD]
            rows.append((label, mean, std, number(own.skewness, 3), *cells, unit))
        columns = [f"{100 * q:g} %" for q in _TOLD]
        lines = [
            head,
            table(("functional", "mean", "deviation", "skewness", *columns, "unit"), rows),
        ]
        lines.append("quantiles with intervals of 95 %; share of the variance by each alone:")
        for label, own in self.spreads.items():
            known = [(name, share) for name, share in own.ranking if np.isfinite(share)]
            most = ", ".join(f"{name} {share:.3f}" for name, share in known[:_MOST])
            told = most or "there is no variance that could be shared"
            lines.append("; ".join([f"{label}: {told}", *filter(None, [own.trust()])]))
            if own.missing is not None and own.missing.value:
                value, low, high = (f"{100 * part:.3g}" for part in own.missing)
                lines.append(f"{label}: no value in {value} % ({low} to {high}) of the runs")
        return "\n".join([*lines, *list_reasons(self.failures), *self.notes])


def _find_quantile(own: Spread, q: float) -> Quantile | None:
    """A quantile, where there is one."""
    try:
        return own.quantile(q)
    except OptionError:
        return None


def _format_quantile(label: str, unit: str, found: Quantile | None) -> str:
    """A quantile with its interval."""
    if found is None:
        return "-"
    value, low, high, _ = amounts(label, unit, *found, digits=5)
    low = "-" if np.isinf(found.low) else low
    high = "-" if np.isinf(found.high) else high
    return f"{value} ({low} to {high})"


@checked
def scatter(
    what: Scattered,
    *,
    over: Over,
    of: Any,
    search: Literal["samples", "derivatives", "chaos"] = "samples",
    runs: int | None = None,
    seed: int = 0,
    sampling: Sampling | None = None,
    gradients: bool = True,
    until: float | str | None = None,
    rtol: float = 1e-6,
    workers: int | None = None,
    **options: Unpack[RunOptions],
) -> Scatter:
    """How results scatter with tolerances: moments, quantiles, shares beyond limits, ranking.

    By samples: the runs of `ensemble`, or modes and order responses of as many designs. Quantiles
    have intervals from order statistics, shares those of Clopper and Pearson, for independent
    runs; other samplings lie closer. By derivatives: functionals are expanded to second order about
    the mean, by differences of exact gradients; a few runs tell how much that misses.
    By polynomial chaos: orthonormal polynomials of the parameters are fitted to some runs and their
    gradients, for functionals that are smooth over the whole of their ranges.

    Parameters
    ----------
    what : System, Modes or OrderResponse
        A system, to be run for each set of parameters; or modes or an order response of the
        nominal drive, which are found again for each, with the same start values and free
        parameters.
    over : mapping of name to distribution, or what `correlated` gives
        Tolerances (see `lumped.distributions` and `lumped.tolerances.toleranced`).
    of : functional, iterable of functionals, or mapping of str to functional
        Of runs what `ensemble` takes; of modes `frequency`, `damping` and `clearance`; of an order
        response `order_peak` and `separation` too.
    search : {"samples", "derivatives", "chaos"}
        How.
    runs : int, optional
        Number of runs; default is 1000 samples, 64 to check derivatives, or 200 for polynomials.
    seed : int
        Of the runs, as for `ensemble`.
    sampling : {"random", "latin", "sobol", "halton"}, optional
        Of samples and chaos, as for `ensemble`; default is "random", for chaos "sobol".
    gradients : bool
        Whether polynomials are fitted to the gradients of the runs too. A gradient counts as many
        values as there are parameters. For a small drive it takes longer than as many runs
        side by side; more runs without gradients are better there.
    until, rtol
        For a system, as for `ensemble`.
    workers : int, optional
        Threads, or processes for gradients; default is one for each core.
    **options : RunOptions
        For a system: of each run (see `RunOptions`).

    Returns
    -------
    Scatter

    Raises
    ------
    OptionError
        If something cannot scatter, has no distribution, or has no such functional.
    UnknownNameError
        If a name does not exist.
    ParameterError
        If a distribution is out of the range of its parameter.
    SolverError
        If no run comes to its end, or there are no derivatives at the mean; it says why.
    Interrupted
        After Ctrl-C; `partial` is the scatter of the first samples that were done.
    """
    begun = clock.perf_counter()
    wanted: Any = of if isinstance(of, Mapping | Iterable) else [of]
    scene = scene_of(what, over=over, of=wanted, until=until, rtol=rtol, workers=workers, **options)
    count = _RUNS[search] if runs is None else runs
    if not gradients and search != "chaos":
        raise OptionError(f"scatter: gradients=False is for search='chaos', not for '{search}'.")

    def tell(found: Spreads) -> Scatter:
        seconds = clock.perf_counter() - begun
        found = found._replace(notes=(*scene.notes, *found.notes))
        return Scatter(scene.system.name, search, scene.names, *found, seconds)

    try:
        if search == "chaos":
            found = by_chaos(scene, count, seed, sampling or "sobol", gradients=gradients)
        elif search == "derivatives":
            if sampling is not None:
                text = "scatter: sampling is for samples and chaos; derivatives need none."
                raise OptionError(text)
            if count < 2:
                raise OptionError(f"scatter: runs = {count}: two at least check derivatives.")
            found = by_derivatives(scene, count, seed)
        else:
            found = _by_samples(scene, scene.draw(count, seed, sampling or "random"))
    except KeyboardInterrupt as error:
        known = getattr(error, "partial", None)
        partial = tell(known) if isinstance(known, Spreads) else None
        raise Interrupted(f"scatter: {str(error) or 'interrupted'}", partial) from None
    return tell(found)


def _by_samples(scene: Scene, points: Real) -> Spreads:
    """How each functional scatters in a sample.

    Raises
    ------
    SolverError
        If none has a value.
    Interrupted
        With the same of the first runs.
    """
    try:
        return _sum_up(scene, points, scene.values(points))
    except Interrupted as error:
        values, known = error.partial, None
        if len(values) > 1 and not np.isnan(values).all():
            known = _sum_up(scene, points[: len(values)], values)
        raise Interrupted(str(error), known) from None


def _sum_up(scene: Scene, points: Real, values: Real) -> Spreads:
    if np.isnan(values).all():
        first, text = next(iter(scene.failures.items()))
        raise SolverError(f"scatter: all {len(values)} runs fail. Run {first}: {text}", None)
    spreads: dict[str, Spread] = {
        label: SampledSpread(label, unit, scene.names, points, column)
        for label, unit, column in zip(scene.labels, scene.units, values.T, strict=True)
    }
    return Spreads(spreads, points, values, scene.failures)
