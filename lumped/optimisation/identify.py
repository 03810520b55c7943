"""Parameters from measured curves: least squares, from one design or from several."""

from __future__ import annotations

import time as clock
from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from typing import Any, Unpack

import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import LumpedError, OptimisationError, OptionError
from lumped.functionals import at_time
from lumped.gradients.sensitivity import Varied
from lumped.gradients.sensitivity_result import Sensitivity
from lumped.optimisation.design import Bounds, room_of
from lumped.optimisation.first_designs import apart, draw_designs, run_designs
from lumped.optimisation.identification import Identification
from lumped.points.start import by_name, run_start
from lumped.simulation.simulate import places_of, run_sampled
from lumped.support.arguments import checked
from lumped.support.made_once import made_once
from lumped.support.units import plain
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.run_options import RunOptions, run_plan

Curves = Mapping[str, Sequence[float] | np.ndarray] | Mapping[Name, Sequence[float] | np.ndarray]
"""Measured curves by their names."""
_Names = tuple[str, ...]

_LOST = 1e-6
"""Singular value, relative to the largest, below which a direction is not told by the curves."""
_TAKES_PART = 0.05
_CHANCE = 1e-4
"""Probability of noise so large, or so regular, below which there is doubt."""
_NEGLIGIBLE = 1e-4
"""Deviation without `sigma` below which residuals are errors of the runs."""


