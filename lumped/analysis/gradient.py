"""Gradients of numbers that sum up a run, by many parameters at once."""

from __future__ import annotations

import time as clock
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import casadi as ca
import numpy as np

from lumped.analysis.adjoint import Leg, Point, Steps, legs_of, sweep
from lumped.analysis.extremes import Extreme, extremes, slope_function
from lumped.analysis.functionals import Final, Functional, Instant, Integral, Peak
from lumped.analysis.ranking import ranked
from lumped.analysis.result import Trajectory
from lumped.analysis.simulate import simulate
from lumped.analysis.varied import slopes_at_zero, sources, varied_values
from lumped.errors import OptionError, SolverError, UnknownNameError, nearest
from lumped.system import Changes, Name, System
from lumped.table import number, table
from lumped.units import in_seconds

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Gradient", "gradient"]

_COLUMNS = 500
"""Derivatives of start states that are computed at once."""
_GRID = 1000
"""Intervals of a run without states, which has no steps."""


@dataclass(frozen=True, eq=False)
class Gradient:
    """Values of functionals and their derivatives; ``found["rms(shaft.tau)", "a.J"]`` is one.

    Attributes
    ----------
    run : Trajectory
        The run, at the steps of the solver.
    of : tuple of str
        Functionals, as printed.
    to : tuple of str
        Parameters and start values.
    values : ndarray, shape (len(of),)
        What the functionals are.
    units : tuple of str
        Units of these.
    derivatives : ndarray, shape (len(of), len(to))
        Their derivatives.
    shared : tuple of float
        Instants at which statically indeterminate constraints let go, s. Derivatives hold the
        shares of what each carries fixed there, and are not exact if these depend on what varies.
    seconds : float
        Wall time of everything after the run.
    rtol : float
        Tolerance of the run. Derivatives are exact for its steps, and as accurate as these.
    """

    run: Trajectory
    of: tuple[str, ...]
    to: tuple[str, ...]
    values: np.ndarray
    units: tuple[str, ...]
    derivatives: np.ndarray
    shared: tuple[float, ...]
    seconds: float
    rtol: float

    def __getitem__(self, pair: tuple[str, Name]) -> float:
        of, to = pair
        key = self.run.system.key(to)
        if key not in self.to:
            raise UnknownNameError(f"'{key}' was not varied. {nearest(key, self.to)}")
        return float(self.derivatives[self._row(of), self.to.index(key)])

    @property
    def relative(self) -> np.ndarray:
        """Relative change of each functional for each relative change, ``p/y dy/dp``."""
        varied = varied_values(self.run, self.to)
        with np.errstate(divide="ignore", invalid="ignore"):
            found: np.ndarray = self.derivatives * varied / self.values[:, None]
        return found

    def ranked(self, of: str) -> list[tuple[str, float]]:
        """Names and relative sensitivities of a functional, the largest first.

        Raises
        ------
        OptionError
            If its value is zero, to which nothing is relative.
        UnknownNameError
            If it was not differentiated.
        """
        row = self._row(of)
        return ranked(of, self.values[row], self.to, self.relative[row])

    def plot(self, of: str | None = None) -> Figure:
        """Tornado of the parameters that matter most (see `lumped.plot.tornado`)."""
        from lumped.plot import tornado

        row = 0 if of is None else self._row(of)
        label = self.of[row]
        title = f"{self.run.system.name}: {label} = {self.values[row]:.4g} {self.units[row]}"
        return tornado(self.ranked(label), title, label)

    def _row(self, of: str) -> int:
        if of not in self.of:
            raise UnknownNameError(f"'{of}' was not differentiated. {nearest(of, self.of)}")
        return self.of.index(of)

    def __repr__(self) -> str:
        rows = []
        for label, value, unit in zip(self.of, self.values, self.units, strict=True):
            text = "zero: nothing is relative to it"
            if value:
                most = [(n, v) for n, v in self.ranked(label)[:4] if v]
                text = "; ".join(f"{name} {change:+.4f}" for name, change in most)
            rows.append((label, number(float(value), 9), unit, text))
        s = self.run.statistics
        head = (
            f"{self.run.system.name}: {len(self.of)} functionals by {len(self.to)} parameters and "
            f"start values, relative; run of {s.steps} steps ({s.method}), {s.evaluations} "
            f"evaluations, rtol {self.rtol:.0e}, in {s.seconds:.3g} s; its exact gradient in "
            f"{self.seconds:.3g} s more"
        )
        if self.shared:
            head += "\nshares of indeterminate constraints held fixed where they let go, t = "
            head += ", ".join(f"{t:.6g} s" for t in self.shared[:6])
        return f"{head}\n" + table(("functional", "value", "unit", "largest"), rows)


