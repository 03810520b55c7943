"""Parameters from measured curves, and how well these tell them."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
import scipy

from lumped.compiler.system import Changes, System
from lumped.errors import OptimisationError, OptionError
from lumped.gradients.sensitivity import Sensitivity, Varied
from lumped.optimisation.design import Bounds, room_of, unit_of
from lumped.points.start import start_point
from lumped.simulation.sampled_runs import places_of, sampled
from lumped.support.arguments import checked
from lumped.support.made_once import made_once
from lumped.support.text_table import number, table
from lumped.support.units import plain
from lumped.timeloop.result import Trajectory

__all__ = ["Identification", "identify"]

_Names = tuple[str, ...]
_LOST = 1e-6
"""Singular value, relative to the largest, below which a direction is not told by the curves."""
_TAKES_PART = 0.05
_CHANCE = 1e-4
"""Probability of noise so large, or so regular, below which there is doubt."""
_NEGLIGIBLE = 1e-4
"""Deviation without `sigma` below which residuals are errors of the runs."""


@dataclass(frozen=True, eq=False)
class Identification:
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
    residuals : dict of str to ndarray
        Measured less computed.
    deviation : float
        Root of the weighted sum of squares over the degrees of freedom: 1 if model, `sigma` and
        noise agree; without `sigma` the relative noise.
    bounded : tuple of str
        Parameters at a bound, for which the interval does not hold.
    doubts : tuple of str
        Why no interval may hold: residuals far above `sigma`, or residuals that are no noise, as in
        a local minimum or where the model cannot follow the curves.
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
    residuals: dict[str, np.ndarray]
    deviation: float
    bounded: tuple[str, ...]
    doubts: tuple[str, ...]
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

    def __repr__(self) -> str:
        system, rows = self.run.system, []
        for name, value in self.parameters.items():
            low, high = self.intervals[name]
            note = "not identified" if name in self.unknown else f"{number(low)} .. {number(high)}"
            if name in self.bounded:
                note += " (at its bound)"
            unit = (
                unit_of(system, name) if name in system.parameters else system.quantity(name).unit
            )
            rows.append((name, number(self.start[name]), number(value, 8), note, unit))
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


@checked
def identify(
    system: System,
    *,
    vary: Mapping[str, Bounds],
    t: Sequence[float] | np.ndarray,
    measured: Mapping[str, Sequence[float] | np.ndarray],
    sigma: Mapping[str, float] | None = None,
    parameters: Changes | None = None,
    start: Changes | None = None,
    level: float = 0.95,
    rtol: float = 1e-8,
) -> Identification:
    """Parameters and start values for which runs fit measured curves best.

    Least squares by Gauss and Newton's method within a trust region, with exact derivatives from
    `sensitivity`, across events too.

    Parameters
    ----------
    system : System
        From `assemble`.
    vary : mapping of name to (low, high)
        Parameters, or start values of states, and their bounds; the search begins at the values
        of the model, of `parameters` or of `start`, and they are its scale.
    t : array_like, shape (n,)
        Instants of the measurement, s, from zero or later, increasing.
    measured : mapping of name to array_like, shape (n,)
        Curves.
    sigma : mapping of name to float, optional
        Standard deviation of the noise of each curve, in its unit. If not given, each curve counts
        relative to its root mean square, and the noise is estimated from what does not fit.
    parameters, start : mapping of name to float, optional
        As for `simulate`.
    level : float
        Probability of the confidence intervals.
    rtol : float
        Relative tolerance of the runs. Tighter than elsewhere: near the best fit a search compares
        runs that hardly differ.

    Returns
    -------
    Identification

    Raises
    ------
    OptionError
        If curves, instants, bounds or names make no sense.
    OptimisationError
        If the search does not end.
    SolverError
        If a run fails, or has no derivative.

    Notes
    -----
    Covariance ``s^2 (J^T J)^-1`` (Bard, Nonlinear Parameter Estimation, 1974, ch. 7).
    """
    if not 0 < level < 1:
        raise OptionError(f"identify: level = {level:g} must lie between 0 and 1.")
    search = _FitSearch(system, vary, t, measured, sigma, parameters or {}, start or {})
    return search.found(level, rtol)


@made_once
def _varied(system: System, of: _Names, to: _Names, start: _Names, rtol: float) -> Varied:
    """Derivatives for any values of the start."""
    return Varied(system, of, to, dict.fromkeys(start, 0.0), rtol)


class _FitSearch:
    def __init__(
        self,
        system: System,
        vary: Mapping[str, Bounds],
        t: Sequence[float] | np.ndarray,
        measured: Mapping[str, Sequence[float] | np.ndarray],
        sigma: Mapping[str, float] | None,
        parameters: Changes,
        start: Changes,
    ) -> None:
        self.system, self.given = system, sigma is not None
        self.t = np.asarray(t, dtype=float)
        if not (
            self.t.ndim == 1 and len(self.t) > 1 and self.t[0] >= 0 and (np.diff(self.t) > 0).all()
        ):
            raise OptionError("identify: t must hold at least two increasing instants from 0 s on.")
        self.curves = {system.key(name): np.asarray(y, dtype=float) for name, y in measured.items()}
        self.names = [system.key(name) for name in vary]
        if not self.curves or not self.names:
            raise OptionError("identify: give at least one measured curve and one name in `vary`.")
        for name, y in self.curves.items():
            if y.shape != self.t.shape or not np.isfinite(y).all():
                raise OptionError(
                    f"identify: {name} has the shape {y.shape} and {int((~np.isfinite(y)).sum())} "
                    f"values that are no numbers; {len(self.t)} finite values are needed."
                )
        self.weights = self._weights(sigma)
        self.parameters = {system.key(k): v for k, v in parameters.items()}
        self.begin = {system.key(k): v for k, v in start.items()}
        point = start_point(system, parameters=parameters, start=start)
        known = point.parameters
        self.u = np.array([known[n] if n in known else point[n] for n in self.names])
        self.low, self.high = np.array([room_of(n, b) for n, b in vary.items()]).T
        for name, value, low, high in zip(self.names, self.u, self.low, self.high, strict=True):
            if not low <= value <= high:
                raise OptionError(
                    f"identify: the search would begin with {name} = {value:g}, outside its bounds "
                    f"({low:g}, {high:g}). Give a value between them in `parameters` or `start`."
                )
        span = self.high - self.low
        self.scale = np.where(self.u != 0, np.abs(self.u), np.where(np.isfinite(span), span, 1.0))
        self.last: tuple[bytes, Sensitivity] | None = None
        self.runs = 0

    def _weights(self, sigma: Mapping[str, float] | None) -> dict[str, float]:
        if sigma is None:
            sizes = {name: float(np.sqrt(np.mean(y**2))) for name, y in self.curves.items()}
            return {name: 1 / size if size else 1.0 for name, size in sizes.items()}
        given = {}
        for name, value in sigma.items():
            key, unit = self.system.key(name), self.system.quantity(name).unit
            given[key] = plain(value, unit, f"identify: sigma of {key} =", OptionError)
        if set(given) != set(self.curves) or not all(0 < v < np.inf for v in given.values()):
            raise OptionError(
                f"identify: sigma = {dict(sigma)!r}; give a positive standard deviation for each "
                f"of {', '.join(self.curves)}."
            )
        return {name: 1 / value for name, value in given.items()}

    def _at(self, u: np.ndarray, rtol: float) -> Sensitivity:
        """Run and derivatives for scaled unknowns."""
        if self.last is not None and self.last[0] == u.tobytes():
            return self.last[1]
        values = dict(zip(self.names, (u * self.scale).tolist(), strict=True))
        inner = {n: v for n, v in values.items() if n in self.system.parameters}
        outer = {n: v for n, v in values.items() if n not in inner}
        begin = self.begin | outer
        names = tuple(self.curves), tuple(self.names), tuple(begin)
        forward = copy(_varied(self.system, *names, rtol))
        forward.given = begin
        point = start_point(self.system, parameters=self.parameters | inner, start=begin)
        run = sampled(point, self.t, rtol)
        found = forward.go(run)
        self.runs += 1
        self.last = u.tobytes(), found
        return found

    def _residuals(self, u: np.ndarray, rtol: float) -> np.ndarray:
        run = self._at(u, rtol).run
        places = places_of(run, self.t)
        parts = [(run[name][places] - y) * self.weights[name] for name, y in self.curves.items()]
        return np.concatenate(parts)

    def _jacobian(self, u: np.ndarray, rtol: float) -> np.ndarray:
        found = self._at(u, rtol)
        places = places_of(found.run, self.t)
        parts = [
            found.values[places, i, :] * self.weights[name] for i, name in enumerate(self.curves)
        ]
        return np.concatenate(parts) * self.scale

    def found(self, level: float, rtol: float) -> Identification:
        """Search, and tell how well the result is known."""
        tic = clock.perf_counter()
        first = self.u / self.scale
        slope = np.abs(self._jacobian(first, rtol).T @ self._residuals(first, rtol)).max()
        result = scipy.optimize.least_squares(
            self._residuals,
            first,
            self._jacobian,
            (self.low / self.scale, self.high / self.scale),
            xtol=1e-12,
            ftol=1e-14,
            gtol=1e-14,
            max_nfev=200,
            args=(rtol,),
        )
        if result.status <= 0:
            raise OptimisationError(
                f"{self.system.name}: identification did not end in {result.nfev} runs; the last "
                f"values are {dict(zip(self.names, result.x * self.scale, strict=True))}. Begin "
                "nearer, or narrow the bounds.",
                result.message,
            )
        J, u = self._jacobian(result.x, rtol), result.x * self.scale
        relative = J * np.where(u != 0, np.abs(u) / self.scale, 1.0)
        _, s, v = np.linalg.svd(relative, full_matrices=False)
        lost = s <= _LOST * s[0]
        unknown = (np.abs(v[lost]) > _TAKES_PART).any(axis=0)
        freedom = max(len(result.fun) - int((~lost).sum()), 1)
        deviation = float(np.sqrt(2 * result.cost / freedom))
        size = np.where(u != 0, np.abs(u), self.scale)
        inverse = v[~lost].T / s[~lost]
        covariance = (inverse @ inverse.T) * np.outer(size, size)
        covariance *= 1.0 if self.given else deviation**2
        errors = np.sqrt(np.diag(covariance))
        with np.errstate(invalid="ignore", divide="ignore"):
            correlation = covariance / np.outer(errors, errors)
        correlation[unknown] = correlation[:, unknown] = np.nan
        covariance[unknown, unknown] = np.inf
        errors[unknown] = np.inf
        reach = (
            scipy.stats.norm.ppf(0.5 + level / 2)
            if self.given
            else scipy.stats.t.ppf(0.5 + level / 2, freedom)
        )
        run = self._at(result.x, rtol).run
        return Identification(
            run,
            dict(zip(self.names, u.tolist(), strict=True)),
            dict(zip(self.names, self.u.tolist(), strict=True)),
            covariance,
            level,
            {
                n: (float(a - reach * e), float(a + reach * e))
                for n, a, e in zip(self.names, u, errors, strict=True)
            },
            correlation,
            s,
            tuple(n for n, lost_ in zip(self.names, unknown, strict=True) if lost_),
            {
                n: -part / self.weights[n]
                for n, part in zip(self.curves, np.split(result.fun, len(self.curves)), strict=True)
            },
            deviation,
            tuple(n for n, m in zip(self.names, result.active_mask, strict=True) if m),
            self._doubts(result.fun, deviation, freedom),
            result.message.rstrip("."),
            int(result.njev),
            self.runs,
            float(np.abs(J.T @ result.fun).max() / slope) if slope else 0.0,
            clock.perf_counter() - tic,
        )

    def _doubts(self, weighted: np.ndarray, deviation: float, freedom: int) -> tuple[str, ...]:
        """What speaks against noise as the reason of the residuals."""
        found = []
        if self.given:
            chance = scipy.stats.chi2.sf(deviation**2 * freedom, freedom)
            if chance < _CHANCE:
                found.append(f"the residuals are {deviation:.3g} times the noise given as sigma")
        if not self.given and deviation < _NEGLIGIBLE:
            return ()
        for name, rest in zip(self.curves, np.split(weighted, len(self.curves)), strict=True):
            along = float(rest[1:] @ rest[:-1] / (rest @ rest)) if rest.any() else 0.0
            # of white noise it is normal with the variance 1 / n (Box and Jenkins, 1970, ch. 2)
            if along > scipy.stats.norm.isf(_CHANCE) / np.sqrt(len(rest)):
                found.append(
                    f"the residuals of {name} follow each other (correlation {along:.2f} from one "
                    "instant to the next), as noise does not"
                )
        return tuple(found)