@checked
def identify(
    system: System,
    *,
    vary: Mapping[str, Bounds],
    t: Sequence[float] | np.ndarray,
    measured: Curves,
    sigma: Mapping[str, float] | Mapping[Name, float] | None = None,
    level: float = 0.95,
    rtol: float = 1e-8,
    searches: int = 1,
    **options: Unpack[RunOptions],
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
        Instants of the measurement, s, from the begin of the runs on, increasing.
    measured : mapping of name to array_like, shape (n,)
        Curves of quantities, or of expressions of quantities.
    sigma : mapping of name to float, optional
        Standard deviation of the noise of each curve, in its unit. If not given, each curve counts
        relative to its root mean square, and the noise is estimated from what does not fit.
    level : float
        Probability of the confidence intervals.
    rtol : float
        Relative tolerance of the runs. Tighter than elsewhere: near the best fit a search compares
        runs that hardly differ.
    searches : int
        Number of searches; all but the first begin at the best of 128 designs each between the
        bounds, and the best result counts. Where another minimum fits as well, `doubts` says so.
    **options : RunOptions
        Of each run (see `RunOptions`).

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
    if searches < 1:
        raise OptionError(f"identify: searches = {searches}: at least one search is needed.")
    search = _FitSearch(system, vary, t, measured, sigma, rtol, options)
    return search.find_best(level, searches)


@made_once
def _vary(system: System, of: _Names, by: _Names, start: _Names, rtol: float) -> Varied:
    """Derivatives for any values of the start."""
    return Varied(system, of, by, dict.fromkeys(start, 0.0), rtol)


class _FitSearch:
    """Searches for the parameters that fit curves best; arguments as for `identify`."""

    def __init__(
        self,
        system: System,
        vary: Mapping[str, Bounds],
        t: Sequence[float] | np.ndarray,
        measured: Curves,
        sigma: Mapping[str, float] | Mapping[Name, float] | None,
        rtol: float,
        options: RunOptions,
    ) -> None:
        self.system, self.given = system, sigma is not None
        self.t = np.asarray(t, dtype=float)
        if not (self.t.ndim == 1 and len(self.t) > 1 and (np.diff(self.t) > 0).all()):
            raise OptionError("identify: t must hold at least two increasing instants.")
        plan = run_plan(float(self.t[-1]), rtol, options).by_steps("identify", are_followed=True)
        if not self.t[0] >= plan.begin:
            raise OptionError(f"identify: t begins at {self.t[0]:g} s, runs at {plan.begin:g} s.")
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
        self.measured = np.array([*self.curves.values()])
        self.weights = self._weights(sigma)
        self.plan, self.parameters, self.begin = plan, plan.changes(system), dict[str, Any]()
        self.inner = [name for name in self.names if name in system.parameters]
        self.point = plan.start if isinstance(plan.start, OperatingPoint) else None
        if self.point is None:
            self.begin = {system.key(k): v for k, v in by_name(plan.start).items()}
        elif len(self.inner) < len(self.names):
            raise OptionError(
                "identify: start values in `vary` are not those of a start point. Give start "
                "values by name, start={...}."
            )
        self.system = system = plan.watching(system, ())
        point = run_start(system, plan)
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

    def _weights(self, sigma: Mapping[str, float] | Mapping[Name, float] | None) -> np.ndarray:
        """Of each curve, shape (curves, 1)."""
        if sigma is None:
            sizes = np.sqrt(np.mean(self.measured**2, axis=1, keepdims=True))
            return 1 / np.where(sizes > 0, sizes, 1.0)
        given = {}
        for name, value in sigma.items():
            key, unit = self.system.key(name), self.system.quantity(name).unit
            given[key] = plain(value, unit, f"identify: sigma of {key} =", OptionError)
        if set(given) != set(self.curves) or not all(0 < v < np.inf for v in given.values()):
            raise OptionError(
                f"identify: sigma = {dict(sigma)!r}; give a positive standard deviation for each "
                f"of {', '.join(self.curves)}."
            )
        return 1 / np.array([[given[name]] for name in self.curves])

    def _at(self, u: np.ndarray) -> Sensitivity:
        """Run and derivatives for scaled unknowns."""
        if self.last is not None and self.last[0] == u.tobytes():
            return self.last[1]
        values = self._named(u)
        inner = {name: values.pop(name) for name in self.inner}
        begin = self.begin | values
        names = tuple(self.curves), tuple(self.names), tuple(begin)
        forward = copy(_vary(self.system, *names, self.plan.rtol))
        forward.given = self.point or begin
        plan = self.plan._replace(parameters=self.parameters | inner, start=forward.given)
        run = run_sampled(self.system, plan, self.t)
        found = forward.go(run)
        self.runs += 1
        self.last = u.tobytes(), found
        return found

    def _residuals(self, u: np.ndarray) -> np.ndarray:
        run = self._at(u).run
        fitted = run.table([*self.curves])[places_of(run, self.t)].T
        found: np.ndarray = (fitted - self.measured) * self.weights
        return found.ravel()

    def _jacobian(self, u: np.ndarray) -> np.ndarray:
        found = self._at(u)
        slopes: np.ndarray = found.derivatives[places_of(found.run, self.t)] * self.weights
        return slopes.transpose(1, 0, 2).reshape(-1, len(u)) * self.scale

    def _begins(self, count: int) -> np.ndarray:
        """Scaled unknowns at which further searches begin: designs that fit best."""
        points = draw_designs("identify", self.names, self.low, self.high, count)
        if len(self.inner) == len(self.names):
            points = points[np.argsort(self._misfits(points), kind="stable")]
        return apart(points, self.low, self.high, count) / self.scale

    def _misfits(self, points: np.ndarray) -> np.ndarray:
        """Weighted sums of squares of many designs; infinite where a run fails."""
        of = [at_time(t, name) for name in self.curves for t in self.t.tolist()]
        plan = self.plan.at(max(self.plan.rtol, 1e-6))
        values, _ = run_designs("identify", self.system, self.names, points, of, plan)
        weights = np.repeat(self.weights, len(self.t))
        total: np.ndarray = (((values - self.measured.ravel()) * weights) ** 2).sum(axis=1)
        return np.where(np.isfinite(total), total, np.inf)

    def _named(self, u: np.ndarray) -> dict[str, float]:
        """Scaled unknowns by name, in their own units."""
        return dict(zip(self.names, (u * self.scale).tolist(), strict=True))

    def _search(self, first: np.ndarray) -> scipy.optimize.OptimizeResult:
        """The minimum to which a search leads."""
        result = scipy.optimize.least_squares(
            self._residuals,
            first,
            self._jacobian,
            (self.low / self.scale, self.high / self.scale),
            xtol=1e-12,
            ftol=1e-14,
            gtol=1e-14,
            max_nfev=200,
        )
        if result.status <= 0:
            raise OptimisationError(
                f"{self.system.name}: identification did not end in {result.nfev} runs; the last "
                f"values are {self._named(result.x)}. Begin nearer, or narrow the bounds.",
                result.message,
            )
        return result

    def find_best(self, level: float, searches: int) -> Identification:
        """Search, and tell how well the result is known."""
        tic = clock.perf_counter()
        first = self.u / self.scale
        slope = np.abs(self._jacobian(first).T @ self._residuals(first)).max()
        results, faults = [], list[LumpedError]()
        for begin in [first, *(self._begins(searches - 1) if searches > 1 else ())]:
            try:
                results.append(self._search(begin))
            except LumpedError as fault:
                faults.append(fault)
        if not results:
            raise faults[0]
        result, *others = sorted(results, key=lambda r: float(r.cost))
        J, u = self._jacobian(result.x), result.x * self.scale
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
        law = scipy.stats.norm if self.given else scipy.stats.t(freedom)
        reach = law.ppf(0.5 + level / 2) * errors
        intervals = np.column_stack([u - reach, u + reach]).tolist()
        rests = result.fun.reshape(len(self.curves), -1)
        doubts = *self._doubts(rests, deviation, freedom), *self._rivals(result, others, deviation)
        return Identification(
            self._at(result.x).run,
            self._named(result.x),
            self._named(first),
            covariance,
            level,
            {n: (low, high) for n, (low, high) in zip(self.names, intervals, strict=True)},
            correlation,
            s,
            tuple(np.array(self.names)[unknown].tolist()),
            self.t,
            dict(zip(self.curves, -rests / self.weights, strict=True)),
            deviation,
            tuple(np.array(self.names)[result.active_mask != 0].tolist()),
            doubts,
            tuple((float(np.sqrt(2 * o.cost / freedom)), self._named(o.x)) for o in others),
            result.message.rstrip("."),
            int(result.njev),
            self.runs,
            float(np.abs(J.T @ result.fun).max() / slope) if slope else 0.0,
            clock.perf_counter() - tic,
        )

    def _rivals(
        self,
        best: scipy.optimize.OptimizeResult,
        others: Sequence[scipy.optimize.OptimizeResult],
        deviation: float,
    ) -> Iterator[str]:
        """Another minimum that noise cannot tell from the best one, with a barrier between them."""
        # the likelihood ratio is chi-square (Seber and Wild, Nonlinear Regression, 1989, ch. 5)
        noise = 1.0 if self.given else deviation**2
        limit = noise * scipy.stats.chi2.isf(_CHANCE, len(self.names))
        for other in others:
            if 2 * (other.cost - best.cost) > limit:
                return
            between = self._residuals(0.5 * (other.x + best.x))
            if between @ between - 2 * other.cost > limit:
                found = self._named(other.x).items()
                values = ", ".join(f"{name} = {value:.6g}" for name, value in found)
                yield f"other values fit as well as noise can tell: {values}"
                return

    def _doubts(self, rests: np.ndarray, deviation: float, freedom: int) -> Iterator[str]:
        """What speaks against noise as the reason of the residuals, given for each curve."""
        if self.given:
            chance = scipy.stats.chi2.sf(deviation**2 * freedom, freedom)
            if chance < _CHANCE:
                yield f"the residuals are {deviation:.3g} times the noise given as sigma"
        elif deviation < _NEGLIGIBLE:
            return
        for name, rest in zip(self.curves, rests, strict=True):
            along = float(rest[1:] @ rest[:-1] / (rest @ rest)) if rest.any() else 0.0
            # of white noise it is normal with the variance 1 / n (Box and Jenkins, 1970, ch. 2)
            if along > scipy.stats.norm.isf(_CHANCE) / np.sqrt(len(rest)):
                yield (
                    f"the residuals of {name} follow each other (correlation {along:.2f} from one "
                    "instant to the next), as noise does not"
                )