def gradient(
    system: System,
    *,
    of: Iterable[Functional],
    to: Iterable[Name] | None = None,
    until: float,
    parameters: Changes | None = None,
    start: Changes | None = None,
    rtol: float = 1e-8,
    method: Literal["auto", "explicit", "implicit"] = "auto",
) -> Gradient:
    """Simulate, and differentiate functionals of the run by parameters and start values.

    The cost hardly depends on the number of parameters: one run, and one sweep backwards over its
    steps for all functionals together (the discrete adjoint), across events by the transposed
    saltation matrix. `sensitivity` gives derivatives over time, at a cost for each parameter.

    Parameters
    ----------
    system : System
        From `assemble`.
    of : iterable of functionals
        From `lumped.functionals`.
    to : iterable of names, optional
        Parameters, given start values, and states, which stand for their start values; default
        is all parameters that can be changed.
    until, parameters, start, rtol, method
        As for `simulate`.

    Returns
    -------
    Gradient

    Raises
    ------
    OptionError
        If there is no functional or nothing to vary, a functional asks for an event that does not
        happen, or none of what is varied changes it.
    UnknownNameError
        If a quantity or parameter does not exist.
    SolverError
        Where the run has no derivative (see `sensitivity`), or one is not finite.
    """
    until = in_seconds(until, "until")
    wanted = tuple(of)
    p = system._flat.parameters
    names = [p.names[i] for i in p.free] if to is None else [system.key(name) for name in to]
    check(system, wanted, names)
    labels = tuple(str(functional) for functional in wanted)
    places, varied = sources(system, names, start or {})
    run = simulate(
        system,
        until=until,
        parameters=parameters,
        start=start,
        grid=None if system.states else _GRID,
        rtol=rtol,
        method=method,
    )
    begin = clock.perf_counter()
    steps, integrals = integrated(system, wanted)
    legs = legs_of(run)
    peaks = [k for k, functional in enumerate(wanted) if isinstance(functional, Peak)]
    tops = extremes(run, legs, steps, [wanted[k] for k in peaks])  # type: ignore[misc]
    values, points = np.zeros(len(wanted)), []
    for k, functional in enumerate(wanted):
        if isinstance(functional, Integral):
            continue
        top = tops[peaks.index(k)] if k in peaks else None
        values[k], point = _point(run, legs, k, functional, top)
        points.append(point)
    by_states, by_parameters, totals, shared = sweep(run, legs, steps, points)
    for total, k in zip(totals, integrals, strict=True):
        functional = wanted[k]
        assert isinstance(functional, Integral)
        values[k], slope, _ = functional.outcome(float(total), until)
        by_states[:, k] *= slope
        by_parameters[:, k] *= slope
    found = _chained(run, start or {}, places, varied, by_states, by_parameters)
    _check_found(system, labels, names, found)
    seconds = clock.perf_counter() - begin
    units = tuple(functional.unit(system) for functional in wanted)
    return Gradient(run, labels, tuple(names), values, units, found, shared, seconds, rtol)


def check(system: System, wanted: Sequence[Functional], names: Sequence[str]) -> None:
    """Refuse what makes no sense before a run."""
    if not wanted:
        raise OptionError(
            "gradient: name at least one functional in `of`, such as "
            "lumped.functionals.peak('shaft.tau')."
        )
    if not names:
        raise OptionError(
            f"{system.name}: nothing to vary; name parameters or start values in `to`."
        )
    for functional in wanted:
        if not isinstance(functional, Functional):
            raise OptionError(
                f"gradient: {functional!r} in `of` is no functional; take one of "
                "lumped.functionals, such as lumped.functionals.final('shaft.tau')."
            )
        if not isinstance(functional, Instant):
            system.expressions(
                functional.names if isinstance(functional, Integral) else [functional.name]
            )


def integrated(system: System, wanted: Sequence[Functional]) -> tuple[Steps, list[int]]:
    """Steps with all integrals, and to which functionals these belong."""
    products, columns = [], []
    for k, functional in enumerate(wanted):
        if isinstance(functional, Integral):
            names = tuple(system.key(name) for name in functional.names)
            products.append(names * (2 if functional.kind == "rms" else 1))
            columns.append(k)
    return Steps.of(system, tuple(products), tuple(columns), len(wanted)), columns


