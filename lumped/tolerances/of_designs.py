"""Probabilities and sample estimates of designs, with derivatives by the design."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lumped.ensembles.distributions import Correlated
from lumped.ensembles.other_laws import Scaled
from lumped.ensembles.variants import Over, marginals_of
from lumped.errors import OptionError, SolverError
from lumped.numerics.nearest_points import FURTHEST, Search, is_same, search_together
from lumped.support.arrays import Real
from lumped.support.text_table import amounts, list_names, number
from lumped.timeloop.run_options import RunPlan
from lumped.tolerances.aims import Probability, RobustAim
from lumped.tolerances.evaluated import Failures
from lumped.tolerances.failure.form import form, nothing_found, search_all
from lumped.tolerances.failure.limit import Limit
from lumped.tolerances.failure.samples import Sampled, around
from lumped.tolerances.failure.unions import join_points
from lumped.tolerances.scene import Scattered, Scene, plan_scene

_MORE = 4
"""How much larger than a sample is the one by which it is checked."""

Design = Mapping[str, float]
Plane = tuple[float, Real, float]
"""Reliability index, point, and growth of the excess there."""


@dataclass(frozen=True, eq=False)
class CheckedProbability:
    """A probability at the best design, checked by samples.

    Attributes
    ----------
    wanted : Probability
        What was asked for.
    most : float or None
        Its greatest value; None where it was made small.
    beta : float
        Reliability index by the design point, the one nearest to the median.
    first_order : float
        Probability with the limit plane at each design point (FORM).
    sampled : Sampled or None
        Estimate from samples around the design points, with its interval of 95 %; None where the
        limit is out of reach, so that the probability is less than 1e-15.
    design_point : dict of str to float
        The most likely combination that fails.
    shift : float
        By how much beta had to be greater than that of the greatest probability, because the limit
        is no plane.
    searches : int
        How often the best design was searched, each time with another shift.
    """

    wanted: Probability
    most: float | None
    beta: float
    first_order: float
    sampled: Sampled | None
    design_point: dict[str, float]
    shift: float = 0.0
    searches: int = 1

    def __str__(self) -> str:
        aim = "" if self.most is None else f" <= {self.most:g}"
        text = f"{self.wanted}{aim}: beta {number(self.beta, 5)}, "
        if self.sampled is None or self.sampled.interval is None:
            return f"{text}the limit is out of reach"
        low, high = self.sampled.interval
        text += (
            f"{self.first_order:.3g} by its design point, {self.sampled.probability:.3g} by "
            f"{self.wanted.runs} samples ({low:.3g} to {high:.3g})"
        )
        if self.shift:
            text += f"; beta shifted by {self.shift:+.3g}, searched {self.searches} times"
        if self.sampled.failed:
            text += f"; {self.sampled.failed} samples failed"
        return "; ".join([text, *self.sampled.notes])


@dataclass(frozen=True, eq=False)
class CheckedAim:
    """What sums up the scatter of a functional at the best design, by two samples.

    Attributes
    ----------
    aim : MeanPlusAim or QuantileAim
        What was asked for.
    value : float
        By the sample with which the design was found.
    fresh : float
        By another sample, four times as large.
    failed : int
        How many runs of this failed, and are left out of it.
    unit : str
        Of both values.
    """

    aim: RobustAim
    value: float
    fresh: float
    failed: int
    unit: str

    def __str__(self) -> str:
        *told, unit = amounts(str(self.aim.of), self.unit, self.value, self.fresh)
        text = (
            f"{self.aim}: {told[0]} {unit} by {self.aim.runs} runs, {told[1]} {unit} by "
            f"{_MORE * self.aim.runs} others"
        )
        return text + (f", of which {self.failed} failed" if self.failed else "")


class MovedScene:
    """One functional of what scatters around designs.

    Parameters of a design may scatter themselves, as `scaled` distributions; the others are the
    same in all samples of a design.

    Parameters
    ----------
    what, over, analysis
        As for `scene_of`.
    functional : functional
    design : sequence of str
        What a design consists of, m parameters.
    plan : RunPlan or None
        Options of the runs of a system.

    Raises
    ------
    OptionError
        If a parameter of the design has a distribution that does not follow its value; otherwise
        as `scene_of`.
    """

    def __init__(
        self,
        what: Scattered,
        functional: Any,
        over: Over,
        design: Sequence[str],
        analysis: str,
        plan: RunPlan | None,
    ) -> None:
        self.first = plan_scene(what, over, [functional], plan, None, analysis)
        self.design, self.analysis = tuple(design), analysis
        names, system = self.first.names, self.first.system
        self._refuse_fixed()
        self._base = {system.key(k): value for k, value in (self.first.parameters or {}).items()}
        self._others = [name for name in self.design if name not in names]
        every = (*names, *self._others)
        self._places = [every.index(name) for name in self.design]
        self._whole = self.first.evaluated_over(every)

    def _refuse_fixed(self) -> None:
        """Refuse parameters of the design whose scatter would not follow."""
        over: Any = self.first.over
        given = over.distributions if isinstance(over, Correlated) else over
        for name, law in zip(self.first.names, given.values(), strict=True):
            if name in self.design and not isinstance(law, Scaled):
                raise OptionError(
                    f"{self.analysis}: {name} is in `vary` and scatters, but its distribution "
                    "does not follow its value. Give that of a factor, such as "
                    "lumped.distributions.scaled(lumped.normal(1.0, 0.05))."
                )

    def at(self, design: Mapping[str, float]) -> Scene:
        """The scene at a design."""
        system, over, base = self.first.system, self.first.over, self._base | dict(design)
        marginals = marginals_of(system, over, parameters=base, analysis=self.analysis)
        held = {name: design[name] for name in self._others}
        return Scene(system, over, marginals, lambda _: self._whole, base, self.analysis, held)

    def slopes(self, design: Mapping[str, float], u: Real) -> tuple[Real, Real, Failures]:
        """The functional, and its derivatives by the design where the normal numbers are held.

        Parameters
        ----------
        design : mapping of str to float
        u : ndarray, shape (n, d)
            Standard normal numbers.

        Returns
        -------
        values : ndarray, shape (n,)
            Not a number where an evaluation failed.
        slopes : ndarray, shape (n, m)
        failures : dict of int to str
        """
        scene = self.at(design)
        x = scene.physical(u)
        values, slopes = scene.slopes_by_all(x)
        found: Real = slopes[:, 0, self._places]
        for j, (name, place) in enumerate(zip(self.design, self._places, strict=True)):
            if place < x.shape[1]:  # a factor times the value of the design
                found[:, j] *= x[:, place] / design[name]
        return values[:, 0], found, scene.failures


class DesignProbability:
    """Reliability indices of designs, found from the design points of the last one.

    Parameters
    ----------
    wanted : Probability
    scene : MovedScene
        Of its functional.

    Attributes
    ----------
    evaluations : int
        Runs or analyses so far.
    """

    def __init__(self, wanted: Probability, scene: MovedScene) -> None:
        self.wanted, self.scene, self.evaluations = wanted, scene, 0
        self._followed: list[Real] = []
        self._last: tuple[Design, list[tuple[float, Real]]] | None = None

    def limit(self, design: Design) -> Limit:
        """The limit at a design."""
        wanted = self.wanted
        return Limit(self.scene.at(design), wanted.above, wanted.below)

    def betas(self, design: Design) -> list[tuple[float, Real]]:
        """Reliability indices, and their derivatives by the design, each of shape (m,).

        One for each design point that is followed, the least first. Where the limit is out of
        reach, it is taken as plane from where the search ended. Whether it is smooth is looked at
        in `check`.

        Raises
        ------
        SolverError
            As `form`.
        """
        if self._last is None or self._last[0] != design:
            limit = self.limit(design)
            planes = self._planes(limit, design)
            self._followed = [u for _, u, _ in planes]
            _, slopes, _ = self.scene.slopes(design, np.array(self._followed))
            self.evaluations += limit.evaluations + len(planes)
            self._last = (
                dict(design),
                [
                    (beta, -limit.sign * by / steepness)
                    for (beta, _, steepness), by in zip(planes, slopes, strict=True)
                ],
            )
        return self._last[1]

    def _planes(self, limit: Limit, design: Design) -> list[Plane]:
        """The limit at the design points that are followed, or at the nearest if there is none."""
        known = search_together(limit.slopes, self._followed)
        ends = [search for search in known if search.is_found]
        if ends:
            kept: list[Plane] = []
            for plane in sorted(map(_plane, ends), key=lambda plane: plane[0]):
                if not any(is_same(plane[1], other) for _, other, _ in kept):
                    kept.append(plane)
            return kept
        every = search_all(limit)
        ends = [search for search in every if search.is_found]
        if not ends and not limit.is_crossed:
            ends = [search for search in every if search.slope.any()]
        if not ends:
            raise self._refuse(design, nothing_found(limit, every))
        return [min(map(_plane, ends), key=lambda plane: abs(plane[0]))]

    def _refuse(self, design: Design, error: Exception) -> SolverError:
        told = list_names([f"{name} = {value:.6g}" for name, value in design.items()])
        return SolverError(f"{self.scene.analysis}: at {told}: {error}", None)

    def check(
        self, design: Design, most: float | None, shift: float, searches: int
    ) -> CheckedProbability:
        """The probability by samples around all design points that are found from four starts.

        A point that is nearer than those that were followed is followed from now on.

        Raises
        ------
        SolverError
            If the limit has a kink at a design point, or no sample passes it.
        """
        (beta, _), *_ = self.betas(design)
        if beta >= FURTHEST:
            return CheckedProbability(self.wanted, most, beta, 0.0, None, {}, shift, searches)
        limit, wanted = self.limit(design), self.wanted
        try:
            points = form(limit, self._followed[0])
            found = around(limit, [point.u for point in points], wanted.runs, wanted.seed)
        except SolverError as error:
            raise self._refuse(design, error) from None
        nearest = points[0]
        if not any(is_same(nearest.u, u) for u in self._followed):
            self._followed.insert(0, nearest.u)
            self._last = None
        own = dict(zip(limit.scene.names, nearest.x.tolist(), strict=True))
        numbers = nearest.beta, join_points(points, limit.is_kept_by_median)
        return CheckedProbability(wanted, most, *numbers, found, own, shift, searches)


def _plane(search: Search) -> Plane:
    """Distance of the median from a limit that is plane at the end of a search."""
    steepness = float(np.linalg.norm(search.slope))
    return float(search.slope @ search.u - search.g) / steepness, search.u, steepness


class DesignAim:
    """What sums up scatter at designs, over the same standard normal numbers for each.

    Parameters
    ----------
    aim : MeanPlusAim or QuantileAim
    scene : MovedScene
        Of its functional.

    Attributes
    ----------
    evaluations : int
        Runs or analyses so far.
    """

    def __init__(self, aim: RobustAim, scene: MovedScene) -> None:
        self.aim, self.scene, self.evaluations = aim, scene, 0
        self._scores: Real | None = None
        self._last: tuple[Design, float, Real] | None = None

    def at(self, design: Design) -> tuple[float, Real]:
        """Value, and its derivatives by the design, shape (m,).

        Raises
        ------
        SolverError
            If a run fails.
        """
        if self._last is None or self._last[0] != design:
            if self._scores is None:
                scene = self.scene.at(design)
                self._scores = scene.scores(self.aim.runs, self.aim.seed, "sobol")
            values, slopes, failures = self.scene.slopes(design, self._scores)
            self.evaluations += len(values)
            for run, reason in failures.items():
                told = [f"{name} = {value:.6g}" for name, value in design.items()]
                raise SolverError(
                    f"{self.scene.analysis}: {self.aim}: {len(failures)} of {self.aim.runs} runs "
                    f"fail at {list_names(told)}. Run {run}: {reason}",
                    None,
                )
            self._last = dict(design), *self.aim.of_sample(values, slopes)
        return self._last[1:]

    def check(self, design: Design) -> CheckedAim:
        """The value beside that of a fresh sample."""
        scene = self.scene.at(design)
        u = scene.scores(_MORE * self.aim.runs, self.aim.seed + 1, "sobol")
        values = scene.values(scene.physical(u))[:, 0]
        sound = values[np.isfinite(values)]
        fresh, _ = self.aim.of_sample(sound, np.zeros((len(sound), 0)))
        value, failed = self.at(design)[0], len(values) - len(sound)
        return CheckedAim(self.aim, value, fresh, failed, scene.units[0])
