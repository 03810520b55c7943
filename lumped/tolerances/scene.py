"""What scatters, by which distributions, and what is asked of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, Unpack

import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.ensembles.ensemble import label_functionals
from lumped.ensembles.laws import central_moments
from lumped.ensembles.variants import (
    Marginals,
    Over,
    Sampling,
    fill_parameters,
    marginals_of,
    probabilities,
    variants_of,
)
from lumped.errors import Interrupted, OptionError, ParameterError, SolverError
from lumped.functionals.functional import refuse_other
from lumped.support.arguments import checked
from lumped.support.arrays import Boolean, Real
from lumped.support.text_table import list_names
from lumped.timeloop.run_options import RunOptions, RunPlan, plan_of
from lumped.tolerances.analyses import OfModes, OfOrders, OfRuns
from lumped.tolerances.evaluated import Evaluated, Evaluation, Failures, curvatures_along
from lumped.vibration.natural.modes import Modes
from lumped.vibration.ordered.order_response import OrderResponse

Scattered = System | Modes | OrderResponse
"""What can scatter."""


class Scene:
    """Functionals of what scatters, for d parameters and k functionals.

    Parameters
    ----------
    system : System
    over : mapping or Correlated
        Distributions of the parameters.
    marginals : Marginals
        The same in numbers.
    evaluated_over : callable
        Makes what evaluates the functionals for any values of parameters, from their names.
    parameters : mapping of name to float or None
        Changes that hold throughout.
    analysis : str
        With which errors begin.
    held : mapping of str to float
        Parameters that do not scatter, m of them, by which is differentiated too; their values.

    Attributes
    ----------
    names : tuple of str
        Parameters that scatter, d of them.
    marginals : Marginals
        Their distributions, and how they depend on each other.
    labels, units : tuple of str
        Functionals as printed and their units, k of each.
    error : float
        Relative error of their derivatives.
    notes : tuple of str
        What the nominal analysis knows of its own accuracy.
    failures : dict of int to str
        Why evaluations of the last call failed, by their number.
    """

    def __init__(
        self,
        system: System,
        over: Over,
        marginals: Marginals,
        evaluated_over: Callable[[tuple[str, ...]], Evaluated],
        parameters: Changes | None,
        analysis: str,
        held: Mapping[str, float] | None = None,
    ) -> None:
        self.held = dict(held or {})
        evaluated = evaluated_over((*marginals.names, *self.held))
        self.system, self.analysis, self.names = system, analysis, marginals.names
        self.labels, self.units, self.error = evaluated.labels, evaluated.units, evaluated.error
        self.notes, self.failures = evaluated.notes, Failures()
        self.over, self.parameters = over, parameters
        self._theta, self._places = fill_parameters(system, parameters), system.places(self.names)
        self.marginals, self._evaluated = marginals, evaluated
        self.evaluated_over = evaluated_over

    def __reduce__(self) -> tuple[Any, ...]:
        parts = self.over, self.marginals, self.evaluated_over, self.parameters, self.analysis
        return Scene, (self.system, *parts, self.held)

    def physical(self, u: Real) -> Real:
        """Parameters in SI units for independent standard normal numbers, both of shape (n, d)."""
        return self.marginals.values(np.asarray(u, dtype=float))[0]

    def physical_slopes(self, u: Real) -> Real:
        """Their derivatives, shape (n, d, d): of parameter i by number j."""
        return self.marginals.values(np.asarray(u, dtype=float))[1]

    @property
    def moments(self) -> tuple[Real, Real]:
        """Means and standard deviations of the parameters that scatter, shape (d,) each."""
        pairs = [central_moments(law) for law in self.marginals.laws]
        return np.array([mean for mean, _ in pairs]), np.sqrt([central[2] for _, central in pairs])

    @property
    def parameter_units(self) -> tuple[str, ...]:
        """SI units of the parameters that scatter."""
        return tuple(self.system.parameter_unit(name) for name in self.names)

    def others(self, names: Iterable[Name]) -> dict[str, float]:
        """Parameters that do not scatter, by their names, with their values in SI units.

        Raises
        ------
        OptionError
            If one of them scatters.
        UnknownNameError
            If a parameter does not exist.
        """
        keys = [self.system.key(name) for name in names]
        self.system.places(keys)
        for key in keys:
            if key in self.names:
                raise OptionError(
                    f"{self.analysis}: {key} scatters; a derivative by its mean is given anyway. "
                    "Leave it out of `by`."
                )
        known = self.system.parameter_values(self.parameters)
        return {key: known[key] for key in keys}

    def slopes_by_others(self, x: Real, others: Mapping[str, float]) -> Real:
        """Derivatives by parameters that do not scatter, shape (n, k, m).

        Parameters
        ----------
        x : ndarray, shape (n, d)
            Those that do.
        others : mapping of str to float
            The m others and their values.

        Raises
        ------
        OptionError
            If a functional has no derivative.
        """
        parts = self.marginals, self.evaluated_over, self.parameters, self.analysis
        whole = Scene(self.system, self.over, *parts, others)
        found = whole.slopes_by_all(x)[1][:, :, len(self.names) :]
        self.failures = whole.failures
        return found

    def draw(self, n: int, seed: int = 0, sampling: Sampling = "random") -> Real:
        """Parameters that `ensemble` draws, shape (n, d).

        Raises
        ------
        OptionError
            If an option makes no sense.
        ParameterError
            If a value is out of the range of its parameter.
        """
        return variants_of(
            self.system,
            self.over,
            runs=n,
            seed=seed,
            sampling=sampling,
            parameters=self.parameters,
            analysis=self.analysis,
        ).values

    def scores(self, n: int, seed: int = 0, sampling: Sampling = "random") -> Real:
        """Independent standard normal numbers of which `physical` makes what `draw` gives.

        Raises
        ------
        OptionError
            If an option makes no sense.
        """
        u = probabilities(n, len(self.names), seed, sampling, self.analysis)
        found: Real = scipy.special.ndtri(u)
        return found

    def values(self, x: Real) -> Real:
        """Functionals, shape (n, k), nan where one failed; if interrupted those of the first."""
        return self._evaluate(x, with_slopes=False)[0]

    def slopes(self, x: Real) -> tuple[Real, Real]:
        """Functionals and their derivatives by the parameters, shapes (n, k) and (n, k, d).

        Raises
        ------
        OptionError
            If a functional has no derivative.
        """
        values, slopes = self.slopes_by_all(x)
        return values, slopes[:, :, : len(self.names)]

    def slopes_by_all(self, x: Real) -> tuple[Real, Real]:
        """The same with derivatives by what is held too, shape (n, k, d + m)."""
        return self._evaluate(x, with_slopes=True)

    def _evaluate(self, x: Real, with_slopes: bool) -> tuple[Real, Real]:
        rows = self._rows(x)
        faults = self._find_faults(rows)
        sound = np.setdiff1d(np.arange(len(rows)), list(faults))
        width = (len(self.names) + len(self.held)) * with_slopes
        values, slopes, _ = Evaluation.unknown(len(rows), len(self.labels), width)
        whole = np.hstack([rows[sound], np.tile([*self.held.values()], (len(sound), 1))])
        stopped: Interrupted | None = None
        try:
            values[sound], slopes[sound], failures = self._evaluated.evaluate(whole, with_slopes)
        except Interrupted as error:
            if not isinstance(error.partial, tuple):  # not of runs side by side
                raise
            stopped, (known, failures) = error, error.partial
            values[sound[: len(known)]] = known
            values = values[: [*sound.tolist(), len(rows)][len(known)]]
        told = {int(sound[i]): text for i, text in failures.items()} | faults
        self.failures = {i: told[i] for i in sorted(told) if i < len(values)}
        if stopped is not None:
            raise Interrupted(str(stopped), values)
        return values, slopes

    def curvatures(self, x: Real) -> Real:
        """Second derivatives at one point, shape (k, d, d).

        Exact ones where there are some; else central differences of first derivatives over
        ``error**(1/3)`` standard deviations (see `curvatures_along`).

        Raises
        ------
        OptionError
            If a functional has no derivative.
        SolverError
            If there are no derivatives beside the point.
        ParameterError
            If the point is out of range.
        """
        found = self.exact_curvatures(x)
        if found is not None:
            return found
        _, wide = self.moments
        scaled = curvatures_along(lambda at: self.slopes(at)[1], x, np.diag(wide), self.error)
        if not np.isfinite(scaled).all():
            why = next(iter(self.failures.values()), "")
            raise SolverError(f"{self.analysis}: no derivatives beside the point: {why}", None)
        return scaled / np.outer(wide, wide)

    def exact_curvatures(self, x: Real) -> Real | None:
        """The same; None where none are formed (runs, order responses, modes of equilibria)."""
        row = self._rows(np.reshape(x, (1, -1)))
        for text in self._find_faults(row).values():
            raise ParameterError(f"{self.analysis}: {text}.")
        return self._evaluated.curvatures(row[0])

    def _find_faults(self, rows: Real) -> Failures:
        """Which parameters are out of range, and why."""
        if not len(rows):
            return {}
        parameters = self.system.structure.parameters
        found = parameters.outside(self._theta, self._places, rows)
        return {run: text for text, runs in found for run in runs.tolist()}

    def _rows(self, x: Real) -> Real:
        found = np.ascontiguousarray(x, dtype=float)
        if found.ndim != 2 or found.shape[1] != len(self.names):
            raise OptionError(
                f"{self.analysis}: parameters have the shape {found.shape}; rows of "
                f"{len(self.names)} are needed: {', '.join(self.names)}."
            )
        return found


@checked
def scene_of(
    what: Scattered,
    *,
    over: Over,
    of: Mapping[str, Any] | Iterable[Any],
    until: float | str | None = None,
    rtol: float = 1e-6,
    workers: int | None = None,
    analysis: str = "scatter",
    **options: Unpack[RunOptions],
) -> Scene:
    """The scene of a study: functionals of runs, modes or order responses, and distributions.

    Parameters
    ----------
    what : System, Modes or OrderResponse
        A system, to be run for each set of parameters; or modes or an order response of the
        nominal drive, which are found again for each.
    over : mapping of name to distribution, or Correlated
        What scatters.
    of : mapping of str to functional, or iterable of functionals
        Of runs what `ensemble` takes; of modes `frequency`, `damping` and `clearance`; of an order
        response `order_peak` and `separation` too.
    until : float or str, optional
        For a system: end of each run, s.
    rtol : float
        For a system: relative tolerance.
    workers : int, optional
        Threads, or processes for gradients; default is one for each core.
    analysis : str
        With which errors begin.
    **options : RunOptions
        For a system: of each run (see `RunOptions`).

    Returns
    -------
    Scene

    Raises
    ------
    OptionError
        If something cannot scatter, has no distribution, or has no such functional.
    UnknownNameError
        If a name does not exist.
    ParameterError
        If a distribution is out of the range of its parameter.
    """
    if not isinstance(what, System | Modes | OrderResponse):
        raise OptionError(
            f"{analysis}: {type(what).__name__} is nothing that can scatter; give a system with "
            "until=, modes or an order response."
        )
    plan = plan_of(what, analysis, until, rtol, options)
    return plan_scene(what, over, of, plan, workers, analysis)


def plan_scene(
    what: Scattered,
    over: Over,
    of: Mapping[str, Any] | Iterable[Any],
    plan: RunPlan | None,
    workers: int | None,
    analysis: str,
) -> Scene:
    """The scene of a study with options that were checked (see `scene_of`)."""
    wanted = label_functionals(of, analysis)
    if workers is not None and workers < 1:
        raise OptionError(f"{analysis}: workers = {workers}: at least one thread is needed.")
    kind: Any
    if isinstance(what, System):
        assert plan is not None
        system, changes, name = what, plan.changes(what), "run"
        steps = plan.by_steps(analysis)
        kind = partial(OfRuns, plan=steps, workers=workers)
    elif isinstance(what, Modes):
        system, changes, name, kind = what.system, what.point.parameters, "modes", OfModes
        what.refuse_mean(analysis)
        if what.near is not None:
            raise OptionError(
                f"{analysis}: of other designs other modes may be near {what.near:g} Hz; give all "
                "modes, lumped.modes(system)."
            )
    else:
        system, changes = what.system, what.rotation.points[0].parameters
        name, kind = "order response", OfOrders
    refuse_other(wanted.values(), name, analysis)
    marginals = marginals_of(system, over, parameters=changes, analysis=analysis)
    evaluated_over = partial(kind, what, of=wanted, analysis=analysis)
    return Scene(system, over, marginals, evaluated_over, changes, analysis)


def find_correlated(scene: Scene) -> Boolean:
    """Which parameters depend on others, shape (d,)."""
    mixing = scene.marginals.mixing
    off = (mixing != 0) & ~np.eye(len(mixing), dtype=bool)
    found: Boolean = off.any(axis=0) | off.any(axis=1)
    return found


def refuse_correlated(scene: Scene) -> None:
    """Refuse parameters that depend on each other, as their shares are not defined.

    Raises
    ------
    OptionError
        With their names.
    """
    names = [
        name for name, is_one in zip(scene.names, find_correlated(scene), strict=True) if is_one
    ]
    if names:
        raise OptionError(
            f"{scene.analysis}: {list_names(names)} are correlated, so that the variance has no "
            "share of each. Give distributions without correlation, or take the ranking of "
            "lumped.scatter, which is of each alone."
        )