def _point(
    run: Trajectory,
    legs: list[Leg],
    column: int,
    functional: Final | Peak | Instant,
    top: Extreme | None,
) -> tuple[float, Point]:
    """Value of a functional that looks at one instant, and what it owes to it."""
    system, theta = run.system, run.theta
    if isinstance(functional, Instant):
        leg, t = _event(run, legs, functional)
        none = np.zeros(len(system.states)), np.zeros(len(theta))
        return t, Point(leg, t, column, *none, leg, 1.0)
    name = system.key(functional.name)
    if top is None:
        last = legs[-1]
        top = Extreme(len(legs) - 1, float(last.t[-1]), 1.0, 0, last.x[-1], last.settings[-1])
    at = (top.x, theta, top.time, top.settings)
    y, by_states, by_parameters = (
        np.asarray(v).ravel() for v in _differentiated(system, name)(*at)
    )
    sign = top.sign if isinstance(functional, Peak) and functional.kind == "peak" else 1.0
    late = sign * float(slope_function(system, name)(*at)) if top.edge else 0.0
    slopes = sign * by_states, sign * by_parameters
    return sign * float(y[0]), Point(top.leg, top.time, column, *slopes, top.edge, late)


def _differentiated(system: System, name: str) -> ca.Function:
    """A quantity and its derivatives by states and parameters: (x, p, t, m)."""
    key = ("differentiated", name)
    if key not in system.made:
        x, p, _, _ = system._inputs
        y = system.expressions([name])
        results = [ca.densify(v) for v in (y, ca.jacobian(y, x), ca.jacobian(y, p))]
        system.made[key] = ca.Function("differentiated", system._inputs, results)
    found: ca.Function = system.made[key]
    return found


def _event(run: Trajectory, legs: list[Leg], wanted: Instant) -> tuple[int, float]:
    """Leg that begins at an event, and when."""
    times = [
        event.time
        for event in run.events
        if event.component == wanted.component and wanted.after in ("", event.after)
    ]
    label = str(wanted)
    if not -len(times) <= wanted.number < len(times):
        known = sorted(
            {f"{e.component}, {e.after}" if e.after else e.component for e in run.events}
        )
        raise OptionError(
            f"{run.system.name}: {label}: there are {len(times)} such events in this run. Events "
            f"are: {'; '.join(known[:8]) or 'none'}."
        )
    time = times[wanted.number]
    leg = next((k for k, leg in enumerate(legs) if k and leg.t[0] == time), None)
    if leg is None:
        raise OptionError(
            f"{run.system.name}: {label} is at t = {time:g} s, where the run begins or ends; this "
            "instant does not move."
        )
    return leg, time


def _chained(
    run: Trajectory,
    start: Changes,
    places: list[int],
    varied: dict[int, np.ndarray],
    by_states: np.ndarray,
    by_parameters: np.ndarray,
) -> np.ndarray:
    """Derivatives by what is varied, through states at the time zero and directly."""
    found = np.zeros((by_states.shape[1], len(places)))
    for begin in range(0, len(places), _COLUMNS):
        own = slice(begin, begin + _COLUMNS)
        seed = np.zeros((len(by_parameters), len(places[own])))
        for column, place in enumerate(places[own]):
            if place >= 0:
                seed[place, column] = 1.0
        units = {unknown: unit[own] for unknown, unit in varied.items()}
        S = slopes_at_zero(run, start, seed, units)
        found[:, own] = by_states.T @ S
    # one by one: what has no derivative by one parameter may have one by others
    for column, place in enumerate(places):
        if place >= 0:
            found[:, column] += by_parameters[place]
    return found


def _check_found(
    system: System, labels: Sequence[str], names: Sequence[str], found: np.ndarray
) -> None:
    if not np.isfinite(found).all():
        row, column = np.argwhere(~np.isfinite(found))[0]
        raise SolverError(
            f"{system.name}: the derivative of {labels[row]} by {names[column]} is not finite. "
            "Change this value, or leave it out of `to`."
        )
    for label, row in zip(labels, found, strict=True):
        if not row.any():
            more = f" and {len(names) - 8} more" if len(names) > 8 else ""
            raise OptionError(
                f"{system.name}: {label} does not depend on {', '.join(names[:8])}{more}: all its "
                "derivatives are exactly zero. Vary something else, or leave it out of `of`."
            )
